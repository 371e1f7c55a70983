"""The two schemes in taichi, in the manner of its examples mpm88 and mpm99."""

import taichi as ti
from schemes import Body, State


@ti.data_oriented
class TaichiPeer:
    """Explicit MPM in a periodic unit square: hat functions and FLIP, or quadratic splines and APIC; USL, linear elastic."""

    def __init__(self, body: Body, quadratic: bool, threads: int) -> None:
        ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=threads, log_level=ti.ERROR)
        self.quadratic, self.n, count = quadratic, body.cells, len(body.position)
        self.h, self.mass, self.volume, self.lame, self.shear = 1 / body.cells, body.mass, body.volume, body.lame, body.shear
        self.x, self.v = (ti.Vector.field(2, ti.f64, shape=count) for _ in range(2))
        self.C = ti.Matrix.field(2, 2, ti.f64, shape=count if quadratic else 1)
        self.stress, self.J = ti.Vector.field(3, ti.f64, shape=count), ti.field(ti.f64, shape=count)
        self.m = ti.field(ti.f64, shape=(self.n, self.n))
        self.p, self.f = (ti.Vector.field(2, ti.f64, shape=(self.n, self.n)) for _ in range(2))

    def load(self, state: State) -> None:
        for field, values in (
            (self.x, state.position),
            (self.v, state.velocity),
            (self.stress, state.stress),
            (self.J, state.J),
        ):
            field.from_numpy(values)
        if self.quadratic:
            self.C.from_numpy(state.affine)

    def state(self) -> State:
        return State(*(field.to_numpy() for field in (self.x, self.v, self.C, self.stress, self.J)))

    def step(self, kick: float, dt: float) -> None:
        self.clear()
        if self.quadratic:
            self.splines_to_grid(kick)
            self.update_momentum()
            self.grid_to_splines(dt)
        else:
            self.hats_to_grid()
            self.update(kick)
            self.grid_to_hats(kick, dt)

    def wait(self) -> None:
        ti.sync()

    @ti.func
    def hats(self, x):
        """First node, functions and derivatives along the axes."""
        s = x / self.h
        first = ti.floor(s, ti.i32)
        xi = s - first
        one = ti.Vector([1.0, 1.0])
        return first, ti.static([one - xi, xi]), ti.static([-one / self.h, one / self.h])

    @ti.func
    def splines(self, x):
        """First of three nodes in the middle of cells, functions and derivatives along the axes, and the distance from it in cells."""
        s = x / self.h
        first = ti.floor(s, ti.i32) - 1
        r = s - 0.5 - first
        w = ti.static([0.5 * (1.5 - r) ** 2, 0.75 - (r - 1.0) ** 2, 0.5 * (r - 0.5) ** 2])
        d = ti.static([(r - 1.5) / self.h, -2.0 * (r - 1.0) / self.h, (r - 0.5) / self.h])
        return first, w, d, r

    @ti.func
    def node(self, first, a, b):
        """Row and column of a node, brought back into the square."""
        i, j = first[0] + a, first[1] + b
        i = i + self.n if i < 0 else (i - self.n if i >= self.n else i)
        j = j + self.n if j < 0 else (j - self.n if j >= self.n else j)
        return ti.Vector([j, i])

    @ti.func
    def force(self, p):
        """-V sigma, the volume that of t^n."""
        xx, yy, xy = self.stress[p][0], self.stress[p][1], self.stress[p][2]
        return -self.volume * self.J[p] * ti.Matrix([[xx, xy], [xy, yy]])

    @ti.func
    def strain(self, p, L):
        """J and stress after an increment L = dt dv/dx."""
        self.J[p] *= (1.0 + L[0, 0]) * (1.0 + L[1, 1]) - L[0, 1] * L[1, 0]
        volumetric = self.lame * (L[0, 0] + L[1, 1])
        self.stress[p] += ti.Vector(
            [volumetric + 2 * self.shear * L[0, 0], volumetric + 2 * self.shear * L[1, 1], self.shear * (L[0, 1] + L[1, 0])]
        )

    @ti.kernel
    def clear(self):
        for i, j in self.m:
            self.m[i, j] = 0.0
            self.p[i, j] = ti.Vector.zero(ti.f64, 2)
            self.f[i, j] = ti.Vector.zero(ti.f64, 2)

    @ti.kernel
    def hats_to_grid(self):
        for p in self.x:
            first, w, d = self.hats(self.x[p])
            T, v = self.force(p), self.v[p]
            for a, b in ti.static(ti.ndrange(2, 2)):
                k, N = self.node(first, a, b), self.mass * w[a][0] * w[b][1]
                self.m[k] += N
                self.p[k] += N * v
                self.f[k] += T @ ti.Vector([d[a][0] * w[b][1], w[a][0] * d[b][1]])

    @ti.kernel
    def update(self, kick: ti.f64):
        for i, j in self.m:
            if self.m[i, j] > 0.0:
                self.f[i, j] /= self.m[i, j]
                self.p[i, j] = self.p[i, j] / self.m[i, j] + kick * self.f[i, j]

    @ti.kernel
    def grid_to_hats(self, kick: ti.f64, dt: ti.f64):
        for p in self.x:
            first, w, d = self.hats(self.x[p])
            a_p, v_p, L = ti.Vector.zero(ti.f64, 2), ti.Vector.zero(ti.f64, 2), ti.Matrix.zero(ti.f64, 2, 2)
            for a, b in ti.static(ti.ndrange(2, 2)):
                k, N = self.node(first, a, b), w[a][0] * w[b][1]
                v = self.p[k]
                a_p += N * self.f[k]
                v_p += N * v
                L += v.outer_product(ti.Vector([d[a][0] * w[b][1], w[a][0] * d[b][1]]))
            self.v[p] += kick * a_p
            self.x[p] += dt * v_p
            self.strain(p, dt * L)

    @ti.kernel
    def splines_to_grid(self, kick: ti.f64):
        for p in self.x:
            first, w, d, r = self.splines(self.x[p])
            T, v, C = kick * self.force(p), self.v[p], self.C[p]
            for a, b in ti.static(ti.ndrange(3, 3)):
                k, N = self.node(first, a, b), self.mass * w[a][0] * w[b][1]
                self.m[k] += N
                distance = self.h * (ti.Vector([a, b], ti.f64) - r)
                self.p[k] += N * (v + C @ distance) + T @ ti.Vector([d[a][0] * w[b][1], w[a][0] * d[b][1]])

    @ti.kernel
    def update_momentum(self):
        for i, j in self.m:
            if self.m[i, j] > 0.0:
                self.p[i, j] /= self.m[i, j]

    @ti.kernel
    def grid_to_splines(self, dt: ti.f64):
        for p in self.x:
            first, w, d, r = self.splines(self.x[p])
            v_p, B, L = ti.Vector.zero(ti.f64, 2), ti.Matrix.zero(ti.f64, 2, 2), ti.Matrix.zero(ti.f64, 2, 2)
            for a, b in ti.static(ti.ndrange(3, 3)):
                v = self.p[self.node(first, a, b)]
                moment = w[a][0] * w[b][1] * v
                v_p += moment
                B += moment.outer_product(ti.Vector([a, b], ti.f64) - r)
                L += v.outer_product(ti.Vector([d[a][0] * w[b][1], w[a][0] * d[b][1]]))
            self.v[p] = v_p
            self.C[p] = 4.0 / self.h * B
            self.x[p] += dt * v_p
            self.strain(p, dt * L)
