"""Shapes of bodies that do not fill their box: disks, rings, blocks and sets of them."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpmverify.errors import UsageError
from mpmverify.problem.quantities import Array


@dataclass(frozen=True)
class Disk:
    """A closed disk.

    Parameters
    ----------
    center : (float, float)
        Centre [m].
    radius : float
        Radius [m].

    Raises
    ------
    UsageError
        If the centre has not two finite coordinates, or the radius is not positive and finite.
    """

    center: tuple[float, float]
    radius: float

    def __post_init__(self) -> None:
        if not (_in_plane(self.center) and 0 < self.radius < math.inf):
            raise UsageError(f"a disk needs a center of two finite coordinates and a positive, finite radius, not {self!r}")

    @property
    def bodies(self) -> "tuple[Body, ...]":
        return (self,)

    @property
    def inner(self) -> float:
        return 0.0

    @property
    def outer(self) -> float:
        return self.radius

    @property
    def measure(self) -> float:
        """Area [m^2]."""
        return math.pi * self.radius**2

    def within(self, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
        """Whether the body lies in the box between these corners [m]; it may touch the faces."""
        return _within(_bounding_block(self), lower, upper)

    def contains(self, X: Array) -> NDArray[np.bool_]:
        """Return whether each point (P, 2) [m] belongs to the body, (P,)."""
        return _distance(X, self.center) <= self.radius

    def parts(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Return areas (B,) [m^2] and centroids (B, 2) [m] of the body's intersection with boxes between corners (B, 2) [m]."""
        return _centroids(self.center, *_moments(self.radius, lower - self.center, upper - self.center))


@dataclass(frozen=True)
class Ring:
    """A closed ring between two concentric circles.

    Parameters
    ----------
    center : (float, float)
        Centre [m].
    inner, outer : float
        Radii [m].

    Raises
    ------
    UsageError
        If the centre has not two finite coordinates, or 0 < inner < outer < infinity does not hold.
    """

    center: tuple[float, float]
    inner: float
    outer: float

    def __post_init__(self) -> None:
        if not (_in_plane(self.center) and 0 < self.inner < self.outer < math.inf):
            raise UsageError(f"a ring needs a center of two finite coordinates and radii 0 < inner < outer, not {self!r}")

    @property
    def bodies(self) -> "tuple[Body, ...]":
        return (self,)

    @property
    def measure(self) -> float:
        """Area [m^2]."""
        return math.pi * (self.outer - self.inner) * (self.outer + self.inner)

    def within(self, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
        """Whether the body lies in the box between these corners [m]; it may touch the faces."""
        return _within(_bounding_block(self), lower, upper)

    def contains(self, X: Array) -> NDArray[np.bool_]:
        """Return whether each point (P, 2) [m] belongs to the body, (P,)."""
        distance = _distance(X, self.center)
        return (self.inner <= distance) & (distance <= self.outer)

    def parts(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Return areas (B,) [m^2] and centroids (B, 2) [m] of the body's intersection with boxes between corners (B, 2) [m]."""
        lower, upper = lower - self.center, upper - self.center
        (outer, outer_moment), (inner, inner_moment) = (_moments(radius, lower, upper) for radius in (self.outer, self.inner))
        return _centroids(self.center, outer - inner, outer_moment - inner_moment)


@dataclass(frozen=True)
class Block:
    """A closed axis-aligned box in d = 1, 2 or 3 dimensions.

    Parameters
    ----------
    lower, upper : tuple of float
        Corners [m].

    Raises
    ------
    UsageError
        If the corners do not have the same number of finite coordinates, one to three, or an upper one is not above its lower one.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def __post_init__(self) -> None:
        ends = [*self.lower, *self.upper]
        finite = 1 <= len(self.lower) == len(self.upper) <= 3 and all(math.isfinite(x) for x in ends)
        if not (finite and all(lo < hi for lo, hi in zip(self.lower, self.upper, strict=True))):
            raise UsageError(
                f"a block needs two corners of one to three finite coordinates, the upper above the lower, not {self!r}"
            )

    @property
    def bodies(self) -> "tuple[Body, ...]":
        return (self,)

    @property
    def measure(self) -> float:
        """Length, area or volume [m^d]."""
        return math.prod(hi - lo for lo, hi in zip(self.lower, self.upper, strict=True))

    def within(self, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
        """Whether the body lies in the box between these corners [m]; it may touch the faces."""
        return _within(self, lower, upper)

    def contains(self, X: Array) -> NDArray[np.bool_]:
        """Return whether each point (P, d) [m] belongs to the body, (P,)."""
        return np.asarray(((np.array(self.lower) <= X) & (np.array(self.upper) >= X)).all(axis=1))

    def parts(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Return measures (B,) [m^d] and centroids (B, d) [m] of the intersection with boxes between corners (B, d) [m]."""
        low, high = np.maximum(lower, self.lower), np.minimum(upper, self.upper)
        measure = np.maximum(high - low, 0).prod(axis=1)
        return measure, (low + high) / 2


Body = Disk | Ring | Block


@dataclass(frozen=True)
class Bodies:
    """Several bodies, which may touch each other but not overlap.

    Parameters
    ----------
    bodies : tuple of Disk, Ring or Block
        One or more bodies of the same dimension.

    Raises
    ------
    UsageError
        If there is no body, the dimensions differ, or two bodies overlap.
    """

    bodies: tuple[Body, ...]

    def __post_init__(self) -> None:
        if not self.bodies or len({len(_bounding_block(body).lower) for body in self.bodies}) > 1:
            raise UsageError(f"give one or more bodies of the same dimension, not {self!r}")
        for one, other in itertools.combinations(self.bodies, 2):
            if not _disjoint(one, other):
                raise UsageError(f"bodies may touch but not overlap: move {one!r} away from {other!r}")

    @property
    def measure(self) -> float:
        """Sum of the lengths, areas or volumes [m^d]."""
        return math.fsum(body.measure for body in self.bodies)

    def within(self, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
        """Whether all bodies lie in the box between these corners [m]; they may touch the faces."""
        return all(body.within(lower, upper) for body in self.bodies)

    def contains(self, X: Array) -> NDArray[np.bool_]:
        """Return whether each point (P, d) [m] belongs to one of the bodies, (P,)."""
        return np.asarray(np.stack([body.contains(X) for body in self.bodies]).any(axis=0))


Shape = Body | Bodies


def _bounding_block(body: Body) -> Block:
    """Return the smallest block that contains a body."""
    if isinstance(body, Block):
        return body
    (x, y), r = body.center, body.outer
    return Block((x - r, y - r), (x + r, y + r))


def touching(bodies: tuple[Body, ...], axis: int, end: float) -> list[Block]:
    """Return the blocks with a side in the plane x[axis] = end [m], to round-off; a circle touches it in one point at most."""
    blocks = [body for body in bodies if isinstance(body, Block)]
    return [
        block for block in blocks if any(math.isclose(side[axis], end, abs_tol=1e-14) for side in (block.lower, block.upper))
    ]


def _disjoint(one: Body, other: Body) -> bool:
    """Whether the interiors of two bodies are disjoint."""
    if isinstance(one, Block) and isinstance(other, Block):
        ends = zip(one.lower, one.upper, other.lower, other.upper, strict=True)
        return any(b <= c or d <= a for a, b, c, d in ends)
    if isinstance(one, Block):
        return _disjoint(other, one)
    if isinstance(other, Block):
        corners = np.abs(np.array([other.lower, other.upper]) - one.center)
        nearest = np.maximum(np.maximum(np.array(other.lower) - one.center, one.center - np.array(other.upper)), 0)
        return math.hypot(*nearest) >= one.outer or math.hypot(*corners.max(axis=0)) <= one.inner
    distance = math.dist(one.center, other.center)
    nested = distance + other.outer <= one.inner or distance + one.outer <= other.inner
    return nested or distance >= one.outer + other.outer


def _in_plane(center: tuple[float, ...]) -> bool:
    return len(center) == 2 and all(math.isfinite(x) for x in center)


def _within(block: Block, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
    """Whether a block lies in the box between these corners; False if the dimensions differ."""
    if len(block.lower) != len(lower):
        return False
    return all(lo <= a and b <= hi for lo, a, b, hi in zip(lower, block.lower, block.upper, upper, strict=True))


def _distance(X: Array, center: tuple[float, float]) -> Array:
    return np.hypot(X[:, 0] - center[0], X[:, 1] - center[1])


def _moments(radius: float, lower: Array, upper: Array) -> tuple[Array, Array]:
    """Return areas (B,) [m^2] and first moments (B, 2) [m^3] of the parts of boxes (B, 2) [m] in a circle around the origin.

    Notes
    -----
    The abscissae at which the circle crosses the horizontal sides cut a box into five slabs. The part in a slab is a trapezoid, plus
    a circular segment beyond each chord that replaces an arc. A chord c has the angle theta = 2 asin(c/2r), and its segment the area
    r^2 (theta - sin theta)/2 and the moment c^3/12 along the normal. No small area is computed as a difference of large ones.
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
    """Return the ordinate of the upper half of a circle around the origin [m]."""
    return np.sqrt(np.maximum((radius - x) * (radius + x), 0))


def _centroids(center: tuple[float, float], area: Array, moment: Array) -> tuple[Array, Array]:
    """Return areas and centroids from areas and first moments about a centre; the centroid of an empty part is the centre."""
    area = np.maximum(area, 0)
    return area, center + moment / np.where(area > 0, area, np.inf)[:, None]
