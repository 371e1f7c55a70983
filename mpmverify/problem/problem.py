"""The initial-boundary-value problem as a solver sees it, without its exact solution."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem.boundary import BoundaryCondition, Fixed, Periodic, Traction, Velocity
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
        Current positions (P, dim) [m], times (T,) [s] -> acceleration (T, P, dim) [m/s^2]. Along periodic axes a position is not
        wrapped back into the box.
    """

    force: BodyForce


@dataclass(frozen=True)
class Problem:
    """An initial-boundary-value problem on a box; in two dimensions plane strain, unless the material is in plane stress.

    Parameters
    ----------
    name : str
        Identifies the problem in files and reports.
    lower, upper : tuple of float
        Corners of the box, one entry per dimension [m].
    material : Material
        Material of the body, or of all bodies.
    boundary : mapping of str to BoundaryCondition
        One condition for each of the faces "x-", "x+", "y-", ...
    end_time : float
        Final time [s]; the problem starts at 0.
    initial : mapping of str to Field
        Initial fields by quantity, see `Solution`; a quantity that is not given is zero. For a body that starts deformed, give
        displacement, displacement gradient and stress.
    body_force : BodyForce or Spatial, optional
        Acceleration [m/s^2] as a function of reference positions, or of current positions (`Spatial`).
    outputs : int
        Number of output intervals; a solver that takes fewer steps returns every step.
    shape : Shape, optional
        Initial shape of the body; by default it fills the box. Its surface is traction-free except where it touches a face of the
        box. Several bodies have one material; a solver without contact moves them as one body where they meet.

    Raises
    ------
    UsageError
        If the box is empty or has more than three dimensions, a face has no boundary condition, the final time is not positive and
        finite, `outputs` is less than 1, an initial quantity is unknown, or the shape does not lie in the box.
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
            raise UsageError(f"problem {self.name!r}: give the box one to three sides, and upper bounds above its lower bounds")
        faces = {axis + side for axis in "xyz"[: self.dimension] for side in "-+"}
        if set(self.boundary) != faces:
            raise UsageError(f"problem {self.name!r}: give one boundary condition for each of {', '.join(sorted(faces))}")
        if unknown := sorted(self.initial.keys() - UNITS.keys()):
            raise UsageError(f"problem {self.name!r}: the initial {unknown[0]!r} is unknown: known are {', '.join(UNITS)}")
        if self.shape is not None and not self.shape.within(self.lower, self.upper):
            raise UsageError(f"problem {self.name!r}: {self.shape!r} must lie in the box, in its dimension: move or replace it")

    @property
    def dimension(self) -> int:
        return len(self.lower)

    @property
    def lengths(self) -> tuple[float, ...]:
        return tuple(hi - lo for lo, hi in zip(self.lower, self.upper, strict=True))

    @property
    def measure(self) -> float:
        """Initial length, area or volume of the body [m^dim]."""
        return math.prod(self.lengths) if self.shape is None else self.shape.measure

    def touched(self, face: str) -> list[Block]:
        """Return the blocks with a side on a face of the box; without a shape, the body is one block that fills the box."""
        axis = "xyz".index(face[0])
        bodies = (Block(self.lower, self.upper),) if self.shape is None else self.shape.bodies
        return touching(bodies, axis, (self.lower if face[1] == "-" else self.upper)[axis])

    def initial_field(self, quantity: str, points: Array) -> Array:
        """Return the initial values of a quantity, (P, components), at reference positions (P, dim) [m]."""
        shape = len(points), len(components(quantity, self.dimension))
        if quantity in self.initial:
            return np.asarray(self.initial[quantity](points), dtype=float).reshape(shape)
        return np.zeros(shape)

    def force(self, X: Array, x: Array, t: float) -> Array:
        """Return the body force (P, dim) [m/s^2] at a time [s], at points with reference positions X and positions x (P, dim) [m]."""
        if self.body_force is None:
            return np.zeros(x.shape)
        force, points = (self.body_force.force, x) if isinstance(self.body_force, Spatial) else (self.body_force, X)
        return np.asarray(force(points, np.array([t], dtype=float)), dtype=float)[0]


def require(condition: Any, solver: str, problem: Problem, what: str) -> None:
    """Raise a `UsageError` that says `what` the solver accepts, unless the condition holds."""
    if not condition:
        raise UsageError(f"solver {solver!r} cannot solve {problem.name!r}: it takes {what}")


def require_body(solver: str, problem: Problem) -> None:
    """Require faces that are held, loaded or periodic, and an initial state that is given as a whole.

    Raises
    ------
    UsageError
        If a face has another condition, one end of an axis alone is joined, a traction acts on a face that no side of a body lies
        against, or the body begins deformed and one of displacement, displacement gradient and stress is not given.
    """
    conditions = problem.boundary.values()
    taken = all(isinstance(condition, Velocity | Fixed | Traction | Periodic) for condition in conditions)
    require(taken, solver, problem, "prescribed velocities, tractions and joined ends as boundary conditions")
    joined = [isinstance(condition, Periodic) for _, condition in sorted(problem.boundary.items())]
    require(joined[::2] == joined[1::2], solver, problem, "axes of which both ends are joined or neither")
    loaded = [face for face, c in problem.boundary.items() if isinstance(c, Traction) and c != Traction()]
    require(all(map(problem.touched, loaded)), solver, problem, "no traction on faces that no side of a body lies against")
    state = {"displacement", "displacement_gradient", "stress"}
    whole = f"bodies that begin undeformed, or with all of {', '.join(sorted(state))}"
    require(state & problem.initial.keys() in (set(), state), solver, problem, whole)
