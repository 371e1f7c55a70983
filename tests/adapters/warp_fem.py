"""Explicit finite elements in warp for the bench of mpmverify: constant strain triangles, lumped mass, central differences."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
import warp as wp

from mpmverify.problem import Array, Discretisation, LinearElastic, NeoHookean, Problem, Velocity, output_steps, require
from mpmverify.solution import Solution, Work

wp.config.quiet = True
wp.config.enable_backward = False


@cache
def kernels(real: type):
    """Return the kernels of a step in the precision wp.float32 or wp.float64."""
    vector, matrix = wp.types.vector(2, real), wp.types.matrix((2, 2), real)

    @wp.kernel
    def move(u: wp.array(dtype=vector), v: wp.array(dtype=vector), a: wp.array(dtype=vector), half: real, dt: real):
        i = wp.tid()
        v[i] = v[i] + half * a[i]
        u[i] = u[i] + dt * v[i]

    @wp.kernel
    def internal_forces(
        triangle: wp.array2d(dtype=wp.int32),
        slope: wp.array2d(dtype=vector),
        area: real,
        lam: real,
        mu: real,
        linear: wp.bool,
        u: wp.array(dtype=vector),
        f: wp.array(dtype=vector),
    ):
        e = wp.tid()
        H = matrix()
        for k in range(3):
            H += wp.outer(u[triangle[e, k]], slope[e, k])
        one = wp.identity(n=2, dtype=real)
        P = lam * wp.trace(H) * one + mu * (H + wp.transpose(H))
        if not linear:
            F = one + H
            back = wp.transpose(wp.inverse(F))
            P = lam * wp.log(wp.determinant(F)) * back + mu * (F - back)
        for k in range(3):
            wp.atomic_add(f, triangle[e, k], -area * (P * slope[e, k]))

    @wp.kernel
    def accelerate(
        m: wp.array(dtype=real),
        free: wp.array(dtype=vector),
        f: wp.array(dtype=vector),
        b: wp.array(dtype=vector),
        v: wp.array(dtype=vector),
        a: wp.array(dtype=vector),
        half: real,
    ):
        i = wp.tid()
        a[i] = wp.cw_mul(free[i], f[i] / m[i] + b[i])
        v[i] = v[i] + half * a[i]

    return move, internal_forces, accelerate


@dataclass(frozen=True)
class WarpFem:
    """A linear elastic or neo-Hookean rectangle between rollers, in single or in double precision."""

    single: bool = False

    @property
    def name(self) -> str:
        return f"warp-fem-{'single' if self.single else 'double'}"

    @property
    def orders(self) -> Mapping[str, float]:
        return {"displacement": 2, "velocity": 2, "stress": 1}

    @property
    def conserves(self) -> frozenset[str]:
        """To the round-off of double precision."""
        return frozenset() if self.single else frozenset({"mass", "momentum"})

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        law, h = problem.material, discretisation.h
        suits = problem.dimension == 2 and problem.shape is None and set(problem.boundary.values()) == {Velocity()}
        suits &= type(law) in (LinearElastic, NeoHookean)
        require(suits, self.name, problem, "elastic and neo-Hookean rectangles between rollers")
        real, kind = (wp.float32, np.float32) if self.single else (wp.float64, np.float64)
        move, internal_forces, accelerate = kernels(real)
        vector = wp.types.vector(2, real)

        (nx, ny), (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
        X = problem.lower + h * np.argwhere(np.ones((nx + 1, ny + 1)))
        corner = (np.arange(nx)[:, None] * (ny + 1) + np.arange(ny)).ravel()[:, None]
        triangle = np.concatenate([corner + np.array(nodes) for nodes in ([0, ny + 1, ny + 2], [0, ny + 2, 1])])
        slope = np.repeat(np.array([[[-1, 0], [1, -1], [0, 1]], [[0, -1], [1, 0], [-1, 1]]]) / h, nx * ny, axis=0)
        area = h**2 / 2
        m = np.bincount(triangle.ravel(), minlength=len(X)) * law.density * area / 3
        free = ~(np.isclose(X, problem.lower) | np.isclose(X, problem.upper))

        def on_device(values: Array, dtype: type) -> wp.array:
            return wp.array(np.ascontiguousarray(values, dtype=kind), dtype=dtype, device="cpu")

        u, v = (on_device(problem.initial_field(q, X) * free, vector) for q in ("displacement", "velocity"))
        a, f, b = (on_device(np.zeros_like(X), vector) for _ in range(3))
        mass, mask, slopes = on_device(m, real), on_device(free, vector), on_device(slope, vector)
        elements = wp.array(triangle, dtype=wp.int32, device="cpu")
        shown, saved, histories, impulse, before = output_steps(steps, problem.outputs), [], [], np.zeros(2), np.zeros(2)
        for n in range(steps + 1):
            if n:
                wp.launch(move, len(X), [u, v, a, dt / 2, dt], device="cpu")
            f.zero_()
            constants = [area, law.lame_lambda, law.shear_modulus, type(law) is LinearElastic]
            wp.launch(internal_forces, len(triangle), [elements, slopes, *constants, u, f], device="cpu")
            if problem.body_force:
                b.assign(problem.force(X, X + u.numpy(), n * dt).astype(kind))
            wp.launch(accelerate, len(X), [mass, mask, f, b, v, a, dt / 2 if n else 0.0], device="cpu")
            load = (np.where(free, m[:, None] * b.numpy(), -f.numpy())).sum(axis=0, dtype=float)  # reactions at the rollers
            impulse = impulse + dt / 2 * (before + load) if n else impulse
            before = load
            histories.append((m.sum(), *(m @ v.numpy().astype(float)), *impulse))
            if n in shown:
                saved.append([array.numpy().astype(float) for array in (u, v)])

        moved, velocity = np.stack(saved, axis=1)
        H = np.einsum("tekc,ekd->tecd", moved[:, triangle], slope)
        middle = X[triangle].mean(axis=1)
        fields = {
            "displacement": moved[:, triangle].mean(axis=2),
            "velocity": velocity[:, triangle].mean(axis=2),
            "stress": cauchy_stress(law, H),
        }
        names = ("mass", "momentum_x", "momentum_y", "impulse_x", "impulse_y")
        return Solution(
            time=dt * shown,
            dt=dt,
            reference=middle,
            position=middle + fields["displacement"],
            weight=np.full((len(shown), len(triangle)), area),
            fields=fields,
            histories={"time": dt * np.arange(steps + 1), **dict(zip(names, np.transpose(histories), strict=True))},
            work=Work(steps, steps * len(triangle)),
        )


def cauchy_stress(law: LinearElastic, H: Array) -> Array:
    """Return the stress (T, E, 3) of the displacement gradient (T, E, 2, 2)."""
    one, lam, mu = np.eye(2), law.lame_lambda, law.shear_modulus
    sigma = lam * np.trace(H, axis1=2, axis2=3)[..., None, None] * one + mu * (H + np.swapaxes(H, 2, 3))
    if isinstance(law, NeoHookean):
        F = one + H
        J = np.linalg.det(F)[..., None, None]
        sigma = (lam * np.log(J) * one + mu * (F @ np.swapaxes(F, 2, 3) - one)) / J
    return np.stack([sigma[..., 0, 0], sigma[..., 1, 1], sigma[..., 0, 1]], axis=2)
