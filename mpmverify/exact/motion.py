"""Motions of finite amplitude of a neo-Hookean body, and the fields that derive from one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mpmverify.exact.solution import ExactField
from mpmverify.problem import Array, Field, NeoHookean
from mpmverify.quantities import SYMMETRIC


class Motion(Protocol):
    """A motion as a frozen value; what it gives takes reference positions (P, dim) [m] and times (T,) [s]."""

    @property
    def material(self) -> NeoHookean: ...

    def displacement(self, X: Array, t: Array) -> Array:
        """Displacement u (T, P, dim) [m]."""

    def velocity(self, X: Array, t: Array) -> Array:
        """Velocity v = u_t (T, P, dim) [m/s]."""

    def gradient(self, X: Array, t: Array) -> Array:
        """Displacement gradient H_ij = du_i/dX_j (T, P, dim, dim) [1]; the deformation gradient is F = I + H."""

    def force(self, X: Array, t: Array) -> Array:
        """Body force b (T, P, dim) [m/s^2], from rho u_tt = Div P + rho b."""


def cauchy_stress(law: NeoHookean, gradient: Array) -> Array:
    """Cauchy stress [lambda ln(J) I + mu (F F^T - I)]/J of a displacement gradient (..., dim, dim), (..., components) [Pa]."""
    dimension = gradient.shape[-1]
    identity = np.eye(dimension)
    J = np.linalg.det(identity + gradient)[..., None, None]
    transposed = np.swapaxes(gradient, -1, -2)
    strain = gradient + transposed + gradient @ transposed  # F F^T - I, without the digits that a difference would lose
    stress = (law.lame_lambda * np.log(J) * identity + law.shear_modulus * strain) / J
    pairs = SYMMETRIC.get(dimension, ("xx",))
    return stress[..., ["xyz".index(pair[0]) for pair in pairs], ["xyz".index(pair[1]) for pair in pairs]]


@dataclass(frozen=True)
class DisplacementOf:
    """Displacement of a motion, (T, P, dim) [m]."""

    motion: Motion

    def __call__(self, X: Array, t: Array) -> Array:
        return self.motion.displacement(X, t)


@dataclass(frozen=True)
class VelocityOf:
    """Velocity of a motion, (T, P, dim) [m/s]."""

    motion: Motion

    def __call__(self, X: Array, t: Array) -> Array:
        return self.motion.velocity(X, t)


@dataclass(frozen=True)
class StressOf:
    """Cauchy stress of a motion at its material points, (T, P, components) [Pa]."""

    motion: Motion

    def __call__(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.motion.material, self.motion.gradient(X, t))


@dataclass(frozen=True)
class GradientOf:
    """Displacement gradient of a motion, row by row, (T, P, dim * dim) [1]."""

    motion: Motion

    def __call__(self, X: Array, t: Array) -> Array:
        gradient = self.motion.gradient(X, t)
        return gradient.reshape(*gradient.shape[:2], -1)


@dataclass(frozen=True)
class ForceOf:
    """Body force that makes a motion exact, (T, P, dim) [m/s^2]."""

    motion: Motion

    def __call__(self, X: Array, t: Array) -> Array:
        return self.motion.force(X, t)


@dataclass(frozen=True)
class AtStart:
    """A field of a motion at t = 0: (P, dim) [m] -> (P, components)."""

    field: ExactField

    def __call__(self, X: Array) -> Array:
        return self.field(X, np.zeros(1))[0]


def fields_of(motion: Motion) -> Mapping[str, ExactField]:
    """All fields of a motion, by quantity."""
    return {
        "displacement": DisplacementOf(motion),
        "velocity": VelocityOf(motion),
        "stress": StressOf(motion),
        "displacement_gradient": GradientOf(motion),
    }


def pushed(motion: Motion) -> Mapping[str, Field]:
    """Initial fields of a motion that starts undeformed."""
    return {"velocity": AtStart(VelocityOf(motion))}


def deformed(motion: Motion) -> Mapping[str, Field]:
    """Initial fields of a motion that starts deformed but at rest."""
    fields = fields_of(motion)
    return {quantity: AtStart(fields[quantity]) for quantity in ("displacement", "stress", "displacement_gradient")}
