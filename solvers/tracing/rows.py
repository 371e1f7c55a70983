"""Rows of arrays: loaded into tuples of values, and stored from them; the rows of `LANES` indices as vectors."""

from llvmlite import ir

from .arrays import Pointer
from .lanes import pack, reduce_sum, unpack
from .tracer import traced
from .values import DOUBLE, LANES, VECTOR, Value, as_code, shuffle

# Scalars or vectors have no annotation.
# mypy: disable-error-code="no-untyped-def"

PAIR = ir.VectorType(DOUBLE, 2)


@traced
def load_row(array, index, like):
    """Elements from array[index] on as a tuple, as many as `like` has; no index counts from the end."""
    start = array.pointer(*index)
    return tuple(start.load(k) for k in range(len(like)))


@traced
def load_rows(array, numbers, column, like):
    """Columns of the rows of some numbers, one or `LANES`, from a column on, as many as `like` has: a tuple of values."""
    starts, paired = [array.pointer(n, column) for n in numbers], len(like) // 2 * 2 if len(numbers) == LANES else 0
    pairs = [value for k in range(0, paired, 2) for value in _load_pair(starts, k)]
    return (*pairs, *(pack([start.load(k) for start in starts]) for k in range(paired, len(like))))


def _load_pair(starts: list[Pointer], k: int) -> list[Value]:
    """Two columns of four rows, from the k-th on: two loads and a shuffle each, where scalars would take three shuffles."""
    builder = starts[0].builder
    a, b, c, d = (start.offset(k).load_vector(PAIR) for start in starts)
    even, odd = shuffle(builder, a, c, [0, 1, 2, 3]), shuffle(builder, b, d, [0, 1, 2, 3])
    return [Value(builder, shuffle(builder, even, odd, lanes)) for lanes in ([0, 4, 2, 6], [1, 5, 3, 7])]


@traced
def store_rows(array, numbers, column, values):
    """Store a tuple of values, or of numbers for all rows, to the rows of some numbers, from a column on.

    The first row is stored last: it may stand in for missing ones.
    """
    starts, paired = [array.pointer(n, column) for n in numbers], len(values) // 2 * 2 if len(numbers) == LANES else 0
    for k in range(0, paired, 2):
        x, y = (as_code(array.builder, value, VECTOR) for value in values[k : k + 2])
        _store_pair(starts, k, x, y)
    for k in range(paired, len(values)):
        for start, number in zip(starts[::-1], unpack(values[k], len(starts))[::-1], strict=True):
            start.store(number, k)


def _store_pair(starts: list[Pointer], k: int, x: ir.Value, y: ir.Value) -> None:
    """Store two columns of four rows, from the k-th on."""
    builder = starts[0].builder
    even, odd = shuffle(builder, x, y, [0, 4, 2, 6]), shuffle(builder, x, y, [1, 5, 3, 7])
    for start, pairs, lanes in zip(starts[::-1], (odd, even, odd, even), ([2, 3], [2, 3], [0, 1], [0, 1]), strict=True):
        start.offset(k).store_vector(shuffle(builder, pairs, pairs, lanes))


@traced
def add_sums(array, first, factor, values):
    """Add the sums over the lanes of a factor times each of a tuple of values to consecutive elements, from `first` on."""
    start = array.pointer(first)
    for k, value in enumerate(values):
        start.store(start.load(k) + reduce_sum(factor * value), k)
