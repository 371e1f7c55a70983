"""Shapes of bodies that do not fill their box."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpmverify.errors import UsageError
from mpmverify.quantities import Array


@dataclass(frozen=True)
class Disk:
    """What lies within a circle, its edge included.

    Parameters
    ----------
    center : (float, float)
        [m].
    radius : float
        [m].

    Raises
    ------
    UsageError
        If the centre is not finite and in the plane, or the radius is not positive and finite.
    """

    center: tuple[float, float]
    radius: float

    def __post_init__(self) -> None:
        if not (_in_plane(self.center) and 0 < self.radius < math.inf):
            raise UsageError(f"a disk needs two finite coordinates of its center and a positive, finite radius: {self!r}")

    @property
    def measure(self) -> float:
        """Area [m^2]."""
        return math.pi * self.radius**2

    def within(self, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
        """Whether the body lies in a box of these corners [m]; it may touch its faces."""
        return _within(self.center, self.radius, lower, upper)

    def contains(self, X: Array) -> NDArray[np.bool_]:
        """Whether points (P, 2) [m] belong to the body, (P,)."""
        return _distance(X, self.center) <= self.radius

    def parts(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Areas (B,) [m^2] and centroids (B, 2) [m] of what lies in boxes of these corners (B, 2) [m]."""
        return _parts(self.center, *_moments(self.radius, lower - self.center, upper - self.center))


@dataclass(frozen=True)
class Ring:
    """What lies between two concentric circles, its edges included.

    Parameters
    ----------
    center : (float, float)
        [m].
    inner, outer : float
        Radii [m].

    Raises
    ------
    UsageError
        If the centre is not finite and in the plane, or not 0 < inner < outer < infinity.
    """

    center: tuple[float, float]
    inner: float
    outer: float

    def __post_init__(self) -> None:
        if not (_in_plane(self.center) and 0 < self.inner < self.outer < math.inf):
            raise UsageError(f"a ring needs two finite coordinates of its center and radii 0 < inner < outer: {self!r}")

    @property
    def measure(self) -> float:
        """Area [m^2]."""
        return math.pi * (self.outer - self.inner) * (self.outer + self.inner)

    def within(self, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
        """Whether the body lies in a box of these corners [m]; it may touch its faces."""
        return _within(self.center, self.outer, lower, upper)

    def contains(self, X: Array) -> NDArray[np.bool_]:
        """Whether points (P, 2) [m] belong to the body, (P,)."""
        distance = _distance(X, self.center)
        return (self.inner <= distance) & (distance <= self.outer)

    def parts(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Areas (B,) [m^2] and centroids (B, 2) [m] of what lies in boxes of these corners (B, 2) [m]."""
        lower, upper = lower - self.center, upper - self.center
        (outer, of_outer), (inner, of_inner) = (_moments(radius, lower, upper) for radius in (self.outer, self.inner))
        return _parts(self.center, outer - inner, of_outer - of_inner)


Shape = Disk | Ring


def _in_plane(center: tuple[float, ...]) -> bool:
    return len(center) == 2 and all(math.isfinite(x) for x in center)


def _within(center: tuple[float, ...], reach: float, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
    return all(lo <= x - reach and x + reach <= hi for lo, x, hi in zip(lower, center, upper, strict=True))


def _distance(X: Array, center: tuple[float, float]) -> Array:
    return np.hypot(X[:, 0] - center[0], X[:, 1] - center[1])


def _moments(radius: float, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Area (B,) [m^2] and first moments (B, 2) [m^3] of what a circle around the origin cuts out of boxes (B, 2) [m].

    Notes
    -----
    The abscissae where the circle crosses the sides cut a box into five slabs. In each of them the part is a trapezoid between
    chords, and a segment of the circle beyond each chord that stands for an arc: of a chord c its angle is theta = 2 asin(c/2r), its
    area r^2 (theta - sin theta)/2, and its moment along the normal c^3/12. No small part is the difference of large ones.
    """
    bottom, top = lower[:, 1], upper[:, 1]
    crossings = [np.sqrt(np.maximum(radius**2 - side**2, 0)) for side in (bottom, top)]
    cuts = np.stack([lower[:, 0], *crossings, *(-x for x in crossings), upper[:, 0]])
    x = np.sort(np.clip(cuts, *np.clip([lower[:, 0], upper[:, 0]], -radius, radius)), axis=0)
    middle = _half_chord(radius, (x[:-1] + x[1:]) / 2)
    within = (np.maximum(bottom, -middle) < np.minimum(top, middle)) * np.diff(x, axis=0)
    low, high = np.maximum(bottom, -_half_chord(radius, x)), np.minimum(top, _half_chord(radius, x))
    height = np.maximum(high - low, 0)
    area = within * (height[:-1] + height[1:]) / 2
    a, b = x[:-1], x[1:]
    moment_x = within * (height[:-1] * (2 * a + b) + height[1:] * (a + 2 * b)) / 6
    squares = [side[:-1] ** 2 + side[:-1] * side[1:] + side[1:] ** 2 for side in (high, low)]
    moment_y = within * (squares[0] - squares[1]) / 6
    for side, rising, arc in ((high, 1, middle < top), (low, -1, bottom < -middle)):
        rise = np.diff(side, axis=0)
        chord = np.where(arc & (within > 0), np.hypot(within, rise), 0)
        angle = 2 * np.arcsin(np.minimum(chord / (2 * radius), 1))
        area += radius**2 * (angle - np.sin(angle)) / 2
        moment_x -= rising * chord**2 * rise / 12
        moment_y += rising * chord**2 * within / 12
    return area.sum(axis=0), np.stack([moment_x.sum(axis=0), moment_y.sum(axis=0)], axis=1)


def _half_chord(radius: float, x: Array) -> Array:
    """Ordinate of the upper half of a circle around the origin [m]."""
    return np.sqrt(np.maximum((radius - x) * (radius + x), 0))


def _parts(center: tuple[float, float], area: Array, moment: Array) -> tuple[Array, Array]:
    """Areas and centroids from the moments about a center, which is the centroid of what is empty."""
    area = np.maximum(area, 0)
    return area, center + moment / np.where(area > 0, area, np.inf)[:, None]
