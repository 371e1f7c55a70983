"""B-splines of the grid, also with the gradients of moving least squares or with Taylor least squares in the cells.

A kind of basis is a class of empty tuples, which tells compiled loops apart; its methods run while the time loop is traced. What a kind has:

domains : bool
    Whether a particle has a domain, so that its whole deformation gradient is kept.
together : bool
    Whether one stencil may serve several particles.
fitted : bool
    Whether fields are fitted to the particles of each cell, see `reconstruction`.
reach : int
    Rows of cells before that of a particle in which its functions may begin.
supported(grid, s, F)
    Whether a particle at s (d,) in cells is on the grid with all its functions.
begins(grid, s, F)
    First node along the axes (d,), and the distance in cells from it to where the functions of one particle begin (d,).
begin_in_cells(grid, s, F)
    Distances from the lower ends in cells to where the functions of four particles begin (d,).
alike(grid, s, begin, under, shared)
    How many of four particles, from the first on, are on the grid and have its stencil; `under` are the whole parts of where its
    functions begin (d,), `shared` tells which particles have the same.
support(grid, first, offset, F)
    Support of particles whose functions begin at `offset` (d,) from the first node along the axes (d,), see `support`.
"""

from typing import NamedTuple

from ..tracing import as_integer, count_leading, load_row, maximum, minimum, traced, where
from .places import in_a_cell, inside, node_of
from .state import Grid
from .support import Products, moment_along
from .vectors import Vector, axpy, scale

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

EDGE = 1e-30
"""Distance in cells from the edge where a cell begins, of a particle that lies on it.

A function with a slope on the edge then has a mass, and hence a velocity; even the cube of the distance leaves one above `SMALLEST`.
"""
ONE = (0,)
"""Tuple of length one: its holder loads one element."""


class Kind(NamedTuple):
    """Kind of a basis; a subclass may have the attributes that a NamedTuple itself may not."""


class Splines(Kind):
    """B-splines of the grid."""

    domains = False
    together = True
    fitted = False
    reach = 0

    def supported(self, grid: Grid, s: Vector, F):
        return inside(grid, s)

    def begins(self, grid: Grid, s: Vector, F):
        first = tuple(minimum(as_integer(a), cells - 1) for a, cells in zip(s, grid.cells, strict=True))
        return first, tuple(a - cell for a, cell in zip(s, first, strict=True))

    def begin_in_cells(self, grid: Grid, s, F):
        return s

    def alike(self, grid: Grid, s, begin, under, shared):
        return where(in_a_cell(under, grid.cells), count_leading(shared), 0)

    def support(self, grid: Grid, first, offset, F):
        offset = tuple(minimum(maximum(a, EDGE), 1 - 2**-53) for a in offset)
        along_axes = [self.functions(grid, k, first[k], offset[k]) for k in range(len(offset))]
        N, dN = zip(*along_axes, strict=True)
        return Products(node_of(grid, first), N, dN, first, offset)

    def functions(self, grid: Grid, k: int, first: int, offset):
        """N [1] and dN/dx [1/m] (W,) along axis k."""
        return along(grid, k, first, offset)


class MovingLeastSquares(Splines):
    """B-splines with the gradients of moving least squares."""

    def functions(self, grid: Grid, k: int, first: int, offset):
        N, _ = along(grid, k, first, offset)
        moment, D = moment_along(grid, k, first, offset, N)
        return N, scale(grid.scale / D, moment)


class TaylorLeastSquares(Splines):
    """B-splines, with Taylor polynomials that are fitted to the particles of each cell."""

    fitted = True


@traced
def along(grid: Grid, k: int, cell: int, xi):
    """N [1] and dN/dx [1/m] at xi from the left end of a cell of axis k (W,)."""
    width = grid.width
    if len(width) == 2:
        return (1.0 - xi, xi), (-grid.scale, grid.scale)
    c, piece = grid.polynomials, load_row(grid.piece, (k, cell), ONE)[0]
    c0, c1, c2 = load_row(c, (piece, 0, 0), width), load_row(c, (piece, 1, 0), width), load_row(c, (piece, 2, 0), width)
    if len(width) == 3:
        inner = axpy(xi, c2, c1)
        return axpy(xi, inner, c0), scale(grid.scale, axpy(xi, c2, inner))
    c3 = load_row(c, (piece, 3, 0), width)
    highest = axpy(xi, c3, c2)
    inner = axpy(xi, highest, c1)
    return axpy(xi, inner, c0), scale(grid.scale, axpy(xi, axpy(xi, c3, highest), inner))
