"""Free disk that turns about its centre in a central field, which holds every material point on its circle without stress."""

from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.motion import AtStart
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Disk, NeoHookean, Problem, Spatial, Traction

CITATION = "Rigid rotation under the centripetal acceleration, own derivation."


@dataclass(frozen=True)
class Rotation:
    """One field of the rotation by Omega t about the origin: (P, 2) [m], (T,) [s] -> (T, P, components).

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
            return np.zeros((len(t), len(X), 3))
        angle, quarter = self.spin * t[:, None, None], np.stack([-X[:, 1], X[:, 0]], axis=1)
        if self.quantity == "displacement":
            return np.sin(angle) * quarter - 2 * np.sin(angle / 2) ** 2 * X
        return self.spin * (np.cos(angle) * quarter - np.sin(angle) * X)


@dataclass(frozen=True)
class CentralField:
    """Acceleration b = -Omega^2 x (T, P, 2) [m/s^2] at positions x (P, 2) [m]; spin Omega [rad/s]."""

    spin: float

    def __call__(self, x: Array, t: Array) -> Array:
        return np.tile(-(self.spin**2) * x, (len(t), 1, 1))


def spinning_disk(
    *,
    spin: float = 0.3,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    poissons_ratio: float = 0.3,
    radians: float = 0.6,
    outputs: int = 16,
) -> VerificationProblem:
    """Neo-Hookean disk of radius 0.5 m with traction-free surface that turns about the origin.

    Parameters
    ----------
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
        If the spin is zero, or the angle not positive.

    Notes
    -----
    The field has no torque about the origin at any place of the material points, so that the angular momentum of a scheme that
    conserves it is constant to round-off whatever its other errors are.
    """
    if not spin:
        raise UsageError("the disk must turn: give a spin that is not zero")
    free = {face: Traction() for face in ("x-", "x+", "y-", "y+")}
    fields = {quantity: Rotation(quantity, spin) for quantity in ("displacement", "velocity", "stress")}
    return VerificationProblem(
        problem=Problem(
            name=f"spinning-disk-{radians:g}",
            lower=(-0.75, -0.75),
            upper=(0.75, 0.75),
            material=NeoHookean(youngs_modulus, density, poissons_ratio),
            boundary=free,
            end_time=radians / abs(spin),
            initial={"velocity": AtStart(fields["velocity"])},
            body_force=Spatial(CentralField(spin)),
            outputs=outputs,
            shape=Disk((0.0, 0.0), 0.5),
        ),
        exact=ExactSolution(fields=fields, citation=CITATION),
        exposes="Angular momentum that transfers do not conserve, and stress from rotation.",
        equations=(
            r"\rho\, \partial_{tt} u = \mathrm{Div}\, P + \rho b, \quad b = -\Omega^2 x, \quad P N = 0 \text{ at } |X| = 0.5",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = \Omega\, e_z \times X",
            r"x = R(\Omega t)\, X, \quad \sigma = 0",
            r"\int x \times \rho v\, dV = \frac{\pi}{2} \rho\, \Omega\, (0.5\,\mathrm{m})^4",
        ),
    )
