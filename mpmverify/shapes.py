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


Shape = Disk | Ring


def _in_plane(center: tuple[float, ...]) -> bool:
    return len(center) == 2 and all(math.isfinite(x) for x in center)


def _within(center: tuple[float, ...], reach: float, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
    return all(lo <= x - reach and x + reach <= hi for lo, x, hi in zip(lower, center, upper, strict=True))


def _distance(X: Array, center: tuple[float, float]) -> Array:
    return np.hypot(X[:, 0] - center[0], X[:, 1] - center[1])
