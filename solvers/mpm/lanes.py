"""Lanes: the doubles of one register, one for each of four particles whose stencil is the same.

What the passes compute with is a number for one particle, or lanes for four: functions of tuples of either take both. LLVM does not find
this out by itself. All here is for compiled code alone.
"""

import operator
from collections.abc import Callable
from functools import reduce
from typing import Any, cast

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic as numba_intrinsic
from numba.extending import lower_builtin, models, register_model

# What numba calls while it compiles has types of its own.
# mypy: disable-error-code="no-untyped-def"

intrinsic = cast(Callable[[Callable[..., Any]], Callable[..., Any]], numba_intrinsic)
"""A function that is called without the first of its arguments, and makes the code of its call itself."""
COUNT = 4
"""Lanes of a register."""


class Lanes(types.Type):
    """Doubles that are computed with at the same time."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = Lanes()
VECTOR = ir.VectorType(ir.DoubleType(), COUNT)


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager, lanes: Lanes) -> None:
        super().__init__(manager, lanes, VECTOR)


def shuffled(builder: ir.IRBuilder, a: ir.Value, b: ir.Value, numbers: list[int]) -> ir.Value:
    """Lanes of two registers by number, those of the second counted on."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(cgutils.int32_t, len(numbers)), numbers))


def splat(builder: ir.IRBuilder, value: ir.Value) -> ir.Value:
    """A double in every lane; lanes as they are."""
    if value.type == VECTOR:
        return value
    one = builder.insert_element(ir.Constant(VECTOR, ir.Undefined), value, cgutils.int32_t(0))
    return shuffled(builder, one, one, [0] * COUNT)


def both(builder: ir.IRBuilder, *values: ir.Value) -> list[ir.Value]:
    """Values of one type, lanes if one of them is."""
    return [splat(builder, value) for value in values] if any(value.type == VECTOR for value in values) else list(values)


def _arithmetic(operation: Callable[..., Any], instruction: str) -> None:
    """Give lanes an operation with lanes, and with a number on either side."""

    @infer_global(operation)
    class _Template(AbstractTemplate):
        def generic(self, args, kws):
            fitting = len(args) == 2 and LANES in args and all(arg == LANES or isinstance(arg, types.Number) for arg in args)
            return signature(LANES, *(arg if arg == LANES else types.float64 for arg in args)) if fitting else None

    @lower_builtin(operation, Lanes, Lanes)
    @lower_builtin(operation, types.Float, Lanes)
    @lower_builtin(operation, Lanes, types.Float)
    def _lanewise(context, builder, sig, args):
        return getattr(builder, instruction)(*both(builder, *args))


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")
_arithmetic(operator.truediv, "fdiv")


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args, kws):
        return signature(LANES, *args) if args == (LANES,) else None


@lower_builtin(operator.neg, Lanes)
def _negative(context, builder, sig, args):
    return builder.fneg(args[0])


def type_for(count: int) -> types.Type:
    """Type of a value for so many particles."""
    return types.float64 if count == 1 else LANES


def built(builder, items: list[ir.Value]) -> ir.Value:
    """A value for one particle, or for four."""
    if len(items) == 1:
        return items[0]
    vector = ir.Constant(VECTOR, ir.Undefined)
    for k, item in enumerate(items):
        vector = builder.insert_element(vector, item, cgutils.int32_t(k))
    return vector


def taken(builder, value: ir.Value) -> list[ir.Value]:
    if value.type != VECTOR:
        return [value]
    return [builder.extract_element(value, cgutils.int32_t(k)) for k in range(COUNT)]


@intrinsic
def lanes(typingctx, numbers):
    """Numbers of one particle or of four as a value."""

    def code(context, builder, sig, args):
        return built(builder, cgutils.unpack_tuple(builder, args[0]))

    return type_for(numbers.count)(numbers), code


def _floor(builder, value: ir.Value) -> ir.Value:
    name = "llvm.floor.f64" if value.type != VECTOR else f"llvm.floor.v{COUNT}f64"
    return builder.call(
        cgutils.get_or_insert_function(builder.module, ir.FunctionType(value.type, [value.type]), name), [value]
    )


@intrinsic
def floor(typingctx, value):
    """The whole numbers below a value."""

    def code(context, builder, sig, args):
        return _floor(builder, args[0])

    return value(value), code


@intrinsic
def positive(typingctx, value):
    """Whether a value is positive for all particles, which NaN is not."""

    def code(context, builder, sig, args):
        if value != LANES:
            return builder.fcmp_ordered(">", args[0], ir.Constant(ir.DoubleType(), 0.0))
        above = builder.fcmp_ordered(">", args[0], ir.Constant(VECTOR, [0.0] * COUNT))
        return builder.icmp_unsigned("==", builder.bitcast(above, ir.IntType(COUNT)), ir.IntType(COUNT)(-1))

    return types.boolean(value), code


@intrinsic
def split(typingctx, x, inside, limits):
    """Fractions of a vector of lanes, the whole numbers below it in the first lane (d,), and how many of the first lanes share these, none
    negative, and lie in 0 <= inside < limits (d,); which NaN does not.
    """
    whole = types.UniTuple(types.intp, x.count)

    def code(context, builder, sig, args):
        fractions, firsts, alike = [], [], ir.Constant(ir.VectorType(ir.IntType(1), COUNT), [1] * COUNT)
        for value, place, limit in zip(*unpacked(builder, args), strict=True):
            below = _floor(builder, value)
            first = builder.extract_element(below, cgutils.int32_t(0))
            high = splat(builder, context.cast(builder, limit, limits.dtype, types.float64))
            zero = ir.Constant(VECTOR, [0.0] * COUNT)
            tests = [builder.fcmp_ordered("==", below, splat(builder, first)), builder.fcmp_ordered("<", place, high)]
            tests += [builder.fcmp_ordered(">=", one, zero) for one in (below, place)]
            alike = reduce(builder.and_, tests, alike)
            fractions.append(builder.fsub(value, below))
            firsts.append(builder.fptosi(first, ir.IntType(64)))
        bits = builder.zext(builder.bitcast(builder.not_(alike), ir.IntType(COUNT)), cgutils.int32_t)
        count = builder.cttz(builder.or_(bits, cgutils.int32_t(1 << COUNT)), cgutils.false_bit)
        parts = [
            context.make_tuple(builder, x, fractions),
            context.make_tuple(builder, whole, firsts),
            builder.zext(count, ir.IntType(64)),
        ]
        return context.make_tuple(builder, sig.return_type, parts)

    return types.Tuple([x, whole, types.intp])(x, inside, limits), code


@intrinsic
def repeated(typingctx, vector, present):
    """A vector of lanes, the first lane in the place of those where `present` is zero."""

    def code(context, builder, sig, args):
        there = builder.fcmp_ordered(">", args[1], ir.Constant(VECTOR, [0.0] * COUNT))
        values = cgutils.unpack_tuple(builder, args[0])
        kept = [builder.select(there, value, shuffled(builder, value, value, [0] * COUNT)) for value in values]
        return context.make_tuple(builder, vector, kept)

    return vector(vector, present), code


def _extreme(predicate: str):
    def typed(typingctx, a, b):
        def code(context, builder, sig, args):
            x, y = both(builder, *args)
            return builder.select(builder.fcmp_ordered(predicate, x, y), x, y)

        return (LANES if LANES in (a, b) else types.float64)(a, b), code

    return intrinsic(typed)


largest, least = _extreme(">"), _extreme("<")
"""The larger and the smaller of two values; the second if one is not a number."""


@intrinsic
def lanes_of(typingctx, values, k):
    """The numbers of particle k, of a tuple of values."""

    def code(context, builder, sig, args):
        number = builder.trunc(context.cast(builder, args[1], k, types.int64), cgutils.int32_t)
        items = cgutils.unpack_tuple(builder, args[0])
        taken = [builder.extract_element(item, number) if item.type == VECTOR else item for item in items]
        return context.make_tuple(builder, sig.return_type, taken)

    return types.UniTuple(types.float64, values.count)(values, k), code


@intrinsic
def total(typingctx, value):
    """Sum over the particles."""

    def code(context, builder, sig, args):
        return reduce(builder.fadd, taken(builder, args[0]))

    return types.float64(value), code


def times(builder, a, b):
    """Product, or nothing if there is no factor."""
    return None if a is None else builder.fmul(*both(builder, a, b))


def plus(builder, a, b):
    """Sum of those that there are."""
    if a is None or b is None:
        return a if b is None else b
    return builder.fadd(*both(builder, a, b))


def unpacked(builder, values):
    return [cgutils.unpack_tuple(builder, value) for value in values]


def nested(builder, value) -> list[list[ir.Value]]:
    return [cgutils.unpack_tuple(builder, part) for part in cgutils.unpack_tuple(builder, value)]


def as_tuple(context, builder, sig, values):
    lanewise = sig.return_type.dtype == LANES
    return context.make_tuple(builder, sig.return_type, [splat(builder, v) if lanewise else v for v in values])


def value_of(context, builder, kind, value):
    return value if kind == LANES else context.cast(builder, value, kind, types.float64)
