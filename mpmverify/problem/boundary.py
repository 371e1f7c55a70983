"""Boundary conditions, one for each face of the box, and the functions of time that they prescribe.

A tensile traction is positive. Statements about the shear traction apply in two and three dimensions.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mpmverify.problem.quantities import Array


class History(Protocol):
    """A function of time [s] with its integral from 0; both map (T,) -> (T,)."""

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
    """Clamped: every component of the velocity is zero."""


@dataclass(frozen=True)
class Absorbing:
    """Non-reflecting face: the incoming characteristic is zero."""


@dataclass(frozen=True)
class Inflow:
    """Prescribed value of the transported scalar, at a face where the velocity points into the box."""

    value: History = Constant()


@dataclass(frozen=True)
class Outflow:
    """No prescribed value: the transported scalar leaves the box."""


@dataclass(frozen=True)
class Periodic:
    """Identified with the opposite face."""


BoundaryCondition = Traction | Velocity | Fixed | Absorbing | Inflow | Outflow | Periodic
