"""One-dimensional basis functions, value and derivative together; in more dimensions a basis is made of their products."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from mpmverify.problem import Array

from .compilation import jit

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

SPLINES, GIMP, CPDI = (0.0,), (0.0, 0.0), (0.0, 0.0, 0.0)
"""Kinds of basis; their lengths tell them apart where a function is compiled."""


class Basis(NamedTuple):
    """A basis: its kind, the degree of the B-splines of the grid, and how many functions a particle meets along an axis.

    Whether gradients are those of moving least squares, and whether the domain of a particle stretches with it (cpGIMP).
    """

    kind: tuple[float, ...]
    degree: int
    width: int
    least_squares: bool = False
    stretched: bool = False


BASES = {
    "linear": Basis(SPLINES, 1, 2),
    "quadratic": Basis(SPLINES, 2, 3),
    "cubic": Basis(SPLINES, 3, 4),
    "mls-quadratic": Basis(SPLINES, 2, 3, least_squares=True),
    "mls-cubic": Basis(SPLINES, 3, 4, least_squares=True),
    "ugimp": Basis(GIMP, 1, 3),
    "cpgimp": Basis(GIMP, 1, 3, stretched=True),
    "cpdi": Basis(CPDI, 1, 2, stretched=True),
}
SHORTEST, LONGEST = 0.1, 0.5
"""Half the domain of a particle of cpGIMP, in that of the beginning and in cells: a rotation shrinks its diagonal to nothing, and
beyond half a cell it would meet a fourth function."""


class Axis(NamedTuple):
    """Basis along one axis with C cells and functions of width W (as many live on a cell).

    Lower end [m], number of cells, whether its ends are joined, piece of each cell (C,), polynomials (pieces, W, W) in the local
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
    polynomials = np.array([_polynomials(np.array(local), degree) for local in known])
    return Axis(float(lower), cells, periodic, piece, polynomials, lower + h * means)


def domain_axis(lower: float, h: float, cells: int, width: int, periodic: bool = False) -> Axis:
    """Hats for particles that have a domain, which meets `width` of them; parameters as of `spline_axis`."""
    hats, padding = spline_axis(lower, h, cells, 1, periodic), 0 if periodic else 1
    count = cells + width - 1 + 2 * padding
    return hats._replace(nodes=lower + h * (np.arange(count, dtype=np.float64) - padding), padding=padding)


def basis_axis(basis: Basis, lower: float, h: float, cells: int, periodic: bool = False) -> Axis:
    """The axis of a basis; parameters as of `spline_axis`."""
    if basis.kind == SPLINES:
        return spline_axis(lower, h, cells, basis.degree, periodic)
    return domain_axis(lower, h, cells, basis.width, periodic)


def _polynomials(knots: Array, degree: int) -> Array:
    """Taylor coefficients (W, W) about the left end of the middle span."""
    functions = BSpline(knots, np.eye(degree + 1), degree)
    powers = [functions(0.0, nu=power) / math.factorial(power) for power in range(degree + 1)]
    return np.array(powers).T


@jit
def quadratic(c, piece, k, xi):
    """Value and derivative by xi of function k."""
    return c[piece, k, 0] + xi * (c[piece, k, 1] + xi * c[piece, k, 2]), c[piece, k, 1] + 2 * xi * c[piece, k, 2]


@jit
def cubic(c, piece, k, xi):
    """Value and derivative by xi of function k."""
    value = c[piece, k, 0] + xi * (c[piece, k, 1] + xi * (c[piece, k, 2] + xi * c[piece, k, 3]))
    return value, c[piece, k, 1] + xi * (2 * c[piece, k, 2] + 3 * xi * c[piece, k, 3])


@jit
def along(axis, s, scale, width):
    """First function, N (W,) [1] and dN/dx (W,) [1/m] at s cells from the lower end; `scale` is 1/h, `width` any W numbers."""
    cell = min(int(s), axis.cells - 1)
    xi = s - cell
    if len(width) == 2:
        return cell, (1 - xi, xi), (-scale, scale)
    c, piece = axis.polynomials, axis.piece[cell]
    if len(width) == 3:
        (N0, d0), (N1, d1), (N2, d2) = quadratic(c, piece, 0, xi), quadratic(c, piece, 1, xi), quadratic(c, piece, 2, xi)
        return cell, (N0, N1, N2), (scale * d0, scale * d1, scale * d2)
    (M0, e0), (M1, e1), (M2, e2), (M3, e3) = (
        cubic(c, piece, 0, xi),
        cubic(c, piece, 1, xi),
        cubic(c, piece, 2, xi),
        cubic(c, piece, 3, xi),
    )
    return cell, (M0, M1, M2, M3), (scale * e0, scale * e1, scale * e2, scale * e3)


@jit
def hat_along(axis, s):
    """First function and N (2,) [1] of the hats at s cells from the lower end, which may lie in the padding."""
    cell = min(int(s + axis.padding), axis.cells + 2 * axis.padding - 1)
    xi = s + axis.padding - cell
    return cell, (1 - xi, xi)


@jit
def integrated_along(axis, s, half, scale):
    """First function, N (3,) [1] and dN/dx (3,) [1/m] of hats that are averaged from s - half to s + half, at most a cell apart.

    N = int hat dx/(2 half), and dN/dx is the difference of the hat at both ends, over 2 half.
    """
    a = s - half + axis.padding
    if axis.periodic and a < 0:
        a += axis.cells
    cell = int(a)
    a -= cell
    b = a + 2 * half
    beyond, rest, left = max(b - 1, 0.0), max(1 - b, 0.0), 1 - a
    N0, N2, factor = 0.25 * (left * left - rest * rest) / half, 0.25 * beyond * beyond / half, 0.5 * scale / half
    d0, d2 = factor * (rest - left), factor * beyond
    return cell, (N0, 1 - N0 - N2, N2), (d0, -d0 - d2, d2)


@jit
def affine_along(axis, first, s, scale, N):
    """N (x_I - x)/D (W,) [1/m] and D = sum_I N (x_I - x)^2 [m^2]; D of the hat is 0 at a node, where the quotient is dN/dx."""
    if len(N) == 2:
        return (-scale, scale), N[0] * N[1] / scale**2
    around = axis.cells if axis.periodic and first > s else 0
    cell, x = first, axis.lower + (s + around) / scale
    r0, r1, r2 = axis.nodes[cell] - x, axis.nodes[cell + 1] - x, axis.nodes[cell + 2] - x
    if len(N) == 3:
        D = N[0] * r0 * r0 + N[1] * r1 * r1 + N[2] * r2 * r2
        return (N[0] * r0 / D, N[1] * r1 / D, N[2] * r2 / D), D
    r3 = axis.nodes[cell + 3] - x
    E = N[0] * r0 * r0 + N[1] * r1 * r1 + N[2] * r2 * r2 + N[3] * r3 * r3
    return (N[0] * r0 / E, N[1] * r1 / E, N[2] * r2 / E, N[3] * r3 / E), E
