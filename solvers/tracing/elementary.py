"""Elementary functions of numbers and of values, those of lanes one by one."""

import math
from collections.abc import Callable
from typing import Any

from numba.core import types
from numba.core.registry import cpu_target
from numba.core.typing.templates import signature

from .lanes import built, taken
from .tracing import traced
from .values import DOUBLE, Value, code_of

# What is a number or lanes has no annotation.
# mypy: disable-error-code="no-untyped-def"


def _compiled(function: Callable[..., float], *args: Any) -> Value:
    """A function of Python's as numba compiles it."""
    builder = next(x.builder for x in args if isinstance(x, Value))
    sig = signature(types.float64, *(types.float64 for _ in args))
    write = cpu_target.target_context.get_function(function, sig)
    return Value(builder, write(builder, [code_of(builder, x, DOUBLE) for x in args]))


def _elementary(function: Callable[[float], float]) -> Callable[[Any], Any]:
    def of(x: Any) -> Any:
        return built([_compiled(function, one) for one in taken(x)]) if isinstance(x, Value) else function(x)

    return traced(of)


acos, asinh, atanh, cos = map(_elementary, (math.acos, math.asinh, math.atanh, math.cos))
exp, expm1, log = map(_elementary, (math.exp, math.expm1, math.log))


@traced
def power(x, y):
    """X to the power of the number y."""
    return built([_compiled(math.pow, one, y) for one in taken(x)]) if isinstance(x, Value) else x**y
