"""How the functions of this package are compiled."""

import types
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


class Jit(Protocol):
    """A decorator that keeps the signature of what it compiles."""

    def __call__(self, function: F) -> F: ...


ARITHMETIC: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
WITHOUT_ENTRY: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""For what Python never calls: entries take a third of the time of compilation."""
WITHIN: dict[str, Any] = {"forceinline": True, "_nrt": False}
jit = cast(Jit, njit(**ARITHMETIC, **WITHOUT_ENTRY, **WITHIN))
"""For what runs within a pass: inlined, and without counting references, which would cost more than the arithmetic.

Such a function allocates nothing and returns no array.
"""
SOURCES = zlib.crc32(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
"""As a default argument of a compiled function it adds the files that it inlines to the one that numba's disk cache watches."""


def compiled(function: Callable[..., Any], names: dict[str, object], name: str, **options: bool) -> Any:
    """Compile a copy of a function with other meanings of some of its global names.

    Parameters
    ----------
    function : function
    names : dict
        Meanings by name.
    name : str
        Of the copy: numba's disk cache tells functions of a module apart by their names.
    **options : bool
        Of `numba.njit`.
    """
    assert isinstance(function, types.FunctionType)
    copy = types.FunctionType(function.__code__, function.__globals__ | names, name, function.__defaults__)
    copy.__module__, copy.__qualname__ = function.__module__, name
    return njit(**ARITHMETIC, **cast(dict[str, Any], options))(copy)
