"""Free disk or cube that turns about its centre in a central field, which holds every material point on its circle without stress."""

from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.motion import AtStart
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Block, Disk, NeoHookean, Problem, Spatial, Traction
from mpmverify.problem.quantities import SYMMETRIC

CITATION = "Rigid rotation under the centripetal acceleration, own derivation."


@dataclass(frozen=True)
class Rotation:
    """One field of the rotation by Omega t about the axis z through the origin: (P, dim) [m], (T,) [s] -> (T, P, components).

    Parameters
    ----------
    quantity : {"displacement", "velocity", "stress"}
        The stress is zero.
    spin : float
        Omega [rad/s].
    """

    quantity: str
    spin: float

    def __call__(self, X: Array, t: Array) -> Array:
        if self.quantity == "stress":
            return np.zeros((len(t), len(X), len(SYMMETRIC[X.shape[1]])))
        X = in_plane(X)
        angle, quarter = self.spin * t[:, None, None], np.zeros_like(X)
        quarter[:, 0], quarter[:, 1] = -X[:, 1], X[:, 0]
        if self.quantity == "displacement":
            return np.sin(angle) * quarter - 2 * np.sin(angle / 2) ** 2 * X
        return self.spin * (np.cos(angle) * quarter - np.sin(angle) * X)


def in_plane(x: Array) -> Array:
    """Return places (P, dim) [m] without what lies along the axis."""
    return x * (np.arange(x.shape[1]) < 2)


@dataclass(frozen=True)
class CentralField:
    """Acceleration b = -Omega^2 x across the axis (T, P, dim) [m/s^2] at positions x (P, dim) [m]; spin Omega [rad/s]."""

    spin: float

    def __call__(self, x: Array, t: Array) -> Array:
        return np.tile(-(self.spin**2) * in_plane(x), (len(t), 1, 1))


def spinning_body(
    dimension: int = 2,
    *,
    spin: float = 0.3,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    poissons_ratio: float = 0.3,
    radians: float = 0.6,
    outputs: int = 16,
) -> VerificationProblem:
    """Neo-Hookean disk of radius 0.5 m, or cube of side 0.75 m, with traction-free surface that turns about the axis z.

    Parameters
    ----------
    dimension : {2, 3}
        Disk or cube.
    spin : float
        Omega [rad/s].
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1].
    radians : float
        Angle at the final time [rad].
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3, the spin is zero, or the angle not positive.

    Notes
    -----
    The field has no torque about the origin at any place of the material points, so that the angular momentum of a scheme that
    conserves it is constant to round-off whatever its other errors are.
    """
    if dimension not in (2, 3):
        raise UsageError(f"a spinning body has 2 or 3 dimensions, not {dimension!r}")
    if not spin:
        raise UsageError("the body must turn: give a spin that is not zero")
    free = {axis + side: Traction() for axis in "xyz"[:dimension] for side in "-+"}
    fields = {quantity: Rotation(quantity, spin) for quantity in ("displacement", "velocity", "stress")}
    return VerificationProblem(
        problem=Problem(
            name=f"spinning-{'disk' if dimension == 2 else 'cube'}-{radians:g}",
            lower=(-0.75,) * dimension,
            upper=(0.75,) * dimension,
            material=NeoHookean(youngs_modulus, density, poissons_ratio),
            boundary=free,
            end_time=radians / abs(spin),
            initial={"velocity": AtStart(fields["velocity"])},
            body_force=Spatial(CentralField(spin)),
            outputs=outputs,
            shape=Disk((0.0, 0.0), 0.5) if dimension == 2 else Block((-0.375,) * 3, (0.375,) * 3),
        ),
        exact=ExactSolution(fields=fields, citation=CITATION),
        exposes="Angular momentum that transfers do not conserve, and stress from rotation.",
        equations=(
            r"\rho\, \partial_{tt} u = \mathrm{Div}\, P + \rho b, \quad b = -\Omega^2 (x_1, x_2), \quad P N = 0 \text{ on the surface}",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = \Omega\, e_z \times X",
            r"x = R(\Omega t)\, X, \quad \sigma = 0",
            r"\int x \times \rho v\, dV = \Omega\, e_z \int \rho\, (X_1^2 + X_2^2)\, dV",
        ),
    )
