"""One process for each fault: a fault may hang, kill its process or spoil its memory, and the next one never knows."""

import contextlib
import math
import multiprocessing
import os
import signal
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from typing import Any, Protocol, TypeVar

from mpmverify.execution.processes import no_interrupt

T = TypeVar("T")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)
OUT_OF_TIME = getattr(signal, "SIGXCPU", None)
"""Signal that ends a process at its limit of processor time; None where there is none."""
PATIENCE = 20
SAFE_PATH = {"PYTHONSAFEPATH": "1"}
"""The process that forks the others would import from the working folder first, and take a checkout's for the installed modules."""


class Failed(Protocol[R_co]):
    """Makes a result of the reason why there is none, and of whether that is undecided."""

    def __call__(self, reason: str, *, undecided: bool) -> R_co: ...


@contextmanager
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Have processes that start meanwhile see these variables."""
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


def each_alone(
    work: Callable[[T], R], tasks: Sequence[T], jobs: int, timeout: float, failed: Failed[R], imports: Sequence[str]
) -> Iterator[tuple[T, R]]:
    """Call `work` on every task, each in a process of its own, `jobs` at a time; in the order of completion.

    Parameters
    ----------
    work : callable
        Function or method that travels between processes.
    tasks : sequence
    jobs : int
    timeout : float
        Limit for one task [s of processor time]: a process that nobody waits for any more ends too. A task that has not come to
        it in `PATIENCE` times as long is given up, undecided.
    failed : callable
        Makes a result of the reason why there is none, and of whether that is undecided.
    imports : sequence of str
        Modules that every process needs: imported once where the platform can fork a clean process.

    Raises
    ------
    RuntimeError
        If `work` raised.
    """
    forks = "forkserver" in multiprocessing.get_all_start_methods()
    context: Any = multiprocessing.get_context("forkserver" if forks else "spawn")
    if forks:
        context.set_forkserver_preload(["__main__", *imports])
    waiting = list(reversed(tasks))
    busy: dict[Any, tuple[Any, T, float]] = {}
    try:
        while waiting or busy:
            while waiting and len(busy) < jobs:
                ours, theirs = context.Pipe(duplex=False)
                task = waiting.pop()
                process = context.Process(target=_serve, args=(theirs, work, task, timeout), daemon=True)
                with no_interrupt(), environment(SAFE_PATH):
                    process.start()
                theirs.close()
                busy[ours] = (process, task, time.monotonic() + PATIENCE * timeout)
            pause = max(0.0, min(deadline for _, _, deadline in busy.values()) - time.monotonic())
            ready = wait(list(busy), pause)
            for connection, (process, task, deadline) in list(busy.items()):
                if connection not in ready and time.monotonic() < deadline:
                    continue
                if connection in ready:
                    result = _received(connection, process, failed, timeout)
                else:
                    result = failed(f"no result within {PATIENCE * timeout:g} s", undecided=True)
                _end(connection, process)
                del busy[connection]
                yield task, result
    finally:
        for connection, (process, _, _) in busy.items():
            _end(connection, process)


def _received(connection: Connection, process: Any, failed: Failed[R], timeout: float) -> R:
    try:
        result: R | Exception = connection.recv()
        if isinstance(result, Exception):
            raise result  # no verdict on the task: the judge itself is wrong
        return result
    except (EOFError, ConnectionResetError):
        process.join()
        if OUT_OF_TIME is not None and process.exitcode == -OUT_OF_TIME:
            return failed(f"no result within {timeout:g} s of processor time", undecided=False)
        return failed(f"the process died with exit status {process.exitcode}", undecided=False)


def _end(connection: Connection, process: Any) -> None:
    process.kill()
    process.join()
    connection.close()


def _serve(connection: Connection, work: Callable[[T], R], task: T, timeout: float) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if OUT_OF_TIME is not None:
        import resource  # where there is such a signal, there is this module

        limit = math.ceil(time.process_time() + timeout)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    try:
        result: Any = work(task)
    except Exception as error:
        traceback.print_exc()
        result = RuntimeError(f"{type(error).__name__}: {error}")
    with contextlib.suppress(BrokenPipeError):  # nobody waits any more
        connection.send(result)
