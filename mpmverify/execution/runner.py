"""Studies run from their declaration to their judged file; finished runs are read back."""

import math
import operator
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from mpmverify.criteria import check_storable
from mpmverify.criteria.evidence import evidence_by_series
from mpmverify.dataset import provenance
from mpmverify.dataset.files import Results, make_way
from mpmverify.dataset.study import write_study
from mpmverify.dataset.tree import Group
from mpmverify.dataset.verdicts import read_verdicts, write_verdicts
from mpmverify.execution import processes
from mpmverify.execution.dask import Distributed
from mpmverify.execution.diagnosis import problem_digest
from mpmverify.execution.evaluation import Evaluated, Task
from mpmverify.execution.keys import digest, file_digest
from mpmverify.execution.run_keys import run_keys
from mpmverify.execution.workers import Crew, Failure, Worker
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.judging import judge
from mpmverify.problem import Discretisation, Problem
from mpmverify.study import Study

FEW = 50
"""Number of finished runs up to which this process reads them back: workers take longer to start."""
SHOWN_POINTS = 160
"""Largest number of cells times particles per cell of the level that the pages show."""
JUDGING = ("mpmverify.execution.evaluation", "mpmverify.judgement.judging", "mpmverify.dataset.study")
"""Modules that measure, judge and store."""


@dataclass(frozen=True)
class StudyRun:
    """A study that was run and judged.

    Parameters
    ----------
    study : str
        Its name.
    findings : tuple of Finding
    solved, reused : int
        How many runs were solved, and how many were read back.
    seconds : float
        Time of its runs, compilation included and summed over the processes, and of its judging, without that of its page [s]; 0 when
        all of it was at hand.
    shown : object
        What `show` made of it, see `run`; None when all of it was at hand.
    """

    study: str
    findings: tuple[Finding, ...]
    solved: int
    reused: int
    seconds: float
    shown: Any = None


Show = Callable[[Results, str, Mapping[str, Group]], Any]


def nothing(results: Results, study: str, groups: Mapping[str, Group]) -> None:
    """Show nothing of a study."""


@dataclass(frozen=True)
class Plan:
    """How studies are run.

    Parameters
    ----------
    results : Results
    baseline : Baseline
    tier : str
        "quick" or "full".
    jobs : int
        Worker processes; 0 evaluates in this process.
    timeout : float
        Limit for one run [s].
    reuse : bool
        Whether finished runs are read back.
    scheduler : str
        Address of a dask.distributed scheduler, or "".
    """

    results: Results
    baseline: Baseline
    tier: str = "quick"
    jobs: int = 1
    timeout: float = 600.0
    reuse: bool = True
    scheduler: str = ""


def tasks_of(study: Study, plan: Plan) -> list[Task]:
    """All runs of a study."""
    table: list[Task] = []
    for case, series in study.series():
        levels = series.refinement.tier(plan.tier)
        # The pages show the finest level with few points, in the full tier the same one: its run is at hand.
        common = series.refinement.tier("quick") or levels
        fitting = [k for k, level in enumerate(common) if _points(case.problem.problem, level) <= SHOWN_POINTS]
        shown = max(fitting, default=0)
        keys = run_keys(case.problem, series.solver, levels, series.criteria)
        for k, level in enumerate(levels):
            task = Task(
                results=plan.results.path,
                study=study.name,
                index=len(table),
                case=case.name,
                refinement=series.refinement.label,
                problem=case.problem,
                solver=series.solver,
                discretisation=level,
                criteria=series.criteria,
                key=keys[k],
                shown=k == shown,
                reuse=plan.reuse,
            )
            table.append(task)
    return table


def run(
    studies: Sequence[Study],
    plan: Plan,
    progress: Callable[[str, int, int], None] = lambda *_: None,
    show: Show = nothing,
) -> Iterator[StudyRun]:
    """Run studies; each one is judged and written as soon as its last run is finished.

    Parameters
    ----------
    studies : sequence of Study
    plan : Plan
    progress : callable
        Called with (study, runs done, runs in all) after every run.
    show : callable
        Called with the results folder, the name of a study and the groups of its file when it is judged, in the process that judged it.
        It must travel between processes, and so must what it returns.

    Raises
    ------
    UsageError, ResultsError
        On misuse, or when a file of the results folder is foreign or cannot be written.
    """
    studies, started = [study.in_tier(plan.tier) for study in studies], provenance.now()
    for study in studies:
        check_storable(study.name, study.criteria())
    plan.results.create()
    stored = read_verdicts(plan.results)
    work: dict[str, list[Task]] = {}
    digests: dict[str, str] = {}
    for study in studies:
        tasks = tasks_of(study, plan)
        digests[study.name] = inputs = _inputs(study, plan, tasks)
        entry = stored.get(study.name)
        path = plan.results.study(study.name)
        if plan.reuse and entry and entry.made_from(inputs, path):
            yield StudyRun(study.name, entry.findings, 0, len(tasks), 0.0)
        else:
            make_way(path, "study")  # a foreign file is named before anything is solved
            work[study.name] = tasks
    by_name = {study.name: study for study in studies}
    done: dict[str, dict[int, Evaluated]] = {name: {} for name in work}

    todo = [task for tasks in work.values() for task in tasks]
    solved = all(_at_hand(task) for task in todo)
    here = plan.jobs == 0 or (solved and len(todo) <= FEW)

    def judgements() -> Iterator["tuple[partial[StudyRun] | None, bool]"]:
        left = len(todo)
        for task, evaluated in _evaluate(todo, plan, here=here):
            finished, tasks, left = done[task.study], work[task.study], left - 1
            finished[task.index] = evaluated
            progress(task.study, len(finished), len(tasks))
            complete = len(finished) == len(tasks)
            results = [finished[k] for k in range(len(tasks))] if complete else []
            judged = partial(_judged, by_name[task.study], plan, tasks, results, started, digests[task.study], show=show)
            yield judged if complete else None, left > 0

    if here or plan.scheduler:
        yield from (judged() for judged, _ in judgements() if judged)
    else:
        yield from _beside(judgements())


def _beside(calls: "Iterable[tuple[partial[StudyRun] | None, bool]]") -> Iterator[StudyRun]:
    """Make calls in a process of its own while runs go on, and the rest here.

    What stops the runs does not stop these calls, which show nothing then.

    A thread would not do: the netCDF library takes one at a time, and what is read closes its file wherever it is collected.

    Parameters
    ----------
    calls : iterable of (partial or None, bool)
        After every run: what judges its study, if the run was its last one; and whether others go on.
    """
    waiting: deque[partial[StudyRun]] = deque()
    judge: Worker[partial[StudyRun], StudyRun | None] = Worker(Crew(operator.call, _undone, math.inf))
    try:
        for call, going_on in calls:
            if call:
                waiting.append(call)
            while judge.task and judge.connection.poll():
                if finished := judge.receive():
                    yield finished[1] or finished[0]()
            if waiting and not judge.task and going_on:  # the last study is not worth another process
                judge.start(waiting[0])
                waiting.popleft()
        if call := judge.task:
            yield judge.result() or call()
        while waiting:
            yield waiting.popleft()()
    except BaseException:
        if call := judge.task:
            _ = judge.result() or call(show=nothing)
        for call in waiting:
            call(show=nothing)
        raise
    finally:
        judge.stop()


def _undone(call: "partial[StudyRun]", failure: Failure, reason: str) -> None:
    """Result of a call that killed its process, or raised: it is made here, where the error is seen."""


def _at_hand(task: Task) -> bool:
    return task.reuse and task.results is not None and Results(task.results).run(task.key).exists()


def _evaluate(tasks: list[Task], plan: Plan, *, here: bool) -> Iterator[tuple[Task, Evaluated]]:
    cost = {id(task): 0.0 if _at_hand(task) else _cost(task) for task in tasks}
    # Study by study, the cheapest first: its verdicts are there soon. In each the longest run first: no process waits for it at the end.
    total = {task.study: 0.0 for task in tasks}
    for task in tasks:
        total[task.study] += cost[id(task)]
    rank = {study: k for k, study in enumerate(sorted(total, key=total.__getitem__))}
    ordered = sorted(tasks, key=lambda task: (rank[task.study], -cost[id(task)]))
    if plan.scheduler:
        yield from Distributed(plan.scheduler, plan.timeout).evaluate(ordered)
    elif here:
        yield from processes.inline(ordered)
    else:
        yield from processes.over_processes(ordered, plan.jobs, plan.timeout)


def _cost(task: Task) -> float:
    problem, level = task.problem.problem, task.discretisation
    return level.time_steps(problem)[0] * _points(problem, level)


def _points(problem: Problem, level: Discretisation) -> int:
    """Cells times particles per cell."""
    return math.prod(level.cells(problem)) * level.ppc**problem.dimension


def _inputs(study: Study, plan: Plan, tasks: Sequence[Task]) -> str:
    """Digest of everything that a study's file depends on, the code that judges and stores it included."""
    keys = [task.key for task in tasks]
    return digest(study, plan.tier, keys, file_digest(plan.baseline.path), code=JUDGING)


def _judged(
    study: Study, plan: Plan, tasks: Sequence[Task], evaluated: Sequence[Evaluated], run: str, inputs: str, *, show: Show
) -> StudyRun:
    """Judge a study whose runs are all finished, store it and show it.

    `write_study` says what `run`, when the run of all studies started, and `inputs` are.
    """
    started = time.perf_counter()
    levels = [entry.level for entry in evaluated]
    evidence = evidence_by_series(levels)
    judged = judge(study.name, study.criteria(), evidence, plan.baseline, study.restricted_to)
    # A run that failed has no time step. It is tried again next time, even if its file is there: of an earlier run, or of this one, if
    # the process was killed before it answered.
    complete = all(plan.results.run(task.key).exists() for task in tasks) and not any(math.isnan(level.dt) for level in levels)
    inputs = inputs if complete else ""
    snapshots = {entry.level.series: entry.snapshots for entry in evaluated if entry.snapshots}
    problems = {case.name: problem_digest(case.problem) for case in study.cases}
    path = plan.results.study(study.name)
    groups = write_study(path, study, levels, snapshots, judged, tier=plan.tier, inputs=inputs, run=run, problems=problems)
    write_verdicts(plan.results, study.name, inputs, judged.findings)
    solved = sum(entry.solved for entry in evaluated)
    seconds = sum(entry.seconds for entry in evaluated) + time.perf_counter() - started
    return StudyRun(
        study.name, judged.findings, solved, len(evaluated) - solved, seconds, show(plan.results, study.name, groups)
    )
