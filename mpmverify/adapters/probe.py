"""A verification problem at some points and times: its fields, and their derivatives by central differences of fourth order."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mpmverify.exact import VerificationProblem
from mpmverify.exact.finite_strain import KIRCHHOFF, volume_change
from mpmverify.problem import (
    Array,
)
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
        sigma, d = self.of("stress")(X, t), self.dimension
        tensor = np.zeros((*sigma.shape[:2], d, d))
        for c, pair in enumerate(SYMMETRIC.get(d, ("xx",))):
            i, j = "xyz".index(pair[0]), "xyz".index(pair[1])
            tensor[..., i, j] = tensor[..., j, i] = sigma[..., c]
        if type(self.problem.problem.material) not in KIRCHHOFF:
            return tensor
        F = np.eye(d) + self.gradient(X, t)
        J = 1 + volume_change(F - np.eye(d))
        return J[..., None, None] * tensor @ np.linalg.inv(F).swapaxes(-1, -2)


def _difference(function: Callable[[float], Array], step: float) -> Array:
    return (8 * (function(step) - function(-step)) - (function(2 * step) - function(-2 * step))) / (12 * step)
