"""Order of the particles: sorted by cell, which is quicker in memory, in strips on which threads can work at the same time."""

import math
import operator
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
from .state import FAILED, PASSED, Grid, Integers, Nodes, Particles, Scheme
from .stencil import in_cells, place

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

MOST_STRIPS = 16
BEYOND = 3
"""Rows of nodes beyond either side of a strip in which the functions of its particles may begin."""
INTERVAL = 50
"""Steps after which the particles are sorted again even if none has left its strip."""
UNSORTED = -1
"""Mark, in place of the step of the last sorting, that the particles must be sorted before the next step."""
ARRANGED = 4
"""Steps after which the particles of a strip are ordered again by their stencils."""


class Strips(NamedTuple):
    """S strips of cells across the last axis, each with its particles.

    particles : ndarray
        First particle of each strip, and the number of particles (S + 1,).
    rows : ndarray
        First row of cells of each strip, and the number of rows (S + 1,).
    limits : ndarray
        Limits of the last coordinate; a particle beyond them is sorted again (S, 2) [m].
    passed : ndarray
        Status of the passes over each strip (S,).
    sums : ndarray
        Sums of the passes over the particles of each strip (S, 16).
    nodal : ndarray
        Sums of the passes over the nodes, which are cut into S parts, a cache line each (S, 8).
    total : ndarray
        Sums of `nodal` over the parts, of two passes (2, 8).
    node : ndarray
        First node of each particle for `arrange`, its cell for `sort` (P,).
    shares : ndarray
        Number of particles of a strip at each node, for `arrange` (S, C).
    start : ndarray
        Number of particles in the cells before each, for `sort` (C + 1,).
    spare : ndarray
        Room for a state, for `sort` (K,).
    sorting : ndarray
        Step of the last sorting, and the number of sortings so far (2,).
    """

    particles: Integers
    rows: Integers
    limits: Array
    passed: Integers
    sums: Array
    nodal: Array
    total: Array
    node: NDArray[np.int32]
    shares: Integers
    start: Integers
    spare: Array
    sorting: Integers


def strips(
    lower: float, h: float, cells: tuple[int, ...], width: int, particles: Particles, moving: bool, nodes: int, many: bool
) -> Strips:
    """Strips of a grid: one, or for `many` particles several of about the same length.

    Parameters
    ----------
    lower, h : float
        Lower end of the last axis, and cell size [m].
    cells : tuple of int
        Numbers of cells (d,).
    width : int
        Rows of nodes that a particle writes to, from the row of its cell on, including rows to which unused lanes add zero.
    particles : Particles
    moving : bool
        Whether functions are evaluated at x, so that particles leave their strips.
    nodes : int
        Nodes from one row to the next.
    many : bool
        Whether several threads are to share the work.

    Notes
    -----
    Strips have two colours in turn, and threads work on those of one colour at the same time. A particle may have left its strip by a
    row, so that width + 1 rows lie between two strips of a colour.
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
    """Order the particles of a strip by their first node (counting sort, stable).

    A particle outside the strip or the grid counts as at the nearest node of the strip; the next pass reports it. A basis
    that takes particles one by one is not ordered.
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
    """Permute the particles to an order (P,) along its cycles; `order` becomes the identity, `spare` (K,) holds a state meanwhile."""
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
    """Sort the particles by cell before step n (counting sort, stable) and assign them to strips; FAILED when one is off the grid."""
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
    """One strip needs no sorting."""
    return PASSED
