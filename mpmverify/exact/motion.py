"""Manufactured motions of finite amplitude of a neo-Hookean body, and the fields that follow from a motion."""

import itertools
import operator
from dataclasses import dataclass
from functools import reduce
from typing import Protocol

import numpy as np

from mpmverify.exact.solution import ExactField
from mpmverify.problem import Array, Field, NeoHookean
from mpmverify.problem.quantities import SYMMETRIC


class Motion(Protocol):
    """A motion as a frozen value; its methods take reference positions (P, dim) [m] and times (T,) [s]."""

    @property
    def material(self) -> NeoHookean: ...

    def displacement(self, X: Array, t: Array) -> Array:
        """Return the displacement u (T, P, dim) [m]."""

    def velocity(self, X: Array, t: Array) -> Array:
        """Return the velocity v = u_t (T, P, dim) [m/s]."""

    def gradient(self, X: Array, t: Array) -> Array:
        """Return the displacement gradient H_ij = du_i/dX_j (T, P, dim, dim) [1]; the deformation gradient is F = I + H."""

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force b (T, P, dim) [m/s^2], from rho u_tt = Div P + rho b."""


def volume_change(gradient: Array) -> Array:
    """Return J - 1 (...) [1] of a displacement gradient (..., dim, dim).

    J - 1 is the sum of the principal minors of H, without the cancellation of det F - 1.
    """
    H, axes = np.moveaxis(gradient, (-2, -1), (0, 1)), range(gradient.shape[-1])

    def minor(rows: tuple[int, ...], columns: tuple[int, ...]) -> Array:
        if len(rows) == 1:
            return H[rows[0], columns[0]]
        cofactors = [minor(rows[1:], columns[:k] + columns[k + 1 :]) for k in range(len(columns))]
        return reduce(operator.add, [(-1) ** k * H[rows[0], columns[k]] * cofactor for k, cofactor in enumerate(cofactors)])

    return reduce(operator.add, [minor(some, some) for order in axes for some in itertools.combinations(axes, order + 1)])


def cauchy_stress(law: NeoHookean, gradient: Array) -> Array:
    """Return the Cauchy stress [lambda ln(J) I + mu (F F^T - I)]/J, (..., components) [Pa], of a displacement gradient H.

    Parameters
    ----------
    law : NeoHookean
        Material.
    gradient : Array
        H (..., dim, dim) [1].
    """
    dimension, change = gradient.shape[-1], volume_change(gradient)
    J, pressure = 1 + change, law.lame_lambda * np.log1p(change)
    stress = np.empty((*gradient.shape[:-2], dimension * (dimension + 1) // 2))
    for c, pair in enumerate(SYMMETRIC.get(dimension, ("xx",))):
        i, j = "xyz".index(pair[0]), "xyz".index(pair[1])
        # (F F^T - I)_ij = H_ij + H_ji + H_ik H_jk, without cancellation.
        strain = gradient[..., i, j] + gradient[..., j, i]
        strain += reduce(operator.add, [gradient[..., i, k] * gradient[..., j, k] for k in range(dimension)])
        stress[..., c] = (law.shear_modulus * strain + (pressure if i == j else 0.0)) / J
    return stress


@dataclass(frozen=True)
class FieldOf:
    """One field of a motion: reference positions (P, dim) [m], times (T,) [s] -> values (T, P, components).

    Parameters
    ----------
    motion : Motion
        The motion.
    quantity : str
        "displacement" [m]; "velocity" [m/s]; "stress" [Pa], the Cauchy stress at the material point; "displacement_gradient" [1],
        row by row; or "force" [m/s^2], the body force that makes the motion exact.
    """

    motion: Motion
    quantity: str

    def __call__(self, X: Array, t: Array) -> Array:
        if self.quantity == "stress":
            return cauchy_stress(self.motion.material, self.motion.gradient(X, t))
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
