"""Worker processes for tasks of any kind: one that hangs or kills its process is reported as failed, and the others finish."""

import contextlib
import math
import multiprocessing
import os
import pickle
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.execution.restoring import restored

T = TypeVar("T")
R = TypeVar("R")
READY, STARTED = "ready", "started"
"""Messages of a process: it has begun; it has received a task."""
START_UP = 120.0
"""Limit for a new process to import what its first task needs [s]; it does not count as time of the task."""
LONGEST_WAIT = 3600.0
"""Longest wait for a message [s]: systems refuse to wait for weeks."""
OUT_OF_TIME = getattr(signal, "SIGXCPU", None)
"""Signal that ends a process at its limit of processor time; None where there is none."""


class Failure(StrEnum):
    """Why a task has no result of its own."""

    TIMED_OUT = "timed out"
    OUT_OF_PROCESSOR_TIME = "out of processor time"
    DIED = "died"
    RAISED = "raised"


@dataclass(frozen=True)
class Crew(Generic[T, R]):
    """How tasks are done in worker processes.

    Parameters
    ----------
    work : callable
        Called on every task in a worker process; a function or method that can be pickled.
    failed : callable
        Called with a task, its `Failure` and a sentence on it, and gives the result of the task.
    limit : float
        Limit for one task [s]; its process is killed then.
    processor_limit : float, optional
        Limit of processor time for one task [s]. Every task then has a new process, which ends by itself at this limit.
    context : object, optional
        Context of `multiprocessing` that starts the processes; by default they are spawned.
    environment : mapping of str to str, optional
        Environment variables of the processes.
    """

    work: Callable[[T], R]
    failed: Callable[[T, Failure, str], R]
    limit: float
    processor_limit: float | None = None
    context: Any = None
    environment: Mapping[str, str] | None = None

    def results(self, take: Callable[["Worker[T, R]", Sequence["Worker[T, R]"]], T | None], jobs: int) -> Iterator[tuple[T, R]]:
        """Do tasks, and yield them with their results in the order of completion.

        Parameters
        ----------
        take : callable
            Called with an idle worker and all workers; gives the next task of the idle one, or None when there is none left.
        jobs : int
            Largest number of processes.

        Raises
        ------
        UsageError
            If a task cannot be sent to a process, or a process cannot begin.
        MpmverifyError
            What `work` raised of it.
        """
        workers = [Worker(self) for _ in range(jobs)]
        try:
            while True:
                for worker in workers:
                    if worker.task is None and (task := take(worker, workers)) is not None:
                        worker.start(task)
                busy = [worker for worker in workers if worker.task is not None]
                if not busy:
                    return
                pause = max(0.0, min(worker.deadline for worker in busy) - time.monotonic())
                ready = wait([worker.connection for worker in busy], min(pause, LONGEST_WAIT))
                for worker in busy:
                    # The caller may take its time: a result that has come in meanwhile is no time-out.
                    if worker.connection in ready or worker.connection.poll():
                        if finished := worker.receive():
                            yield finished
                    elif time.monotonic() >= worker.deadline:
                        yield worker.abandon(Failure.TIMED_OUT, f"no result within {self.limit:g} s")
        finally:
            with contextlib.ExitStack() as stopping:
                for worker in workers:
                    stopping.callback(worker.stop)


class Worker(Generic[T, R]):
    """One process at a time, and the task that it works on.

    Parameters
    ----------
    crew : Crew
        What it does, and its limits.

    Attributes
    ----------
    task, latest : object or None
        The task at hand, and the task that was started last.
    deadline : float
        Time at which the task is given up, by the clock of `time.monotonic` [s].
    """

    def __init__(self, crew: Crew[T, R]) -> None:
        self.crew = crew
        self.task: T | None = None
        self.latest: T | None = None
        self.deadline = 0.0
        self.process: Any = None
        self.connection: Any = None
        self.ready = False

    def start(self, task: T) -> None:
        """Send a task to the process, which is started when there is none."""
        if self.process is None:
            self._spawn()
        self.task, self.latest, self.deadline = task, task, time.monotonic() + START_UP + self.crew.limit
        try:
            self.connection.send(task)
        except ConnectionError:  # the process died while idle, of which the task knows nothing
            self.stop()
            self._spawn()
            self.connection.send(task)
        except (AttributeError, TypeError, pickle.PicklingError) as error:
            raise UsageError(
                f"{task} cannot be sent to a worker process ({error}): define the class at the top of a module"
            ) from error

    def _spawn(self) -> None:
        context = self.crew.context or multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self.crew.work, self.crew.processor_limit), daemon=True)
        try:
            with no_interrupt(), environment(self.crew.environment or {}):
                process.start()
        except BaseException:
            ours.close()
            raise
        finally:
            theirs.close()
        self.process, self.connection, self.ready = process, ours, False

    def receive(self) -> tuple[T, R] | None:
        """Take a message of the process; None when it does not finish the task."""
        try:
            message = self.connection.recv()
        except (EOFError, OSError):  # the latter in the middle of a message
            return self._dead()
        if message == READY:
            self.ready = True
            return None
        if message == STARTED:
            self.deadline = time.monotonic() + self.crew.limit
            return None
        if isinstance(message, MpmverifyError):
            raise message
        if isinstance(message, _Raised):
            return self._finish(self.crew.failed(self._at_hand(), Failure.RAISED, message.text))
        return self._finish(message)

    def _dead(self) -> tuple[T, R]:
        self.process.join()
        code, limit = self.process.exitcode, self.crew.processor_limit
        if not self.ready and code >= 0:  # no signal has ended it
            raise UsageError(
                f"a worker process ended before it began, with exit status {code}: a script must keep what it does under "
                "`if __name__ == '__main__':`, since its workers import it too"
            ) from None
        if limit is not None and OUT_OF_TIME is not None and code == -OUT_OF_TIME:
            return self.abandon(Failure.OUT_OF_PROCESSOR_TIME, f"no result within {limit:g} s of processor time")
        return self.abandon(Failure.DIED, f"the process died with exit status {code}")

    def abandon(self, failure: Failure, reason: str) -> tuple[T, R]:
        """End the process, and report its task as failed."""
        self.stop()
        return self._finish(self.crew.failed(self._at_hand(), failure, reason))

    def _at_hand(self) -> T:
        assert self.task is not None
        return self.task

    def _finish(self, result: R) -> tuple[T, R]:
        task, self.task = self._at_hand(), None
        if self.crew.processor_limit is not None:
            self.stop()
        return task, result

    def stop(self) -> None:
        """End the process, if there is one."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.connection.close()
            self.process = None


@dataclass(frozen=True)
class _Raised:
    """What a task raised, as text: the exception itself may not travel between processes."""

    text: str


def _serve(connection: Connection, work: Callable[[T], R], processor_limit: float | None) -> None:
    """Do the tasks that come until the other side closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    message: Any = READY
    while True:
        try:
            connection.send(message)
            task = connection.recv()
            connection.send(STARTED)
            _limit(processor_limit)
            with restored():
                message = work(task)
        except (EOFError, ConnectionError):
            return
        except MpmverifyError as error:
            message = error
        except Exception as error:  # also of a task or a result that does not travel between processes
            message = _Raised(f"{type(error).__name__}: {error}")


def _limit(processor_time: float | None) -> None:
    if processor_time is not None and OUT_OF_TIME is not None:
        import resource  # a platform with this signal has this module

        limit, (_, hard) = math.ceil(time.process_time() + processor_time), resource.getrlimit(resource.RLIMIT_CPU)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5 if hard == resource.RLIM_INFINITY else hard))


@contextlib.contextmanager
def no_interrupt() -> Iterator[None]:
    """Hold back an interrupt from the keyboard: a process that starts meanwhile never sees it, and its parent ends it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it lets interrupts through again when it starts, with the first process otherwise
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@contextlib.contextmanager
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for processes that start meanwhile."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
