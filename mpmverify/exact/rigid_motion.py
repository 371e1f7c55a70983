"""Blocks that translate and fall: motions that a scheme must reproduce wherever the particles lie."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

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
ON_EDGES = tuple(CELL / 4 + beside for beside in (0.0, 1e-15, -1e-15, 4e-15, -4e-15, 0.0, 1e-15, -1e-15))
"""The same for particles that begin on cell edges, or so close to them that the internal force there is dropped [m]."""
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


def _row(starts: Sequence[Sequence[int]]) -> Bodies:
    """Blocks that begin at given cells (dim,)."""
    corners = [tuple(CELL * cell for cell in start) for start in starts]
    return Bodies(tuple(Block(corner, tuple(x + WIDTH * CELL for x in corner)) for corner in corners))


def _flight(
    name: str,
    motion: Flight,
    starts: Sequence[Sequence[int]],
    boundary: Mapping[str, BoundaryCondition],
    exposes: str,
    steps: int = STEPS,
) -> VerificationProblem:
    dimension = len(starts[0])
    return VerificationProblem(
        problem=Problem(
            name=f"{name}-{dimension}d",
            lower=(0.0,) * dimension,
            upper=(len(starts) * PITCH * CELL, *[PITCH * CELL] * (dimension - 1)),
            material=motion.material,
            boundary=boundary,
            end_time=steps * 0.5 * CELL / motion.material.wave_speed,
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
    steps: int = STEPS,
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
    steps : int
        Time steps at a Courant number of 1/2 and the cell size `CELL`.

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
    kind = "fall" if gravity else "translation" if moving else "rest"
    kind += {BESIDE: "", CLEAR: "-clear", ON_EDGES: "-on-edges"}[beside]
    exposes = "A rigid motion that strains a body: nodes of little mass, transfers, joined ends."
    return _flight(f"{kind}{'-joined' if joined else ''}-{law.__name__}", motion, starts, boundary, exposes, steps)


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
