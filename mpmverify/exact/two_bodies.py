"""Two free blocks that pass each other at constant velocities and through joined ends."""

from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.motion import AtStart
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Block, Bodies, NeoHookean, Periodic, Problem, Traction
from mpmverify.problem.quantities import SYMMETRIC


@dataclass(frozen=True)
class TranslationOfBodies:
    """One field of bodies that translate: (P, dim) [m], (T,) [s] -> (T, P, components).

    Parameters
    ----------
    quantity : {"displacement", "velocity", "stress"}
        The stress is zero.
    bodies : tuple of Block
    velocities : tuple of tuple of float
        Velocity of each body [m/s].
    """

    quantity: str
    bodies: tuple[Block, ...]
    velocities: tuple[tuple[float, ...], ...]

    def __call__(self, X: Array, t: Array) -> Array:
        if self.quantity == "stress":
            return np.zeros((len(t), len(X), len(SYMMETRIC[X.shape[1]])))
        of = np.argmax([body.contains(X) for body in self.bodies], axis=0)
        factor = t if self.quantity == "displacement" else np.ones_like(t)
        return factor[:, None, None] * np.asarray(self.velocities)[of]


@dataclass(frozen=True)
class MomentumOfBodies:
    """Momentum, or angular momentum about the origin, of bodies that translate; constant: times (T,) [s] -> (T, components).

    Parameters
    ----------
    bodies : tuple of Block
    velocities : tuple of tuple of float
        Velocity of each body [m/s].
    density : float
        [kg/m^3].
    angular : bool
    """

    bodies: tuple[Block, ...]
    velocities: tuple[tuple[float, ...], ...]
    density: float
    angular: bool

    def __call__(self, t: Array) -> Array:
        momentum = self.density * np.array([body.measure for body in self.bodies])[:, None] * np.asarray(self.velocities)
        if not self.angular:
            return np.tile(momentum.sum(axis=0), (len(t), 1))
        centre = np.array([np.add(body.lower, body.upper) / 2 for body in self.bodies])
        X, p = (np.pad(vectors, [(0, 0), (0, 3 - centre.shape[1])]) for vectors in (centre, momentum))
        turning = np.cross(X, p).sum(axis=0)
        return np.tile(turning if centre.shape[1] == 3 else turning[2:], (len(t), 1))


def two_bodies(
    dimension: int = 2,
    *,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    poissons_ratio: float = 0.3,
    outputs: int = 16,
) -> VerificationProblem:
    """Two neo-Hookean blocks that never come nearer than half a metre and pass the joined ends across x, and in space across z.

    Parameters
    ----------
    dimension : {2, 3}
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1].
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3.
    """
    if dimension not in (2, 3):
        raise UsageError(f"the two bodies have 2 or 3 dimensions, not {dimension!r}")
    corners = ((1.25, 0.25, 0.5), (1.75, 0.75, 1.0)), ((0.25, 1.25, 0.25), (1.0, 1.75, 0.75))
    bodies = tuple(Block(lower[:dimension], upper[:dimension]) for lower, upper in corners)
    velocities = (0.9, -0.15, -0.7)[:dimension], (-1.3, 0.2, 0.4)[:dimension]
    fields = {
        quantity: TranslationOfBodies(quantity, bodies, velocities) for quantity in ("displacement", "velocity", "stress")
    }
    free = {axis + side: Traction() if axis == "y" else Periodic() for axis in "xyz"[:dimension] for side in "-+"}
    return VerificationProblem(
        problem=Problem(
            name=f"two-bodies-{dimension}d",
            lower=(0.0,) * dimension,
            upper=(2.0,) * dimension,
            material=NeoHookean(youngs_modulus, density, poissons_ratio),
            boundary=free,
            end_time=1.0,
            initial={"velocity": AtStart(fields["velocity"])},
            outputs=outputs,
            shape=Bodies(bodies),
        ),
        exact=ExactSolution(
            fields=fields,
            citation="Free bodies move at constant velocity: Newton's first law.",
            totals={
                "momentum": MomentumOfBodies(bodies, velocities, density, angular=False),
                "angular_momentum": MomentumOfBodies(bodies, velocities, density, angular=True),
            },
        ),
        exposes="Bodies that affect each other from afar, and errors of translation across cells and joined ends.",
        equations=(
            r"\rho\, \partial_{tt} u = \mathrm{Div}\, P, \quad P N = 0 \text{ on the surface of each body } b",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = V_b, \quad \text{ends joined across } x \text{ and } z",
            r"u = V_b\, t, \quad \sigma = 0",
            r"\int \rho v\, dV = \sum_b m_b V_b, \quad \int x \times \rho v\, dV = \sum_b m_b\, \bar{X}_b \times V_b",
        ),
    )
