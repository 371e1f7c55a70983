"""Mistakes that a solution beside the exact one shows, each with its most likely cause."""

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.energies import kinetic_apart
from mpmverify.criteria.histories import moved_momentum
from mpmverify.exact import VerificationProblem
from mpmverify.problem import Array, Discretisation, LinearElastic, Periodic, components
from mpmverify.problem.quantities import multiplicity
from mpmverify.solution import Solution

ALIKE = 0.99
"""Correlation from which two fields count as multiples of each other."""
SAME = 0.03
"""Relative difference up to which two factors count as the same."""
SHIFTS = (-1.0, -0.5, 0.5, 1.0)
"""Shifts in time that are looked for, in steps."""


@dataclass(frozen=True)
class Remark:
    """Something that is wrong.

    Parameters
    ----------
    what, cause : str
        What was found, and its most likely cause, as sentences.
    crashed : bool
        Whether a run failed, so that nothing could be compared.
    """

    what: str
    cause: str = ""
    crashed: bool = False


@dataclass(frozen=True)
class Run:
    """One solution beside the exact one."""

    problem: VerificationProblem
    level: Discretisation
    solution: Solution
    conserves: Collection[str]

    @property
    def expected(self) -> dict[str, Array]:
        """Exact values (T, P, components) of each field that both have."""
        found = self.solution
        return {q: exact(found.reference, found.time) for q, exact in self.problem.exact.fields.items() if q in found.fields}

    def product(self, quantity: str, one: Array, other: Array) -> float:
        """Inner product of two fields over the run."""
        entries = multiplicity(quantity, self.solution.reference.shape[1])
        return float(np.einsum("tp,tpc,tpc,c->", self.solution.weight, one, other, entries))

    def likeness(self, quantity: str, one: Array, other: Array) -> float:
        """Correlation of two fields over the run; 0 where one is zero."""
        sizes = self.product(quantity, one, one) * self.product(quantity, other, other)
        return self.product(quantity, one, other) / math.sqrt(sizes) if sizes > 0 else 0.0


Found = Iterator[tuple[object, Remark]]
"""Remarks on one run, each with a value by which the same remark on another level is known."""


def same(one: float, other: float) -> bool:
    """Whether two factors are the same to `SAME`."""
    return abs(one - other) <= SAME * abs(other)


def _still(run: Run) -> Found:
    """Fields that do not change in time, or are zero."""
    for quantity, expected in run.expected.items():
        found = run.solution.fields[quantity]
        changes = np.ptp(expected, axis=0).max() > 0.1 * np.abs(expected).max()
        if changes and not found.any():
            yield (quantity, "zero"), Remark(f"the {quantity} is zero at all times", "it is never updated, or never stored")
        elif changes and np.ptp(found, axis=0).max() <= 1e-12 * np.abs(found).max():
            yield (
                (quantity, "still"),
                Remark(
                    f"the {quantity} is the same at all output times", "every output refers to one array: store a copy of it"
                ),
            )


def _factors(run: Run) -> Found:
    """Fields that are a multiple of the exact ones."""
    for quantity, expected in run.expected.items():
        found = run.solution.fields[quantity]
        if abs(run.likeness(quantity, found, expected)) > ALIKE:
            ratio = run.product(quantity, found, expected) / run.product(quantity, expected, expected)
            if abs(ratio - 1) > 0.1:
                cause = _cause_of_factor(run, quantity, ratio)
                known = cause or (ratio > 0, round(math.log(abs(ratio)) / SAME))
                remark = Remark(f"the {quantity} is {ratio:.4g} times the exact one", cause or "a constant factor")
                yield (quantity, known), remark


def _cause_of_factor(run: Run, quantity: str, ratio: float) -> str:
    level, problem = run.level, run.problem.problem
    known: list[tuple[float, str]] = [
        (-1.0, "stress is positive in tension" if quantity == "stress" else "the sign"),
        (2.0, "it is counted twice"),
        (0.5, "half of it is missing, as after a half step"),
        (level.h, "it is multiplied by h: a slope per cell, not per metre"),
        (1 / level.h, "it is divided by h"),
        (run.solution.dt, "it is an increment, not a rate"),
        (1 / run.solution.dt, "it is divided by dt"),
        *((10.0**power, "units: take metres, seconds, kilograms and pascals") for power in (3, 6, 9, -3, -6, -9)),
    ]
    law = problem.material
    if isinstance(law, LinearElastic):
        p_wave = law.lame_lambda + 2 * law.shear_modulus
        known += [
            (law.density, "it is multiplied by the density"),
            (1 / law.density, "it is divided by the density"),
            (law.youngs_modulus / p_wave, "Young's modulus stands for that of P waves, lambda + 2 mu"),
            (law.youngs_modulus, "it is multiplied by Young's modulus"),
            (1 / law.youngs_modulus, "it is divided by Young's modulus"),
        ]
    return next((why for factor, why in known if same(ratio, factor) and not same(factor, 1.0)), "")


def _exchanged(run: Run) -> Found:
    """Components in another order, and transposed gradients."""
    dimension = run.problem.problem.dimension
    for quantity, expected in run.expected.items():
        found, names = run.solution.fields[quantity], components(quantity, dimension)
        right = run.likeness(quantity, found, expected)
        if len(names) == 1 or right > ALIKE:
            continue
        for i, j in combinations(range(len(names)), 2):
            order = list(range(len(names)))
            order[i], order[j] = j, i
            if run.likeness(quantity, found[..., order], expected) > max(ALIKE, right + 0.05):
                yield (
                    (quantity, i, j),
                    Remark(f"{names[i]} and {names[j]} are exchanged", f"the components are {', '.join(names)}"),
                )
        if quantity == "displacement_gradient":
            turned = found.reshape(*found.shape[:2], dimension, dimension).swapaxes(2, 3).reshape(found.shape)
            if dimension > 2 and run.likeness(quantity, turned, expected) > max(ALIKE, right + 0.05):
                yield (quantity, "transposed"), Remark("the displacement gradient is transposed", "it is du_i/dX_j, row by row")


def _shifted(run: Run) -> Found:
    """Fields at another time than they say."""
    solution, dt = run.solution, run.solution.dt
    inside = (solution.time > dt) & (solution.time < solution.time[-1] - dt)
    weight = solution.weight[inside, :, None]
    if not inside.any():
        return
    for quantity in run.expected:
        exact = run.problem.exact.fields[quantity]
        error = solution.fields[quantity][inside] - exact(solution.reference, solution.time[inside])
        size = float(np.sum(weight * error**2))
        for steps in SHIFTS:
            moved = exact(solution.reference, solution.time[inside] + steps * dt)
            rest = float(np.sum(weight * (solution.fields[quantity][inside] - moved) ** 2))
            if size > 0 and rest < size / 25:
                when = f"{'half a step' if abs(steps) < 1 else 'a step'} {'later' if steps > 0 else 'earlier'}"
                yield (
                    (quantity, steps),
                    Remark(
                        f"the {quantity} fits the exact one {when}",
                        "leapfrog velocities live half a step from the positions: return v + a dt/2 at the output"
                        if quantity == "velocity" and abs(steps) < 1
                        else "the output has the time of another step than its fields; the first one is the initial state",
                    ),
                )


def _moved(run: Run) -> Found:
    """Positions that are not reference positions and displacements."""
    solution, problem = run.solution, run.problem.problem
    if "displacement" in solution.fields and Periodic() not in problem.boundary.values():
        apart = np.abs(solution.position - solution.reference - solution.fields["displacement"]).max()
        if apart > 1e-6 * max(problem.lengths):
            u = np.abs(solution.fields["displacement"]).max()
            cause = "the positions are those of the start" if not np.ptp(solution.position, axis=0).any() and u else ""
            yield "moved", Remark(f"position - reference differs from the displacement by up to {apart:.3g} m", cause)


def _momentum(run: Run) -> Found:
    """Momenta that do not follow the impulse, or are not those of the points."""
    solution, problem = run.solution, run.problem.problem
    histories, dimension, law = solution.histories, problem.dimension, problem.material
    if not isinstance(law, LinearElastic) or "momentum" not in run.conserves:
        return
    moved = moved_momentum(solution, law.density)
    for k, (name, impulse) in enumerate(zip(components("momentum", dimension), components("impulse", dimension), strict=True)):
        if not {name, impulse} <= histories.keys():
            continue
        p, given = histories[name], histories[impulse]
        if "velocity" in solution.fields:
            sums = solution.fields["velocity"][..., k] @ (law.density * solution.weight[0])
            if np.max(np.abs(sums - np.interp(solution.time, histories["time"], p))) > 0.1 * moved:
                remark = Remark(f"the history {name} is not the sum of m v over the points", "sum density x volume x velocity")
                yield (name, "sum"), remark
        change = p - p[0]
        apart = float(np.max(np.abs(change - given)))
        if apart > 1e-6 * max(moved, float(np.max(np.abs(change))), float(np.max(np.abs(given)))):
            opposite = np.max(np.abs(change + given)) < 0.01 * apart
            yield (
                (name, "impulse"),
                Remark(
                    f"{name} does not follow the impulse: p(t) - p(0) differs from it by up to {apart:.3g}, where {moved:.3g} moves",
                    "the impulse has the other sign"
                    if opposite
                    else "the impulse sums dt x all external forces of the scheme: tractions, reactions, body force",
                ),
            )


def _energy(run: Run) -> Found:
    """Kinetic energies that are not those of the points."""
    if "energy" in run.conserves:
        for apart in kinetic_apart(run.solution, Setting(run.problem, run.level)).values():
            what = f"the history kinetic_energy differs from that of the points by up to {apart:.2g} of what is exchanged"
            yield "energy", Remark(what, "sum density x volume x |velocity|^2 / 2, after every step")


TESTS: tuple[Callable[[Run], Found], ...] = (_still, _factors, _exchanged, _shifted, _moved, _momentum, _energy)
