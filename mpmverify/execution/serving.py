"""What a worker process does: it takes tasks from a connection, and sends back results."""

import math
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from mpmverify.errors import MpmverifyError
from mpmverify.execution.restoring import restored

T = TypeVar("T")
R = TypeVar("R")
READY, STARTED = "ready", "started"
"""Messages of a process: it has begun; it has received a task."""
OUT_OF_TIME = getattr(signal, "SIGXCPU", None)
"""Signal that ends a process at its limit of processor time; None where there is none."""


@dataclass(frozen=True)
class Raised:
    """What a task raised, as text: the exception itself may not travel between processes."""

    text: str


def serve(connection: Connection, work: Callable[[T], R], processor_limit: float | None) -> None:
    """Do the tasks that come until the other side closes.

    Parameters
    ----------
    connection : Connection
        Gives tasks, and takes messages and results.
    work : callable
        Called on every task.
    processor_limit : float or None
        Limit of processor time for one task [s]; the process ends by itself at this limit.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
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
            message = Raised(f"{type(error).__name__}: {error}")


def _end_with_parent() -> None:
    """End this process when its parent was killed: a run that hangs would go on for ever."""
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)


def _limit(processor_time: float | None) -> None:
    if processor_time is not None and OUT_OF_TIME is not None:
        import resource  # a platform with this signal has this module

        limit, (_, hard) = math.ceil(time.process_time() + processor_time), resource.getrlimit(resource.RLIMIT_CPU)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5 if hard == resource.RLIM_INFINITY else hard))
