"""Elementary functions of numbers and values: those of the mathematical library of C, called lane by lane for a vector."""

import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir

from .lanes import pack, unpack
from .tracer import traced
from .values import DOUBLE, FUSED, Value, as_code, external

# Scalars or vectors have no annotation.
# mypy: disable-error-code="no-untyped-def"


def _call(name: str, *args: Any) -> Value:
    """Call a function of doubles by its name."""
    builder = next(x.builder for x in args if isinstance(x, Value))
    function = external(builder, name, ir.FunctionType(DOUBLE, [DOUBLE] * len(args)))
    return Value(builder, builder.call(function, [as_code(builder, x, DOUBLE) for x in args], fastmath=FUSED))


def _elementary(name: str, function: Callable[[float], float]) -> Callable[[Any], Any]:
    def of(x: Any) -> Any:
        return pack([_call(name, one) for one in unpack(x)]) if isinstance(x, Value) else function(x)

    return traced(of)


acos, asinh, atanh = _elementary("acos", math.acos), _elementary("asinh", math.asinh), _elementary("atanh", math.atanh)
cos, exp, log = (
    _elementary("llvm.cos.f64", math.cos),
    _elementary("llvm.exp.f64", math.exp),
    _elementary("llvm.log.f64", math.log),
)
expm1 = _elementary("expm1", math.expm1)


@traced
def power(x, y):
    """Return x to the power of a number y."""
    return pack([_call("llvm.pow.f64", one, y) for one in unpack(x)]) if isinstance(x, Value) else x**y
