"""Data in time, and the boundary conditions that hold them, one for each face of a box."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mpmverify.problem.quantities import Array


class History(Protocol):
    """A datum in time, with its integral from 0: both (T,) -> (T,)."""

    def __call__(self, t: Array) -> Array: ...

    def integral(self, t: Array) -> Array: ...


@dataclass(frozen=True)
class Constant:
    """The same value at all times (a `History`)."""

    value: float = 0.0

    def __call__(self, t: Array) -> Array:
        return np.full_like(t, self.value, dtype=float)

    def integral(self, t: Array) -> Array:
        return self.value * np.asarray(t, dtype=float)


# Boundary conditions, one per face of the box; a tensile traction is positive. What is said of the shear traction holds in two
# and three dimensions.


@dataclass(frozen=True)
class Traction:
    """Prescribed normal traction p(t) [Pa] and no shear traction; `Constant(0)` is a free surface."""

    value: History = Constant()


@dataclass(frozen=True)
class Velocity:
    """Prescribed normal velocity along the axis [m/s] and no shear traction; `Constant(0)` is a fixed end or a roller."""

    value: History = Constant()


@dataclass(frozen=True)
class Fixed:
    """No component of the velocity: clamped."""


@dataclass(frozen=True)
class Absorbing:
    """No incoming characteristic."""


@dataclass(frozen=True)
class Inflow:
    """Prescribed value of the transported scalar where the velocity points inwards."""

    value: History = Constant()


@dataclass(frozen=True)
class Outflow:
    """Nothing prescribed: the transported scalar leaves."""


@dataclass(frozen=True)
class Periodic:
    """Joined to the opposite face."""


BoundaryCondition = Traction | Velocity | Fixed | Absorbing | Inflow | Outflow | Periodic
