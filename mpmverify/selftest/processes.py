"""One process for each fault: one that hangs, kills its process or spoils its memory does not affect the next."""

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from mpmverify.execution.workers import Crew, Failure, Worker

T = TypeVar("T")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)
PATIENCE = 20
"""Limit of wall time as a multiple of the limit of processor time: the machine may be busy."""
SAFE_PATH = {"PYTHONSAFEPATH": "1"}
"""Without it the fork server imports from the working folder, perhaps a checkout, instead of the installed modules."""


class Failed(Protocol[R_co]):
    """Makes a result of the reason why there is none, and of whether the task is undecided."""

    def __call__(self, reason: str, *, undecided: bool) -> R_co: ...


def each_alone(
    work: Callable[[T], R], tasks: Sequence[T], jobs: int, timeout: float, failed: Failed[R], imports: Sequence[str]
) -> Iterator[tuple[T, R]]:
    """Call `work` on every task, each in a process of its own, `jobs` at a time; in the order of completion.

    Parameters
    ----------
    work : callable
        Function or method that can be pickled.
    tasks : sequence
    jobs : int
    timeout : float
        Limit for one task [s of processor time]. A task that takes `PATIENCE` times as long by the clock is given up, undecided.
    failed : callable
        Makes a result of the reason why there is none, and of whether the task is undecided.
    imports : sequence of str
        Modules that every process needs: imported once where the platform can fork a clean process.

    Raises
    ------
    RuntimeError, MpmverifyError
        If `work` raised: that is no verdict on the task.
    """

    def without_result(task: T, failure: Failure, reason: str) -> R:
        if failure is Failure.RAISED:
            raise RuntimeError(reason)
        return failed(reason, undecided=failure is Failure.TIMED_OUT)

    def take(worker: Worker[T, R], workers: Sequence[Worker[T, R]]) -> T | None:
        return next(waiting, None)

    forks = "forkserver" in multiprocessing.get_all_start_methods()
    context: Any = multiprocessing.get_context("forkserver" if forks else "spawn")
    if forks:
        context.set_forkserver_preload(["__main__", *imports])
    waiting = iter(tasks)
    crew = Crew(work, without_result, PATIENCE * timeout, timeout, context, SAFE_PATH)
    yield from crew.results(take, min(jobs, len(tasks)))
