"""Places on the grid: distances along the axes in cells, and the numbers of cells and nodes."""

import operator
from functools import reduce

from ..tracing import floor, traced, where
from .state import Grid
from .vectors import Vector, dot

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def back(grid: Grid, k: int, s):
    """Distance s from the lower end of axis k in cells, brought between the ends of a periodic axis."""
    there = (s >= 0.0) & (s < grid.cells[k])
    return where(grid.periodic[k], where(there, s, s - grid.cells[k] * floor(s / grid.cells[k])), s)


@traced
def local(grid: Grid, x: Vector) -> Vector:
    """Distances of a place x (d,) [m] from the lower ends of the axes in cells (d,)."""
    return tuple(back(grid, k, (x[k] - grid.lower[k]) * grid.scale) for k in range(len(x)))


@traced
def images(grid: Grid, s: Vector):
    """Distances (d,) in cells, brought between the ends of periodic axes; quicker than `back`, but rounding may swap the ends."""
    lengths = [where(periodic, cells, 0) for periodic, cells in zip(grid.periodic, grid.cells, strict=True)]
    return tuple(a - length * floor(a * (1 / n)) for a, length, n in zip(s, lengths, grid.cells, strict=True))


@traced
def inside(grid: Grid, s: Vector) -> bool:
    """Whether a place is on the grid; NaN is not."""
    return reduce(operator.and_, [(a >= 0.0) & (a <= cells) for a, cells in zip(s, grid.cells, strict=True)])


@traced
def in_a_cell(s, cells):
    """Which places are in a cell of every axis; neither the upper end of the axis nor NaN is."""
    return reduce(operator.and_, [(a >= 0.0) & (a < n) for a, n in zip(s, cells, strict=True)])


@traced
def node_of(grid: Grid, first) -> int:
    """Number of the node with these numbers along the axes (d,)."""
    return dot(first, (1, *grid.stride[1:]))


@traced
def cell_number(grid: Grid, first) -> int:
    """Number of the cell with these numbers along the axes (d,), x fastest."""
    number = first[-1]
    for k in reversed(range(len(first) - 1)):
        number = first[k] + grid.cells[k] * number
    return number
