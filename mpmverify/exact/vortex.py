"""Generalised vortex: each circle of a neo-Hookean ring rotates by an angle that depends on its radius."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import fields_of
from mpmverify.exact.ring import free_ring, radial
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, NeoHookean, Ring

CITATION = (
    "Brannon R., Kamojjala K., Sadeghirad A. (2011). Establishing credibility of particle methods through verification testing. "
    "Particles 2011; Kamojjala K., Brannon R., Sadeghirad A., Guilkey J. (2015). Verification tests in solid mechanics. "
    "Engineering with Computers 31, 193-213, doi:10.1007/s00366-013-0342-x"
)
INNER, OUTER = 0.75, 1.25
"""Radii of the ring [m]."""


@dataclass(frozen=True)
class VortexMotion:
    """The rotation by alpha = A sin(pi t) h(R), h = 1 - 32 (R-1)^2 + 256 (R-1)^4, about the origin of the plane, a `Motion`.

    Parameters
    ----------
    amplitude : float
        Largest angle A [rad].
    material : NeoHookean
        Material.
    """

    amplitude: float
    material: NeoHookean

    def angle(self, R: Array, t: Array) -> Array:
        """Return the angle alpha (T, P, 1) [rad]."""
        return self.amplitude * np.sin(np.pi * t[:, None, None]) * (1 - 32 * (R - 1) ** 2 + 256 * (R - 1) ** 4)

    def angular_velocity(self, R: Array, t: Array) -> Array:
        """Return alpha_t (T, P, 1) [rad/s]."""
        return self.amplitude * np.pi * np.cos(np.pi * t[:, None, None]) * (1 - 32 * (R - 1) ** 2 + 256 * (R - 1) ** 4)

    def twist(self, R: Array, t: Array) -> Array:
        """Return alpha_R (T, P, 1) [rad/m]."""
        return self.amplitude * np.sin(np.pi * t[:, None, None]) * (-64 * (R - 1) + 1024 * (R - 1) ** 3)

    def twist_gradient(self, R: Array, t: Array) -> Array:
        """Return alpha_RR (T, P, 1) [rad/m^2]."""
        return self.amplitude * np.sin(np.pi * t[:, None, None]) * (-64 + 3072 * (R - 1) ** 2)

    def displacement(self, X: Array, t: Array) -> Array:
        angle = self.angle(radial(X)[0], t)
        return np.sin(angle) * quarter_turn(X) - 2 * np.sin(angle / 2) ** 2 * X

    def velocity(self, X: Array, t: Array) -> Array:
        return self.angular_velocity(radial(X)[0], t) * quarter_turn(X + self.displacement(X, t))

    def gradient(self, X: Array, t: Array) -> Array:
        """Return H = Q - I + alpha_R (k x Q X) e_R (T, P, 2, 2) [1], with Q the rotation by alpha and k normal to the plane."""
        R, e = radial(X)
        angle = self.angle(R, t)[..., None]
        rotation = np.sin(angle) * np.array([[0.0, -1.0], [1.0, 0.0]]) - 2 * np.sin(angle / 2) ** 2 * np.eye(2)
        shear = self.twist(R, t) * quarter_turn(X + self.displacement(X, t))
        return rotation + shear[..., :, None] * e[:, None, :]

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force (T, P, 2) [m/s^2].

        b_r = -R alpha_t^2 + (mu/rho) R alpha_R^2 and b_theta = R alpha_tt - (mu/rho) (3 alpha_R + R alpha_RR), in the radial and
        the circumferential direction at the current position.
        """
        R, e = radial(X)
        angle, twist, diffusivity = self.angle(R, t), self.twist(R, t), self.material.shear_modulus / self.material.density
        b_r = R * (diffusivity * twist**2 - self.angular_velocity(R, t) ** 2)
        b_theta = -(np.pi**2) * R * angle - diffusivity * (3 * twist + R * self.twist_gradient(R, t))
        e_r = np.cos(angle) * e + np.sin(angle) * quarter_turn(e)
        return b_r * e_r + b_theta * quarter_turn(e_r)


def quarter_turn(vector: Array) -> Array:
    """Rotate vectors v (..., 2) by 90 degrees: k x v."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def generalised_vortex(
    amplitude: float = 1.0,
    *,
    youngs_modulus: float = 1000.0,
    density: float = 1000.0,
    poissons_ratio: float = 0.3,
    end_time: float = 1.0,
    outputs: int = 128,
) -> VerificationProblem:
    """Neo-Hookean ring in plane strain, sheared by rotation at constant volume, with traction-free surfaces.

    Parameters
    ----------
    amplitude : float
        Largest angle A [rad].
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1]; the defaults are those of the literature, mu = 384.615 Pa and lambda = 576.923 Pa.
    end_time : float
        Final time [s]. After the default, half a period, the displacement is zero: judge the maximum over time.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If A is zero or not finite. There is no upper limit, since J = 1 for every A.

    Notes
    -----
    In polar components at the current position sigma_rr = 0, sigma_rtheta = mu R alpha_R and sigma_thetatheta = mu (R alpha_R)^2.
    alpha and alpha_R vanish at both surfaces, which therefore are traction-free and do not move. The box is [-1.5, 1.5] x [-1.5, 1.5] m.

    References
    ----------
    Brannon R., Kamojjala K., Sadeghirad A. (2011). Establishing credibility of particle methods through verification testing.
    Particles 2011, II International Conference on Particle-Based Methods.
    Kamojjala K., Brannon R., Sadeghirad A., Guilkey J. (2015). Verification tests in solid mechanics. Engineering with Computers
    31, 193-213, https://doi.org/10.1007/s00366-013-0342-x
    """
    if not (math.isfinite(amplitude) and amplitude):
        raise UsageError(f"the amplitude of the vortex must be finite and not zero, not {amplitude!r}")
    motion = VortexMotion(amplitude, NeoHookean(youngs_modulus, density, poissons_ratio))
    return VerificationProblem(
        problem=free_ring(
            f"generalised-vortex-{amplitude:g}", motion, Ring((0.0, 0.0), INNER, OUTER), 1.5, end_time=end_time, outputs=outputs
        ),
        exact=ExactSolution(fields=fields_of(motion), citation=CITATION),
        exposes="Errors of shear and of large rotation, and a stress that is not objective.",
        equations=(
            r"\rho\, \dot{v} = \mathrm{div}\, \sigma + \rho b, \quad \sigma = \mu (F F^T - I), \quad J = 1",
            r"\sigma_{rr} = 0, \quad \sigma_{r\theta} = \mu R\, \alpha_R, \quad \sigma_{\theta\theta} = \mu (R\, \alpha_R)^2",
            rf"u(X,0) = 0, \quad v_\theta(R,0) = \pi A R\, h, \quad \sigma_{{rr}} = \sigma_{{r\theta}} = 0 \text{{ at }} R = {INNER}, {OUTER}",
            r"b_r = -R\, \alpha_t^2 + \frac{\mu}{\rho} R\, \alpha_R^2",
            r"b_\theta = R\, \alpha_{tt} - \frac{\mu}{\rho} (3 \alpha_R + R\, \alpha_{RR})",
            r"\alpha = A \sin(\pi t)\, h(R), \quad h = 1 - 32 (R-1)^2 + 256 (R-1)^4, \quad r = R, \quad \theta = \theta_0 + \alpha",
        ),
    )
