"""The state of a process, given back after a task."""

import contextlib
import os
import signal
import sys
import warnings
from collections.abc import Iterator

import numpy as np


@contextlib.contextmanager
def restored() -> Iterator[None]:
    """Give the process back as it was: what one task does to it, the next does not see.

    Restored are the working folder, the environment, the import path, NumPy's random numbers and floating-point errors, the filters of
    warnings, and the action on an alarm. A library that a task patches stays patched.
    """
    folder, variables, path = os.getcwd(), dict(os.environ), list(sys.path)
    state = np.random.get_state()  # noqa: NPY002 - what a solver may use
    alarm = getattr(signal, "SIGALRM", None)
    action = signal.getsignal(alarm) if alarm else None
    try:
        with warnings.catch_warnings(), np.errstate():
            yield
    finally:
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(variables)
        sys.path[:] = path
        np.random.set_state(state)  # noqa: NPY002 - the same
        if alarm:
            signal.alarm(0)
            signal.signal(alarm, action)
