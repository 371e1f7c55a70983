"""The initial-boundary-value problem as a solver may see it, and how it is discretised."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem.boundary import (
    BoundaryCondition,
)
from mpmverify.problem.material import Material
from mpmverify.problem.quantities import UNITS, Array, components
from mpmverify.problem.shapes import Block, Shape, touching

Field = Callable[[Array], Array]
"""Initial field: reference positions (P, dim) [m] -> values (P, components)."""
BodyForce = Callable[[Array, Array], Array]
"""Body force: reference positions (P, dim) [m], times (T,) [s] -> acceleration (T, P, dim) [m/s^2]."""


@dataclass(frozen=True)
class Spatial:
    """A body force in spatial coordinates.

    Parameters
    ----------
    force : callable
        Current positions (P, dim) [m], times (T,) [s] -> acceleration (T, P, dim) [m/s^2]. On joined axes positions run on.
    """

    force: BodyForce


@dataclass(frozen=True)
class Problem:
    """An initial-boundary-value problem on a box, in plane strain where it has two dimensions.

    Parameters
    ----------
    name : str
        Identifies the problem in files and pages.
    lower, upper : tuple of float
        Corners of the box, one entry per dimension [m].
    material : Material
        Of the body.
    boundary : mapping of str to BoundaryCondition
        One condition for each of the faces "x-", "x+", "y-", ...
    end_time : float
        Final time [s]; the problem starts at 0.
    initial : mapping of str to Field
        Initial fields by quantity, one of those of `Solution`; an absent one is zero. A body that is strained at first has its
        displacement, its displacement gradient and its stress.
    body_force : BodyForce or Spatial, optional
        In material coordinates, or in spatial ones [m/s^2].
    outputs : int
        Number of output intervals; a solver that takes fewer steps returns every step.
    shape : Shape, optional
        What the body fills of the box at first, all of it by default. Its surface is free but where it touches a face of the box.
        Several bodies are of one material, and where a solver knows of no contact they move as one where they meet.

    Raises
    ------
    UsageError
        If the box is empty, a face lacks its condition, the final time is not positive and finite, there is no output interval, an
        initial quantity is unknown, or the shape does not lie in the box.
    """

    name: str
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    material: Material
    boundary: Mapping[str, BoundaryCondition]
    end_time: float
    initial: Mapping[str, Field] = field(default_factory=dict)
    body_force: BodyForce | Spatial | None = None
    outputs: int = 32
    shape: Shape | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.end_time) and self.end_time > 0):
            raise UsageError(f"problem {self.name!r}: the final time must be positive and finite, not {self.end_time!r}")
        if self.outputs < 1:
            raise UsageError(f"problem {self.name!r}: there must be at least 1 output interval, not {self.outputs!r}")
        ordered = all(lo < hi for lo, hi in zip(self.lower, self.upper, strict=False))
        if not (ordered and 1 <= len(self.lower) == len(self.upper) <= 3):
            raise UsageError(
                f"problem {self.name!r}: give the box a side, at most three, and upper bounds above its lower bounds"
            )
        faces = {axis + side for axis in "xyz"[: self.dimension] for side in "-+"}
        if set(self.boundary) != faces:
            raise UsageError(f"problem {self.name!r}: give one boundary condition for each of {', '.join(sorted(faces))}")
        if unknown := sorted(self.initial.keys() - UNITS.keys()):
            raise UsageError(f"problem {self.name!r}: the initial {unknown[0]!r} is unknown: known are {', '.join(UNITS)}")
        if self.shape is not None and not self.shape.within(self.lower, self.upper):
            raise UsageError(f"problem {self.name!r}: {self.shape!r} must lie in a box of its dimension: enlarge or move it")

    @property
    def dimension(self) -> int:
        return len(self.lower)

    @property
    def lengths(self) -> tuple[float, ...]:
        return tuple(hi - lo for lo, hi in zip(self.lower, self.upper, strict=True))

    @property
    def measure(self) -> float:
        """Length, area or volume of the body at first [m^dim]."""
        return math.prod(self.lengths) if self.shape is None else self.shape.measure

    def touched(self, face: str) -> list[Block]:
        """Blocks of the body that lie against a face of the box, all of it where the body has no shape."""
        axis = "xyz".index(face[0])
        bodies = (Block(self.lower, self.upper),) if self.shape is None else self.shape.bodies
        return touching(bodies, axis, (self.lower if face[1] == "-" else self.upper)[axis])

    def initial_field(self, quantity: str, points: Array) -> Array:
        """Initial values of a quantity at reference positions (P, dim), (P, components)."""
        shape = len(points), len(components(quantity, self.dimension))
        if quantity in self.initial:
            return np.asarray(self.initial[quantity](points), dtype=float).reshape(shape)
        return np.zeros(shape)


def require(condition: Any, solver: str, problem: Problem, what: str) -> None:
    """Raise a `UsageError` when a solver cannot take a problem, and say what it can take."""
    if not condition:
        raise UsageError(f"solver {solver!r} cannot solve {problem.name!r}: it takes {what}")
