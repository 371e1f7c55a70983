"""One solver of any origin on one case of a study, judged by what it declares of itself or by given criteria."""

import dataclasses
import pickle
from collections.abc import Sequence

from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import Level, SeriesId, evidence_of
from mpmverify.criteria.expectations import expectations
from mpmverify.errors import UsageError
from mpmverify.execution.contract import lacking
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
        Any object with the attributes of the protocol `Solver`.
    study : Study
    case : str
        May be left out when the study has one case.
    refinement : Refinement, optional
        By default the ladder that the case names, or else the first of its series; without `criteria`, the first ladder in h at one
        Courant number, since declared orders hold on such a ladder.
    criteria : sequence of Criterion, optional
        By default what follows from the solver's declarations, judged in the norm of the case; see `expectations`.
    tier : str
        "quick" or "full".
    timeout : float, optional
        Limit for one run [s]. Runs are then solved in a worker process, which imports the solver anew; monkeypatches of this process
        have no effect there. By default they are solved in this process, without a limit.

    Returns
    -------
    tuple of Finding
        One for each criterion, and at least one.

    Raises
    ------
    UsageError
        If nothing could be judged: the solver lacks an attribute or cannot take the problem, the case is unknown, there is no
        criterion, or no ladder shows the declared orders.
    """
    if isinstance(solver, type):
        raise UsageError(f"{solver.__name__} is a class: give an instance of it")
    if missing := lacking(solver):
        raise UsageError(f"{type(solver).__name__} is not a solver: it lacks {', '.join(missing)}")
    chosen = _case(study, case)
    demanded = expectations(solver, chosen.problem, chosen.norm, chosen.margin) if criteria is None else tuple(criteria)
    if refinement:
        chosen = dataclasses.replace(chosen, ladder=refinement)
    if criteria is None:
        chosen.converging()
    refinement = chosen.ladder_in_h() if criteria is None else chosen.ladder or chosen.series[0].refinement
    if not demanded:
        raise UsageError(f"no criterion is given for solver {solver.name!r} on {chosen.problem.problem.name!r}: give one")
    tasks = [
        Task(
            results=None,
            study=study.name,
            index=index,
            case=chosen.name,
            refinement=refinement.label,
            problem=chosen.problem,
            solver=solver,
            discretisation=discretisation,
            criteria=demanded,
            key="",
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


def _levels(tasks: Sequence[Task], timeout: float | None) -> list[Level]:
    if timeout is None:
        return [evaluated.level for _, evaluated in inline(tasks)]
    try:
        pickle.dumps(tasks)
    except Exception as error:  # pickle may raise anything
        solver = tasks[0].solver.name
        raise UsageError(
            f"solver {solver!r} cannot be sent to a worker process ({error}): define it in a module, or give no timeout"
        ) from error
    found = {task.index: evaluated.level for task, evaluated in over_processes(tasks, 1, timeout)}
    return [found[index] for index in range(len(tasks))]
