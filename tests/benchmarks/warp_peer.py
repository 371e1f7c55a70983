"""Both schemes in warp, on one thread, as warp runs its kernels on a CPU."""

import warp as wp
from schemes import Body, State

wp.config.quiet = True
wp.config.enable_backward = False


@wp.struct
class Constants:
    """Cells along an axis, h [m], m [kg/m], V0 [m^2], lambda and mu [Pa]."""

    n: wp.int32
    h: wp.float64
    mass: wp.float64
    volume: wp.float64
    lame: wp.float64
    shear: wp.float64


@wp.func
def wrapped(i: wp.int32, n: wp.int32):
    """Periodic index of a node along an axis."""
    if i < 0:
        return i + n
    if i >= n:
        return i - n
    return i


@wp.func
def internal_force(c: Constants, stress: wp.vec3d, J: wp.float64):
    """Return -V sigma with the volume V at t^n."""
    return -c.volume * J * wp.mat22d(stress[0], stress[2], stress[2], stress[1])


@wp.func
def volume_change(L: wp.mat22d):
    """Return det(I + L)."""
    one = wp.float64(1.0)
    return (one + L[0, 0]) * (one + L[1, 1]) - L[0, 1] * L[1, 0]


@wp.func
def hooke(c: Constants, L: wp.mat22d):
    """Stress increment of the symmetric part of L."""
    volumetric, double = c.lame * (L[0, 0] + L[1, 1]), wp.float64(2.0) * c.shear
    return wp.vec3d(volumetric + double * L[0, 0], volumetric + double * L[1, 1], c.shear * (L[0, 1] + L[1, 0]))


@wp.func
def hats(s: wp.float64, first: wp.int32):
    """Hat functions of the two nodes from `first` on."""
    xi = s - wp.float64(first)
    return wp.vec2d(wp.float64(1.0) - xi, xi)


@wp.func
def splines(r: wp.float64):
    """Splines of three nodes at cell centres, for a particle at r cells from the first one."""
    half, one = wp.float64(0.5), wp.float64(1.0)
    u, v, w = wp.float64(1.5) - r, r - one, r - half
    return wp.vec3d(half * u * u, wp.float64(0.75) - v * v, half * w * w)


@wp.func
def slopes(r: wp.float64, scale: wp.float64):
    """Derivatives of the splines."""
    one = wp.float64(1.0)
    return wp.vec3d((r - wp.float64(1.5)) * scale, wp.float64(-2.0) * (r - one) * scale, (r - wp.float64(0.5)) * scale)


@wp.func
def distances(r: wp.float64):
    """Signed distances of the three nodes from the particle, in cells."""
    return wp.vec3d(-r, wp.float64(1.0) - r, wp.float64(2.0) - r)


@wp.kernel
def hats_to_grid(
    c: Constants,
    x: wp.array(dtype=wp.vec2d),
    v: wp.array(dtype=wp.vec2d),
    stress: wp.array(dtype=wp.vec3d),
    J: wp.array(dtype=wp.float64),
    m: wp.array(dtype=wp.float64),
    momentum: wp.array(dtype=wp.vec2d),
    force: wp.array(dtype=wp.vec2d),
):
    p = wp.tid()
    scale = wp.float64(1.0) / c.h
    s = x[p] * scale
    i, j = wp.int32(wp.floor(s[0])), wp.int32(wp.floor(s[1]))
    wx, wy, d = hats(s[0], i), hats(s[1], j), wp.vec2d(-scale, scale)
    T, v_p = internal_force(c, stress[p], J[p]), v[p]
    for b in range(2):
        for a in range(2):
            k, N = wrapped(i + a, c.n) + c.n * wrapped(j + b, c.n), c.mass * wx[a] * wy[b]
            wp.atomic_add(m, k, N)
            wp.atomic_add(momentum, k, N * v_p)
            wp.atomic_add(force, k, T * wp.vec2d(d[a] * wy[b], wx[a] * d[b]))


@wp.kernel
def update(
    kick: wp.float64, m: wp.array(dtype=wp.float64), momentum: wp.array(dtype=wp.vec2d), force: wp.array(dtype=wp.vec2d)
):
    i = wp.tid()
    if m[i] > wp.float64(0.0):
        a = force[i] / m[i]
        force[i] = a
        momentum[i] = momentum[i] / m[i] + kick * a


@wp.kernel
def grid_to_hats(
    c: Constants,
    kick: wp.float64,
    dt: wp.float64,
    x: wp.array(dtype=wp.vec2d),
    v: wp.array(dtype=wp.vec2d),
    stress: wp.array(dtype=wp.vec3d),
    J: wp.array(dtype=wp.float64),
    velocity: wp.array(dtype=wp.vec2d),
    acceleration: wp.array(dtype=wp.vec2d),
):
    p = wp.tid()
    scale = wp.float64(1.0) / c.h
    s = x[p] * scale
    i, j = wp.int32(wp.floor(s[0])), wp.int32(wp.floor(s[1]))
    wx, wy, d = hats(s[0], i), hats(s[1], j), wp.vec2d(-scale, scale)
    a_p, v_p, L = wp.vec2d(), wp.vec2d(), wp.mat22d()
    for b in range(2):
        for a in range(2):
            k, N = wrapped(i + a, c.n) + c.n * wrapped(j + b, c.n), wx[a] * wy[b]
            v_I = velocity[k]
            a_p += N * acceleration[k]
            v_p += N * v_I
            L += wp.outer(v_I, wp.vec2d(d[a] * wy[b], wx[a] * d[b]))
    L = dt * L
    v[p] = v[p] + kick * a_p
    x[p] = x[p] + dt * v_p
    J[p] = J[p] * volume_change(L)
    stress[p] = stress[p] + hooke(c, L)


@wp.kernel
def splines_to_grid(
    c: Constants,
    kick: wp.float64,
    x: wp.array(dtype=wp.vec2d),
    v: wp.array(dtype=wp.vec2d),
    C: wp.array(dtype=wp.mat22d),
    stress: wp.array(dtype=wp.vec3d),
    J: wp.array(dtype=wp.float64),
    m: wp.array(dtype=wp.float64),
    momentum: wp.array(dtype=wp.vec2d),
):
    p = wp.tid()
    scale, half = wp.float64(1.0) / c.h, wp.float64(0.5)
    s = x[p] * scale
    i, j = wp.int32(wp.floor(s[0])) - 1, wp.int32(wp.floor(s[1])) - 1
    r, t = s[0] - half - wp.float64(i), s[1] - half - wp.float64(j)
    wx, wy, dx, dy = splines(r), splines(t), slopes(r, scale), slopes(t, scale)
    rx, ry = distances(r), distances(t)
    T, v_p, C_p = kick * internal_force(c, stress[p], J[p]), v[p], c.h * C[p]
    for b in range(3):
        for a in range(3):
            k, N = wrapped(i + a, c.n) + c.n * wrapped(j + b, c.n), c.mass * wx[a] * wy[b]
            wp.atomic_add(m, k, N)
            affine = v_p + C_p * wp.vec2d(rx[a], ry[b])
            wp.atomic_add(momentum, k, N * affine + T * wp.vec2d(dx[a] * wy[b], wx[a] * dy[b]))


@wp.kernel
def update_momentum(m: wp.array(dtype=wp.float64), momentum: wp.array(dtype=wp.vec2d)):
    i = wp.tid()
    if m[i] > wp.float64(0.0):
        momentum[i] = momentum[i] / m[i]


@wp.kernel
def grid_to_splines(
    c: Constants,
    dt: wp.float64,
    x: wp.array(dtype=wp.vec2d),
    v: wp.array(dtype=wp.vec2d),
    C: wp.array(dtype=wp.mat22d),
    stress: wp.array(dtype=wp.vec3d),
    J: wp.array(dtype=wp.float64),
    velocity: wp.array(dtype=wp.vec2d),
):
    p = wp.tid()
    scale, half = wp.float64(1.0) / c.h, wp.float64(0.5)
    s = x[p] * scale
    i, j = wp.int32(wp.floor(s[0])) - 1, wp.int32(wp.floor(s[1])) - 1
    r, t = s[0] - half - wp.float64(i), s[1] - half - wp.float64(j)
    wx, wy, dx, dy = splines(r), splines(t), slopes(r, scale), slopes(t, scale)
    rx, ry = distances(r), distances(t)
    v_p, B, L = wp.vec2d(), wp.mat22d(), wp.mat22d()
    for b in range(3):
        for a in range(3):
            v_I = velocity[wrapped(i + a, c.n) + c.n * wrapped(j + b, c.n)]
            moment = wx[a] * wy[b] * v_I
            v_p += moment
            B += wp.outer(moment, wp.vec2d(rx[a], ry[b]))
            L += wp.outer(v_I, wp.vec2d(dx[a] * wy[b], wx[a] * dy[b]))
    L = dt * L
    v[p] = v_p
    C[p] = (wp.float64(4.0) * scale) * B
    x[p] = x[p] + dt * v_p
    J[p] = J[p] * volume_change(L)
    stress[p] = stress[p] + hooke(c, L)


class WarpPeer:
    """Explicit MPM in a periodic unit square: hat functions and FLIP, or quadratic splines and APIC; USL, linear elastic."""

    def __init__(self, body: Body, quadratic: bool) -> None:
        self.quadratic, self.count, nodes = quadratic, len(body.position), body.cells**2
        self.c = Constants()
        self.c.n, self.c.h, self.c.mass, self.c.volume = body.cells, 1 / body.cells, body.mass, body.volume
        self.c.lame, self.c.shear = body.lame, body.shear
        self.m = wp.zeros(nodes, dtype=wp.float64, device="cpu")
        self.p, self.f = (wp.zeros(nodes, dtype=wp.vec2d, device="cpu") for _ in range(2))

    def load(self, state: State) -> None:
        def array(values, dtype):
            return wp.array(values, dtype=dtype, device="cpu")

        self.x, self.v = array(state.position, wp.vec2d), array(state.velocity, wp.vec2d)
        self.C = array(state.affine, wp.mat22d)
        self.stress, self.J = array(state.stress, wp.vec3d), array(state.J, wp.float64)

    def state(self) -> State:
        return State(*(array.numpy().copy() for array in (self.x, self.v, self.C, self.stress, self.J)))

    def step(self, kick: float, dt: float) -> None:
        self.m.zero_()
        self.p.zero_()
        particles = (self.stress, self.J)
        if self.quadratic:
            self._launch(splines_to_grid, self.count, self.c, kick, self.x, self.v, self.C, *particles, self.m, self.p)
            self._launch(update_momentum, len(self.m), self.m, self.p)
            self._launch(grid_to_splines, self.count, self.c, dt, self.x, self.v, self.C, *particles, self.p)
        else:
            self.f.zero_()
            self._launch(hats_to_grid, self.count, self.c, self.x, self.v, *particles, self.m, self.p, self.f)
            self._launch(update, len(self.m), kick, self.m, self.p, self.f)
            self._launch(grid_to_hats, self.count, self.c, kick, dt, self.x, self.v, *particles, self.p, self.f)

    def wait(self) -> None:
        wp.synchronize()

    def _launch(self, kernel: wp.Kernel, count: int, *inputs: object) -> None:
        wp.launch(kernel, dim=count, inputs=inputs, device="cpu")
