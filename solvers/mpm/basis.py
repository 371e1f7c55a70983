"""One-dimensional basis functions, value and derivative together; in more dimensions a basis is made of their products."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from mpmverify.problem import Array

from ..tracing import load_row, maximum, traced
from .vectors import axpy, by_components, dot, less, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

SPLINES, GIMP, CPDI, MLS, TLS = (0.0,), (0.0,) * 2, (0.0,) * 3, (0.0,) * 4, (0.0,) * 5
"""Kinds of basis, MLS the splines with gradients of moving least squares, TLS with fits of Taylor least squares in the cells; their
lengths tell them apart where a function is compiled."""


class Basis(NamedTuple):
    """A basis: its kind, the degree of the B-splines of the grid, and how many functions a particle meets along an axis.

    Whether the domain of a particle stretches with it.
    """

    kind: tuple[float, ...]
    degree: int
    width: int
    stretched: bool = False


BASES = {
    "linear": Basis(SPLINES, 1, 2),
    "quadratic": Basis(SPLINES, 2, 3),
    "cubic": Basis(SPLINES, 3, 4),
    "mls-quadratic": Basis(MLS, 2, 3),
    "mls-cubic": Basis(MLS, 3, 4),
    "tls-linear": Basis(TLS, 1, 2),
    "tls-quadratic": Basis(TLS, 2, 3),
    "tls-cubic": Basis(TLS, 3, 4),
    "ugimp": Basis(GIMP, 1, 3),
    "cpgimp": Basis(GIMP, 1, 3, stretched=True),
    "cpdi": Basis(CPDI, 1, 2, stretched=True),
}
SHORTEST, LONGEST = 0.1, 0.5
"""Half the domain of a particle of cpGIMP, in that of the beginning and in cells: a rotation shrinks its diagonal to nothing, and
beyond half a cell it would meet a fourth function."""


ONE = (0,)
"""As long as one number is."""


class Axis(NamedTuple):
    """Basis along one axis with C cells and functions of width W (as many live on a cell).

    Lower end [m], number of cells, whether its ends are joined, piece of each cell (C,), polynomials (pieces, powers, W) in the local
    coordinate, lowest power first, and the nodes at which sum_I x_I N_I(x) = x [m]: C + W - 1, and `padding` more at each end for
    particles whose domain reaches beyond it.
    """

    lower: float
    cells: int
    periodic: bool
    piece: NDArray[np.uint8]
    polynomials: Array
    nodes: Array
    padding: int = 0


def spline_axis(lower: float, h: float, cells: int, degree: int, periodic: bool = False) -> Axis:
    """B-splines of a degree on uniform cells, clamped (each end knot repeated) unless periodic.

    Parameters
    ----------
    lower : float
        Lower end [m].
    h : float
        Cell size [m].
    cells : int
    degree : int
        1, 2 or 3.
    periodic : bool
        Uniform knots throughout: functions reach beyond the ends.

    Notes
    -----
    On cell e live the functions e, ..., e + degree. The node of a function is the mean of its inner knots (Greville).

    References
    ----------
    de Boor, A Practical Guide to Splines, 1978. Steffen, Kirby and Berzins, 2008, doi:10.1002/nme.2360.
    """
    knots = np.arange(cells + 2 * degree + 1, dtype=float) - degree
    if not periodic:
        knots = np.clip(knots, 0, cells)
    means = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree).mean(axis=1)
    known: dict[tuple[float, ...], int] = {}
    piece = np.zeros(cells, dtype=np.uint8)
    for cell in range(cells):
        piece[cell] = known.setdefault(tuple(knots[cell : cell + 2 * degree + 2] - cell), len(known))
    polynomials = np.array([_polynomials(local, degree) for local in known])
    return Axis(float(lower), cells, periodic, piece, polynomials, lower + h * means)


def domain_axis(lower: float, h: float, cells: int, width: int, periodic: bool = False) -> Axis:
    """Hats for particles that have a domain, which meets `width` of them; parameters as of `spline_axis`."""
    hats, padding = spline_axis(lower, h, cells, 1, periodic), 0 if periodic else 1
    count = cells + width - 1 + 2 * padding
    return hats._replace(nodes=lower + h * (np.arange(count, dtype=np.float64) - padding), padding=padding)


def basis_axis(basis: Basis, lower: float, h: float, cells: int, periodic: bool = False) -> Axis:
    """The axis of a basis; parameters as of `spline_axis`."""
    if basis.kind in (SPLINES, MLS, TLS):
        return spline_axis(lower, h, cells, basis.degree, periodic)
    return domain_axis(lower, h, cells, basis.width, periodic)


@lru_cache
def _polynomials(knots: tuple[float, ...], degree: int) -> Array:
    """Taylor coefficients (powers, W) about the left end of the middle span."""
    functions = BSpline(np.array(knots), np.eye(degree + 1), degree)
    return np.array([functions(0.0, nu=power) / math.factorial(power) for power in range(degree + 1)])


@traced
def along(grid, k, cell, xi):
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


@traced
def integrated_along(grid, a, half):
    """N [1] and dN/dx [1/m] (3,) of three hats that are averaged from a to a + 2 half, at most a cell apart, a from the first node.

    N = int hat dx/(2 half), and dN/dx is the difference of the hat at both ends, over 2 half.
    """
    b = a + 2 * half
    beyond, rest, left = maximum(b - 1, 0.0), maximum(1 - b, 0.0), 1 - a
    N0, N2, factor = 0.25 * (left * left - rest * rest) / half, 0.25 * beyond * beyond / half, 0.5 * grid.scale / half
    d0, d2 = factor * (rest - left), factor * beyond
    return (N0, 1 - N0 - N2, N2), (d0, -d0 - d2, d2)


@traced
def moment_along(grid, k, first, place, N):
    """N (x_I - x) (W,) and D = sum_I N (x_I - x)^2 along axis k, in cells, at a place in cells from the lower end."""
    from_here = less(load_row(grid.nodes, (k, first), N), place)
    moment = by_components(N, from_here)
    return moment, dot(moment, from_here)
