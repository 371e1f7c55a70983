"""Fits of power laws to (h, error): orders with confidence intervals, without and with an error floor."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.student import student_quantile

CONFIDENCE = 0.95
"""Confidence level of the interval of an order."""


@dataclass(frozen=True)
class Fit:
    """Least-squares line through (log h, log E).

    Parameters
    ----------
    order : float
        Slope p of E = A h^p.
    low, high : float
        Confidence interval of the slope by Student's t with n - 2 degrees of freedom; infinite with two levels.
    constant : float
        A, in the unit of the error per unit of h^p.
    """

    order: float
    low: float
    high: float
    constant: float


@dataclass(frozen=True)
class FloorFit:
    """E = E0 + A h^p, fitted by relative deviations.

    Parameters
    ----------
    floor, constant, order : float
        E0, A and p.
    residual : float
        Root mean square of log(E/fit).
    """

    floor: float
    constant: float
    order: float
    residual: float


def pairwise_orders(h: Array, error: Array) -> Array:
    """Return the observed orders log(E_i/E_{i+1}) / log(h_i/h_{i+1}) of neighbouring levels, (n - 1,).

    Parameters
    ----------
    h, error : Array
        Sizes and errors (n,), coarsest first. Of replicates at one size the geometric mean counts.

    Returns
    -------
    Array
        Order from the next coarser size to each level but the first; NaN where an error is not positive and finite, and for
        replicates of the coarsest size.
    """
    sizes, level = np.unique(-h, return_inverse=True)
    usable = np.isfinite(error) & (error > 0)
    log_error = np.bincount(level, np.log(np.where(usable, error, np.nan))) / np.bincount(level)
    orders = np.append(np.nan, np.diff(log_error) / np.diff(np.log(-sizes)))
    return orders[level][1:]


def fit_order(h: Array, error: Array, confidence: float = CONFIDENCE) -> Fit:
    """Fit E = A h^p by least squares of the logarithms.

    Parameters
    ----------
    h, error : Array
        Sizes and errors (n,) of at least two levels, positive and finite.
    confidence : float
        Confidence level of the interval of p by Student's t [1].
    """
    x, y = np.log(h), np.log(error)
    dx = x - x.mean()
    sxx = float(dx @ dx)
    order = float(dx @ y) / sxx
    intercept = float(y.mean() - order * x.mean())
    constant = math.exp(intercept) if intercept < 700 else math.inf
    half_width = math.inf
    if len(h) > 2:
        residual = y - (intercept + order * x)
        standard_error = math.sqrt(float(residual @ residual) / (len(h) - 2) / sxx)
        half_width = student_quantile(len(h) - 2, confidence) * standard_error
    return Fit(order, order - half_width, order + half_width, constant)


def fit_floor(h: Array, error: Array) -> FloorFit:
    """Fit E = E0 + A h^p, E0 >= 0 and A >= 0.

    Parameters
    ----------
    h, error : Array
        Sizes and errors (n,) of at least four levels, positive and finite.

    Notes
    -----
    The relative residual is linear in E0 and A at a fixed p, which is searched on a grid that is refined three times.
    """
    unit, size = h.max(), error.max()
    orders = np.linspace(0.1, 8.0, 80)
    for _ in range(4):
        powers = (h / unit) ** orders[:, None]
        floor, constant = _weighted_pair(np.ones_like(powers), powers, size / error)
        misfit = np.sum(((floor[:, None] + constant[:, None] * powers) * size / error - 1) ** 2, axis=1)
        best = int(np.argmin(misfit))
        spacing = orders[1] - orders[0]
        chosen = float(floor[best] * size), float(constant[best] * size), float(orders[best])
        orders = np.linspace(max(orders[best] - spacing, orders[0]), orders[best] + spacing, 41)
    found = chosen[0] + chosen[1] * (h / unit) ** chosen[2]
    # Of errors that differ by many decades, the least at a coarse level, zero may be the best fit.
    residual = float(np.sqrt(np.mean(np.log(error / found) ** 2))) if found.all() else math.inf
    return FloorFit(chosen[0], float(chosen[1] / np.power(unit, chosen[2])), chosen[2], residual)


def _weighted_pair(one: Array, other: Array, weight: Array) -> tuple[Array, Array]:
    """Non-negative a and b (m,) with the least sum of squares of weight (a one + b other) - 1, columns (m, n)."""
    u, v = one * weight, other * weight
    uu, uv, vv, u1, v1 = (np.sum(t, axis=1) for t in (u * u, u * v, v * v, u, v))
    determinant = uu * vv - uv**2
    determinant = np.where(determinant > 0, determinant, np.inf)  # columns that round-off makes parallel fit nothing
    a, b = (u1 * vv - v1 * uv) / determinant, (v1 * uu - u1 * uv) / determinant
    return np.where(b < 0, u1 / uu, np.where(a < 0, 0, a)), np.where(a < 0, v1 / vv, np.where(b < 0, 0, b))


def significant_floor(h: Array, error: Array) -> FloorFit | None:
    """Fit E = E0 + A h^p and return it if the floor E0 is significant, else None.

    Parameters
    ----------
    h, error : Array
        Sizes and errors (n,), coarsest first, positive and finite.

    Notes
    -----
    The floor is significant if the series has at least four levels, the last observed order is below half of the largest one, E0 is
    more than half of the smallest error, and the residual is below a third of that of the fit A h^p.
    """
    if len(h) < 4:
        return None
    orders = pairwise_orders(h, error)
    if not (orders.max() > 0.5 and orders[-1] < 0.5 * orders.max()):
        return None
    line = fit_order(h / h[0], error)
    spread = float(np.sqrt(np.mean(np.log(error / (line.constant * (h / h[0]) ** line.order)) ** 2)))
    floor = fit_floor(h, error)
    return floor if floor.floor > 0.5 * error.min() and floor.residual < spread / 3 else None
