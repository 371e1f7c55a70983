"""Motions with the same deformation at every point: constant velocity gradients, and rotation."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import FieldOf, fields_of, initial_velocity
from mpmverify.exact.rigid_motion import CELL, CITATION, SPEED, STEPS
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import (
    Array,
    Block,
    BoundaryCondition,
    Constant,
    LinearElastic,
    NeoHookean,
    Problem,
    Traction,
    Velocity,
)


@dataclass(frozen=True)
class Homogeneous:
    """A constant velocity gradient, u = t L (X - centre), a `Motion` without acceleration.

    Parameters
    ----------
    material : LinearElastic
    rate : tuple of tuple of float
        L (dim, dim) [1/s].
    center : tuple of float
        Point at rest [m].
    """

    material: LinearElastic
    rate: tuple[tuple[float, ...], ...]
    center: tuple[float, ...]

    def displacement(self, X: Array, t: Array) -> Array:
        return t[:, None, None] * self.velocity(X, t)

    def velocity(self, X: Array, t: Array) -> Array:
        values: Array = (X - np.array(self.center)) @ np.array(self.rate).T
        return np.broadcast_to(values, (len(t), *X.shape)).copy()

    def gradient(self, X: Array, t: Array) -> Array:
        return t[:, None, None, None] * np.broadcast_to(np.array(self.rate), (len(t), *X.shape, X.shape[1]))

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))


@dataclass(frozen=True)
class Rotation:
    """Rotation at a constant rate in the plane of x and y, u = (Q(t) - I)(X - centre), a `Motion`.

    Parameters
    ----------
    material : LinearElastic
    rate : float
        Angular velocity [1/s].
    center : tuple of float
        Point at rest [m].
    """

    material: LinearElastic
    rate: float
    center: tuple[float, ...]

    def turn(self, t: Array, derivative: int) -> Array:
        """Return the derivative of Q - I in time of some order (T, 1, dim, dim) [1/s^order], 1 - cos without cancellation."""
        angle, quarter = self.rate * t, derivative * np.pi / 2
        cosine, sine = (np.cos(angle + quarter), np.sin(angle + quarter))
        if derivative == 0:
            cosine = -2 * np.sin(angle / 2) ** 2
        Q = np.zeros((len(t), 1, len(self.center), len(self.center)))
        Q[:, 0, 0, 0], Q[:, 0, 0, 1], Q[:, 0, 1, 0], Q[:, 0, 1, 1] = cosine, -sine, sine, cosine
        return self.rate**derivative * Q

    def _of(self, X: Array, t: Array, derivative: int) -> Array:
        values: Array = (self.turn(t, derivative) @ (X - np.array(self.center))[None, :, :, None])[..., 0]
        return values

    def displacement(self, X: Array, t: Array) -> Array:
        return self._of(X, t, 0)

    def velocity(self, X: Array, t: Array) -> Array:
        return self._of(X, t, 1)

    def force(self, X: Array, t: Array) -> Array:
        return self._of(X, t, 2)

    def gradient(self, X: Array, t: Array) -> Array:
        return np.broadcast_to(self.turn(t, 0), (len(t), *X.shape, X.shape[1])).copy()

    def stress(self, X: Array, t: Array) -> Array:
        return np.zeros((len(t), len(X), X.shape[1] * (X.shape[1] + 1) // 2))


RATE = np.array([(1.0, 0.5, -0.25), (-0.75, -0.5, 0.125), (0.375, 0.25, 0.75)])
"""Velocity gradient [1/s], with unequal shears and a spin."""


def shear(dimension: int) -> VerificationProblem:
    """A constant velocity gradient in a free block: away from its surface, nothing else happens for some steps.

    Parameters
    ----------
    dimension : {1, 2, 3}

    References
    ----------
    Irons B. M., Razzaque A. (1972), doi:10.1016/B978-0-12-068650-6.50026-2.
    """
    side = 2 * SHEARED[dimension] * CELL
    law = NeoHookean(SPEED**2, 1.0, 0.3)
    motion = Homogeneous(law, tuple(map(tuple, RATE[:dimension, :dimension].tolist())), (side / 2 + CELL,) * dimension)
    return _homogeneous(
        motion,
        f"shear-{dimension}d",
        side + 2 * CELL,
        {axis + face: Traction() for axis in "xyz"[:dimension] for face in "-+"},
        2 * 0.5 * CELL / law.wave_speed,
        Block((CELL,) * dimension, (side + CELL,) * dimension),
    )


SHEARED = {1: 26, 2: 26, 3: 16}
"""Half the width of the sheared block in cells, by dimension: what its surface does comes less far in the steps of the run."""


def stretch(dimension: int, steps: int = STEPS) -> VerificationProblem:
    """Uniform stretch of the box by its faces, which move as the body does.

    Parameters
    ----------
    dimension : {1, 2, 3}
    steps : int
        Time steps at a Courant number of 1/2 and the cell size `CELL`.

    References
    ----------
    Irons B. M., Razzaque A. (1972), doi:10.1016/B978-0-12-068650-6.50026-2.
    """
    law, rates = NeoHookean(SPEED**2, 1.0, 0.3), (1.0, -0.5, 0.25)[:dimension]
    motion = Homogeneous(
        law, tuple(tuple(rate * (i == k) for k in range(dimension)) for i, rate in enumerate(rates)), (0.0,) * dimension
    )
    side = 8 * CELL
    boundary: dict[str, BoundaryCondition] = {}
    for axis, rate in zip("xyz", rates, strict=False):
        boundary |= {f"{axis}-": Velocity(), f"{axis}+": Velocity(Constant(rate * side))}
    return _homogeneous(motion, f"stretch-{dimension}d-{steps}", side, boundary, steps * 0.5 * CELL / law.wave_speed)


def _homogeneous(
    motion: Homogeneous,
    name: str,
    side: float,
    boundary: Mapping[str, BoundaryCondition],
    end_time: float,
    shape: Block | None = None,
) -> VerificationProblem:
    dimension = len(motion.center)
    return VerificationProblem(
        problem=Problem(
            name,
            (0.0,) * dimension,
            (side,) * dimension,
            motion.material,
            boundary,
            end_time,
            initial_velocity(motion),
            shape=shape,
        ),
        exact=ExactSolution(fields_of(motion), CITATION),
        exposes="A strain increment that is not that of the velocity gradient: its components, spin, basis and faces.",
        equations=(
            r"u = t\, L\, (X - X_0), \quad v = L\, (X - X_0), \quad F = I + t L",
            r"\sigma = \sigma(F) \text{ is uniform, so that no point is accelerated}",
        ),
    )


def rotation(dimension: int, *, rate: float = 4.0, end_time: float = 0.25) -> VerificationProblem:
    """A free block that rotates in the plane of x and y, held on its circles by a body force.

    Parameters
    ----------
    dimension : {2, 3}
    rate : float
        Angular velocity [1/s].
    end_time : float
        Final time [s].

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3.

    References
    ----------
    Irons B. M., Razzaque A. (1972), doi:10.1016/B978-0-12-068650-6.50026-2.
    """
    if dimension not in (2, 3):
        raise UsageError(f"a body rotates in two or three dimensions, not in {dimension!r}")
    motion = Rotation(NeoHookean(SPEED**2, 1.0, 0.3), rate, (0.5,) * dimension)
    return VerificationProblem(
        problem=Problem(
            name=f"rotation-{dimension}d",
            lower=(0.0,) * dimension,
            upper=(1.0,) * dimension,
            material=motion.material,
            boundary={axis + face: Traction() for axis in "xyz"[:dimension] for face in "-+"},
            end_time=end_time,
            initial=initial_velocity(motion),
            body_force=FieldOf(motion, "force"),
            shape=Block((0.25,) * dimension, (0.75,) * dimension),
        ),
        exact=ExactSolution(fields_of(motion), CITATION),
        exposes="A rotation that strains a body: the spin in the strain increment, and transfers at free surfaces.",
        equations=(
            r"u = (Q(\omega t) - I)(X - X_0), \quad F = Q, \quad \sigma = 0",
            r"b = \partial_{tt} u = -\omega^2\, Q\, (X - X_0) \text{ in the plane of } x \text{ and } y",
        ),
    )
