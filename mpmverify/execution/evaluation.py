"""One run: solved or read back from its file, compared with the exact solution, and measured for the criteria."""

import dataclasses
import math
import time
import traceback
from collections.abc import Hashable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mpmverify.criteria.criterion import Criterion, Setting
from mpmverify.criteria.evidence import Level
from mpmverify.criteria.norms import compare
from mpmverify.dataset.files import Results, set_aside
from mpmverify.dataset.runs import Run, read_run, write_run
from mpmverify.dataset.snapshots import Snapshots
from mpmverify.errors import DamagedError, MpmverifyError, UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.execution.contract import breach, confirmed, malformed, plain
from mpmverify.execution.keys import in_library
from mpmverify.problem import Discretisation
from mpmverify.solution import Outcome, RunError, Solution, Solver, Status

SHOWN_OUTPUTS, SHOWN_SAMPLES = {1: 17, 2: 5, 3: 5}, 257
"""Largest numbers of output times, by dimension, and of samples of the histories that are kept of a run that the pages show."""
KEPT_POINTS = 10_000
"""Largest number of points that are kept of a run: at all outputs together in several dimensions, at the last one if it is not shown."""


@dataclass(frozen=True)
class Task:
    """One run and the criteria that measure it; a value that can be sent to worker processes.

    Parameters
    ----------
    results : Path or None
        Results folder; None when nothing is stored.
    study : str
    index : int
        Position among the runs of the study.
    case, refinement : str
        Series that the run belongs to, with the solver.
    problem : VerificationProblem
    solver : Solver
    discretisation : Discretisation
    criteria : tuple of Criterion
    key : str
        Content key of the run.
    shown : bool
        Whether its fields and histories go into the study's file.
    reuse : bool
        Whether a finished run may be read back.
    """

    results: Path | None
    study: str
    index: int
    case: str
    refinement: str
    problem: VerificationProblem
    solver: Solver
    discretisation: Discretisation
    criteria: tuple[Criterion, ...]
    key: str
    shown: bool = False
    reuse: bool = True

    def __str__(self) -> str:
        return f"{self.study} / {self.case} / {self.solver.name} / {self.refinement} / h={self.discretisation.h:g}"

    @property
    def kernel(self) -> Hashable:
        """Identity of the code that the solver compiles for the problem, see `Solver`; None when the solver does not declare it.

        Raises
        ------
        UsageError
            If the solver raises, or its declaration is not hashable.
        """
        declares = getattr(self.solver, "kernel", None)
        try:
            found: Hashable = declares(self.problem.problem) if callable(declares) else None
            hash(found)
        except Exception as error:
            raise UsageError(
                f"solver {self.solver.name!r} does not say what it compiles ({type(error).__name__}: {error}): let kernel(problem) "
                "return a hashable value, or leave it out"
            ) from error
        return found


@dataclass(frozen=True)
class Evaluated:
    """Result of a task.

    Parameters
    ----------
    level : Level
    snapshots : Snapshots or None
        What the pages show, of a task that is `shown`.
    solved : bool
        Whether the run was solved now, and not read back.
    seconds : float
        Wall time of the task, compilation included [s]; 0 when its process died.
    run : Run or None
        What would be stored, of a task without a results folder.
    """

    level: Level
    snapshots: Snapshots | None = None
    solved: bool = False
    seconds: float = 0.0
    run: Run | None = None


def failed(task: Task, status: Status, detail: str, seconds: float = 0.0, advice: str = "") -> Evaluated:
    """Result of a run without a solution: it crashed or timed out. Nothing is stored, so that the run is tried again."""
    return Evaluated(_level(task, Outcome(status, plain(detail), plain(advice))), solved=True, seconds=seconds)


def evaluate(task: Task) -> Evaluated:
    """Solve a run or read it back, and compare it with the exact solution.

    Raises
    ------
    UsageError
        If the solver cannot take the problem.
    ResultsError
        If a run file is foreign or cannot be written.
    """
    started = time.perf_counter()
    evaluated = read_back(task) or _solved(task)
    if task.results:
        evaluated = stored(task, evaluated)
    return dataclasses.replace(evaluated, seconds=time.perf_counter() - started)


def _solved(task: Task) -> Evaluated:
    try:
        solution = task.solver.solve(task.problem.problem, task.discretisation)
        if wrong := malformed(solution, task.problem.problem.dimension):
            return failed(task, Status.CRASHED, wrong)
        solution = dataclasses.replace(solution, outcome=confirmed(solution))
        if wrong := breach(solution, task.problem.problem, task.discretisation):
            return failed(task, Status.CRASHED, wrong)
        run = measure(task, solution)
        return dataclasses.replace(_of(task, run), solved=True, run=run)
    except MpmverifyError:
        raise
    except RunError as error:
        return failed(task, error.outcome.status, error.outcome.detail, advice=error.outcome.advice)
    except (Exception, SystemExit) as error:  # a solver under test may raise anything; the other runs must still finish
        advice = "run `mpmverify check` on the solver to see its lines"
        return failed(task, Status.CRASHED, f"{type(error).__name__}: {error} ({place(error)})", advice=advice)


def stored(task: Task, evaluated: Evaluated) -> Evaluated:
    """Write the run of a result, if it has one, and return the result without it.

    Raises
    ------
    ResultsError
        If the file is foreign or cannot be written.
    """
    if evaluated.run and task.results:
        write_run(Results(task.results).run(task.key), task.key, evaluated.run, str(task))
    return dataclasses.replace(evaluated, run=None)


def read_back(task: Task) -> Evaluated | None:
    """Read back a run that is at hand.

    Returns
    -------
    Evaluated or None
        None when there is none, when too little of it is kept to show it, or when it is damaged: then it is set aside.

    Raises
    ------
    ResultsError
        If the file is foreign.
    """
    if not task.results or not task.reuse:
        return None
    path = Results(task.results).run(task.key)
    if not path.exists():
        return None
    try:
        run = read_run(path, task.key)
    except DamagedError:
        set_aside(path)
        return None
    return _of(task, run) if run.shown or not task.shown else None


def _of(task: Task, run: Run) -> Evaluated:
    return Evaluated(level_of(task, run), _snapshots(task, run.solution) if task.shown else None)


def place(error: BaseException) -> str:
    """File and line of an exception: the innermost frame in the user's own code, not in a library."""
    frames = traceback.extract_tb(error.__traceback__)[1:] or traceback.extract_tb(error.__traceback__)
    where = next((frame for frame in reversed(frames) if not in_library(Path(frame.filename))), frames[-1])
    return f"{Path(where.filename).name}:{where.lineno}"


def _level(task: Task, outcome: Outcome, **measured: Any) -> Level:
    at = task.discretisation
    identity = (task.case, task.solver.name, task.refinement, at.h, at.courant, at.ppc, task.key)
    return Level(*identity, jitter=at.jitter, seed=at.seed, outcome=str(outcome), **measured)


def level_of(task: Task, run: Run) -> Level:
    """Return what of a run is evidence."""
    kept = run.solution
    facts = dataclasses.asdict(kept.work) | {"dt": kept.dt, "errors": run.errors, "metrics": run.metrics}
    return _level(task, kept.outcome, **facts)


def measure(task: Task, solution: Solution) -> Run:
    """Compare a solution with the exact one, measure it for the criteria, and choose what is kept of it.

    Raises
    ------
    UsageError
        If two criteria measure the same quantity differently.
    """
    metrics: dict[str, float] = {}
    table: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    if solution.outcome.completed:
        table, metrics = compare(solution, task.problem.exact)
        setting = Setting(task.problem, task.discretisation)
        for criterion in task.criteria:
            measured = criterion.measure(solution, setting)
            for name in measured.keys() & metrics.keys():
                if not np.array_equal(measured[name], metrics[name], equal_nan=True):
                    raise UsageError(f"{task}: two criteria measure {name!r} differently: give each a series of its own")
            metrics |= measured
    return Run(_excerpt(task, solution), table, metrics, task.shown)


def _excerpt(task: Task, solution: Solution) -> Solution:
    """Return the last output, at every k-th of many points; of a run that the pages show all points of several outputs, and histories."""
    if not task.shown:
        return solution.excerpt(_spread(len(solution.time), 1), None, math.ceil(len(solution.reference) / KEPT_POINTS) or 1)
    most = SHOWN_OUTPUTS[task.problem.problem.dimension]
    if task.problem.problem.dimension > 1:
        most = min(most, max(1, KEPT_POINTS // max(len(solution.reference), 1)))
    return solution.excerpt(_spread(len(solution.time), most), _spread(len(solution.histories["time"]), SHOWN_SAMPLES))


def _snapshots(task: Task, kept: Solution) -> Snapshots:
    return Snapshots(
        case=task.case,
        refinement=task.refinement,
        h=task.discretisation.h,
        time=kept.time,
        reference=kept.reference,
        fields=kept.fields,
        exact={q: field(kept.reference, kept.time) for q, field in task.problem.exact.fields.items() if q in kept.fields},
        histories=kept.histories,
    )


def _spread(count: int, most: int) -> np.ndarray:
    """Return at most `most` of `count` indices, evenly spaced, with the last and, of several, the first."""
    return np.unique(np.round(np.linspace(count - 1, 0, min(count, most))).astype(int))
