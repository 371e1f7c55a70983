"""Clamped B-splines of degree 1 and 2 on a uniform grid, value and gradient together."""

import numpy as np
from numba import njit

from mpmverify.problem import Array

jit = njit(fastmath={"contract"}, error_model="numpy")

WIDTH = 3
"""Functions in a stencil; the last is zero for degree 1, so that one compiled loop serves both degrees."""


@jit
def basis(xi: float, cell: int, cells: int, degree: int) -> tuple[float, float, float, float, float, float]:
    """Functions that live on a cell, `cell`, `cell` + 1 and `cell` + 2, at a local coordinate.

    Parameters
    ----------
    xi : float
        Local coordinate in [0, 1] [1].
    cell, cells : int
        Index of the cell and number of cells of the grid.
    degree : int
        1 or 2.

    Returns
    -------
    tuple of float
        N_0, N_1, N_2 [1] and their derivatives by xi [1].

    Notes
    -----
    Degree 1 is the hat, (1 - xi, xi). Degree 2 by Cox and de Boor with L and R the lengths of the knot spans to the left and
    to the right in cells, 1 inside and 0 at a repeated end knot:
    N_0 = (1 - xi)^2/(1 + L), N_2 = xi^2/(1 + R), N_1 = 1 - N_0 - N_2.

    References
    ----------
    de Boor, A Practical Guide to Splines, 1978. Steffen, Kirby and Berzins, 2008, doi:10.1002/nme.2360.
    """
    if degree == 1:
        return 1 - xi, xi, 0.0, -1.0, 1.0, 0.0
    left = 1.0 + min(cell, 1)
    right = 1.0 + min(cells - 1 - cell, 1)
    first, third = (1 - xi) ** 2 / left, xi**2 / right
    d_first, d_third = -2 * (1 - xi) / left, 2 * xi / right
    return first, 1 - first - third, third, d_first, -d_first - d_third, d_third


def greville(lower: float, h: float, cells: int, degree: int) -> Array:
    """Material coordinates of the nodes, at which sum_I X_I N_I(X) = X, (cells + degree,) [m]."""
    knots = np.clip(np.arange(cells + 2 * degree + 1) - degree, 0, cells)
    means = np.lib.stride_tricks.sliding_window_view(knots[1:-1], degree).mean(axis=1)
    return np.asarray(lower + h * means)
