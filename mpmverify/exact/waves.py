"""Root of a damped oscillation, and positions of fronts and jumps. A value that is not finite gives NaN."""

import math
from collections.abc import Callable

import numpy as np

from mpmverify.problem import Array


def oscillating_root(trace: Array, determinant: Array) -> np.ndarray:
    """Return the root of z^2 - trace z + determinant with positive imaginary part, or the real root of larger magnitude."""
    half = np.asarray(trace, dtype=float) / 2
    discriminant = half**2 - determinant
    real = half + np.copysign(np.sqrt(np.maximum(discriminant, 0)), half)
    return np.asarray(np.where(discriminant < 0, half, real) + 1j * np.sqrt(np.maximum(-discriminant, 0)))


def front(position: Array, values: Array, level: float) -> float:
    """Return the position [m] at which samples (P,) cross a level: the middle crossing, interpolated linearly.

    The samples at the two ends must lie on different sides of the level. Oscillations around the front that reach the level add
    crossings in pairs, so the middle crossing is that of the front.

    Parameters
    ----------
    position : Array
        Positions (P,) [m], in any order.
    values : Array
        Samples (P,).
    level : float
        Level half-way up the front.

    Returns
    -------
    float
        NaN if both ends lie on the same side of the level, or a value is not finite.
    """
    if not (np.all(np.isfinite(position)) and np.all(np.isfinite(values)) and math.isfinite(level)):
        return math.nan
    along = np.argsort(position, kind="stable")
    x, above = position[along], values[along] - level
    before = np.flatnonzero((above[1:] > 0) != (above[:-1] > 0))
    if len(before) % 2 == 0:
        return math.nan
    i = before[len(before) // 2]
    return float(x[i] + (x[i + 1] - x[i]) * above[i] / (above[i] - above[i + 1]))


def jump(field: Callable[[Array], Array], position: Array) -> tuple[float, float]:
    """Return the position [m] and the mean of both sides of the largest jump of a profile between neighbouring points.

    Parameters
    ----------
    field : callable
        Profile: positions (n,) [m] -> values (n,).
    position : Array
        Points (P,) [m], in any order.

    Returns
    -------
    (float, float)
        Position, by bisection to 2^-45 of the spacing, and level; NaN if the profile is constant or not finite.
    """
    x = np.sort(position)
    values = field(x)
    if not np.all(np.isfinite(values)) or np.ptp(values) == 0:
        return math.nan, math.nan
    i = int(np.argmax(np.abs(np.diff(values))))
    level, rising = (values[i] + values[i + 1]) / 2, values[i + 1] > values[i]
    low, high = float(x[i]), float(x[i + 1])
    for _ in range(45):
        middle = (low + high) / 2
        passed = (field(np.array([middle]))[0] > level) == rising
        low, high = (low, middle) if passed else (middle, high)
    return (low + high) / 2, float(level)
