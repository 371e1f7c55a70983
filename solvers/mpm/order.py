"""Order of the particles: by cell for the memory, and in strips that threads may work on at the same time."""

import math
import operator
from functools import reduce

import numpy as np

from mpmverify.problem import Array

from ..tracing import (
    LANES,
    Variable,
    as_double,
    as_integer,
    equal,
    floor,
    for_range,
    logical_not,
    maximum,
    minimum,
    traced,
    unpack,
    when,
    where,
    while_loop,
)
from .places import cell_number, inside, node_of
from .state import FAILED, PASSED, UNSORTED, Grid, Integers, Nodes, Particles, Scheme, Strips
from .stencil import in_cells, place

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

MOST_STRIPS = 16
BEYOND = 3
"""Rows of nodes beyond a strip on either side in which the functions of its particles may begin."""
INTERVAL = 50
"""Steps after which the particles are sorted again, though none has left its strip."""
ARRANGED = 4
"""Steps after which those of one stencil are brought together again in the order of the passes."""


def strips(
    lower: float, h: float, cells: tuple[int, ...], width: int, particles: Particles, moving: bool, nodes: int, many: bool
) -> Strips:
    """Strips for a grid of so many cells, with so many `nodes` from row to row: one, or where there are `many` particles several of the
    same length, and not so short that two of one colour could meet.

    Notes
    -----
    Strips are worked on at the same time when they are of one colour, each second one. A particle may have left its strip by a
    row, and touches the nodes of `width` rows from its own, in the lane that a stencil of three does not use by adding zero: between
    two strips of a colour lie width + 1 rows. Where functions stay with their material points (`moving` false), particles do not
    leave their strips.
    """
    rows, size = cells[-1], particles.place.size
    count = min(MOST_STRIPS, rows // (width + 1)) // 2 * 2 if many else 1
    count = max(count, 1)
    first = (np.arange(count + 1) * rows // count).astype(np.int64)
    limits = np.stack([lower + h * (first[:-1] - 1), lower + h * (first[1:] + 1)], axis=1)
    if count == 1 or not moving:
        limits[:] = -np.inf, np.inf
    held = np.zeros(count + 1, dtype=np.int64)
    held[1:] = size
    longest = int(np.diff(first).max()) + 2 * BEYOND + 1
    return Strips(
        held,
        first,
        limits,
        np.ones(count, dtype=np.int64),
        np.zeros((count, 16)),
        np.zeros((count, 8)),
        np.zeros((2, 8)),
        np.zeros(size, dtype=np.int32),
        np.zeros((count, nodes * longest + 1), dtype=np.int64),
        np.zeros(math.prod(cells) + 1 if count > 1 else 0, dtype=np.int64),
        np.zeros(particles.state.shape[1]),
        np.array([UNSORTED, 0]),
    )


@traced
def arrange(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int) -> int:
    """Bring the particles of a strip together by their first node in the order of the passes (counting sort, stable).

    One that is elsewhere, or off the grid, which it is the passes that tell, counts as at a node of the strip all the same. A basis that
    takes particles one by one has no use for it.
    """
    if not grid.kind.together:
        return PASSED
    begin, end = strips.particles[s], strips.particles[s + 1]
    node, share, order = strips.node, strips.shares[s], particles.order
    lowest, highest = grid.stride[-1] * (strips.rows[s] - BEYOND), share.shape[0] - 2
    with for_range(0, share.shape[0]) as c:
        share[c] = 0
    with for_range(begin, end, LANES) as p:
        which = [minimum(p + k, end - 1) for k in range(LANES)]
        _, first = in_cells(scheme, grid, particles, which)
        nodes_of_four = node_of(grid, [floor(along) for along in first]) - lowest
        for k, one in enumerate(unpack(minimum(maximum(nodes_of_four, 0.0), as_double(highest)))):
            node[which[k]] = as_integer(one)
            share[node[which[k]] + 1] += where(p + k < end, 1, 0)
    with for_range(0, highest + 1) as c:
        share[c + 1] += share[c]
    with for_range(begin, end) as p:
        order[begin + share[node[p]]] = p
        share[node[p]] += 1
    return PASSED


@traced
def cell_of(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> int:
    """Number of the cell of a particle, x fastest; -1 when it is not on the grid."""
    s = place(scheme, grid, particles, p)
    return where(
        inside(grid, s), cell_number(grid, [minimum(as_integer(a), n - 1) for a, n in zip(s, grid.cells, strict=True)]), -1
    )


@traced
def permute(particles: Particles, order: Integers, spare: Array) -> None:
    """Particles in another order (P,), along its cycles; `order` becomes that of the sorted ones, `spare` holds a state (K,)."""
    place, state = particles.place, particles.state
    with for_range(0, order.shape[0]) as first, when(logical_not(equal(order[first], first))):
        number, hole = place[first], Variable(first)
        with for_range(0, spare.shape[0]) as c:
            spare[c] = state[first, c]
        with while_loop(lambda: logical_not(equal(order[hole.value], first)), like=first):
            at, source = hole.value, order[hole.value]
            place[at] = place[source]
            with for_range(0, spare.shape[0]) as c:
                state[at, c] = state[source, c]
            order[at] = at
            hole.value = source
        last = hole.value
        place[last] = number
        order[last] = last
        with for_range(0, spare.shape[0]) as c:
            state[last, c] = spare[c]


@traced
def sort(scheme: Scheme, grid: Grid, particles: Particles, strips: Strips, n: int) -> int:
    """Sort the particles by cell before step n (counting sort, stable) and share them out among the strips; FAILED when one is off the
    grid.
    """
    cell, order, start = strips.node, particles.order, strips.start
    row_of_cells = reduce(operator.mul, grid.cells[:-1], 1)
    away = Variable(0, order.shape[0])
    with for_range(0, start.shape[0]) as c:
        start[c] = 0
    with for_range(0, order.shape[0]) as p:
        cell[p] = cell_of(scheme, grid, particles, p)
        away.value = where(cell[p] < 0, 1, away.value)
        start[cell[p] + 1] += 1
    with when(away.value < 1):
        with for_range(1, start.shape[0]) as c:
            start[c] += start[c - 1]
        with for_range(0, strips.rows.shape[0]) as s:
            strips.particles[s] = start[strips.rows[s] * row_of_cells]
        with for_range(0, order.shape[0]) as p:
            order[start[cell[p]]] = p
            start[cell[p]] += 1
        permute(particles, order, strips.spare)
        strips.sorting[0] = n
        strips.sorting[1] += 1
    return where(away.value < 1, PASSED, FAILED)


@traced
def no_sort(scheme: Scheme, grid: Grid, particles: Particles, strips: Strips, n: int) -> int:
    """For one strip."""
    return PASSED
