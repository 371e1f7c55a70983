"""What crosses the border between Python and compiled code: arguments and results, in slots of eight bytes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from llvmlite import ir

from .arrays import Array, Kind
from .values import BOOLEAN, DOUBLE, INTEGER, KINDS, LANES, RANKS, VECTOR, Value, as_code, rank

SLOTS = INTEGER.as_pointer()
"""Address of slots."""


def kinds_of(argument: Any) -> Any:
    """Kinds of an argument: hashable, and equal for arguments that share compiled code.

    Raises
    ------
    TypeError
        If it is neither a number, a C-contiguous array of doubles or integers, None, nor a tuple of these.
    """
    if isinstance(argument, tuple):
        return type(argument), *map(kinds_of, argument)
    if isinstance(argument, np.ndarray):
        kind = Kind(argument.dtype, argument.ndim, argument.flags.writeable)
        if not argument.flags.c_contiguous:
            raise TypeError(f"{kind} may have gaps: pass a C-contiguous array")
        if not argument.dtype.isnative or (argument.dtype != np.float64 and argument.dtype.kind not in "iu"):
            raise TypeError(f"compiled code takes arrays of doubles or integers in the byte order of this machine, not {kind}")
        return kind
    if argument is None:
        return None
    for number, kind in ((bool | np.bool_, BOOLEAN), (int | np.integer, INTEGER), (float, DOUBLE)):
        if isinstance(argument, number):
            return RANKS[kind]
    raise TypeError(f"compiled code takes numbers, arrays and tuples of these, not {type(argument).__name__}")


def spelled(kinds: Any) -> str:
    """Kinds as a text, the same in every process."""
    if isinstance(kinds, tuple) and not isinstance(kinds, Kind):
        names = getattr(kinds[0], "_fields", [""] * (len(kinds) - 1))
        items = [f"{name}: {spelled(kind)}" for name, kind in zip(names, kinds[1:], strict=True)]
        return f"{kinds[0].__module__}.{kinds[0].__qualname__}({', '.join(items)})"
    return str(kinds)


def words(argument: Any) -> Iterator[int | float]:
    """Numbers that an argument consists of: an array has its address and its shape."""
    if isinstance(argument, tuple):
        for item in argument:
            yield from words(item)
    elif isinstance(argument, np.ndarray):
        yield argument.__array_interface__["data"][0]
        yield from argument.shape
    elif argument is not None:
        yield argument


def slots_of(arguments: Any) -> Any:
    """Slots (K,) of arguments, as 64-bit integers."""
    numbers = list(words(arguments))
    slots = np.empty(len(numbers), dtype=np.int64)
    doubles = slots.view(np.float64)
    for k, number in enumerate(numbers):
        if isinstance(number, float):
            doubles[k] = number
        else:
            slots[k] = number
    return slots


def loaded(builder: ir.IRBuilder, kinds: Any, codes: Iterator[ir.Value]) -> Any:
    """Argument of a traced function from the codes of its slots, which are integers."""
    if isinstance(kinds, Kind):
        data = builder.inttoptr(next(codes), kinds.element.as_pointer())
        return Array(builder, kinds, data, [next(codes) for _ in range(kinds.axes)])
    if isinstance(kinds, tuple):
        items = [loaded(builder, item, codes) for item in kinds[1:]]
        return kinds[0](*items) if hasattr(kinds[0], "_fields") else tuple(items)
    if kinds is None:
        return None
    code, kind = next(codes), KINDS[kinds]
    if kind == BOOLEAN:
        code = builder.trunc(code, BOOLEAN)
    return Value(builder, builder.bitcast(code, DOUBLE) if kind == DOUBLE else code)


def count_slots(kinds: Any) -> int:
    """Number of slots of an argument."""
    if isinstance(kinds, Kind):
        return 1 + kinds.axes
    if isinstance(kinds, tuple):
        return sum(map(count_slots, kinds[1:]))
    return 0 if kinds is None else 1


def form_of(result: Any) -> Any:
    """Form of what a traced function returns: nested lists of the ranks of its numbers; None for nothing.

    Raises
    ------
    TypeError
        If an array is returned.
    """
    if isinstance(result, tuple | list):
        return [form_of(item) for item in result]
    if isinstance(result, Array):
        raise TypeError("a compiled function returns numbers and tuples of them, not an array")
    return None if result is None else rank(result)


def store(builder: ir.IRBuilder, result: Any, address: ir.Value) -> None:
    """Store what a traced function returns to slots; a vector takes one for each lane."""
    slot = 0
    for item in _numbers(result):
        kind = KINDS[rank(item)]
        code = as_code(builder, item, kind)
        if kind == BOOLEAN:
            code, kind = builder.zext(code, INTEGER), INTEGER
        place = builder.gep(address, [INTEGER(slot)], inbounds=True, source_etype=INTEGER)
        builder.store(code, builder.bitcast(place, kind.as_pointer()), align=8)
        slot += LANES if kind == VECTOR else 1


def _numbers(result: Any) -> Iterator[Any]:
    if isinstance(result, tuple | list):
        for item in result:
            yield from _numbers(item)
    elif result is not None:
        yield result


def room(form: Any) -> int:
    """Number of slots of a result."""
    if isinstance(form, list):
        return sum(map(room, form))
    return 0 if form is None else LANES if KINDS[form] == VECTOR else 1


def read(form: Any, slots: Iterator[Any]) -> Any:
    """Result from its slots, an iterator over 64-bit integers; a vector is a tuple of its lanes."""
    if isinstance(form, list):
        return tuple(read(item, slots) for item in form)
    if form is None:
        return None
    if KINDS[form] == VECTOR:
        return tuple(float(next(slots).view(np.float64)) for _ in range(LANES))
    slot = next(slots)
    return float(slot.view(np.float64)) if KINDS[form] == DOUBLE else bool(slot) if KINDS[form] == BOOLEAN else int(slot)
