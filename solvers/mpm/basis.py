"""Table of the bases, and their functions along one axis.

In more dimensions a basis is made of products of these or, for CPDI, of means over the corners of a domain.

To add a basis, write its kind in `splines` or `domains` (or a module of its own) and enter it in `BASES`.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from mpmverify.problem import Array

from .domains import Cpdi, Gimp
from .splines import MovingLeastSquares, Splines, TaylorLeastSquares
from .state import Grid, Integers


class Basis(NamedTuple):
    """A basis.

    kind : Splines
        What its functions are, see `splines`.
    degree : int
        Of the B-splines of the grid.
    width : int
        W, how many functions a particle meets along an axis.
    stretched : bool
        Whether the domain of a particle stretches with it.
    """

    kind: Splines
    degree: int
    width: int
    stretched: bool = False


BASES = {
    "linear": Basis(Splines(), 1, 2),
    "quadratic": Basis(Splines(), 2, 3),
    "cubic": Basis(Splines(), 3, 4),
    "mls-quadratic": Basis(MovingLeastSquares(), 2, 3),
    "mls-cubic": Basis(MovingLeastSquares(), 3, 4),
    "tls-linear": Basis(TaylorLeastSquares(), 1, 2),
    "tls-quadratic": Basis(TaylorLeastSquares(), 2, 3),
    "tls-cubic": Basis(TaylorLeastSquares(), 3, 4),
    "ugimp": Basis(Gimp(), 1, 3),
    "cpgimp": Basis(Gimp(), 1, 3, stretched=True),
    "cpdi": Basis(Cpdi(), 1, 2, stretched=True),
}


class Axis(NamedTuple):
    """Basis along one axis with C cells, on each of which W functions are non-zero.

    lower : float
        Lower end [m].
    cells : int
        C.
    periodic : bool
        Whether its ends are joined.
    piece : ndarray
        Number of the piece of each cell (C,).
    polynomials : ndarray
        Functions of each piece (pieces, powers, W) in the local coordinate, lowest power first.
    nodes : ndarray
        Places x_I with sum_I x_I N_I(x) = x [m]: C + W - 1, and `padding` more at each end.
    padding : int
        Nodes beyond each end for particles whose domain reaches there.
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
    """Hats for particles with domains, each of which meets `width` hats; other parameters as of `spline_axis`."""
    hats, padding = spline_axis(lower, h, cells, 1, periodic), 0 if periodic else 1
    count = cells + width - 1 + 2 * padding
    return hats._replace(nodes=lower + h * (np.arange(count, dtype=np.float64) - padding), padding=padding)


def basis_axis(basis: Basis, lower: float, h: float, cells: int, periodic: bool = False) -> Axis:
    """Axis of a basis; other parameters as of `spline_axis`."""
    if basis.kind.domains:
        return domain_axis(lower, h, cells, basis.width, periodic)
    return spline_axis(lower, h, cells, basis.degree, periodic)


@lru_cache
def _polynomials(knots: tuple[float, ...], degree: int) -> Array:
    """Taylor coefficients (powers, W) of the B-splines with these knots about the left end of the middle span."""
    functions = BSpline(np.array(knots), np.eye(degree + 1), degree)
    return np.array([functions(0.0, nu=power) / math.factorial(power) for power in range(degree + 1)])


def grid_of(axes: tuple[Axis, ...], h: float, basis: Basis, ghosts: Integers, half: float, stretched: bool) -> Grid:
    """Grid of some axes; other parameters as of `Grid`."""
    counts = [len(axis.nodes) for axis in axes]
    nodes = np.zeros((len(axes), max(counts)))
    piece = np.zeros((len(axes), max(axis.cells for axis in axes)), dtype=np.uint8)
    before = 0
    for k, axis in enumerate(axes):
        nodes[k, : counts[k]], piece[k, : axis.cells] = (axis.nodes - axis.lower) / h, axis.piece + before
        before += len(axis.polynomials)
    return Grid(
        tuple(axis.lower for axis in axes),
        1 / h,
        tuple(axis.cells for axis in axes),
        tuple(axis.periodic for axis in axes),
        tuple(math.prod(counts[:k]) for k in range(len(counts))),
        (0.0,) * basis.width,
        tuple(axis.padding for axis in axes),
        piece,
        np.concatenate([axis.polynomials for axis in axes]),
        nodes,
        ghosts,
        basis.kind,
        half,
        stretched,
    )
