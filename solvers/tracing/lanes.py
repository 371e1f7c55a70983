"""Lanes: the doubles of one register, one for each of four particles.

What the passes compute with is a number for one particle, or lanes for four: traced functions take both. LLVM does not find this out by
itself.
"""

import math
import operator
from functools import reduce

from llvmlite import ir
from numba.core import cgutils

from .tracing import traced
from .values import COUNT, DOUBLE, TRUTH, VECTOR, WHOLE, Value, code_of, real, shuffled, splat, where

# What is a number or lanes has no annotation.
# mypy: disable-error-code="no-untyped-def"


def built(items):
    """Numbers of one particle or of four as a value."""
    if len(items) == 1:
        return items[0]
    vector, builder = ir.Constant(VECTOR, ir.Undefined), next(item.builder for item in items if isinstance(item, Value))
    for k, item in enumerate(items):
        vector = builder.insert_element(vector, code_of(builder, item, DOUBLE), cgutils.int32_t(k))
    return Value(builder, vector)


def taken(value, count=1):
    """Numbers of the particles of a value; a number that all share is repeated."""
    if not isinstance(value, Value) or value.code.type == DOUBLE:
        return [value] * count
    return [Value(value.builder, value.builder.extract_element(value.code, cgutils.int32_t(k))) for k in range(COUNT)]


lanes = traced(built)


def _of_llvm(name: str, value: Value) -> Value:
    """A function of LLVM of a value."""
    code, kind = value.builder, value.code.type
    full = f"llvm.{name}.{'f64' if kind == DOUBLE else f'v{COUNT}f64'}"
    return Value(
        code, code.call(cgutils.get_or_insert_function(code.module, ir.FunctionType(kind, [kind]), full), [value.code])
    )


@traced
def floor(value):
    """The whole number below a value."""
    return _of_llvm("floor", real(value)) if isinstance(value, Value) else float(math.floor(value))


@traced
def root(value):
    """Square root of a value."""
    return _of_llvm("sqrt", value) if isinstance(value, Value) else math.sqrt(value)


@traced
def whole(value):
    """The whole part of a number."""
    return Value(value.builder, value.builder.fptosi(value.code, WHOLE)) if isinstance(value, Value) else int(value)


@traced
def positive(value):
    """Whether a value is positive for all particles, which NaN is not."""
    above = value > 0.0
    if not isinstance(above, Value) or above.code.type == TRUTH:
        return above
    bits = above.builder.bitcast(above.code, ir.IntType(COUNT))
    return Value(above.builder, above.builder.icmp_unsigned("==", bits, ir.IntType(COUNT)(-1)))


@traced
def split(x):
    """Fractions of a vector of lanes, the whole numbers below it in the first lane (d,), and in which lanes they are the same."""
    under = [floor(value) for value in x]
    firsts = tuple(taken(value)[0] for value in under)
    shared = reduce(operator.and_, [same(value, first) for value, first in zip(under, firsts, strict=True)])
    return tuple(value - floored for value, floored in zip(x, under, strict=True)), firsts, shared


def same(a: Value, b: Value) -> Value:
    """Where values are equal."""
    return Value(a.builder, a.builder.fcmp_ordered("==", a.code, splat(a.builder, b.code)))


def leading(truths: Value) -> Value:
    """How many of the lanes, from the first on, are true."""
    code = truths.builder
    bits = code.zext(code.bitcast(code.not_(truths.code), ir.IntType(COUNT)), cgutils.int32_t)
    count = code.cttz(code.or_(bits, cgutils.int32_t(1 << COUNT)), cgutils.false_bit)
    return Value(code, code.zext(count, WHOLE))


@traced
def first_lanes(count):
    """1 in so many lanes, the first, and 0 in the others."""
    code = count.builder
    numbers = splat(code, WHOLE(0)).type(list(range(COUNT)))
    return where(Value(code, code.icmp_signed("<", numbers, splat(code, count.code))), 1.0, 0.0)


@traced
def repeated(vector, present):
    """A vector of lanes, the first lane in the place of those where `present` is zero."""
    there = present > 0.0
    return tuple(
        where(there, value, Value(value.builder, shuffled(value.builder, value.code, value.code, [0] * COUNT)))
        for value in vector
    )


@traced
def largest(a, b):
    """The larger of two values; the second if one is not a number."""
    return where(a > b, a, b)


@traced
def least(a, b):
    """The smaller of two values; the second if one is not a number."""
    return where(a < b, a, b)


@traced
def size(value):
    """How far a value is from zero."""
    return largest(value, -value)


@traced
def total(value):
    """Sum over the particles."""
    return reduce(operator.add, taken(value))
