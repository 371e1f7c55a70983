"""Hats averaged over the domain of a particle: along the axes (uGIMP, cpGIMP), or over the corners of a parallelepiped (CPDI).

The methods of the kinds are explained in `splines`. F is the deformation gradient of the domain, I where it does not stretch.
"""

import operator
from collections.abc import Iterator
from functools import reduce
from typing import Any, NamedTuple

from ..tracing import as_integer, count_leading, maximum, minimum, traced, where
from .nodes import add_field, gathered
from .places import back, in_a_cell, inside, node_of
from .splines import Splines
from .state import Grid
from .support import Products
from .tensors import cofactor, det
from .vectors import Vector, axpy, combination, dot, dyad, null, scale

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

SHORTEST, LONGEST = 0.1, 0.5
"""Bounds of half the domain of a cpGIMP particle: at least 0.1 of its initial value, for a rotation shrinks the diagonal of F to zero;
at most 0.5 cells, beyond which it would meet a fourth function."""


class Gimp(Splines):
    """Hats averaged over a domain that stays a box along the axes."""

    domains = True
    reach = 1

    def begins(self, grid: Grid, s: Vector, F):
        along_axes = [self.begin(grid, k, s[k], stretch) for k, stretch in enumerate(stretches(F, s))]
        return tuple(first for first, _ in along_axes), tuple(offset for _, offset in along_axes)

    def begin(self, grid: Grid, k: int, s: float, stretch: float):
        """First node along axis k, and the distance from it in cells to where the functions begin."""
        a = s - half_domain(grid, stretch) + grid.padding[k]
        a = where(grid.periodic[k], where(a < 0.0, a + grid.cells[k], a), a)
        return as_integer(a), a - as_integer(a)

    def begin_in_cells(self, grid: Grid, s, F):
        before = tuple(grid.padding[k] - half_domain(grid, stretch) for k, stretch in enumerate(stretches(F, s)))
        return axpy(1.0, before, s)

    def alike(self, grid: Grid, s, begin, under, shared):
        return count_leading(reduce(operator.and_, [shared, in_a_cell(s, grid.cells), *(a >= 0.0 for a in begin)]))

    def support(self, grid: Grid, first, offset, F):
        half = [half_domain(grid, stretch) for stretch in stretches(F, offset)]
        N, dN = zip(*(integrated_along(grid, a, b) for a, b in zip(offset, half, strict=True)), strict=True)
        centre = tuple(offset[k] + half[k] - grid.padding[k] for k in range(len(half)))
        return Products(node_of(grid, first), N, dN, first, centre)


class Cpdi(Splines):
    """Hats averaged over the corners of a domain that deforms to a parallelepiped; it takes one particle at a time."""

    domains = True
    together = False
    reach = 2

    def supported(self, grid: Grid, s: Vector, F):
        """The domain keeps within a cell from its middle on every side, as threads and the padding take for granted."""
        there, n = inside(grid, s), len(s)
        for i in range(n):
            reach = reduce(operator.add, [maximum(R, -R) for R in F[n * i : n * i + n]])
            there = there & (grid.half * reach <= 1.0)
        return there

    def begins(self, grid: Grid, s: Vector, F):
        """Zero, and the middle of the domain."""
        return (0,) * len(s), s

    def support(self, grid: Grid, first, offset, F):
        share = grid.scale / (2 ** len(offset) * grid.half * det(F))
        return Corners(offset, scale(grid.half, F), scale(share, cofactor(F)))


class Corners(NamedTuple):
    """Support of one particle where N_Ip is a mean of hats over the corners of a domain.

    middle : tuple of float
        Distances of the middle from the lower ends in cells (d,).
    edges : tuple of float
        Half edges R in cells as columns (d d).
    gradient : tuple of float
        R^-T/2^d (d d) [1/m].
    """

    middle: Any
    edges: Any
    gradient: Any

    def _corners(self, grid: Grid) -> Iterator[tuple[Any, Any, Any]]:
        """First node, hats (d, 2) and gradient (d,) [1/m] of what its nodes have, of each corner."""
        d = len(self.middle)
        for c in range(1 << d):
            side = [1.0 if c >> k & 1 else -1.0 for k in range(d)]
            hats = [hat_at(grid, k, self.middle[k] + dot(side, self.edges[d * k : d * k + d])) for k in range(d)]
            gradient = tuple(dot(side, self.gradient[d * k : d * k + d]) for k in range(d))
            yield node_of(grid, [first for first, _ in hats]), tuple(N for _, N in hats), gradient

    def spread(self, grid: Grid, nodes, component, amount):
        share = scale(1 / (1 << len(self.middle)), amount)
        for first, hats, _ in self._corners(grid):
            add_field(grid, nodes, component, first, hats, hats, share, None)

    def spread_tensor(self, grid: Grid, nodes, component, T):
        for first, hats, gradient in self._corners(grid):
            add_field(grid, nodes, component, first, hats, hats, combination(T, gradient), None)

    def gather(self, grid: Grid, nodes):
        mean, _, _ = null(grid.lower)
        for first, hats, _ in self._corners(grid):
            mean = axpy(1 / (1 << len(self.middle)), gathered(grid, nodes, first, hats), mean)
        return mean

    def gather_tensor(self, grid: Grid, nodes):
        _, mean, _ = null(grid.lower)
        for first, hats, gradient in self._corners(grid):
            mean = axpy(1.0, dyad(gathered(grid, nodes, first, hats), gradient), mean)
        return mean


def stretches(F, like):
    """Stretches of a domain along the axes (d,)."""
    return F[:: len(like) + 1]


@traced
def half_domain(grid: Grid, stretch):
    """Half the domain of a particle of GIMP along an axis, in cells."""
    return minimum(maximum(stretch, SHORTEST) * grid.half, LONGEST)


@traced
def integrated_along(grid: Grid, a, half):
    """N [1] and dN/dx [1/m] (3,) of three hats that are averaged from a to a + 2 half, at most a cell apart, a from the first node.

    N = int hat dx/(2 half), and dN/dx is the difference of the hat at both ends, over 2 half.
    """
    b = a + 2 * half
    beyond, rest, left = maximum(b - 1, 0.0), maximum(1 - b, 0.0), 1 - a
    N0, N2, factor = 0.25 * (left * left - rest * rest) / half, 0.25 * beyond * beyond / half, 0.5 * grid.scale / half
    d0, d2 = factor * (rest - left), factor * beyond
    return (N0, 1 - N0 - N2, N2), (d0, -d0 - d2, d2)


@traced
def hat_at(grid: Grid, k: int, s: float):
    """First of the hats at a place that may lie in the padding or have left a periodic axis, and both of them (2,)."""
    a = back(grid, k, s) + grid.padding[k]
    cell = minimum(as_integer(a), grid.cells[k] + 2 * grid.padding[k] - 1)
    return cell, (1.0 - (a - cell), a - cell)
