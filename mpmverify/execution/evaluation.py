"""One run: solved or read back from its file, compared with the exact solution, and measured for the criteria."""

import dataclasses
import time
import traceback
from collections.abc import Hashable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mpmverify.criteria.criterion import Criterion, Setting
from mpmverify.criteria.evidence import Level
from mpmverify.criteria.norms import errors
from mpmverify.dataset.files import Results
from mpmverify.dataset.runs import read_run, write_run
from mpmverify.dataset.snapshots import Snapshots
from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.execution.contract import breach, confirmed, malformed, plain
from mpmverify.execution.keys import digest, in_library
from mpmverify.problem import Discretisation
from mpmverify.solution import Outcome, Solution, Solver, Status

SNAPSHOT_OUTPUTS = 32
"""Output intervals of a run that its snapshots keep at most."""
HISTORY_SAMPLES = 256
"""Intervals of a run's histories that its snapshots keep at most."""


@dataclass(frozen=True)
class Task:
    """One run and the criteria that measure it; a value that can be sent to worker processes.

    Parameters
    ----------
    results : Path
        Results folder.
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

    results: Path
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
        Fields and histories for the pages, of a task that is `shown`.
    solved : bool
        Whether the run was solved now, and not read back.
    seconds : float
        Wall time of the task, compilation included [s]; 0 when its process died.
    """

    level: Level
    snapshots: Snapshots | None = None
    solved: bool = False
    seconds: float = 0.0


def run_key(problem: VerificationProblem, solver: Solver, discretisation: Discretisation) -> str:
    """Content key of a run: problem, solver, discretisation, their code and the numerical libraries.

    Parameters
    ----------
    problem : VerificationProblem
        Its exact solution is not in the key: a solver does not see it.
    solver : Solver
    discretisation : Discretisation

    Raises
    ------
    UsageError
        If one of them is not a value; see `digest`.
    """
    return digest(problem.problem, solver, discretisation)


def failed(task: Task, status: Status, detail: str, seconds: float = 0.0) -> Evaluated:
    """Result of a run without a solution: it crashed or timed out. Nothing is stored, so that the run is tried again."""
    return Evaluated(_level(task, Outcome(status, plain(detail))), solved=True, seconds=seconds)


def evaluate(task: Task) -> Evaluated:
    """Solve a run or read it back, and compare it with the exact solution.

    Raises
    ------
    UsageError
        If the solver cannot take the problem.
    ResultsError
        If a run file is damaged or cannot be written.
    """
    started = time.perf_counter()
    return dataclasses.replace(_evaluated(task), seconds=time.perf_counter() - started)


def _evaluated(task: Task) -> Evaluated:
    path = Results(task.results).run(task.key)
    solved = not (task.reuse and path.exists())
    try:
        if solved:
            solution = task.solver.solve(task.problem.problem, task.discretisation)
            if wrong := malformed(solution, task.problem.problem.dimension):
                return failed(task, Status.CRASHED, wrong)
            solution = dataclasses.replace(solution, outcome=confirmed(solution))
            if wrong := breach(solution, task.problem.problem, task.discretisation):
                return failed(task, Status.CRASHED, wrong)
            write_run(path, task.key, solution, str(task))
        else:
            solution = read_run(path, task.key)
        return Evaluated(compare(task, solution), _snapshots(task, solution) if task.shown else None, solved)
    except MpmverifyError:
        raise
    except (Exception, SystemExit) as error:  # a solver under test may raise anything; the other runs must still finish
        return failed(task, Status.CRASHED, f"{type(error).__name__}: {error} ({place(error)})")


def place(error: BaseException) -> str:
    """File and line of an exception: the innermost frame in the user's own code, not in a library."""
    frames = traceback.extract_tb(error.__traceback__)[1:] or traceback.extract_tb(error.__traceback__)
    where = next((frame for frame in reversed(frames) if not in_library(Path(frame.filename))), frames[-1])
    return f"{Path(where.filename).name}:{where.lineno}"


def _level(task: Task, outcome: Outcome, **measured: Any) -> Level:
    at = task.discretisation
    identity = (task.case, task.solver.name, task.refinement, at.h, at.courant, at.ppc, task.key)
    return Level(*identity, jitter=at.jitter, seed=at.seed, outcome=str(outcome), **measured)


def compare(task: Task, solution: Solution) -> Level:
    """Compare a solution with the exact one, and measure it for the criteria.

    Raises
    ------
    UsageError
        If two criteria measure the same quantity differently.
    """
    metrics: dict[str, float] = {}
    table = {}
    if solution.outcome.completed:
        table = errors(solution, task.problem.exact)
        setting = Setting(task.problem, task.discretisation)
        for criterion in task.criteria:
            measured = criterion.measure(solution, setting)
            for name in measured.keys() & metrics.keys():
                if not np.array_equal(measured[name], metrics[name], equal_nan=True):
                    raise UsageError(f"{task}: two criteria measure {name!r} differently: give each a series of its own")
            metrics |= measured
    work = dataclasses.asdict(solution.work)
    return _level(task, solution.outcome, dt=solution.dt, errors=table, metrics=metrics, **work)


def _snapshots(task: Task, solution: Solution) -> Snapshots:
    outputs = _spread(len(solution.time), SNAPSHOT_OUTPUTS + 1)
    samples = _spread(len(solution.histories["time"]), HISTORY_SAMPLES + 1)
    time = solution.time[outputs]
    return Snapshots(
        case=task.case,
        refinement=task.refinement,
        h=task.discretisation.h,
        time=time,
        reference=solution.reference,
        position=solution.position[outputs],
        fields={quantity: values[outputs] for quantity, values in solution.fields.items()},
        exact={q: field(solution.reference, time) for q, field in task.problem.exact.fields.items() if q in solution.fields},
        histories={name: values[samples] for name, values in solution.histories.items()},
    )


def _spread(count: int, most: int) -> np.ndarray:
    """Return at most `most` of `count` indices, evenly spaced, with the first and the last."""
    return np.unique(np.round(np.linspace(0, count - 1, min(count, most))).astype(int))
