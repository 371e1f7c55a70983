"""Manufactured radial motion of a neo-Hookean ring with free surfaces."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.axis_aligned import CITATION
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import FieldOf, Motion, fields_of, initial_velocity
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Constant, NeoHookean, Problem, Ring, Traction

INNER, OUTER = 0.4, 0.6
"""Radii of the ring [m]."""
_SCALE = OUTER * (OUTER - 3 * INNER)
C1, C2, C3 = -6 * INNER / _SCALE, 3 * (INNER + OUTER) / (OUTER * _SCALE), -2 / (OUTER * _SCALE)
"""Coefficients of U(R) = C3 R^3 + C2 R^2 + C1 R, with U' = 0 at both radii and U = 1 at the outer one."""
MAX_AMPLITUDE = INNER / (C3 * INNER**3 + C2 * INNER**2 + C1 * INNER)
"""Amplitude at which the hoop stretch of the inner surface reaches zero [m]; all other stretches stay positive up to it."""


@dataclass(frozen=True)
class RadialMotion:
    """The motion u_R = q U(R) with q = A sin(c pi t) around the origin of the plane, a `Motion`.

    Parameters
    ----------
    amplitude : float
        A [m].
    material : NeoHookean
        Material with nu = 0; c = sqrt(E/rho).
    """

    amplitude: float
    material: NeoHookean

    @property
    def frequency(self) -> float:
        """Angular frequency c pi [rad/s]."""
        return math.pi * math.sqrt(self.material.youngs_modulus / self.material.density)

    def time_factor(self, t: Array) -> Array:
        """Return q = A sin(c pi t) (T, 1, 1) [m]."""
        return self.amplitude * np.sin(self.frequency * t[:, None, None])

    def displacement(self, X: Array, t: Array) -> Array:
        R, _ = radial(X)
        return self.time_factor(t) * (C3 * R**2 + C2 * R + C1) * X

    def velocity(self, X: Array, t: Array) -> Array:
        R, _ = radial(X)
        rate = self.amplitude * self.frequency * np.cos(self.frequency * t[:, None, None])
        return rate * (C3 * R**2 + C2 * R + C1) * X

    def gradient(self, X: Array, t: Array) -> Array:
        """Return H = q [U/R I + (U' - U/R) e_R (x) e_R] (T, P, 2, 2) [1]."""
        R, e = radial(X)
        hoop = (C3 * R**2 + C2 * R + C1)[..., None] * np.eye(2)
        rest = (2 * C3 * R**2 + C2 * R)[..., None] * (e[:, :, None] * e[:, None, :])
        return self.time_factor(t)[..., None] * (hoop + rest)

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force (T, P, 2) [m/s^2].

        b_R = -(c pi)^2 q U - (mu/rho) [q U'' (1 + 1/f^2) + ((f - 1/f) - (g - 1/g))/R] with the stretches f = 1 + q U' and
        g = 1 + q U/R. The last term is evaluated as q (2 C3 R + C2) (1 + 1/(f g)), which is finite at a grid node at the origin.
        """
        R, e = radial(X)
        q, law = self.time_factor(t), self.material
        hoop, slope, curvature = C3 * R**2 + C2 * R + C1, 3 * C3 * R**2 + 2 * C2 * R + C1, 6 * C3 * R + 2 * C2
        f, g = 1 + q * slope, 1 + q * hoop
        divergence = curvature * (1 + 1 / f**2) + (2 * C3 * R + C2) * (1 + 1 / (f * g))
        return -q * (self.frequency**2 * hoop * R + law.shear_modulus / law.density * divergence) * e


def radial(X: Array) -> tuple[Array, Array]:
    """Return the radius (P, 1) [m] and the radial unit vector (P, 2) of points (P, 2) [m]; the vector is zero at the origin."""
    R = np.hypot(X[:, :1], X[:, 1:])
    return R, X / np.where(R > 0, R, 1.0)


def free_ring(name: str, motion: Motion, ring: Ring, half: float, *, end_time: float, outputs: int) -> Problem:
    """Return the problem of an initially undeformed, traction-free ring in the box [-half, half] x [-half, half] [m]."""
    free = Traction(Constant(0.0))
    return Problem(
        name=name,
        lower=(-half, -half),
        upper=(half, half),
        material=motion.material,
        boundary={"x-": free, "x+": free, "y-": free, "y+": free},
        end_time=end_time,
        initial=initial_velocity(motion),
        body_force=FieldOf(motion, "force"),
        outputs=outputs,
        shape=ring,
    )


def expanding_ring(
    amplitude: float = 0.1,
    *,
    youngs_modulus: float = 1e7,
    density: float = 1000.0,
    end_time: float = 0.02,
    outputs: int = 128,
) -> VerificationProblem:
    """Neo-Hookean ring in plane strain that expands and contracts with traction-free surfaces.

    Parameters
    ----------
    amplitude : float
        Largest displacement A of the outer surface [m].
    youngs_modulus, density : float
        E [Pa], rho [kg/m^3]; Poisson's ratio is 0.
    end_time : float
        Final time [s]. After the default, one period, the displacement is zero: judge the maximum over time.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If A is zero, or |A| >= 0.386 m, where a stretch would not stay positive.

    Notes
    -----
    U' and hence the traction mu (f - 1/f) vanish at both radii. The box is [-1, 1] x [-1, 1] m.

    References
    ----------
    Wallstedt P. C., Guilkey J. E. (2008). An evaluation of explicit time integration schemes for use with the generalized
    interpolation material point method. Journal of Computational Physics 227(22), 9628-9642,
    https://doi.org/10.1016/j.jcp.2008.07.019
    """
    if not 0 < abs(amplitude) < MAX_AMPLITUDE:
        limit = f"{MAX_AMPLITUDE:.3g} m"
        raise UsageError(f"the amplitude of the expanding ring must be below {limit} and not zero, not {amplitude!r}")
    motion = RadialMotion(amplitude, NeoHookean(youngs_modulus, density))
    return VerificationProblem(
        problem=free_ring(
            f"expanding-ring-{amplitude:g}", motion, Ring((0.0, 0.0), INNER, OUTER), 1.0, end_time=end_time, outputs=outputs
        ),
        exact=ExactSolution(fields=fields_of(motion), citation=CITATION),
        exposes="Errors at free surfaces across the cells of the grid, and gaps that open between particles.",
        equations=(
            r"\rho\, \partial_{tt} u_R = \partial_R P_R + \frac{P_R - P_\theta}{R} + \rho b_R",
            r"P_R = \mu (f - 1/f), \quad P_\theta = \mu (g - 1/g), \quad f = 1 + q\, U', \quad g = 1 + q\, U/R",
            rf"u(R,0) = 0, \quad \partial_t u_R(R,0) = \pi c A\, U, \quad P_R = 0 \text{{ at }} R = r_i, r_o = {INNER}, {OUTER}",
            r"b_R = -(\pi c)^2 q\, U - \frac{\mu}{\rho} \left[q\, U'' \left(1 + \frac{1}{f^2}\right) + \frac{(f - 1/f) - (g - 1/g)}{R}\right]",
            r"u_R = q\, U, \quad q = A \sin(\pi c t), \quad U = c_3 R^3 + c_2 R^2 + c_1 R, \quad c = \sqrt{E/\rho}",
            r"c_1 = \frac{-6 r_i}{r_o d}, \quad c_2 = \frac{3 (r_i + r_o)}{r_o^2 d}, \quad c_3 = \frac{-2}{r_o^2 d}, \quad d = r_o - 3 r_i",
        ),
    )
