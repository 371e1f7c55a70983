"""What runs within a pass of a solver has no entry for Python: the tests give it one."""

from types import SimpleNamespace

from numba import njit
from numba.core.dispatcher import Dispatcher

from mpmverify.solvers.mpm.compilation import ARITHMETIC


def callable_from_python(function):
    """The same compiled function, with an entry."""
    return njit(**ARITHMETIC)(function.py_func)


def entries(module):
    """All names of a module, its compiled functions with an entry."""
    return SimpleNamespace(
        **{
            name: callable_from_python(value) if isinstance(value, Dispatcher) else value
            for name, value in vars(module).items()
        }
    )
