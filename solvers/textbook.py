"""The explicit material point method in NumPy, to be read beside a textbook; faster codes are held against it.

`Textbook.solve` has the steps in their order, worded as in the notes of GeHoJerez and continued after Sulsky and after Zhang, Chen and
Liu. Velocities live at t^{n-1/2}, half a step before positions, strain and stress. N_Ip is the function of node I at particle p; in the
total Lagrangian formulation, at its reference position, where P = J sigma F^-T acts on the reference volume.

Sulsky, Chen and Schreyer, 1994, doi:10.1016/0045-7825(94)90112-0; Zhang, Chen and Liu, The Material Point Method, 2017, chapter 3;
Bardenhagen, 2002, doi:10.1006/jcph.2002.7103 (USF, USL); Jiang, Schroeder and Teran, 2017, doi:10.1016/j.jcp.2017.02.050 (APIC);
de Vaucorbeil, Nguyen and Hutchinson, 2020, doi:10.1016/j.cma.2019.112783 (total Lagrangian).
"""

import time
from collections.abc import Mapping
from dataclasses import astuple, dataclass
from functools import reduce
from typing import Any, ClassVar

import numpy as np
from numpy import einsum

from mpmverify import problem as bvp
from mpmverify.errors import UsageError
from mpmverify.problem import Array
from mpmverify.solution import Outcome, Solution, Status, Work

CHOICES = (("USF", "USL", "MUSL"), ("FLIP", "PIC", "APIC"), ("linear", "quadratic"), ("updated", "total"))
MASSLESS = {"linear": 1e-12, "quadratic": 0.0}
"""Nodal mass, by that of the heaviest particle, up to which a node takes no internal force and no traction: a hat has a slope even there."""
TINY, STATE = np.finfo(float).tiny, ("displacement", "velocity", "displacement_gradient", "stress")
VOIGT = {1: ([0], [0]), 2: ([0, 1, 0], [0, 1, 1]), 3: ([0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0])}
"""Rows and columns of the independent components of the stress, by dimension."""


@dataclass(frozen=True)
class Textbook:
    """Explicit material point method in one, two and three dimensions, in NumPy alone.

    Parameters
    ----------
    schedule : {"USF", "USL", "MUSL"}
        When the stress is updated.
    transfer : {"FLIP", "PIC", "APIC"}
        How the velocity of the grid becomes that of the particles.
    basis : {"linear", "quadratic"}
        B-splines of the grid, clamped at its ends.
    formulation : {"updated", "total"}
        Lagrangian formulation.

    Raises
    ------
    UsageError
        If a choice does not exist.
    """

    schedule: str = "MUSL"
    transfer: str = "FLIP"
    basis: str = "linear"
    formulation: str = "updated"
    conserves: ClassVar[frozenset[str]] = frozenset({"mass", "momentum"})

    def __post_init__(self) -> None:
        for value, choices in zip(astuple(self), CHOICES, strict=True):
            if value not in choices:
                raise UsageError(f"the textbook's material point method takes {', '.join(choices)}, not {value!r}")

    @property
    def name(self) -> str:
        return f"textbook-{self.formulation[0]}l-{self.basis}-{self.schedule.lower()}-{self.transfer.lower()}"

    @property
    def coarse_orders(self) -> Mapping[str, float]:
        return dict.fromkeys(self.orders, 0.5 if self.transfer == "PIC" else 2.0)

    @property
    def orders(self) -> Mapping[str, float]:
        """Formal orders in h while no particle crosses a cell; on coarse levels `coarse_orders`. See `MaterialPoint`."""
        linear, pic = self.basis == "linear", self.transfer == "PIC"
        velocity = 1.0 if pic else 2.0 if linear or self.transfer == "APIC" else 1.5
        return {"displacement": 1.0 if pic else 2.0, "velocity": velocity, "stress": 1.0 if linear or pic else 1.5}

    def solve(self, problem: bvp.Problem, discretisation: bvp.Discretisation) -> Solution:
        """Solve; numerical failure is an `Outcome`.

        Raises
        ------
        UsageError
            If the material is neither linear elastic nor neo-Hookean, or `require_body` refuses the faces or the initial state.
        """
        law, d, total, flip = problem.material, problem.dimension, self.formulation == "total", self.transfer == "FLIP"
        hooke = type(law) is bvp.LinearElastic
        bvp.require(hooke or type(law) is bvp.NeoHookean, self.name, problem, "linear elastic or neo-Hookean bodies")
        bvp.require_body(self.name, problem)
        assert isinstance(law, bvp.LinearElastic)
        (steps, dt), grid = discretisation.time_steps(problem), Grid(problem, discretisation, self.basis)
        began, X, V0 = time.perf_counter(), *bvp.place_particles(problem, discretisation)
        wanted, outcome, outputs, histories = bvp.output_steps(steps, problem.outputs), Outcome(), list[Any](), list[Any]()
        m, one, given, impulse, B, stress = law.density * V0, np.eye(d), 0.0, np.zeros(d), *np.zeros((2, len(X), d, d))
        u, v, H, sigma = (problem.initial_field(quantity, X) for quantity in STATE)
        x, F, stress[:, *VOIGT[d]], stress[:, *VOIGT[d][::-1]] = X + u, one + H.reshape(-1, d, d), sigma, sigma

        def nodal_momentum() -> Array:
            return grid.sum(node, einsum("p,pw,pwi->pwi", m, N, v[:, None] + einsum("pij,pwj->pwi", B / D, r)))

        def strained() -> tuple[Array, Array]:
            step = dt * einsum("pwi,pwj->pij", v_I[node], dN)
            after, strain = F + (step if total else step @ F), (step + step.mT) / 2
            if hooke:
                return after, stress + law.lame_lambda * einsum("pkk,ij->pij", strain, one) + 2 * law.shear_modulus * strain
            J = np.linalg.det(after)[:, None, None]
            return after, (law.lame_lambda * np.log(J) * one + law.shear_modulus * (after @ after.mT - one)) / J

        with np.errstate(all="ignore"):  # a run that diverges overflows; its outcome says so
            for n in range(steps + 1):
                kick, leap = (dt / 2, dt) if n else (0.0, dt / 2)  # from v^{n-1/2} to v^n, and to v^{n+1/2}
                before, now, after = max(n - 0.5, 0.0) * dt, n * dt, (n + 0.5) * dt
                at = X if total else x
                inside = np.abs((at - grid.lower) / grid.h - grid.cells / 2) <= grid.cells / 2
                if not np.all(inside | grid.joined & np.isfinite(at)):
                    outcome = Outcome(Status.LEFT_GRID, f"at step {n} of {steps}")
                    break
                node, N, dN, r = grid.support(at)
                # 1. Calculate the grid nodal mass and momentum by mapping the particle mass and momentum to the grid nodes.
                D = einsum("pw,pwi,pwi->pi", N, r, r)[:, None]
                m_I, p_I = grid.sum(node, (m[:, None] * N)[:, :, None]), nodal_momentum()
                # 2. Impose essential boundary conditions on the grid nodal momentum. At the fixed boundary, set it to zero.
                v_I = grid.held(p_I / np.maximum(m_I, TINY), before)
                gained = (m_I * v_I - p_I).sum(axis=0)
                # 3. For the USF only, calculate the particle strain increment, and update the particle density and stress.
                if self.schedule == "USF" and n:
                    F, stress = strained()
                # 4. Calculate the grid nodal internal force, and the external one of body force and tractions.
                J = np.linalg.det(F)
                P = J[:, None, None] * stress @ np.linalg.inv(F).mT if total and not hooke else stress
                V, heavy = V0 if total and hooke else J * V0, m_I > MASSLESS[self.basis] * m.max()
                internal = -grid.sum(node, einsum("p,pij,pwj->pwi", V0 if total else V, P, dN))
                external = grid.sum(node, einsum("p,pi,pw->pwi", m, problem.force(X, x, now), N)) + heavy * grid.load(now)
                # 5. Integrate the momentum equation with essential boundary conditions. The first step is a half one.
                a_I = (heavy * internal + external) / np.maximum(m_I, TINY)
                a_I = np.where(grid.fixed, (grid.held(v_I, after) - v_I) / leap, a_I)
                external = np.where(grid.fixed, m_I * a_I - internal, external)
                given += dt * np.abs((external * (v_I + kick * a_I)).sum())
                v_I, external = v_I + leap * a_I, external.sum(axis=0)
                # Record the synchronous state at t^n.
                v_n = v + kick * (a := einsum("pw,pwi->pi", N, a_I[node]))
                sums = now, m_I.sum(), *(m @ v_n), *(impulse + kick * external), m @ einsum("pi,pi->p", v_n, v_n) / 2
                given += 0.0 if n else sums[-1] + einsum("p,pij,pij->", V0, stress, stress) / law.youngs_modulus
                finite = np.isfinite(sums).all() and np.isfinite(stress).all() and (V > 0).all()
                if not finite or sums[-1] > 100 * given:  # a kinetic energy that nothing gave
                    outcome = Outcome(Status.UNSTABLE if finite else Status.NON_FINITE, f"at step {n} of {steps}")
                    break
                histories.append(sums)
                impulse = impulse + leap * external + (0.0 if flip else gained)
                if n in wanted:
                    outputs.append((now, x - X, v_n, stress[:, *VOIGT[d]], V))
                # 6. Update the particle velocity and position.
                moved = einsum("pw,pwi->pi", N, v_I[node])
                v, x = v + leap * a if flip else moved, x + dt * moved
                B = einsum("pw,pwi,pwj->pij", N, v_I[node], r) if self.transfer == "APIC" else B
                # 7. For the MUSL only, map the updated particle momentum to the grid nodes again, with essential boundary conditions.
                if self.schedule == "MUSL":
                    v_I = grid.held(nodal_momentum() / np.maximum(m_I, TINY), after)
                # 8. For the USL and the MUSL, calculate the particle strain increment, and update the particle density and stress.
                if self.schedule != "USF":
                    F, stress = strained()
        t, u, v, sigma, V = (np.array(values) for values in zip(*outputs, strict=True))
        names = "time", "mass", *bvp.components("momentum", d), *bvp.components("impulse", d), "kinetic_energy"
        columns = dict(zip(names, np.array(histories).T.copy(), strict=True))
        fields, work = {"displacement": u, "velocity": v, "stress": sigma}, Work(n, n * len(X), time.perf_counter() - began)
        return Solution(t, dt, X, X + u, V, fields, columns, work, outcome)


class Grid:
    """Nodes of products of B-splines on the box of a problem, and the conditions on its faces, of which clamped ones have the last word."""

    def __init__(self, problem: bvp.Problem, at: bvp.Discretisation, basis: str) -> None:
        self.h, self.degree, self.axes = at.h, 1 if basis == "linear" else 2, range(problem.dimension)
        self.cells, self.lower = np.array(at.cells(problem)), np.array(problem.lower)
        self.joined = np.array([isinstance(problem.boundary["xyz"[k] + "-"], bvp.Periodic) for k in self.axes])
        self.counts = np.where(self.joined, self.cells, self.cells + self.degree)
        numbers = np.arange(self.counts.prod()).reshape(self.counts)
        self.fixed, self.velocities, self.tractions = np.zeros((numbers.size, len(self.axes)), bool), list[Any](), list[Any]()
        for face, condition in sorted(problem.boundary.items(), key=lambda item: isinstance(item[1], bvp.Fixed)):
            k, side = "xyz".index(face[0]), 0 if face[1] == "-" else -1
            nodes = numbers.take(side, axis=k).ravel()
            if isinstance(condition, bvp.Fixed):
                self.velocities.append((np.ix_(nodes, self.axes), bvp.Constant()))
            elif isinstance(condition, bvp.Velocity):
                self.velocities.append((np.ix_(nodes, [k]), condition.value))
            elif isinstance(condition, bvp.Traction):
                area = np.zeros(self.fixed.shape)
                for body in problem.touched(face):
                    sides = [self.integrals(c, body.lower[c], body.upper[c]) for c in self.axes if c != k]
                    area[nodes, k] += reduce(np.multiply.outer, sides, np.array(1.0 if side else -1.0)).ravel()
                self.tractions.append((area, condition.value))
        for entries, _ in self.velocities:
            self.fixed[entries] = True

    def held(self, v: Array, t: float) -> Array:
        """Nodal velocities (n, d) [m/s] with those that are prescribed at a time [s]."""
        v = v.copy()
        for entries, value in self.velocities:
            v[entries] = value(np.array([t]))
        return v

    def load(self, t: float) -> Array:
        """Nodal forces (n, d) [N] of the tractions at a time [s]."""
        return sum((area * value(np.array([t])) for area, value in self.tractions), np.zeros(self.fixed.shape))

    def sum(self, node: Array, values: Array) -> Array:
        """Sums (n, ...) over the particles of values (P, W, ...) at their nodes (P, W)."""
        sums: list[Any] = [np.bincount(node.ravel(), column, len(self.fixed)) for column in values.reshape(node.size, -1).T]
        return np.array(sums).T.reshape(-1, *values.shape[2:])

    def support(self, x: Array) -> tuple[Any, ...]:
        """Nodes (P, W), N_Ip (P, W), its gradient (P, W, d) [1/m] and x_I - x_p (P, W, d) [m] at places (P, d) [m]."""
        s = np.where(self.joined, (x - self.lower) / self.h % self.cells, (x - self.lower) / self.h)
        node, N, dN, r = zip(*(self.along(k, s[:, k]) for k in self.axes), strict=True)

        def outer(combine: Any, *along: Array) -> Any:
            return reduce(lambda a, b: combine(a[:, :, None], b[:, None]).reshape(len(x), -1), along)

        number = outer(np.add, *(node[k] * self.counts[k + 1 :].prod() for k in self.axes))
        gradient = [outer(np.multiply, *N[:k], dN[k], *N[k + 1 :]) for k in self.axes]
        from_here = [outer(np.multiply, *(r[c] ** (c == k) for c in self.axes)) for k in self.axes]
        return number, outer(np.multiply, *N), np.stack(gradient, axis=-1), np.stack(from_here, axis=-1)

    def along(self, k: int, s: Array) -> tuple[Any, ...]:
        """The same along axis k at distances s (P,) from its lower end in cells, by the recursion of Cox and de Boor."""
        p, cells, none = self.degree, self.cells[k], np.zeros((len(s), 1))
        knots = np.arange(-p, cells + p + 1.0)
        knots = knots if self.joined[k] else np.clip(knots, 0, cells)
        cell, N = np.minimum(s.astype(int), cells - 1)[:, None], none + 1
        xi = np.clip(
            s[:, None] - cell, 1e-30, 1 - 2**-53
        )  # on a cell edge a function with a slope keeps a mass, and hence a velocity
        for q in range(1, p + 1):
            left, right = (knots[cell + first + np.arange(q)] - cell for first in (p - q + 1, p + 1))
            share = N / (right - left)
            N = np.hstack([none, (xi - left) * share]) + np.hstack([(right - xi) * share, none])
            dN = q / self.h * (np.hstack([none, share]) - np.hstack([share, none]))
        node = cell + np.arange(p + 1)
        places = np.lib.stride_tricks.sliding_window_view(knots[1:-1], p).mean(axis=1)  # with them sum_I x_I N_I(x) = x
        return node % self.counts[k], N, dN, self.h * (places[node] - cell - xi)

    def integrals(self, k: int, lower: float, upper: float) -> Array:
        """Integrals [m] of the functions of axis k between two places [m], by two Gauss points in each cell."""
        ends = np.clip(self.lower[k] + self.h * np.arange(self.cells[k] + 1), lower, upper)
        points = [(ends[1:] + ends[:-1] + sign * np.diff(ends) / np.sqrt(3)) / 2 for sign in (-1, 1)]
        node, N, _, _ = self.along(k, (np.concatenate(points) - self.lower[k]) / self.h)
        return self.sum(node, np.tile(np.diff(ends) / 2, 2)[:, None] * N)[: self.counts[k]]
