"""Both schemes in taichi, written like its examples mpm88 and mpm99."""

import taichi as ti
from schemes import Body, State

PLACE = {2: ((0, 2), (2, 1)), 3: ((0, 3, 5), (3, 1, 4), (5, 4, 2))}
"""Index of the stress component ij in the stored tuple, by dimension."""


@ti.data_oriented
class TaichiPeer:
    """Explicit MPM in a periodic unit box: hat functions and FLIP, or quadratic splines and APIC; USL, linear elastic."""

    def __init__(self, body: Body, quadratic: bool, threads: int) -> None:
        ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=threads, log_level=ti.ERROR)
        self.quadratic, self.n, (count, d) = quadratic, body.cells, body.position.shape
        self.d, self.place, self.nodes = d, PLACE[d], (3 if quadratic else 2,) * d
        self.h, self.mass, self.volume, self.lame, self.shear = 1 / body.cells, body.mass, body.volume, body.lame, body.shear
        self.x, self.v = (ti.Vector.field(d, ti.f64, shape=count) for _ in range(2))
        self.C = ti.Matrix.field(d, d, ti.f64, shape=count if quadratic else 1)
        self.stress, self.J = ti.Vector.field(d * (d + 1) // 2, ti.f64, shape=count), ti.field(ti.f64, shape=count)
        self.m = ti.field(ti.f64, shape=(self.n,) * d)
        self.p, self.f = (ti.Vector.field(d, ti.f64, shape=(self.n,) * d) for _ in range(2))

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
        """First of two nodes, and the hat functions and their derivatives along each axis."""
        s = x / self.h
        first = ti.floor(s, ti.i32)
        xi = s - first
        one = ti.Vector.one(ti.f64, self.d)
        return first, ti.static([one - xi, xi]), ti.static([-one / self.h, one / self.h])

    @ti.func
    def splines(self, x):
        """First of three nodes (at cell centres), splines and derivatives along each axis, and the distance from that node in cells."""
        s = x / self.h
        first = ti.floor(s, ti.i32) - 1
        r = s - 0.5 - first
        w = ti.static([0.5 * (1.5 - r) ** 2, 0.75 - (r - 1.0) ** 2, 0.5 * (r - 0.5) ** 2])
        d = ti.static([(r - 1.5) / self.h, -2.0 * (r - 1.0) / self.h, (r - 0.5) / self.h])
        return first, w, d, r

    @ti.func
    def node(self, first, offset: ti.template()):
        """Periodic indices of a node; that along x comes last."""
        k = ti.Vector.zero(ti.i32, self.d)
        for i in ti.static(range(self.d)):
            number = first[i] + offset[i]
            k[self.d - 1 - i] = number + self.n if number < 0 else (number - self.n if number >= self.n else number)
        return k

    @ti.func
    def product(self, w: ti.template(), offset: ti.template()):
        """Product of the functions along all axes."""
        N = 1.0
        for i in ti.static(range(self.d)):
            N *= w[offset[i]][i]
        return N

    @ti.func
    def gradient(self, w: ti.template(), d: ti.template(), offset: ti.template()):
        """Gradient of the product."""
        g = ti.Vector.one(ti.f64, self.d)
        for i, j in ti.static(ti.ndrange(self.d, self.d)):
            g[i] *= d[offset[j]][j] if ti.static(i == j) else w[offset[j]][j]
        return g

    @ti.func
    def force(self, p):
        """Return -V sigma with the volume V at t^n."""
        T = ti.Matrix.zero(ti.f64, self.d, self.d)
        for i, j in ti.static(ti.ndrange(self.d, self.d)):
            T[i, j] = self.stress[p][self.place[i][j]]
        return -self.volume * self.J[p] * T

    @ti.func
    def strain(self, p, L):
        """Update J and the stress by an increment L = dt dv/dx."""
        one = ti.Matrix.identity(ti.f64, self.d)
        self.J[p] *= (one + L).determinant()
        T = self.lame * L.trace() * one + self.shear * (L + L.transpose())
        for i, j in ti.static(ti.ndrange(self.d, self.d)):
            if ti.static(i <= j):
                self.stress[p][self.place[i][j]] += T[i, j]

    @ti.kernel
    def clear(self):
        for k in ti.grouped(self.m):
            self.m[k] = 0.0
            self.p[k] = ti.Vector.zero(ti.f64, self.d)
            self.f[k] = ti.Vector.zero(ti.f64, self.d)

    @ti.kernel
    def hats_to_grid(self):
        for p in self.x:
            first, w, d = self.hats(self.x[p])
            T, v = self.force(p), self.v[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*self.nodes))):
                k, N = self.node(first, offset), self.mass * self.product(w, offset)
                self.m[k] += N
                self.p[k] += N * v
                self.f[k] += T @ self.gradient(w, d, offset)

    @ti.kernel
    def update(self, kick: ti.f64):
        for k in ti.grouped(self.m):
            if self.m[k] > 0.0:
                self.f[k] /= self.m[k]
                self.p[k] = self.p[k] / self.m[k] + kick * self.f[k]

    @ti.kernel
    def grid_to_hats(self, kick: ti.f64, dt: ti.f64):
        for p in self.x:
            first, w, d = self.hats(self.x[p])
            a_p, v_p = ti.Vector.zero(ti.f64, self.d), ti.Vector.zero(ti.f64, self.d)
            L = ti.Matrix.zero(ti.f64, self.d, self.d)
            for offset in ti.static(ti.grouped(ti.ndrange(*self.nodes))):
                k, N = self.node(first, offset), self.product(w, offset)
                v = self.p[k]
                a_p += N * self.f[k]
                v_p += N * v
                L += v.outer_product(self.gradient(w, d, offset))
            self.v[p] += kick * a_p
            self.x[p] += dt * v_p
            self.strain(p, dt * L)

    @ti.kernel
    def splines_to_grid(self, kick: ti.f64):
        for p in self.x:
            first, w, d, r = self.splines(self.x[p])
            T, v, C = kick * self.force(p), self.v[p], self.C[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*self.nodes))):
                k, N = self.node(first, offset), self.mass * self.product(w, offset)
                self.m[k] += N
                distance = self.h * (offset.cast(ti.f64) - r)
                self.p[k] += N * (v + C @ distance) + T @ self.gradient(w, d, offset)

    @ti.kernel
    def update_momentum(self):
        for k in ti.grouped(self.m):
            if self.m[k] > 0.0:
                self.p[k] /= self.m[k]

    @ti.kernel
    def grid_to_splines(self, dt: ti.f64):
        for p in self.x:
            first, w, d, r = self.splines(self.x[p])
            v_p = ti.Vector.zero(ti.f64, self.d)
            B, L = ti.Matrix.zero(ti.f64, self.d, self.d), ti.Matrix.zero(ti.f64, self.d, self.d)
            for offset in ti.static(ti.grouped(ti.ndrange(*self.nodes))):
                v = self.p[self.node(first, offset)]
                moment = self.product(w, offset) * v
                v_p += moment
                B += moment.outer_product(offset.cast(ti.f64) - r)
                L += v.outer_product(self.gradient(w, d, offset))
            self.v[p] = v_p
            self.C[p] = 4.0 / self.h * B
            self.x[p] += dt * v_p
            self.strain(p, dt * L)
