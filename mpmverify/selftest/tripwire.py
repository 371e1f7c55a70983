"""Tripwire: a call placed in front of an edited statement, to find out whether any trial reaches it."""

import sys
from collections.abc import Iterator, Mapping
from typing import Any


def spoil_arrays(names: Mapping[str, object]) -> None:
    """Generate code that writes NaN to the first and last element of every array in the variables of a traced function.

    If the function has no array, the arrays of the nearest caller that has some are spoiled. The writes happen when the compiled
    code reaches the call.

    Parameters
    ----------
    names : mapping of str to object
        Local variables of the traced function.

    Raises
    ------
    ArithmeticError
        At once, if neither the function nor any of its callers has an array.
    """
    arrays, frame = list(_arrays(list(names.values()))), sys._getframe(1).f_back
    while not arrays and frame:
        arrays, frame = list(_arrays(list(frame.f_locals.values()))), frame.f_back
    if not arrays:
        raise ArithmeticError
    for array in arrays:
        some = array.shape[0] > 0
        for length in array.shape[1:]:
            some = some & (length > 0)
        with array.builder.if_then(some.code):
            for end in (0, -1):
                array.pointer(*[end] * len(array.shape)).store(float("nan"))


def _arrays(found: Any) -> Iterator[Any]:
    """Yield the writable arrays of doubles, found by their attributes: each planted copy has its own array class."""
    if isinstance(found, list | tuple):
        for item in found:
            yield from _arrays(item)
    elif hasattr(found, "pointer") and found.kind.mutable and str(found.kind.dtype) == "float64":
        yield found
