"""Worker processes for tasks of any kind: one that hangs or kills its process is reported as failed, and the others finish."""

import contextlib
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from typing import Any, Generic, TypeVar

from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.execution.serving import OUT_OF_TIME, READY, STARTED, Raised, serve

T = TypeVar("T")
R = TypeVar("R")
START_UP = 120.0
"""Limit for a new process to import what its first task needs [s]; it does not count as time of the task."""
LONGEST_WAIT = 3600.0
"""Longest wait for a message [s]: systems refuse to wait for weeks."""


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
                        yield worker.give_up()
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
        except Exception as error:  # pickle may raise anything
            self.task = None  # nobody works on it
            raise UsageError(
                f"{task} cannot be sent to a worker process ({error}): define the class at the top of a module"
            ) from error

    def _spawn(self) -> None:
        context = self.crew.context or multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=serve, args=(theirs, self.crew.work, self.crew.processor_limit), daemon=True)
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
            self.task = None
            raise message
        if isinstance(message, Raised):
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

    def do(self, task: T) -> R:
        """Do one task, and wait for its result.

        Raises
        ------
        UsageError
            If the task cannot be sent to a process, or a process cannot begin.
        MpmverifyError
            What the work raised of it.
        """
        self.start(task)
        return self.result()

    def result(self) -> R:
        """Wait for the result of the task at hand; errors as of `do`."""
        while True:
            pause = max(0.0, self.deadline - time.monotonic())
            finished = None
            if self.connection.poll(min(pause, LONGEST_WAIT)):
                finished = self.receive()
            elif time.monotonic() >= self.deadline:
                finished = self.give_up()
            if finished:
                return finished[1]

    def give_up(self) -> tuple[T, R]:
        """End the process at the limit of its task."""
        return self.abandon(Failure.TIMED_OUT, f"no result within {self.crew.limit:g} s")

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
