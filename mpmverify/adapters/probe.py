"""A verification problem at some points and times: its fields, and their derivatives by central differences of fourth order."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mpmverify.exact import VerificationProblem
from mpmverify.exact.finite_strain import KIRCHHOFF, cauchy_stress, volume_change
from mpmverify.problem import Array, LinearElastic
from mpmverify.problem.quantities import SYMMETRIC


@dataclass(frozen=True)
class Probe:
    """A verification problem at points X (P, dim) [m] and times t (T,) [s]."""

    problem: VerificationProblem
    X: Array
    t: Array
    step: float

    @property
    def dimension(self) -> int:
        return self.problem.problem.dimension

    def has(self, *quantities: str) -> bool:
        return set(quantities) <= self.problem.exact.fields.keys()

    def field(self, quantity: str) -> Array:
        return self.of(quantity)(self.X, self.t)

    def of(self, quantity: str) -> Callable[[Array, Array], Array]:
        return self.problem.exact.fields[quantity]

    def rate(self, function: Callable[[Array, Array], Array]) -> Array:
        """Derivative in time of a function of (X, t)."""
        step = self.step * self.problem.problem.end_time
        return _difference(lambda s: function(self.X, self.t + s), step)

    def slopes(self, function: Callable[[Array, Array], Array]) -> Array:
        """Derivatives along each axis (..., dim) of a function of (X, t)."""

        def along(axis: Array, side: float) -> Array:
            return _difference(lambda s: function(self.X + s * axis, self.t), self.step * side)

        return np.stack(
            [along(*one) for one in zip(np.eye(self.dimension), self.problem.problem.lengths, strict=True)], axis=-1
        )

    def gradient(self, X: Array, t: Array) -> Array:
        """Displacement gradient (T, P, dim, dim), by differences where the problem does not give it."""
        if self.has("displacement_gradient"):
            return self.of("displacement_gradient")(X, t).reshape(len(t), len(X), self.dimension, self.dimension)
        return Probe(self.problem, X, t, self.step).slopes(self.of("displacement"))

    def stress(self, X: Array, t: Array) -> Array:
        """Stress tensor whose divergence accelerates the body (T, P, dim, dim): the first Piola-Kirchhoff stress at finite strain."""
        d, law = self.dimension, self.problem.problem.material
        assert isinstance(law, LinearElastic), "a transported scalar has no stress"
        if self.has("stress"):
            sigma = self.of("stress")(X, t)
        else:
            sigma = (cauchy_stress if type(law) in KIRCHHOFF else elastic_stress)(law, self.gradient(X, t))
        tensor = np.zeros((*sigma.shape[:2], d, d))
        for c, pair in enumerate(SYMMETRIC.get(d, ("xx",))):
            i, j = "xyz".index(pair[0]), "xyz".index(pair[1])
            tensor[..., i, j] = tensor[..., j, i] = sigma[..., c]
        if type(self.problem.problem.material) not in KIRCHHOFF:
            return tensor
        F = np.eye(d) + self.gradient(X, t)
        J = 1 + volume_change(F - np.eye(d))
        return J[..., None, None] * tensor @ np.linalg.inv(F).swapaxes(-1, -2)


def elastic_stress(law: LinearElastic, gradient: Array) -> Array:
    """Return the stress (T, P, components) [Pa] of isotropic linear elasticity at small strain."""
    d = gradient.shape[-1]
    strain = (gradient + gradient.swapaxes(-1, -2)) / 2
    trace = np.trace(strain, axis1=-2, axis2=-1)
    tensor = law.lame_lambda * trace[..., None, None] * np.eye(d) + 2 * law.shear_modulus * strain
    return np.stack([tensor[..., "xyz".index(pair[0]), "xyz".index(pair[1])] for pair in SYMMETRIC.get(d, ("xx",))], axis=-1)


def _difference(function: Callable[[float], Array], step: float) -> Array:
    return (8 * (function(step) - function(-step)) - (function(2 * step) - function(-2 * step))) / (12 * step)
