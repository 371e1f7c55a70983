"""A first look at a solver, in its author's words: what is wrong with its solutions before any order is measured, and the likely cause.

Every test here compares two levels of one case with the exact solution, and remarks on what both show: an error of discretisation changes
with the level, a mistake does not.
"""

import math
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from mpmverify.criteria.histories import moved_momentum
from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.execution.contract import breach, confirmed, malformed
from mpmverify.execution.keys import in_library
from mpmverify.problem import UNITS, Array, Discretisation, LinearElastic, Periodic, Transport, components
from mpmverify.problem.quantities import multiplicity
from mpmverify.solution import RunError, Solution, Solver
from mpmverify.study import Case

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


def check(solver: Solver, case: Case) -> list[Remark]:
    """Solve the two coarsest levels of a case, and say what is wrong with the solutions.

    Parameters
    ----------
    solver : Solver
    case : Case

    Returns
    -------
    list of Remark
        Empty when nothing was found; an order can still be wrong.

    Raises
    ------
    UsageError
        If the solver refuses the problem, or the case cannot judge what it declares.
    """
    if remarks := list(_declared(solver)):
        return remarks
    case.with_solver(solver)  # raises where an order cannot be judged
    runs: list[Run] = []
    levels = case.ladder_in_h().levels[:2]
    if len(levels) < 2:
        raise UsageError(f"case {case.name!r} has one level: choose another, since an error of discretisation is told by two")
    for level in levels:
        run, remark = _solved(solver, case.problem, level)
        if remark or run is None:
            return [remark] if remark else []
        runs.append(run)
    remarks = list(_missing(solver, runs[0]))
    for test in TESTS:
        on_each = [dict(test(run)) for run in runs]
        remarks += [remark for key, remark in on_each[-1].items() if all(key in found for found in on_each)]
    if not remarks:
        remarks += _not_refined(runs)
    return remarks


def _declared(solver: Solver) -> Iterator[Remark]:
    orders, conserves = solver.orders, solver.conserves
    if not (isinstance(orders, Mapping) and orders.keys() <= UNITS.keys()):
        yield Remark(
            f"orders is {orders!r}", f"it is a mapping from some of {', '.join(UNITS)} to orders, such as {{'displacement': 2}}"
        )
    if isinstance(conserves, str) or not set(conserves) <= {"mass", "momentum"}:
        yield Remark(f"conserves is {conserves!r}", "it is a set of 'mass' and 'momentum', or frozenset()")


def _solved(solver: Solver, problem: VerificationProblem, level: Discretisation) -> tuple[Run | None, Remark | None]:
    at = f"at h = {level.h:.4g}"
    try:
        solution = solver.solve(problem.problem, level)
    except RunError as error:
        return None, Remark(f"the run {at} failed: {error.outcome.detail}", error.outcome.advice, crashed=True)
    except MpmverifyError:
        raise
    except (Exception, SystemExit) as error:  # a solver under test may raise anything
        return None, Remark(f"the run {at} raised\n{_own_frames(error)}", crashed=True)
    if wrong := malformed(solution, problem.problem.dimension):
        return None, Remark(
            f"the solution {at} is no `Solution`: {wrong}", 'help("mpmverify.solution") has every array with its shape'
        )
    outcome = confirmed(solution)
    if not outcome.completed:
        return None, Remark(f"the run {at} ended early: {outcome}", crashed=True)
    run = Run(problem, level, solution, solver.conserves)
    if wrong := breach(solution, problem.problem, level):
        return None, Remark(f"the solution {at} cannot be judged: {wrong}", _cause_of_weights(run))
    return run, None


def _own_frames(error: BaseException) -> str:
    """Traceback of the author's own lines."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__)[1:] if not in_library(Path(frame.filename))]
    return "".join(traceback.format_list(frames)) + "".join(traceback.format_exception_only(error)).strip()


def _cause_of_weights(run: Run) -> str:
    measure, problem, level = run.problem.problem.measure, run.problem.problem, run.level
    ratio = float(run.solution.weight[0].sum()) / measure
    box = math.prod(problem.lengths) / measure
    known = {
        level.ppc**problem.dimension: "a weight is the volume of a particle, not of its cell",
        1 / level.h**problem.dimension: "a weight is a volume, not a number of cells",
        problem.material.density if isinstance(problem.material, LinearElastic) else 0.0: "a weight is a volume, not a mass",
        box: "the weights fill the box, not the body",
    }
    return next((why for factor, why in known.items() if factor > 0 and _same(ratio, factor) and not _same(factor, 1.0)), "")


def _same(one: float, other: float) -> bool:
    return abs(one - other) <= SAME * abs(other)


def _missing(solver: Solver, run: Run) -> Iterator[Remark]:
    for quantity in solver.orders:
        if quantity in run.problem.exact.fields and quantity not in run.solution.fields:
            yield Remark(f"it declares an order of the {quantity} and returns none", "return the field, or leave its order out")
    dimension = run.problem.problem.dimension
    needed = {"mass": ("mass",), "momentum": (*components("momentum", dimension), *components("impulse", dimension))}
    for invariant in solver.conserves:
        if invariant == "momentum" and isinstance(run.problem.problem.material, Transport):
            continue
        if lacks := [name for name in needed[invariant] if name not in run.solution.histories]:
            yield Remark(
                f"it declares that it conserves {invariant}, and lacks the history {lacks[0]}",
                "return it, or leave the promise out",
            )


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
    return next((why for factor, why in known if _same(ratio, factor) and not _same(factor, 1.0)), "")


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


TESTS: tuple[Callable[[Run], Found], ...] = (_still, _factors, _exchanged, _shifted, _moved, _momentum)


def _not_refined(runs: list[Run]) -> Iterator[Remark]:
    """Errors that do not depend on the level."""
    for quantity in runs[0].expected:
        sizes = []
        for run in runs:
            expected = run.expected[quantity]
            error = run.solution.fields[quantity] - expected
            sizes.append(
                math.sqrt(run.product(quantity, error, error) / max(run.product(quantity, expected, expected), 1e-300))
            )
        if min(sizes) > 0.01 and abs(sizes[0] - sizes[1]) < 1e-3 * sizes[0]:
            yield Remark(
                f"the error of the {quantity}, {sizes[1]:.2g} of the solution, is the same on both levels",
                "the solver does not take h or dt from the level, or what it solves is another problem",
            )
