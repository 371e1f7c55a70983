"""What compiled code reads and writes: rows of arrays, and the values of nodes at a stencil."""

import operator
from functools import reduce

from llvmlite import ir
from numba.core import cgutils

from .flow import Kept, each
from .lanes import built, taken, total
from .tracing import traced
from .values import COUNT, DOUBLE, VECTOR, Memory, Value, alike, beyond, code_of, shuffled

# What is a number or lanes has no annotation.
# mypy: disable-error-code="no-untyped-def"

PAIR = ir.VectorType(DOUBLE, 2)


@traced
def row(array, index, like):
    """The values from array[index] on as a tuple, as many as `like` has; no index counts from the end."""
    start = array.address(*index)
    return tuple(array.load(start, k) for k in range(len(like)))


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


def _starts(grid, nodes: Memory, component, first, plane=None) -> list[ir.Value]:
    """Addresses of the first nodes of the rows along x of a stencil, that along y fastest: of all, or of those of a plane of it."""
    start = nodes.address(component, first)
    starts, steps = (
        ([start], grid.stride) if plane is None else ([beyond(nodes.builder, start, grid.stride[-1] * plane)], grid.stride[:-1])
    )
    for step in steps[:0:-1]:
        moves = [step * k for k in range(len(grid.width))]
        starts = [beyond(nodes.builder, start, move) for start in starts for move in moves]
    return starts


class _Table:
    """Values that compiled code finds by their number."""

    def __init__(self, builder: ir.IRBuilder, values) -> None:
        items = alike(builder, *values)
        self.builder, self.place = builder, cgutils.alloca_once(builder, ir.ArrayType(items[0].type, len(items)))
        for k, item in enumerate(items):
            builder.store(item, cgutils.gep_inbounds(builder, self.place, 0, k))

    def __getitem__(self, k: Value) -> Value:
        return Value(self.builder, self.builder.load(cgutils.gep_inbounds(self.builder, self.place, 0, k.code)))


def _in_planes(grid) -> bool:
    """Whether the planes of a stencil are gone through by a loop of compiled code: all at once would take seconds to compile."""
    return len(grid.stride) == 3 and len(grid.width) > 3


@traced
def gathered(grid, nodes, first, w):
    """Sums of w a_I over a stencil that begins at its first node, by component of the values of nodes (C, n), as many as axes.

    w are the products of functions w (d, W) along the axes.
    """
    return _product_sums(grid, nodes, first, [w])


@traced
def gathered_by(grid, nodes, first, w, e):
    """The same with each of e (d, W) in the place of its own: by component, then by axis."""
    return _product_sums(grid, nodes, first, [(*w[:k], e[k], *w[k + 1 :]) for k in range(len(w))])


def _product_sums(grid, nodes: Memory, first, products) -> tuple[Value, ...]:
    """Sums of the values of nodes times products, by component, then by product."""
    if not _in_planes(grid):
        return tuple(_product_sum(component, w) for component in _loaded(grid, nodes, first) for w in products)
    along_z = [_Table(nodes.builder, w[-1]) for w in products]
    sums = [Kept(0.0, like=w[-1][0]) for _ in grid.stride for w in products]
    with each(0, len(grid.width), like=nodes) as k:
        terms = [
            table[k] * _product_sum(component, w[:-1])
            for component in _loaded(grid, nodes, first, k)
            for w, table in zip(products, along_z, strict=True)
        ]
        for kept, term in zip(sums, terms, strict=True):
            kept.value += term
    return tuple(kept.value for kept in sums)


def _loaded(grid, nodes: Memory, first, plane=None) -> list[list[Value]]:
    """Values of nodes by component and node, x fastest."""
    width = range(len(grid.width))
    return [
        [nodes.load(start, j) for start in _starts(grid, nodes, c, first, plane) for j in width]
        for c in range(len(grid.stride))
    ]


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
    # What stands before w and, by axis, before e.
    before = [(amount and amount[c], [s[c] for s in slope] if slope else [None] * d) for c in range(len(amount or slope[0]))]
    if not _in_planes(grid):
        for c, one in enumerate(before):
            _add(_starts(grid, nodes, component + c, first), _spread([one], w, e), nodes.builder, width)
        return
    along_z = _Table(nodes.builder, w[-1]), _Table(nodes.builder, e[-1])
    with each(0, width, like=nodes) as k:
        for c, one in enumerate(before):
            of_plane = _along([one], *([table[k]] for table in along_z))
            _add(_starts(grid, nodes, component + c, first, k), _spread(of_plane, w[:-1], e[:-1]), nodes.builder, width)


def _spread(terms, w, e) -> list[Value]:
    """Values of nodes, x fastest, of what stands before the functions w and e of the axes."""
    for functions in zip(reversed(w), reversed(e), strict=True):
        terms = _along(terms, *functions)
    return [value for value, _ in terms]


def _along(terms, w, e):
    """What stands before the functions of the axes before one, by node along it."""
    return [
        (_plus(_times(a, w_j), _times(s[-1], e_j)), [_times(b, w_j) for b in s[:-1]])
        for a, s in terms
        for w_j, e_j in zip(w, e, strict=True)
    ]


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
