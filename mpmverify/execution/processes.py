"""Runs of solvers, one after the other in this process or spread over worker processes."""

import os
from collections import deque
from collections.abc import Hashable, Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from functools import partial

from mpmverify.errors import UsageError
from mpmverify.execution.evaluation import Evaluated, Task, evaluate, failed
from mpmverify.execution.workers import Crew, Failure, Worker
from mpmverify.solution import Status


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def inline(tasks: Iterable[Task]) -> Iterator[tuple[Task, Evaluated]]:
    """Evaluate in this process, one after the other."""
    for task in tasks:
        yield task, evaluate(task)


def over_processes(tasks: Iterable[Task], jobs: int, timeout: float) -> Iterator[tuple[Task, Evaluated]]:
    """Evaluate over `jobs` processes, in the order of completion.

    Parameters
    ----------
    tasks : iterable of Task
    jobs : int
        Number of processes.
    timeout : float
        Limit for one run [s], compilation included; a run that exceeds it is killed and reported as timed out.

    Raises
    ------
    UsageError
        If there is no process, a task cannot be sent to one, or one cannot begin.
    MpmverifyError
        What a worker raised: misuse, or a damaged results folder.
    """
    waiting = Waiting(tasks)
    compiled: set[Hashable] = {None}

    def take(worker: Worker[Task, Evaluated], workers: Sequence[Worker[Task, Evaluated]]) -> Task | None:
        if not waiting:
            return None
        compiling = {other.task.kernel for other in workers if other.task} - compiled
        taken = {other.latest.study for other in workers if other.latest}
        return waiting.take(worker.latest.study if worker.latest else "", taken, compiling)

    if jobs < 1:
        raise UsageError(f"{jobs} worker processes can solve nothing: give at least 1")
    jobs = min(jobs, len(waiting))
    crew = Crew(evaluate, partial(failed_by, timeout), timeout, environment=_threads(jobs))
    for task, evaluated in crew.results(take, jobs):
        compiled.add(task.kernel)
        yield task, evaluated


THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that limit the threads of numerical libraries and of programs."""


def _threads(jobs: int) -> dict[str, str]:
    """Share the processors between processes, unless the user has set how many threads there are."""
    return {name: str(max(1, processors() // max(1, jobs))) for name in THREADS if name not in os.environ}


def failed_by(timeout: float, task: Task, failure: Failure, reason: str) -> Evaluated:
    """Result of a run whose process ended or was ended."""
    if failure is Failure.TIMED_OUT:
        return failed(task, Status.TIMED_OUT, reason, timeout)
    return failed(task, Status.CRASHED, reason)


class Waiting:
    """Tasks that are not begun, by study."""

    def __init__(self, tasks: Iterable[Task]) -> None:
        self._tasks: dict[str, deque[Task]] = {}
        for task in tasks:
            self._tasks.setdefault(task.study, deque()).append(task)

    def __len__(self) -> int:
        return sum(map(len, self._tasks.values()))

    def put(self, task: Task) -> None:
        """Put a task back: the next one of its study."""
        self._tasks.setdefault(task.study, deque()).appendleft(task)

    def take(self, mine: str, taken: AbstractSet[str], compiling: AbstractSet[Hashable]) -> Task:
        """Take a task of the study that a worker is at, else of the first that none is at, else of the one with most tasks left.

        Two workers at one study compile the same solvers at the same time, unless the solvers say what they compile. A task whose
        kernel others are `compiling` is then taken only when there is no other.
        """
        tasks = self._tasks
        first = [study for study in tasks if study == mine] + [study for study in tasks if study not in taken]
        studies = list(dict.fromkeys([*first, *sorted(tasks, key=lambda name: len(tasks[name]), reverse=True)]))
        free = ((study, k) for study in studies for k, task in enumerate(tasks[study]) if task.kernel not in compiling)
        study, k = next(free, (studies[0], 0))
        task = tasks[study][k]
        del tasks[study][k]
        if not tasks[study]:
            del tasks[study]
        return task
