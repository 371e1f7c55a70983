"""Runs over worker processes: a run that hangs or kills its process becomes an outcome, and its neighbours finish."""

import contextlib
import multiprocessing
import os
import pickle
import signal
import time
from collections import deque
from collections.abc import Hashable, Iterable, Iterator
from collections.abc import Set as AbstractSet
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.execution.evaluation import Evaluated, Task, evaluate, failed
from mpmverify.solution import Status

READY, STARTED = "ready", "started"
"""What a process says when it has begun, and when it has received a task."""
START_UP = 120.0
"""Limit for a new process to import the solver [s]; it does not count as time of the run."""
LONGEST_WAIT = 3600.0
"""At one go [s]: systems refuse to wait for some weeks."""


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
        If a task cannot be sent to a process, or a process cannot begin.
    MpmverifyError
        What a worker raised: misuse, or a damaged results folder.
    """
    waiting: dict[str, deque[Task]] = {}
    for task in tasks:
        waiting.setdefault(task.study, deque()).append(task)
    workers: list[_Worker] = []
    compiled: set[Hashable] = {None}
    try:
        workers += (_Worker(timeout) for _ in range(min(jobs, sum(map(len, waiting.values())))))
        while waiting or any(worker.task for worker in workers):
            for worker in workers:
                if worker.task is None and waiting:
                    compiling = {other.task.kernel for other in workers if other.task} - compiled
                    worker.start(_next(waiting, worker.study, {other.study for other in workers}, compiling))
            busy = [worker for worker in workers if worker.task]
            pause = max(0.0, min(worker.deadline for worker in busy) - time.monotonic())
            ready = wait([worker.connection for worker in busy], min(pause, LONGEST_WAIT))
            for worker in busy:
                # Whoever takes the results may be slow: what has come in meanwhile is no time-out.
                if worker.connection in ready or worker.connection.poll():
                    if finished := worker.receive():
                        compiled.add(finished[0].kernel)
                        yield finished
                elif time.monotonic() >= worker.deadline:
                    yield worker.abandon(Status.TIMED_OUT, f"no result within {timeout:g} s")
    finally:
        for worker in workers:
            worker.stop()


def _next(waiting: dict[str, deque[Task]], mine: str, taken: AbstractSet[str], compiling: AbstractSet[Hashable]) -> Task:
    """Take a task of the study that a worker is at, else of the first that none is at, else of the one with most tasks left.

    Two workers at one study compile the same solvers at the same time, unless these say what they compile: what others are
    `compiling` comes when they have, where there is anything else to do.
    """
    first = [study for study in waiting if study == mine] + [study for study in waiting if study not in taken]
    studies = list(dict.fromkeys([*first, *sorted(waiting, key=lambda name: len(waiting[name]), reverse=True)]))
    free = ((study, k) for study in studies for k, task in enumerate(waiting[study]) if task.kernel not in compiling)
    study, k = next(free, (studies[0], 0))
    task = waiting[study][k]
    del waiting[study][k]
    if not waiting[study]:
        del waiting[study]
    return task


class _Worker:
    """One process, the task that it works on, and the study that this is of."""

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.task: Task | None = None
        self.study = ""
        self.deadline = 0.0
        self.ready = False
        self._spawn()

    def _spawn(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process: BaseProcess = context.Process(target=_serve, args=(theirs,), daemon=True)
        with no_interrupt():
            self.process.start()
        theirs.close()

    def start(self, task: Task) -> None:
        self.task, self.study, self.deadline = task, task.study, time.monotonic() + START_UP + self.timeout
        try:
            self.connection.send(task)
        except BrokenPipeError:  # the process died while idle: receiving says so
            pass
        except (AttributeError, TypeError, pickle.PicklingError) as error:
            raise UsageError(
                f"{task} cannot be sent to a worker process ({error}): define the class at the top of a module"
            ) from error

    def receive(self) -> tuple[Task, Evaluated] | None:
        """Take what the process sent; None when the task is not finished by it."""
        task = self.task
        assert task is not None
        try:
            result = self.connection.recv()
        except (EOFError, ConnectionResetError):
            self.process.join()
            if not self.ready:
                raise UsageError(
                    f"a worker process ended before it began, with exit status {self.process.exitcode}: a script must keep what it "
                    "does under `if __name__ == '__main__':`, since its workers import it too"
                ) from None
            return self.abandon(Status.CRASHED, f"the process died with exit status {self.process.exitcode}")
        if result == READY:
            self.ready = True
            return None
        if result == STARTED:
            self.deadline = time.monotonic() + self.timeout
            return None
        if isinstance(result, MpmverifyError):
            raise result
        self.task = None
        return task, failed(task, Status.CRASHED, result) if isinstance(result, str) else result

    def abandon(self, status: Status, detail: str) -> tuple[Task, Evaluated]:
        """Replace the process, and report its task as failed."""
        task, self.task = self.task, None
        assert task is not None
        self.stop()
        self.ready = False
        self._spawn()
        return task, failed(task, status, detail)

    def stop(self) -> None:
        self.process.kill()
        self.process.join()
        self.connection.close()


@contextlib.contextmanager
def no_interrupt() -> Iterator[None]:
    """Hold back an interrupt from the keyboard, which a process that starts meanwhile never sees: its parent ends it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


def _serve(connection: Connection) -> None:
    """Evaluate what comes until the other side closes; a failure that is no outcome of the solver is sent as text."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    message: Any = READY
    while True:
        try:
            connection.send(message)
            task = connection.recv()
            connection.send(STARTED)
            message = evaluate(task)
        except (EOFError, ConnectionError):
            return
        except MpmverifyError as error:
            message = error
        except Exception as error:  # a task or a result that does not travel between processes
            message = f"{type(error).__name__}: {error}"
