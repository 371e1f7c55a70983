"""Any solver on any problem: what it claims of itself is what must hold, limited by the smoothness of the exact solution."""

import pickle
import tempfile
from collections.abc import Sequence
from pathlib import Path

from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import Level, SeriesId, evidence_of
from mpmverify.criteria.expectations import expectations
from mpmverify.dataset.files import Results
from mpmverify.errors import UsageError
from mpmverify.execution.evaluation import Task
from mpmverify.execution.processes import inline, over_processes
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.judging import judge
from mpmverify.solution import Solver
from mpmverify.study import Case, Refinement, Study


def verify(
    solver: Solver,
    study: Study,
    case: str = "",
    *,
    refinement: Refinement | None = None,
    criteria: Sequence[Criterion] | None = None,
    tier: str = "quick",
    timeout: float | None = None,
) -> tuple[Finding, ...]:
    """Solve one case of a study with a solver of any origin, and judge it; nothing is stored and nothing is read back.

    Parameters
    ----------
    solver : Solver
        Any object that keeps the protocol.
    study : Study
    case : str
        May be left out where the study has one case.
    refinement : Refinement, optional
        By default the first ladder of the case; where `criteria` is absent, the first in h at one Courant number, for such is
        the ladder of which a solver declares its orders.
    criteria : sequence of Criterion, optional
        By default what follows from the solver's declarations; see `expectations`.
    tier : str
        "quick" or "full".
    timeout : float, optional
        Limit for one run [s]. The runs are then solved in a worker process, which must be able to import the solver and sees nothing
        that this process has patched; by default they are solved in this process, without a limit.

    Returns
    -------
    tuple of Finding
        One for each criterion, and at least one.

    Raises
    ------
    UsageError
        If nothing could be judged: the solver lacks a part of the protocol or cannot take the problem, the case is unknown, no
        criterion is given or follows from what it declares, or no ladder shows the orders that it declares.
    """
    if isinstance(solver, type):
        raise UsageError(f"{solver.__name__} is a class and no solver: give an instance of it")
    missing = [part for part in ("name", "orders", "conserves", "solve") if not hasattr(solver, part)]
    if missing:
        raise UsageError(f"{type(solver).__name__} is no solver: it lacks {', '.join(missing)}")
    chosen = _case(study, case)
    demanded = expectations(solver, chosen.problem) if criteria is None else tuple(criteria)
    ladders = [series.refinement for series in chosen.series] if refinement is None else [refinement]
    refinement = _in_h(chosen, ladders) if criteria is None else ladders[0]
    if not demanded:
        raise UsageError(f"no criterion is given for solver {solver.name!r} on {chosen.problem.problem.name!r}: give one")
    with tempfile.TemporaryDirectory(prefix="mpmverify-") as folder:
        tasks = [
            Task(
                results=Path(folder),
                study=study.name,
                index=index,
                case=chosen.name,
                refinement=refinement.label,
                problem=chosen.problem,
                solver=solver,
                discretisation=discretisation,
                criteria=demanded,
                key=f"{index}",
                reuse=False,
            )
            for index, discretisation in enumerate(refinement.tier(tier))
        ]
        levels = _levels(tasks, timeout)
    series = SeriesId(chosen.name, solver.name, refinement.label)
    return judge(study.name, {series: demanded}, {series: evidence_of(levels)}).findings


def _case(study: Study, name: str) -> Case:
    cases = {case.name: case for case in study.cases}
    if not name and len(cases) == 1:
        return study.cases[0]
    if name not in cases:
        which = f"has no case {name!r}" if name else "has several cases"
        raise UsageError(f"study {study.name!r} {which}: choose from {', '.join(cases)}")
    return cases[name]


def _in_h(case: Case, ladders: Sequence[Refinement]) -> Refinement:
    """First of some ladders in h whose dt is proportional to h: others show other orders than a solver declares."""
    for ladder in ladders:
        if len({(level.courant, level.ppc) for level in ladder.levels}) == 1:
            return ladder
    raise UsageError(
        f"{ladders[0].label!r} on case {case.name!r} is no ladder in h at one Courant number, of which a solver declares its "
        "orders: give such a one by refinement=, or criteria= for this one"
    )


def _levels(tasks: Sequence[Task], timeout: float | None) -> list[Level]:
    Results(tasks[0].results).create()
    if timeout is None:
        return [evaluated.level for _, evaluated in inline(tasks)]
    try:
        pickle.dumps(tasks)
    except Exception as error:  # pickle raises what it likes
        solver = tasks[0].solver.name
        raise UsageError(
            f"solver {solver!r} cannot travel to a worker process ({error}): define it in a module, or give no timeout"
        ) from error
    found = {task.index: evaluated.level for task, evaluated in over_processes(tasks, 1, timeout)}
    return [found[index] for index in range(len(tasks))]
