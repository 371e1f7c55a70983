"""A first look at a solver, in its author's words: what is wrong with its solutions before any order is measured, and the likely cause.

Every test here compares two levels of one case with the exact solution, and remarks on what both show: an error of discretisation changes
with the level, a mistake does not.
"""

import math
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from mpmverify.adapters.mistakes import TESTS, Remark, Run, same
from mpmverify.criteria.expectations import INVARIANTS
from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.execution.contract import breach, confirmed, malformed
from mpmverify.execution.keys import in_library
from mpmverify.problem import UNITS, Discretisation, LinearElastic, Transport, components
from mpmverify.solution import RunError, Solver
from mpmverify.study import Case

LOST = (
    ", or it computes in single precision, in which positions and strains lose so small a motion, and more of it the more steps there are: "
    "compute in double precision, or choose a case that moves farther"
)


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
    if isinstance(conserves, str) or not set(conserves) <= set(INVARIANTS):
        yield Remark(f"conserves is {conserves!r}", f"it is a set of some of {', '.join(INVARIANTS)}, or frozenset()")


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
    return next((why for factor, why in known.items() if factor > 0 and same(ratio, factor) and not same(factor, 1.0)), "")


def _missing(solver: Solver, run: Run) -> Iterator[Remark]:
    for quantity in solver.orders:
        if quantity in run.problem.exact.fields and quantity not in run.solution.fields:
            yield Remark(f"it declares an order of the {quantity} and returns none", "return the field, or leave its order out")
    dimension = run.problem.problem.dimension
    needed = {
        "mass": ("mass",),
        "momentum": (*components("momentum", dimension), *components("impulse", dimension)),
        "energy": ("kinetic_energy", "strain_energy", "external_work"),
    }
    for invariant in solver.conserves:
        if invariant != "mass" and isinstance(run.problem.problem.material, Transport):
            continue
        if lacks := [name for name in needed[invariant] if name not in run.solution.histories]:
            yield Remark(
                f"it declares that it conserves {invariant}, and lacks the history {lacks[0]}",
                "return it, or leave the promise out",
            )


def _not_refined(runs: list[Run]) -> Iterator[Remark]:
    """Errors that do not fall from level to level."""
    for quantity in runs[0].expected:
        sizes = []
        for run in runs:
            expected = run.expected[quantity]
            error = run.solution.fields[quantity] - expected
            sizes.append(
                math.sqrt(run.product(quantity, error, error) / max(run.product(quantity, expected, expected), 1e-300))
            )
        if min(sizes) > 0.05 and sizes[1] > 0.95 * sizes[0]:
            same_on_both = abs(sizes[0] - sizes[1]) < 1e-3 * sizes[0]
            yield Remark(
                f"the error of the {quantity} does not fall: it is {sizes[0]:.2g} of the solution, and {sizes[1]:.2g} on the finer level",
                "the solver does not take h or dt from the level"
                if same_on_both
                else "it solves another problem (conditions on the faces, body force, material, initial state), or the scheme has this limit"
                + (LOST if sizes[1] > sizes[0] and _moves_little(runs[1]) else ""),
            )


def _moves_little(run: Run) -> bool:
    """Whether the motion is so small beside the positions that one of single precision rounds off by more than a thousandth of it."""
    exact = run.problem.exact.fields.get("displacement")
    if exact is None:
        return False
    moved = np.max(np.abs(exact(run.solution.reference, run.solution.time)))
    return bool(1e-3 * moved < np.finfo(np.float32).eps * np.max(np.abs(run.solution.reference)))
