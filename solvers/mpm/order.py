"""Order of the particles: by cell for the memory, and in strips that threads may work on at the same time."""

import numpy as np
from numba import njit

from mpmverify.problem import Array

from .compilation import ARITHMETIC, SOURCES, jit
from .state import PASSED, Grid, Integers, Nodes, Particles, Scheme, Strips
from .stencil import found, inside, node_of, place

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

MOST_STRIPS = 16
BEYOND = 3
"""Rows of nodes beyond a strip on either side in which the functions of its particles may begin."""
INTERVAL = 50
"""Steps after which the particles are sorted again, though none has left its strip."""
ARRANGED = 4
"""Steps after which those of one stencil are brought together again in the order of the passes."""


def strips(lower: float, h: float, rows: int, width: int, particles: int, moving: bool, nodes: int, many: bool) -> Strips:
    """Strips for a grid of so many rows of cells, with so many `nodes` from row to row: one, or where there are `many` particles several of
    the same length, and not so short that two of one colour could meet.

    Notes
    -----
    Strips are worked on at the same time when they are of one colour, each second one. A particle may have left its strip by a
    row, and touches the nodes of `width` rows from its own, in the lane that a stencil of three does not use by adding zero: between
    two strips of a colour lie width + 1 rows. Where functions stay with their material points (`moving` false), particles do not
    leave their strips.
    """
    count = min(MOST_STRIPS, rows // (width + 1)) // 2 * 2 if many else 1
    count = max(count, 1)
    first = (np.arange(count + 1) * rows // count).astype(np.int64)
    limits = np.stack([lower + h * (first[:-1] - 1), lower + h * (first[1:] + 1)], axis=1)
    if count == 1 or not moving:
        limits[:] = -np.inf, np.inf
    held = np.zeros(count + 1, dtype=np.int64)
    held[1:] = particles
    longest = int(np.diff(first).max()) + 2 * BEYOND + 1
    return Strips(
        held,
        first,
        limits,
        np.ones(count, dtype=np.int64),
        np.zeros((count, 16)),
        np.zeros((count, 8)),
        np.zeros((2, 8)),
        np.zeros(particles, dtype=np.int32),
        np.zeros((count, nodes * longest + 1), dtype=np.int64),
    )


@jit
def arrange(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    strips: Strips,
    s: int,
    body: Array,
    load: int,
    n: int,
    dt: float,
    record: bool,
    advance: bool,
) -> int:
    """Bring the particles of a strip together by their first node in the order of the passes (counting sort, stable).

    One that is elsewhere counts as in the first or the last row, one that is off the grid as the first: it is the passes that fail it.
    """
    begin, end = strips.particles[s], strips.particles[s + 1]
    node, share, order = strips.node, strips.shares[s], particles.order
    lowest, highest = grid.stride[-1] * (strips.rows[s] - BEYOND), share.size - 2
    for c in range(share.size):
        share[c] = 0
    for p in range(begin, end):
        here, first, _ = found(scheme, grid, particles, p)
        node[p] = min(max(node_of(grid, first) - lowest, 0), highest) if here else 0
        share[node[p] + 1] += 1
    for c in range(highest + 1):
        share[c + 1] += share[c]
    for p in range(begin, end):
        order[begin + share[node[p]]] = p
        share[node[p]] += 1
    return PASSED


@jit
def cell_of(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> int:
    """Number of the cell of a particle, x fastest; -1 when it is not on the grid."""
    s = place(scheme, grid, particles, p)
    if not inside(grid, s):
        return -1
    cell, stride = 0, 1
    for k in range(len(s)):
        cell += stride * min(int(s[k]), grid.cells[k] - 1)
        stride *= grid.cells[k]
    return cell


@jit
def permute(particles: Particles, order: Integers, spare: Array) -> None:
    """Particles in another order (P,), along its cycles; `order` becomes that of one that is sorted, `spare` holds a state (K,)."""
    place, state = particles.place, particles.state
    for first in range(order.size):
        if order[first] == first:
            continue
        number, hole = place[first], first
        for c in range(spare.size):
            spare[c] = state[first, c]
        while order[hole] != first:
            source = order[hole]
            place[hole] = place[source]
            for c in range(spare.size):
                state[hole, c] = state[source, c]
            order[hole], hole = hole, source
        place[hole], order[hole] = number, hole
        for c in range(spare.size):
            state[hole, c] = spare[c]


@njit(cache=True, **ARITHMETIC)
def sort(scheme: Scheme, grid: Grid, particles: Particles, strips: Strips, sources: int = SOURCES) -> bool:
    """Sort the particles by cell (counting sort, stable) and share them out among the strips; False when one is off the grid."""
    cells = 1
    for k in range(len(grid.lower)):
        cells *= grid.cells[k]
    row_of_cells = cells // grid.cells[len(grid.lower) - 1]
    count = particles.place.size
    cell = np.empty(count, dtype=np.int32)
    start = np.zeros(cells + 1, dtype=np.int64)
    for p in range(count):
        cell[p] = cell_of(scheme, grid, particles, p)
        if cell[p] < 0:
            return False
        start[cell[p] + 1] += 1
    for c in range(cells):
        start[c + 1] += start[c]
    for s in range(strips.rows.size):
        strips.particles[s] = start[strips.rows[s] * row_of_cells]
    order = np.empty(count, dtype=np.int64)
    for p in range(count):
        order[start[cell[p]]] = p
        start[cell[p]] += 1
    permute(particles, order, np.empty(particles.state.shape[1]))
    for p in range(count):
        particles.order[p] = p
    return True
