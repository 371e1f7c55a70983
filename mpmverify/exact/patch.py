"""Motions that a scheme must reproduce: rigid translation and fall, rotation, and a constant velocity gradient."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import FieldOf, fields_of, initial_deformation, initial_velocity
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import (
    Array,
    Block,
    Bodies,
    BoundaryCondition,
    Constant,
    LinearElastic,
    NeoHookean,
    Periodic,
    Problem,
    Traction,
    Velocity,
)

CITATION = (
    "Irons B. M., Razzaque A. (1972). Experience with the patch test for convergence of finite elements. In: Aziz A. K. (ed.), The "
    "Mathematical Foundations of the Finite Element Method, Academic Press, 557-587, doi:10.1016/B978-0-12-068650-6.50026-2"
)
CELL = 1 / 16
"""Cell size that the problems are made for [m]. With dyadic sizes and speeds, particles come to lie on cell edges exactly."""
SPEED = 8.0
"""Speed of P waves of the bodies without Poisson's ratio [m/s]."""
BESIDE = (0.0, 1e-15, -1e-15, 1e-13, -1e-13, 1e-9, -1e-9, 0.0123)
"""Distance of the particles of each block from where they come to lie on cell edges [m]."""
CLEAR = (0.0123,) * 8
"""The same, clear of the cell edges but while they pass them [m]."""
WIDTH, PITCH = 2, 10
"""Width of a block, and distance from one to the next, in cells; no function reaches from one block to another."""
DIRECTIONS = ((1.0, 1.0, 1.0), (-1.0, 0.5, -1.0), (0.5, -1.0, -0.25), (0.25, -0.5, 1.0))
"""Velocities of the blocks in turn [m/s]."""
STEPS = 24
"""Time steps of a flight at a Courant number of 1/2 and the cell size `CELL`."""


@dataclass(frozen=True)
class Flight:
    """Blocks in a row, one in each `PITCH` cells along x, that translate with velocities of their own and fall, a `Motion`.

    Parameters
    ----------
    material : LinearElastic
    velocities : tuple of tuple of float
        Initial velocity of each block (dim,) [m/s].
    beside : tuple of float
        Initial displacement of each block along every axis [m].
    gravity : float
        Acceleration down the last axis [m/s^2].
    """

    material: LinearElastic
    velocities: tuple[tuple[float, ...], ...]
    beside: tuple[float, ...]
    gravity: float = 0.0

    def block(self, X: Array) -> Any:
        """Return the number of the block of each point (P,)."""
        return np.floor(X[:, 0] / (PITCH * CELL)).astype(int)

    def displacement(self, X: Array, t: Array) -> Array:
        fallen = 0.5 * t[:, None, None] ** 2 * self._acceleration(X)
        return np.array(self.beside)[self.block(X), None] + t[:, None, None] * np.array(self.velocities)[self.block(X)] + fallen

    def velocity(self, X: Array, t: Array) -> Array:
        return np.array(self.velocities)[self.block(X)] + t[:, None, None] * self._acceleration(X)

    def gradient(self, X: Array, t: Array) -> Array:
        return np.zeros((len(t), *X.shape, X.shape[1]))

    def stress(self, X: Array, t: Array) -> Array:
        return np.zeros((len(t), len(X), X.shape[1] * (X.shape[1] + 1) // 2))

    def force(self, X: Array, t: Array) -> Array:
        return np.zeros((len(t), 1, 1)) + self._acceleration(X)

    def _acceleration(self, X: Array) -> Array:
        acceleration = np.zeros_like(X)
        acceleration[:, -1] = -self.gravity
        return acceleration


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


def _row(starts: Sequence[Sequence[int]]) -> Bodies:
    """Blocks that begin at given cells (dim,)."""
    corners = [tuple(CELL * cell for cell in start) for start in starts]
    return Bodies(tuple(Block(corner, tuple(x + WIDTH * CELL for x in corner)) for corner in corners))


def _flight(
    name: str, motion: Flight, starts: Sequence[Sequence[int]], boundary: Mapping[str, BoundaryCondition], exposes: str
) -> VerificationProblem:
    dimension = len(starts[0])
    return VerificationProblem(
        problem=Problem(
            name=f"{name}-{dimension}d",
            lower=(0.0,) * dimension,
            upper=(len(starts) * PITCH * CELL, *[PITCH * CELL] * (dimension - 1)),
            material=motion.material,
            boundary=boundary,
            end_time=STEPS * 0.5 * CELL / motion.material.wave_speed,
            initial=initial_velocity(motion) | initial_deformation(motion),
            body_force=FieldOf(motion, "force") if motion.gravity else None,
            shape=_row(starts),
        ),
        exact=ExactSolution(fields_of(motion), CITATION),
        exposes=exposes,
        equations=(
            r"\rho\, \partial_{tt} u = \operatorname{div} \sigma + \rho g, \quad \sigma n = 0 \text{ on free surfaces}",
            r"u = u_0 + v_0 t + \tfrac{1}{2} g t^2, \quad \sigma = 0",
        ),
    )


def flight(
    dimension: int,
    law: type[LinearElastic] = NeoHookean,
    *,
    moving: bool = True,
    gravity: float = 0.0,
    joined: bool = False,
    beside: tuple[float, ...] = BESIDE,
) -> VerificationProblem:
    """Free blocks whose particles pass cell edges exactly, just beside them, and anywhere, each block with its own velocity.

    Parameters
    ----------
    dimension : {1, 2, 3}
    law : type
        Material of the blocks.
    moving : bool
        Whether the blocks begin with the velocities `DIRECTIONS` in turn, or at rest.
    gravity : float
        Acceleration down the last axis [m/s^2].
    joined : bool
        Whether the ends of the box are joined; then blocks begin at the ends, and move across them.
    beside : tuple of float
        Initial displacement of each block along every axis [m].

    References
    ----------
    Irons B. M., Razzaque A. (1972), doi:10.1016/B978-0-12-068650-6.50026-2.
    """
    count = len(beside)
    velocities = [DIRECTIONS[k % len(DIRECTIONS)][:dimension] if moving else (0.0,) * dimension for k in range(count)]
    motion = Flight(law(SPEED**2, 1.0), tuple(velocities), beside, gravity)
    last, middle = PITCH - WIDTH, (PITCH - WIDTH) // 2
    starts = [
        (
            PITCH * k + (last if joined else middle),
            *(last if joined and v > 0 else 0 if joined else middle for v in velocity[1:]),
        )
        for k, velocity in enumerate(velocities)
    ]
    condition: BoundaryCondition = Periodic() if joined else Traction()
    boundary = {axis + side: condition for axis in "xyz"[:dimension] for side in "-+"}
    kind = "fall-clear" if gravity and beside != BESIDE else "fall" if gravity else "translation" if moving else "rest"
    exposes = "A rigid motion that strains a body: nodes of little mass, transfers, joined ends."
    return _flight(f"{kind}{'-joined' if joined else ''}-{law.__name__}", motion, starts, boundary, exposes)


def parting(dimension: int) -> VerificationProblem:
    """Blocks that move along or away from the faces that they touch, as fast as the faces do.

    The first follows a face of prescribed velocity, the last leaves a free one; in more dimensions, the second leaves a free face
    across, and the third slides along a roller.

    Parameters
    ----------
    dimension : {1, 2, 3}

    References
    ----------
    Irons B. M., Razzaque A. (1972), doi:10.1016/B978-0-12-068650-6.50026-2.
    """
    last, middle = PITCH - WIDTH, (PITCH - WIDTH) // 2
    starts = (
        (0, middle, middle),
        (PITCH + middle, 0, 0),
        (2 * PITCH + middle, last, last),
        (4 * PITCH - WIDTH, middle, middle),
    )
    velocities = ((1.0, 0.0, 0.0), (0.5, 0.5, 0.25), (-1.0, 0.0, 0.0), (-0.5, 0.5, -0.25))
    motion = Flight(NeoHookean(SPEED**2, 1.0), tuple(v[:dimension] for v in velocities), (0.0,) * len(starts))
    boundary: dict[str, BoundaryCondition] = {"x-": Velocity(Constant(1.0)), "x+": Traction()}
    for axis in "yz"[: dimension - 1]:
        boundary |= {f"{axis}-": Traction(), f"{axis}+": Velocity()}
    exposes = "Faces that hold, push or pull what moves along them or away from them."
    return _flight("parting", motion, [start[:dimension] for start in starts], boundary, exposes)


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
    side = 2 * SHEARED * CELL
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


SHEARED = 14
"""Half the width of the sheared block in cells."""


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
