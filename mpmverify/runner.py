"""Studies from declaration to judged dataset; what is already solved is not solved again."""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from mpmverify import pool
from mpmverify.atomic import write_atomic
from mpmverify.baseline import Baseline
from mpmverify.dataset.content import digest, file_digest
from mpmverify.dataset.files import Results, check_ours
from mpmverify.errors import ResultsError
from mpmverify.evaluation import Evaluated, Task, run_key
from mpmverify.gate import Finding
from mpmverify.problem import Discretisation, Problem
from mpmverify.study import Study

SHOWN_POINTS = 160
"""The pages show the finest level of a series with at most so many cells times particles."""


@dataclass(frozen=True)
class Judged:
    """A judged study: its findings, how many runs were solved for it and how many were at hand."""

    study: str
    findings: tuple[Finding, ...]
    solved: int
    reused: int


@dataclass(frozen=True)
class Plan:
    """Everything that one invocation does.

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
        fitting = [k for k, level in enumerate(levels) if _points(case.problem.problem, level) <= SHOWN_POINTS]
        shown = max(fitting, default=0)
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
                key=run_key(case.problem, series.solver, level),
                shown=k == shown,
                reuse=plan.reuse,
            )
            table.append(task)
    return table


def run(studies: Sequence[Study], plan: Plan, progress: Callable[[str, int, int], None] = lambda *_: None) -> Iterator[Judged]:
    """Run and judge studies, each as soon as its last run is in; its file is written then.

    Parameters
    ----------
    studies : sequence of Study
    plan : Plan
    progress : callable
        Called with (study, runs done, runs in all) after every run.

    Raises
    ------
    UsageError, ResultsError
        On misuse, or when a file of the results folder is damaged or cannot be written.
    """
    plan.results.create()
    stored = read_verdicts(plan.results)
    work: dict[str, list[Task]] = {}
    for study in studies:
        tasks = tasks_of(study, plan)
        inputs = _inputs(study, plan, tasks)
        entry = stored.get(study.name, {"inputs": "", "findings": []})
        # Looked at in any case: a foreign file is named before anything is solved.
        up_to_date = _made_from(inputs, plan.results.study(study.name), entry)
        if plan.reuse and up_to_date:
            yield Judged(study.name, _findings(entry), 0, len(tasks))
        else:
            work[study.name] = tasks
    by_name = {study.name: study for study in studies}
    done: dict[str, dict[int, Evaluated]] = {name: {} for name in work}
    for task, evaluated in _evaluate([task for tasks in work.values() for task in tasks], plan):
        finished, tasks = done[task.study], work[task.study]
        finished[task.index] = evaluated
        progress(task.study, len(finished), len(tasks))
        if len(finished) == len(tasks):
            yield _judge(by_name[task.study], plan, tasks, [finished[k] for k in range(len(tasks))])


def _evaluate(tasks: list[Task], plan: Plan) -> Iterator[tuple[Task, Evaluated]]:
    at_hand = {id(task) for task in tasks if task.reuse and plan.results.run(task.key).exists()}
    cost = {id(task): 0.0 if id(task) in at_hand else _cost(task) for task in tasks}
    total: dict[str, float] = {}
    for task in tasks:
        total[task.study] = total.get(task.study, 0.0) + cost[id(task)]
    # Study by study, so that one is judged while the next is solved; the longest first, so that none is left alone at the end.
    ordered = sorted(tasks, key=lambda task: (total[task.study], task.study, cost[id(task)]), reverse=True)
    if plan.scheduler:
        yield from pool.Distributed(plan.scheduler).evaluate(ordered)
    elif plan.jobs == 0 or (len(at_hand) == len(tasks) and len(tasks) <= 50):
        yield from pool.inline(tasks)
    else:
        yield from pool.over_processes(ordered, plan.jobs, plan.timeout)


def _cost(task: Task) -> float:
    problem, level = task.problem.problem, task.discretisation
    return level.time_steps(problem)[0] * _points(problem, level)


def _points(problem: Problem, level: Discretisation) -> int:
    """Cells times particles per cell."""
    return math.prod(level.cells(problem)) * level.ppc**problem.dimension


def _inputs(study: Study, plan: Plan, tasks: Sequence[Task]) -> str:
    """Digest of everything that a study's file depends on, the code that judges it included."""
    keys = [task.key for task in tasks]
    return digest(
        study, plan.tier, keys, file_digest(plan.baseline.path), code=["mpmverify.evaluation", "mpmverify.dataset.verdicts"]
    )


def _judge(study: Study, plan: Plan, tasks: Sequence[Task], evaluated: Sequence[Evaluated]) -> Judged:
    from mpmverify.dataset.study import build, write_study
    from mpmverify.dataset.verdicts import declare, findings, judged

    # A run that left no file is tried again next time: its study is never up to date.
    complete = all(plan.results.run(task.key).exists() for task in tasks)
    inputs = _inputs(study, plan, tasks) if complete else ""
    snapshots = {entry.level.series: entry.snapshots for entry in evaluated if entry.snapshots}
    tree = build(study, plan.tier, inputs, [entry.level for entry in evaluated], snapshots)
    tree = judged(declare(tree, study), plan.baseline)
    write_study(plan.results.study(study.name), tree)
    found = tuple(findings(tree))
    write_verdicts(plan.results, study.name, inputs, found)
    solved = sum(entry.solved for entry in evaluated)
    return Judged(study.name, found, solved, len(evaluated) - solved)


def _made_from(inputs: str, path: Path, entry: dict) -> bool:
    """Whether a study's file and verdicts were made from these inputs; a file that has not been touched is not opened."""
    if not path.exists():
        return False
    stored = entry["inputs"] if entry.get("stamp") == _stamp(path) else check_ours(path, "study").get("inputs", "")
    return bool(stored == inputs == entry["inputs"])


def _stamp(path: Path) -> list[int]:
    status = path.stat()
    return [status.st_size, status.st_mtime_ns]


def _findings(entry: dict) -> tuple[Finding, ...]:
    """Findings of one study as `verdicts.json` holds them."""
    return tuple(Finding.of(finding) for finding in entry["findings"])


def read_verdicts(results: Results) -> dict[str, dict]:
    """Stored verdicts by study; empty when there are none yet.

    Raises
    ------
    ResultsError
        If the file is damaged.
    """
    try:
        studies = dict(json.loads(results.verdicts.read_text(encoding="utf-8"))["studies"])
        for entry in studies.values():  # what is malformed raises here
            _findings(entry), entry["inputs"]
        return studies
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ResultsError(f"'{results.verdicts}' is not a list of mpmverify verdicts: delete it and run again") from error


def write_verdicts(results: Results, study: str, inputs: str, findings: Sequence[Finding]) -> None:
    """Replace the verdicts of one study in `verdicts.json`."""
    studies = {name: entry for name, entry in read_verdicts(results).items() if results.study(name).exists()}
    studies[study] = {
        "inputs": inputs,
        "stamp": _stamp(results.study(study)),
        "findings": [asdict(finding) for finding in findings],
    }
    text = json.dumps({"schema": 1, "studies": studies}, indent=1, sort_keys=True)
    write_atomic(results.verdicts, lambda temporary: temporary.write_text(text + "\n", encoding="utf-8"))
