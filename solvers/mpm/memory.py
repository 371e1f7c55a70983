"""What compiled code reads and writes: rows of arrays, and the values of nodes at a stencil."""

import operator
from functools import reduce

from llvmlite import ir

from .lanes import built, taken, total
from .tracing import traced
from .values import COUNT, DOUBLE, VECTOR, Memory, Value, beyond, code_of, shuffled

# What is a number or lanes has no annotation.
# mypy: disable-error-code="no-untyped-def"

PAIR = ir.VectorType(DOUBLE, 2)


@traced
def row(array, index, like):
    """The values from array[index] on as a tuple, as many as `like` has; no index counts from the end."""
    start = array.address(*index)
    return tuple(array.load(start, k) for k in range(len(like)))


@traced
def store(array, index, values):
    """Write a tuple to array[index] and on."""
    start = array.address(*index)
    for k, value in enumerate(values):
        array.store(start, k, value)


@traced
def rows(array, numbers, column, like):
    """As many columns as `like` has, from one on, of the rows of some numbers, one or four: a tuple of values."""
    starts, paired = [array.address(n, column) for n in numbers], len(like) // 2 * 2 if len(numbers) == COUNT else 0
    pairs = [value for k in range(0, paired, 2) for value in _loaded_pair(array, starts, k)]
    return (*pairs, *(built([array.load(start, k) for start in starts]) for k in range(paired, len(like))))


def _loaded_pair(array: Memory, starts: list[ir.Value], k: int) -> list[Value]:
    """Two columns of four rows from the k-th on: two loads and a shuffle for each, where numbers one by one take three shuffles."""
    builder = array.builder
    a, b, c, d = (array.together(beyond(builder, start, k), PAIR) for start in starts)
    even, odd = shuffled(builder, a, c, [0, 1, 2, 3]), shuffled(builder, b, d, [0, 1, 2, 3])
    return [Value(builder, shuffled(builder, even, odd, lanes)) for lanes in ([0, 4, 2, 6], [1, 5, 3, 7])]


def _store_pair(array: Memory, starts: list[ir.Value], k: int, x: ir.Value, y: ir.Value) -> None:
    """Write two columns of four rows from the k-th on, the first row last."""
    builder = array.builder
    even, odd = shuffled(builder, x, y, [0, 4, 2, 6]), shuffled(builder, x, y, [1, 5, 3, 7])
    for start, of_two, lanes in zip(starts[::-1], (odd, even, odd, even), ([2, 3], [2, 3], [0, 1], [0, 1]), strict=True):
        array.store_together(beyond(builder, start, k), shuffled(builder, of_two, of_two, lanes))


@traced
def store_rows(array, numbers, column, values):
    """Write a tuple of values, or of numbers for all, into the rows of some numbers, from a column on.

    The first row comes last, which stands in for missing ones.
    """
    starts, paired = [array.address(n, column) for n in numbers], len(values) // 2 * 2 if len(numbers) == COUNT else 0
    for k in range(0, paired, 2):
        x, y = (code_of(array.builder, value, VECTOR) for value in values[k : k + 2])
        _store_pair(array, starts, k, x, y)
    for k in range(paired, len(values)):
        for start, number in zip(starts[::-1], taken(values[k], len(starts))[::-1], strict=True):
            array.store(start, k, number)


@traced
def add_totals(array, first, m, values):
    """Add sum_p m times a tuple of values to an array, from an entry on."""
    start = array.address(first)
    for k, value in enumerate(values):
        array.store(start, k, array.load(start, k) + total(m * value))


def _starts(grid, nodes: Memory, component, first) -> list[ir.Value]:
    """Addresses of the first nodes of the rows along x of a stencil, that along y fastest."""
    starts = [nodes.address(component, first)]
    for step in grid.stride[:0:-1]:
        moves = [step * k for k in range(len(grid.width))]
        starts = [beyond(nodes.builder, start, move) for start in starts for move in moves]
    return starts


@traced
def gathered(grid, nodes, first, w):
    """Sums of w a_I over a stencil that begins at its first node, by component of the values of nodes (C, n), as many as axes.

    w are the products of functions w (d, W) along the axes.
    """
    return tuple(_product_sum(component, w) for component in _loaded(grid, nodes, first))


@traced
def gathered_by(grid, nodes, first, w, e):
    """The same with each of e (d, W) in the place of its own: by component, then by axis."""
    return tuple(
        _product_sum(component, (*w[:k], e[k], *w[k + 1 :])) for component in _loaded(grid, nodes, first) for k in range(len(w))
    )


def _loaded(grid, nodes: Memory, first) -> list[list[Value]]:
    """Values of nodes by component and node, x fastest."""
    width = range(len(grid.width))
    return [[nodes.load(start, j) for start in _starts(grid, nodes, c, first) for j in width] for c in range(len(grid.stride))]


def _product_sum(values: list[Value], functions) -> Value:
    """Sum of the values of nodes times the products of functions by axis and node."""
    for factors in functions:
        n = len(factors)
        terms = [factors[k % n] * value for k, value in enumerate(values)]
        values = [reduce(operator.add, terms[k : k + n]) for k in range(0, len(terms), n)]
    return values[0]


@traced
def add_field(grid, nodes, component, first, w, e, amount, slope):
    """Add to components of the values of nodes (C, n), from one on, what particles have at a stencil: a_c w + sum_k s_kc w_k.

    w_k are the products with e_k in the place of w_k. Either of the amounts a (C,) and the slopes s (d, C) may be None.
    """
    d, width = len(grid.stride), len(grid.width)
    for c in range(len(amount or slope[0])):
        # What stands before w and, by axis, before e: by nodes, as one axis after the other is multiplied in.
        terms = [(amount and amount[c], [s[c] for s in slope] if slope else [None] * d)]
        for k in reversed(range(d)):
            terms = [
                (_plus(_times(a, w[k][j]), _times(s[k], e[k][j])), [_times(b, w[k][j]) for b in s[:k]])
                for a, s in terms
                for j in range(width)
            ]
        _add(_starts(grid, nodes, component + c, first), [value for value, _ in terms], nodes.builder, width)


def _times(a, b):
    """Product, or nothing if there is no factor."""
    return None if a is None else a * b


def _plus(a, b):
    """Sum of those that there are."""
    return a if b is None else b if a is None else a + b


def _add(starts: list[ir.Value], values: list[Value], builder: ir.IRBuilder, width: int) -> None:
    """Add values by row and node, each the sum of its lanes, to what begins at the starts of the rows."""
    if values[0].code.type != VECTOR:
        for k, value in enumerate(values):
            place = beyond(builder, starts[k // width], k % width)
            builder.store(builder.fadd(builder.load(place), value.code), place)
        return
    together = min(2, len(starts)) if width == 2 else 1  # rows that fill a register
    for k in range(0, len(starts), together):
        zeros = [ir.Constant(VECTOR, [0.0] * COUNT)] * (COUNT - width * together)
        sums = _added_up(builder, [value.code for value in values[k * width : (k + together) * width]] + zeros)
        for j, start in enumerate(starts[k : k + together]):
            added = shuffled(builder, sums, sums, [2 * j, 2 * j + 1]) if width == 2 else sums
            place = builder.bitcast(start, added.type.as_pointer())
            builder.store(builder.fadd(builder.load(place, align=8), added), place, align=8)


def _added_up(builder, values: list[ir.Value]) -> ir.Value:
    """Sums over the lanes of four values, as lanes; pairs of registers are added until each lane holds a sum."""
    for even, odd in ([0, 4, 2, 6], [1, 5, 3, 7]), ([0, 1, 4, 5], [2, 3, 6, 7]):
        pairs = zip(values[::2], values[1::2], strict=True)
        values = [builder.fadd(shuffled(builder, a, b, even), shuffled(builder, a, b, odd)) for a, b in pairs]
    return values[0]
