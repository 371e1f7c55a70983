"""Motions of a body in closed form, and the fields that follow from a motion."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mpmverify.exact.solution import ExactField
from mpmverify.problem import Array, Field, LinearElastic


class Motion(Protocol):
    """A motion as a frozen value; its methods take reference positions (P, dim) [m] and times (T,) [s]."""

    @property
    def material(self) -> LinearElastic: ...

    def displacement(self, X: Array, t: Array) -> Array:
        """Return the displacement u (T, P, dim) [m]."""

    def velocity(self, X: Array, t: Array) -> Array:
        """Return the velocity v = u_t (T, P, dim) [m/s]."""

    def gradient(self, X: Array, t: Array) -> Array:
        """Return the displacement gradient H_ij = du_i/dX_j (T, P, dim, dim) [1]; the deformation gradient is F = I + H."""

    def stress(self, X: Array, t: Array) -> Array:
        """Return the Cauchy stress at the material point (T, P, components) [Pa]."""


@dataclass(frozen=True)
class FieldOf:
    """One field of a motion: reference positions (P, dim) [m], times (T,) [s] -> values (T, P, components).

    Parameters
    ----------
    motion : Motion
        The motion.
    quantity : str
        "displacement" [m]; "velocity" [m/s]; "stress" [Pa], the Cauchy stress at the material point; "displacement_gradient" [1],
        row by row; or "force" [m/s^2], the body force b of rho u_tt = Div P + rho b, of motions that have such a method.
    """

    motion: Motion
    quantity: str

    def __call__(self, X: Array, t: Array) -> Array:
        if self.quantity == "displacement_gradient":
            gradient = self.motion.gradient(X, t)
            return gradient.reshape(*gradient.shape[:2], -1)
        values: Array = getattr(self.motion, self.quantity)(X, t)
        return values


@dataclass(frozen=True)
class AtStart:
    """A field at t = 0: reference positions (P, dim) [m] -> values (P, components)."""

    field: ExactField

    def __call__(self, X: Array) -> Array:
        return self.field(X, np.zeros(1))[0]


def fields_of(motion: Motion) -> dict[str, ExactField]:
    """Return the displacement, velocity, stress and displacement gradient of a motion, by quantity."""
    return {quantity: FieldOf(motion, quantity) for quantity in ("displacement", "velocity", "stress", "displacement_gradient")}


def initial_velocity(motion: Motion) -> dict[str, Field]:
    """Return the initial velocity of a motion, by quantity: all initial fields of a body that starts undeformed."""
    return {"velocity": AtStart(FieldOf(motion, "velocity"))}


def initial_deformation(motion: Motion) -> dict[str, Field]:
    """Return the initial displacement, stress and displacement gradient of a motion, by quantity."""
    fields = fields_of(motion)
    return {quantity: AtStart(fields[quantity]) for quantity in ("displacement", "stress", "displacement_gradient")}
