"""Functions of values: of a scalar, or of a vector lane by lane.

A caller writes a function once and calls it with scalars or with vectors of `LANES` doubles. LLVM does not vectorise such code itself.
"""

import math
import operator
from functools import reduce

from llvmlite import ir

from .selection import where
from .tracer import traced
from .values import (
    BOOLEAN,
    DOUBLE,
    FUSED,
    INTEGER,
    LANES,
    NUMBER,
    VECTOR,
    Value,
    as_code,
    as_double,
    broadcast,
    external,
    shuffle,
)

# Scalars or vectors have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def pack(items):
    """Pack `LANES` scalars into a vector; a single scalar stays one."""
    if len(items) == 1:
        return items[0]
    vector, builder = ir.Constant(VECTOR, ir.Undefined), next(item.builder for item in items if isinstance(item, Value))
    for k, item in enumerate(items):
        vector = builder.insert_element(vector, as_code(builder, item, DOUBLE), NUMBER(k))
    return Value(builder, vector)


def unpack(value, count=1):
    """Scalars of the lanes of a vector; a scalar `count` times."""
    if not has_lanes(value):
        return [value] * count
    return [Value(value.builder, value.builder.extract_element(value.code, NUMBER(k))) for k in range(LANES)]


def has_lanes(value) -> bool:
    """Whether a value is a vector."""
    return isinstance(value, Value) and isinstance(value.code.type, ir.VectorType)


def _intrinsic(name: str, value: Value) -> Value:
    """Call an intrinsic function of LLVM."""
    builder, kind = value.builder, value.code.type
    full = f"llvm.{name}.{'f64' if kind == DOUBLE else f'v{LANES}f64'}"
    return Value(builder, builder.call(external(builder, full, ir.FunctionType(kind, [kind])), [value.code], fastmath=FUSED))


@traced
def floor(value):
    """Largest integer not above a value, as a double."""
    return _intrinsic("floor", as_double(value)) if isinstance(value, Value) else float(math.floor(value))


@traced
def sqrt(value):
    """Square root."""
    return _intrinsic("sqrt", value) if isinstance(value, Value) else math.sqrt(value)


@traced
def as_integer(value):
    """Integer part of a double, as an integer."""
    return Value(value.builder, value.builder.fptosi(value.code, INTEGER)) if isinstance(value, Value) else int(value)


@traced
def maximum(a, b):
    """The larger of two values; the second if either is NaN."""
    return where(a > b, a, b)


@traced
def minimum(a, b):
    """The smaller of two values; the second if either is NaN."""
    return where(a < b, a, b)


@traced
def absolute(value):
    """Absolute value."""
    return maximum(value, -value)


@traced
def reduce_sum(value):
    """Sum over the lanes, from the first on; a scalar stays as it is."""
    return reduce(operator.add, unpack(value))


def reduce_sums(values) -> Value:
    """Sums over the lanes of at most `LANES` vectors, as a vector with one sum in each lane and zero in the rest."""
    builder = values[0].builder
    codes = [value.code for value in values] + [ir.Constant(VECTOR, [0.0] * LANES)] * (LANES - len(values))
    # Pairs of vectors are added until each lane holds one sum.
    for even, odd in ([0, 4, 2, 6], [1, 5, 3, 7]), ([0, 1, 4, 5], [2, 3, 6, 7]):
        pairs = zip(codes[::2], codes[1::2], strict=True)
        codes = [builder.fadd(shuffle(builder, a, b, even), shuffle(builder, a, b, odd), flags=FUSED) for a, b in pairs]
    return Value(builder, codes[0])


@traced
def all_positive(value):
    """Whether a value is positive in all lanes; NaN is not."""
    above = value > 0.0
    if not isinstance(above, Value) or above.code.type == BOOLEAN:
        return above
    bits = above.builder.bitcast(above.code, ir.IntType(LANES))
    return Value(above.builder, above.builder.icmp_unsigned("==", bits, ir.IntType(LANES)(-1)))


@traced
def split_floor(x):
    """Fractions of vectors (d,), their floors in lane 0 (d,), and a mask of the lanes whose floors are all those of lane 0."""
    floors = [floor(value) for value in x]
    firsts = tuple(unpack(value)[0] for value in floors)
    shared = reduce(operator.and_, [_equal_doubles(value, first) for value, first in zip(floors, firsts, strict=True)])
    return tuple(value - below for value, below in zip(x, floors, strict=True)), firsts, shared


def _equal_doubles(a: Value, b: Value) -> Value:
    """Mask of the lanes of a that are equal to a scalar b."""
    return Value(a.builder, a.builder.fcmp_ordered("==", a.code, broadcast(a.builder, b.code)))


def count_leading(mask: Value) -> Value:
    """Number of lanes, from lane 0 on, before the first in which a mask is false."""
    builder = mask.builder
    bits = builder.zext(builder.bitcast(builder.not_(mask.code), ir.IntType(LANES)), NUMBER)
    count = builder.cttz(builder.or_(bits, NUMBER(1 << LANES)), BOOLEAN(0))
    return Value(builder, builder.zext(count, INTEGER))


@traced
def leading_ones(count):
    """Vector of 1 in the first `count` lanes and 0 in the others."""
    builder = count.builder
    numbers = broadcast(builder, INTEGER(0)).type(list(range(LANES)))
    return where(Value(builder, builder.icmp_signed("<", numbers, broadcast(builder, count.code))), 1.0, 0.0)


@traced
def fill_from_first(vectors, present):
    """Vectors whose lanes are replaced by their lane 0 where `present` is zero."""
    there = present > 0.0
    return tuple(
        where(there, value, Value(value.builder, shuffle(value.builder, value.code, value.code, [0] * LANES)))
        for value in vectors
    )
