"""How the functions of this package are compiled."""

import types
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from numba import njit

ARITHMETIC: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
WITHOUT_ENTRY: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""For what Python never calls: entries take a third of the time of compilation."""
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
