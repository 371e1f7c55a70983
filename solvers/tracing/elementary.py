"""Elementary functions of numbers and values: numba's own, called lane by lane for a vector."""

import math
from collections.abc import Callable
from typing import Any

from numba.core import types
from numba.core.registry import cpu_target
from numba.core.typing.templates import signature

from .lanes import pack, unpack
from .tracer import traced
from .values import DOUBLE, Value, as_code

# Scalars or vectors have no annotation.
# mypy: disable-error-code="no-untyped-def"


def _call(function: Callable[..., float], *args: Any) -> Value:
    """Call a function of Python's `math` as numba compiles it."""
    builder = next(x.builder for x in args if isinstance(x, Value))
    sig = signature(types.float64, *(types.float64 for _ in args))
    emit = cpu_target.target_context.get_function(function, sig)
    return Value(builder, emit(builder, [as_code(builder, x, DOUBLE) for x in args]))


def _elementary(function: Callable[[float], float]) -> Callable[[Any], Any]:
    def of(x: Any) -> Any:
        return pack([_call(function, one) for one in unpack(x)]) if isinstance(x, Value) else function(x)

    return traced(of)


acos, asinh, atanh, cos = map(_elementary, (math.acos, math.asinh, math.atanh, math.cos))
exp, expm1, log = map(_elementary, (math.exp, math.expm1, math.log))


@traced
def power(x, y):
    """Return x to the power of a number y."""
    return pack([_call(math.pow, one, y) for one in unpack(x)]) if isinstance(x, Value) else x**y
