"""Cases of a study that a solver does not take."""

import dataclasses
from collections.abc import Mapping

from mpmverify.errors import UsageError
from mpmverify.execution import processes
from mpmverify.execution.runner import Plan, tasks_of
from mpmverify.solution import Solver, Status
from mpmverify.study import Case, Series, Study


def without_refused(study: Study, solver: Solver, plan: Plan) -> tuple[Study | None, Mapping[str, str]]:
    """Solve the coarsest level of each case, and leave out the cases that the solver refuses; of one that hangs, finer levels.

    Parameters
    ----------
    study : Study
    solver : Solver
        One of its solvers.
    plan : Plan
        Finished runs are kept in its results folder for the run of the study.

    Returns
    -------
    (Study or None, mapping of str to str)
        The study with the other cases, None if there is none; and the reason by case.

    Raises
    ------
    UsageError
        If a run has no key, or cannot be sent to a worker process.
    ResultsError
        If the results folder cannot be written.
    """
    plan.results.create()
    refused: dict[str, str] = {}
    kept = []
    for case in study.in_tier(plan.tier).cases:
        tasks = tasks_of(dataclasses.replace(study, cases=(case,)), plan)
        coarsest = max((task for task in tasks if task.solver == solver), key=lambda task: task.discretisation.h)
        try:
            ((_, evaluated),) = processes.over_processes([coarsest], 1, plan.timeout)
            hangs = evaluated.level.outcome.startswith(Status.TIMED_OUT)
            kept.append(_coarsest(case, solver) if hangs else case)
        except UsageError as error:
            refused[case.name] = str(error)
    return (dataclasses.replace(study, cases=tuple(kept)) if kept else None), refused


def _coarsest(case: Case, solver: Solver) -> Case:
    """Return a case with one level for a solver: where that one hangs, finer ones would."""

    def cut(series: Series) -> Series:
        level = max(series.refinement.levels, key=lambda level: level.h)
        ladder = dataclasses.replace(series.refinement, levels=(level,), quick=1)
        return dataclasses.replace(series, refinement=ladder) if series.solver == solver else series

    return dataclasses.replace(case, series=tuple(map(cut, case.series)))
