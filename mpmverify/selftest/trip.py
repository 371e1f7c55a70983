"""What stands before a statement to find out whether a trial comes to it."""

import sys
from collections.abc import Iterator, Mapping
from typing import Any


def trip(names: Mapping[str, object]) -> None:
    """Spoil both ends of every array that a traced function of the material point method has at hand, or if it has none the next of those
    that call it, when compiled code comes to where it is called.

    Raises
    ------
    ArithmeticError
        If none has, at once.
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
    """The arrays of doubles that may be written to; whose class is not known here: each planted copy of the sources has its own."""
    if isinstance(found, list | tuple):
        for item in found:
            yield from _arrays(item)
    elif hasattr(found, "pointer") and found.kind.mutable and str(found.kind.dtype) == "float64":
        yield found
