"""Selection between values, and comparisons that Python has no overloadable operator for."""

from typing import Any

from llvmlite import ir

from .arrays import Array
from .values import VECTOR, Value, as_code, promoted


def where(condition: Any, x: Any, y: Any) -> Any:
    """Return x where a condition holds, else y; both have been computed.

    Parameters
    ----------
    condition : bool or Value
        May differ from lane to lane.
    x, y : float, Value, Array or tuple of these
        Alike in structure; arrays of one type.
    """
    if not isinstance(condition, Value):
        return x if condition else y
    if isinstance(x, tuple):
        return tuple(where(condition, a, b) for a, b in zip(x, y, strict=True))
    if x is y:
        return x
    if isinstance(x, Array):
        data = x.builder.select(condition.code, x.data, y.data)
        lengths = [where(condition, a, b).code for a, b in zip(x.shape, y.shape, strict=True)]
        return Array(x.builder, x.kind, data, lengths)
    a, b = promoted(condition.builder, x, y)
    if isinstance(condition.code.type, ir.VectorType):
        a, b = (as_code(condition.builder, Value(condition.builder, code), VECTOR) for code in (a, b))
    return Value(condition.builder, condition.builder.select(condition.code, a, b))


def equal(x: Any, y: Any) -> Any:
    """Whether two integers are equal."""
    if not isinstance(x, Value):
        return x == y
    return Value(x.builder, x.builder.icmp_signed("==", *promoted(x.builder, x, y)))


def logical_not(condition: Any) -> Any:
    """Whether a condition does not hold."""
    return where(condition, False, True)
