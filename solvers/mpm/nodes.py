"""Sums of the values of nodes over a stencil, and what particles add to these values."""

import operator
from functools import reduce

from ..tracing import Array, Pointer, Table, Value, Variable, for_range, has_lanes, reduce_sums, traced

# Scalars or vectors have no annotation.
# mypy: disable-error-code="no-untyped-def"


def _starts(grid, nodes: Array, component, first, plane=None) -> list[Pointer]:
    """Pointers to the first nodes of the rows of a stencil along x, y fastest: of all rows, or of those in a plane of constant z."""
    start = nodes.pointer(component, first)
    starts, steps = ([start], grid.stride) if plane is None else ([start.offset(grid.stride[-1] * plane)], grid.stride[:-1])
    for step in steps[:0:-1]:
        moves = [step * k for k in range(len(grid.width))]
        starts = [start.offset(move) for start in starts for move in moves]
    return starts


def _in_planes(grid) -> bool:
    """Whether compiled code loops over the planes of a stencil; to unroll them all would take seconds to compile."""
    return len(grid.stride) == 3 and len(grid.width) > 3


@traced
def gathered(grid, nodes, first, w):
    """Vector sum_I w_I a_I (d,) over the stencil from the node `first` on, of values of nodes a (d, n).

    The weights w_I are products of functions w (d, W) along the axes.
    """
    return _product_sums(grid, nodes, first, [w])


@traced
def gathered_by(grid, nodes, first, w, e):
    """The same sums with e_k (W,) instead of w_k in the products, for each axis k: row-major (d d), by component, then by axis."""
    return _product_sums(grid, nodes, first, [(*w[:k], e[k], *w[k + 1 :]) for k in range(len(w))])


def _product_sums(grid, nodes: Array, first, products) -> tuple[Value, ...]:
    """Sums of the values of nodes times products of functions: by component, then by product."""
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
    """Add a_c w_I + sum_k s_kc w_kI of particles to the values of nodes (C, n) at a stencil, from row `component` on.

    w_I are products of functions w (d, W) along the axes, and w_kI those with e_k instead of w_k. Either `amount` a (C,) or
    `slope` s (d, C) may be None.
    """
    d, width = len(grid.stride), len(grid.width)
    # Factors of w and, by axis, of e.
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
    """Values of nodes, x fastest, from the factors of the functions w and e of the axes."""
    for functions in zip(reversed(w), reversed(e), strict=True):
        terms = _along(terms, *functions)
    return [value for value, _ in terms]


def _along(terms, w, e):
    """Factors of the functions of the remaining axes, for each node along the last one."""
    return [
        (_plus(_times(a, w_j), _times(s[-1], e_j)), [_times(b, w_j) for b in s[:-1]])
        for a, s in terms
        for w_j, e_j in zip(w, e, strict=True)
    ]


def _times(a, b):
    """Product; None if a is None."""
    return None if a is None else a * b


def _plus(a, b):
    """Sum of those that are not None."""
    return a if b is None else b if a is None else a + b


def _add(starts: list[Pointer], values: list[Value], width: int) -> None:
    """Add values, by row and node, to the nodes from the starts of the rows on; of lanes their sum."""
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
