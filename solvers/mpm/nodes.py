"""Values of nodes at a stencil: what they sum up to, and what is added to them."""

import operator
from functools import reduce

from ..tracing import Array, Pointer, Table, Value, Variable, for_range, has_lanes, reduce_sums, traced

# Scalars or vectors have no annotation.
# mypy: disable-error-code="no-untyped-def"


def _starts(grid, nodes: Array, component, first, plane=None) -> list[Pointer]:
    """Addresses of the first nodes of the rows along x of a stencil, that along y fastest: of all, or of those of a plane of it."""
    start = nodes.pointer(component, first)
    starts, steps = ([start], grid.stride) if plane is None else ([start.offset(grid.stride[-1] * plane)], grid.stride[:-1])
    for step in steps[:0:-1]:
        moves = [step * k for k in range(len(grid.width))]
        starts = [start.offset(move) for start in starts for move in moves]
    return starts


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


def _product_sums(grid, nodes: Array, first, products) -> tuple[Value, ...]:
    """Sums of the values of nodes times products, by component, then by product."""
    if not _in_planes(grid):
        return tuple(_product_sum(component, w) for component in _loaded(grid, nodes, first) for w in products)
    along_z = [Table(w[-1], like=nodes) for w in products]
    sums = [Variable(0.0, like=w[-1][0]) for _ in grid.stride for w in products]
    with for_range(0, len(grid.width), like=nodes) as k:
        terms = [
            table[k] * _product_sum(component, w[:-1])
            for component in _loaded(grid, nodes, first, k)
            for w, table in zip(products, along_z, strict=True)
        ]
        for one, term in zip(sums, terms, strict=True):
            one.value += term
    return tuple(one.value for one in sums)


def _loaded(grid, nodes: Array, first, plane=None) -> list[list[Value]]:
    """Values of nodes by component and node, x fastest."""
    width = range(len(grid.width))
    return [[start.load(j) for start in _starts(grid, nodes, c, first, plane) for j in width] for c in range(len(grid.stride))]


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
            _add(_starts(grid, nodes, component + c, first), _spread([one], w, e), width)
        return
    along_z = Table(w[-1], like=nodes), Table(e[-1], like=nodes)
    with for_range(0, width, like=nodes) as k:
        for c, one in enumerate(before):
            of_plane = _along([one], *([table[k]] for table in along_z))
            _add(_starts(grid, nodes, component + c, first, k), _spread(of_plane, w[:-1], e[:-1]), width)


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


def _add(starts: list[Pointer], values: list[Value], width: int) -> None:
    """Add values by row and node, each the sum of its lanes, to what begins at the starts of the rows."""
    if not has_lanes(values[0]):
        for k, value in enumerate(values):
            starts[k // width].add(value, k % width)
        return
    together = min(2, len(starts)) if width == 2 else 1  # rows that fill a vector
    for k in range(0, len(starts), together):
        sums = reduce_sums(values[k * width : (k + together) * width])
        for j, start in enumerate(starts[k : k + together]):
            if width == 2:
                start.add_lanes(sums, 2 * j, 2)
            else:
                start.add_lanes(sums)
