"""Runs over the workers of a dask.distributed scheduler."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.execution.evaluation import Evaluated, Task, evaluate, failed
from mpmverify.solution import Status


@dataclass(frozen=True)
class Distributed:
    """A dask.distributed scheduler; its workers must see the same results folder."""

    address: str

    def evaluate(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, Evaluated]]:
        """Evaluate on the scheduler's workers, in the order of completion.

        Raises
        ------
        UsageError
            If dask.distributed is not installed or the scheduler does not answer.
        """
        try:
            from distributed import Client, as_completed
        except ImportError as error:
            raise UsageError("--scheduler needs dask.distributed: pip install 'mpmverify[distributed]'") from error
        try:
            client: Any = Client(self.address, timeout=10)
        except (OSError, ValueError) as error:
            raise UsageError(f"no dask scheduler answers at {self.address!r}: start one with `dask scheduler`") from error
        with client:
            tasks = list(tasks)
            futures = {client.submit(evaluate, task, pure=False): task for task in tasks}
            for future in as_completed(futures):
                task = futures[future]
                raised = future.exception()
                if isinstance(raised, MpmverifyError):
                    raise raised
                yield task, failed(task, Status.CRASHED, repr(raised)) if raised else future.result()
