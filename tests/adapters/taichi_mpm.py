"""MLS-MPM in taichi, after its example mpm128: quadratic B-splines, APIC, explicit; for the bench of mpmverify.

The law, the body force and the joined ends are those of the problem. The rest is the example's.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
import taichi as ti

from mpmverify.problem import (
    Discretisation,
    LinearElastic,
    NeoHookean,
    Periodic,
    Problem,
    Traction,
    output_steps,
    place_particles,
    require,
)
from mpmverify.solution import Solution, Work


@lru_cache(maxsize=1)
def start(real):
    """Start taichi anew when the precision changes; one thread, so that a run repeats to the last bit."""
    ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=1, log_level=ti.ERROR)


@ti.func
def splines(s):
    """Return the first of three nodes along each axis, the distance from it in cells, and the quadratic B-splines."""
    base = ti.floor(s - 0.5, int)
    fx = s - base
    return base, fx, ti.static([0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2])


@ti.func
def node(k, m: ti.template()):
    """Return the index of a node; the ends are joined, and a body that is free stays away from them."""
    return ti.Vector([(k[0] + m.shape[0]) % m.shape[0], (k[1] + m.shape[1]) % m.shape[1]])


@ti.func
def kirchhoff_stress(F, lam: float, mu: float, linear: int):
    one = ti.Matrix.identity(float, 2)
    tau = mu * (F @ F.transpose() - one) + lam * ti.log(F.determinant()) * one
    if linear:
        tau = mu * (F + F.transpose() - 2 * one) + lam * (F.trace() - 2) * one
    return tau


@ti.kernel
def substep(
    x: ti.types.ndarray(ndim=1),
    v: ti.types.ndarray(ndim=1),
    C: ti.types.ndarray(ndim=1),
    F: ti.types.ndarray(ndim=1),
    b: ti.types.ndarray(ndim=1),
    V: ti.types.ndarray(ndim=1),
    grid_v: ti.types.ndarray(ndim=2),
    grid_m: ti.types.ndarray(ndim=2),
    h: float,
    rho: float,
    lam: float,
    mu: float,
    linear: int,
    kick: float,
    dt: float,
):
    """One step; `kick` is the time over which the forces act."""
    for k in ti.grouped(grid_m):
        grid_v[k] = ti.Vector.zero(float, 2)
        grid_m[k] = 0
    for p in x:  # particles to grid
        base, fx, w = splines(x[p] / h)
        m = rho * V[p]
        affine = m * C[p] - kick * V[p] * 4 / h**2 * kirchhoff_stress(F[p], lam, mu, linear)
        for i, j in ti.static(ti.ndrange(3, 3)):
            weight = w[i][0] * w[j][1]
            k = node(base + ti.Vector([i, j]), grid_m)
            grid_v[k] += weight * (m * (v[p] + kick * b[p]) + affine @ ((ti.Vector([i, j]) - fx) * h))
            grid_m[k] += weight * m
    for k in ti.grouped(grid_m):
        if grid_m[k] > 0:
            grid_v[k] /= grid_m[k]
    for p in x:  # grid to particles
        base, fx, w = splines(x[p] / h)
        new_v, new_C = ti.Vector.zero(float, 2), ti.Matrix.zero(float, 2, 2)
        for i, j in ti.static(ti.ndrange(3, 3)):
            g = w[i][0] * w[j][1] * grid_v[node(base + ti.Vector([i, j]), grid_m)]
            new_v += g
            new_C += 4 / h * g.outer_product(ti.Vector([i, j]) - fx)
        v[p], C[p] = new_v, new_C
        x[p] += dt * new_v
        F[p] = (ti.Matrix.identity(float, 2) + dt * new_C) @ F[p]


def arrays(x, v, F, V, cells, real):
    """Return the arrays of `substep`, with these values of positions, velocities, deformation gradients and volumes."""
    count, kind = len(x), np.float32 if real == ti.f32 else np.float64
    vector, matrix = ti.types.vector(2, real), ti.types.matrix(2, 2, real)
    made = [ti.ndarray(t, count) for t in (vector, vector, matrix, matrix, vector, real)]
    for array, values in zip(made, (x, v, np.zeros_like(F), F, np.zeros_like(x), V), strict=True):
        array.from_numpy(np.ascontiguousarray(values, dtype=kind))
    return [*made, ti.ndarray(vector, cells), ti.ndarray(real, cells)]


@dataclass(frozen=True)
class TaichiMPM:
    """MLS-MPM for a linear elastic body at small strain, or a neo-Hookean one, in two dimensions.

    Parameters
    ----------
    single : bool
        Whether it computes in single precision.
    centred : bool
        Whether the forces act over half a step at first, so that velocities are half a step behind positions. The example has no such step.
    """

    single: bool = False
    centred: bool = True
    orders: ClassVar[Mapping[str, float]] = {"displacement": 2}
    conserves: ClassVar[frozenset[str]] = frozenset()

    @property
    def name(self) -> str:
        return f"taichi-mls-mpm-{'single' if self.single else 'double'}{'' if self.centred else '-uncentred'}"

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        conditions, law = set(problem.boundary.values()), problem.material
        suits = problem.dimension == 2 and type(law) in (LinearElastic, NeoHookean)
        suits &= conditions == {Periodic()} or (conditions == {Traction()} and problem.shape is not None)
        require(suits, self.name, problem, "elastic and neo-Hookean planes, free inside the box or with all ends joined")
        real, kind = (ti.f32, np.float32) if self.single else (ti.f64, np.float64)
        start(real)
        cells, (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
        X, V = place_particles(problem, discretisation)
        placed = X - problem.lower + problem.initial_field("displacement", X)
        H = problem.initial_field("displacement_gradient", X).reshape(-1, 2, 2)
        of_particles = arrays(placed, problem.initial_field("velocity", X), np.eye(2) + H, V, cells, real)
        x, _, _, F, b, *_ = of_particles
        constants = discretisation.h, law.density, law.lame_lambda, law.shear_modulus, type(law) is LinearElastic
        shown, position, gradient = output_steps(steps, problem.outputs), [], []
        for n in range(steps + 1):
            if n in shown:
                position.append(x.to_numpy().astype(float) + problem.lower)
                gradient.append(F.to_numpy().astype(float))
            if n < steps:
                if problem.body_force:
                    b.from_numpy(problem.force(X, x.to_numpy() + problem.lower, n * dt).astype(kind))
                substep(*of_particles, *constants, dt / 2 if self.centred and n == 0 else dt, dt)

        F, one = np.stack(gradient), np.eye(2)
        if type(law) is LinearElastic:
            H = F - one
            trace = np.trace(H, axis1=2, axis2=3)[..., None, None]
            sigma = law.lame_lambda * trace * one + law.shear_modulus * (H + np.swapaxes(H, 2, 3))
        else:
            J = np.linalg.det(F)[..., None, None]
            sigma = (law.lame_lambda * np.log(J) * one + law.shear_modulus * (F @ np.swapaxes(F, 2, 3) - one)) / J
        fields = {
            "displacement": np.stack(position) - X,
            "stress": np.stack([sigma[..., 0, 0], sigma[..., 1, 1], sigma[..., 0, 1]], axis=2),
        }
        return Solution(
            time=dt * shown,
            dt=dt,
            reference=X,
            position=np.stack(position),
            weight=np.tile(V, (len(shown), 1)),
            fields=fields,
            histories={"time": dt * np.arange(steps + 1)},
            work=Work(steps, steps * len(X)),
        )
