"""Waves as closed forms see them: roots of a damped oscillation, and the position of a front; NaN poisons all."""

import math
from collections.abc import Callable

import numpy as np

from mpmverify.problem import Array


def oscillation(trace: Array, determinant: Array) -> np.ndarray:
    """Root of z^2 - trace z + determinant: that of positive imaginary part, or the real one of greater magnitude."""
    half = np.asarray(trace, dtype=float) / 2
    discriminant = half**2 - determinant
    real = half + np.copysign(np.sqrt(np.maximum(discriminant, 0)), half)
    return np.asarray(np.where(discriminant < 0, half, real) + 1j * np.sqrt(np.maximum(-discriminant, 0)))


def front(position: Array, values: Array, level: float) -> float:
    """Position at which samples (P,) cross a level [m]: the middle one of all crossings, linear between the points.

    Samples before a front and behind it lie on different sides of the level halfway up; oscillations that reach it cross it
    forth and back, as often on one side as on the other. NaN when both ends lie on one side, or something is not finite.
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
    """Position [m] and middle level of the greatest jump of a known profile between neighbouring points (P,).

    Parameters
    ----------
    field : callable
        Positions (n,) [m] -> values (n,).

    Notes
    -----
    The position is bisected to 2^-45 of the spacing. NaN when the profile is constant or not finite.
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
