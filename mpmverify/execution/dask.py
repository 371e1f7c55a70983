"""Runs over the workers of a dask.distributed scheduler: as over processes, but that the results are stored here.

Each thread of a dask worker has a process of its own for the runs, with the limit of time and the safeguards of `workers`: a run that
hangs or crashes costs itself alone, and what a solver has compiled serves the next run. The process is a new one for every command, so
that it imports what the files hold then. A worker needs no access to the results folder.
"""

import contextlib
import logging
import multiprocessing
import pickle
import queue
import sys
import threading
import uuid
from collections.abc import Hashable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, replace
from typing import Any

from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.execution.evaluation import Evaluated, Task, evaluate, failed, read_back, stored
from mpmverify.execution.processes import Waiting, failed_by
from mpmverify.execution.run_keys import run_keys
from mpmverify.execution.workers import Crew, Failure, Worker
from mpmverify.solution import Status

IN_FLIGHT = 2
"""Number of runs that are sent for each thread of the workers: the next is there when one ends."""
PATIENCE = 30
"""Limit for the scheduler to answer, at first and when the connection was lost [s]."""
ALONE = 10
"""Seconds without a worker after which this is said."""


@dataclass(frozen=True)
class Distributed:
    """A dask.distributed scheduler and the limits of the runs on its workers.

    Parameters
    ----------
    address : str
    timeout : float
        Limit for one run [s].
    """

    address: str
    timeout: float

    def evaluate(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, Evaluated]]:
        """Evaluate on the scheduler's workers, in the order of completion; what is stored is read back here.

        A run whose worker is lost is sent to another one, and so is a run that a scheduler forgot when it was started again.

        Raises
        ------
        UsageError
            If dask.distributed is not installed, the scheduler does not answer, a task cannot be sent, or a worker has other code.
        MpmverifyError
            What a worker raised: misuse, or a damaged results folder.
        """
        todo = []
        for task in tasks:
            if evaluated := read_back(task):
                yield task, evaluated
            else:
                todo.append(task)
        if todo:
            with self._client() as client:
                yield from self._solve(client, todo)

    def _client(self) -> Any:
        try:
            from distributed import Client
        except ImportError as error:
            raise UsageError("--scheduler needs dask.distributed: pip install 'mpmverify[distributed]'") from error
        try:
            return Client(self.address, timeout=PATIENCE)
        except Exception as error:  # of an address in a wrong form, anything
            raise UsageError(f"no dask scheduler answers at {self.address!r}: start one with `dask scheduler`") from error

    def _solve(self, client: Any, tasks: Sequence[Task]) -> Iterator[tuple[Task, Evaluated]]:
        waiting = Waiting(tasks)
        finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        flying: dict[Any, Task] = {}
        compiled: set[Hashable] = {None}
        session = uuid.uuid4().hex
        while waiting or flying:
            self._check(client)
            while waiting and len(flying) < max(1, IN_FLIGHT * _threads(client)):
                task = waiting.take("", set(), {other.kernel for other in flying.values()} - compiled)
                packed = _packed(task)
                try:
                    future = client.submit(solve_apart, packed, sys.path, self.timeout, session, pure=False)
                except Exception:  # raised again, unless the client was closed meanwhile
                    self._check(client)
                    raise
                future.add_done_callback(finished.put)
                flying[future] = task
            future = self._next(client, finished)
            task = flying.pop(future)
            try:
                evaluated = self._evaluated(task, future)
            except MpmverifyError:
                self._keep(flying)
                raise
            if evaluated is None:
                waiting.put(task)
                continue
            compiled.add(task.kernel)
            yield task, stored(task, evaluated)

    def _evaluated(self, task: Task, future: Any) -> Evaluated | None:
        """Result of a finished future; None when the scheduler has forgotten it, or the connection was lost."""
        if future.cancelled():
            return None
        raised = future.exception()
        if isinstance(raised, MpmverifyError):
            raise raised
        if raised:
            return failed(task, Status.CRASHED, f"{type(raised).__name__}: {raised}")
        try:
            found: Evaluated | tuple[Failure, str] = future.result()
        except (CancelledError, OSError):  # it was cancelled, or the connection closed, since it was asked for its exception
            return None
        except Exception as error:  # a result that cannot be read: sent again, it could not be read again
            return failed(task, Status.CRASHED, f"{type(error).__name__}: {error}")
        return failed_by(self.timeout, task, *found) if isinstance(found, tuple) else found

    def _keep(self, flying: dict[Any, Task]) -> None:
        """Store what is finished: an error ends the command."""
        for future, task in flying.items():
            with contextlib.suppress(Exception):  # the error that is raised already comes first
                if future.status == "finished" and (evaluated := self._evaluated(task, future)):
                    stored(task, evaluated)

    def _next(self, client: Any, finished: "queue.SimpleQueue[Any]") -> Any:
        alone = 0
        while True:
            with contextlib.suppress(queue.Empty):
                return finished.get(timeout=1.0)
            self._check(client)
            alone = 0 if client.status != "running" or _threads(client) else alone + 1
            if alone == ALONE:
                logging.getLogger("mpmverify").warning(
                    "The dask scheduler at '%s' has no worker: the runs wait for one. Start it with `dask worker %s`.",
                    *(self.address, self.address),
                )

    def _check(self, client: Any) -> None:
        if client.status == "closed":
            raise UsageError(
                f"the dask scheduler at {self.address!r} does not answer any more: start it and run the same command again; "
                "what is finished is kept"
            )


def _threads(client: Any) -> int:
    """Number of threads of all workers; 0 while the connection is lost."""
    try:
        return sum(client.nthreads().values())
    except (OSError, RuntimeError):  # the latter of a client that is closed
        return 0


def _packed(task: Task) -> bytes:
    """Pickle a task, without the results folder, which a worker may not see."""
    try:
        return pickle.dumps(replace(task, results=None))
    except Exception as error:  # pickle may raise anything
        raise UsageError(f"{task} cannot be sent to a worker ({error}): define the class at the top of a module") from error


_thread = threading.local()


def solve_apart(packed: bytes, path: Sequence[str], timeout: float, session: str) -> Evaluated | tuple[Failure, str]:
    """Solve a run in the process that belongs to this thread of a dask worker.

    Parameters
    ----------
    packed : bytes
        Task, pickled.
    path : sequence of str
        Folders from which the sender imports. They come last here, so that nothing in them hides a library.
    timeout : float
        Limit [s].
    session : str
        Name of the command that sent the task; the process serves one command.

    Returns
    -------
    Evaluated or (Failure, str)
        The latter when the process ended or was ended.

    Raises
    ------
    UsageError
        If the code of the task cannot be imported here, or differs from the sender's.
    """
    sys.path.extend(folder for folder in path if folder not in sys.path)
    if getattr(_thread, "session", "") != session:
        if _thread.__dict__.get("worker"):
            _thread.worker.stop()
        # A dask worker is a daemon, which multiprocessing forbids children. Ours end with their parent, see `serving`. There is no public
        # way to allow them, so that a type checker does not know this one.
        multiprocessing.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
        _thread.worker, _thread.session = Worker(Crew(_solve_packed, _ended, timeout)), session
    worker: Worker[bytes, Evaluated | tuple[Failure, str]] = _thread.worker
    return worker.do(packed)


def _ended(packed: bytes, failure: Failure, reason: str) -> tuple[Failure, str]:
    return failure, reason


def _solve_packed(packed: bytes) -> Evaluated | tuple[Failure, str]:
    """Evaluate a task, if the code here is that of the sender: the result would be stored under a wrong key otherwise."""
    try:
        task: Task = pickle.loads(packed)
    except Exception as error:  # importing a module runs it, which may raise anything
        raise UsageError(
            f"a dask worker cannot import what it must run ({type(error).__name__}: {error}): install it where the worker runs, or "
            "give the worker a folder in which it lies"
        ) from error
    if run_keys(task.problem, task.solver, [task.discretisation], task.criteria) != [task.key]:
        raise UsageError(
            f"{task}: a dask worker has another version of the solver, of mpmverify or of a numerical library: install the same ones "
            "on all machines"
        )
    return evaluate(task)
