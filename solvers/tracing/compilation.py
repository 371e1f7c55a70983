"""Jitted functions out of traced ones, and what tells numba's disk cache that a source has changed."""

import types
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from numba import njit, typeof

ARITHMETIC: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy"}
"""Options of `numba.njit`: products and sums may be fused, and a division by zero is no error."""
WITHOUT_ENTRY: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of what Python never calls: entries take a third of the time of compilation."""


def checksum(folder: Path) -> int:
    """Checksum of the Python files in a folder and of the tracing compiler.

    Numba's disk cache watches the file of a jitted function only, not those of the traced functions that it inlines. As a part of
    the name of the jitted function the checksum gives each version of the files an index of its own. This matters beyond old code: an
    index refers to the classes of arguments, and numba fails to read it once one of them has moved.

    Parameters
    ----------
    folder : Path
        Of the code that is compiled.
    """
    paths = [path for part in (folder, Path(__file__).parent) for path in sorted(part.glob("*.py"))]
    return zlib.crc32(b"".join(path.read_bytes() for path in paths))


def compiled(function: Callable[..., Any], names: dict[str, object], name: str, **options: bool) -> Any:
    """Compile a copy of a function in which some of its global names have other meanings.

    Parameters
    ----------
    function : function
    names : dict
        Meanings by name.
    name : str
        Of the copy: numba's disk cache tells the functions of a module apart by their names.
    **options : bool
        Of `numba.njit`, beside `ARITHMETIC`.
    """
    assert isinstance(function, types.FunctionType)
    copy = types.FunctionType(function.__code__, function.__globals__ | names, name, function.__defaults__)
    copy.__module__, copy.__qualname__ = function.__module__, name
    return njit(**ARITHMETIC, **cast(dict[str, Any], options))(copy)


def entry(function: Any, arguments: tuple[Any, ...]) -> Any:
    """Compile a jitted function for the types of some arguments, and return what numba calls then.

    A call of the result does not look at the types again: they must be the same. Numba finds out the types of named tuples in Python, a
    millisecond at each call of a function that takes several.
    """
    types = typeof(arguments).types
    function.compile(types)
    return function.get_overload(types)
