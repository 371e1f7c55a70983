"""Manufactured standing wave of finite amplitude in a neo-Hookean bar that starts deformed and at rest."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import FieldOf, fields_of, initial_deformation
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Constant, NeoHookean, Problem, Velocity

CITATION = (
    "Steffen M., Kirby R. M., Berzins M. (2008). Analysis and reduction of quadrature errors in the material point method (MPM). "
    "International Journal for Numerical Methods in Engineering 76(6), 922-948, doi:10.1002/nme.2360"
)


@dataclass(frozen=True)
class FullWave:
    """The motion u = A sin(2 pi X) cos(c pi t) on [0, 1], a `Motion`.

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

    def displacement(self, X: Array, t: Array) -> Array:
        return self.amplitude * np.sin(2 * np.pi * X[None]) * np.cos(self.frequency * t[:, None, None])

    def velocity(self, X: Array, t: Array) -> Array:
        rate = -self.amplitude * self.frequency * np.sin(self.frequency * t[:, None, None])
        return rate * np.sin(2 * np.pi * X[None])

    def gradient(self, X: Array, t: Array) -> Array:
        """Return H = 2 pi A cos(2 pi X) cos(c pi t) (T, P, 1, 1) [1]."""
        slope = 2 * np.pi * self.amplitude * np.cos(2 * np.pi * X[None]) * np.cos(self.frequency * t[:, None, None])
        return slope[..., None]

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force b = c^2 pi^2 u (1 + 2/F^2) (T, P, 1) [m/s^2]."""
        F = 1 + self.gradient(X, t)[..., 0]
        return self.frequency**2 * self.displacement(X, t) * (1 + 2 / F**2)


def steffen(
    amplitude: float = 0.05,
    *,
    youngs_modulus: float = 1e4,
    density: float = 1.0,
    periods: float = 1.1,
    outputs: int = 32,
) -> VerificationProblem:
    """Neo-Hookean bar on [0, 1] with fixed ends, released from a full sine wave of finite amplitude.

    Parameters
    ----------
    amplitude : float
        A [m].
    youngs_modulus, density : float
        E [Pa], rho [kg/m^3].
    periods : float
        Final time in periods 2/c. At 1.1 periods neither displacement nor velocity is near zero.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If A is zero, or 2 pi |A| >= 1, where F would not stay positive.

    References
    ----------
    Steffen M., Kirby R. M., Berzins M. (2008). Analysis and reduction of quadrature errors in the material point method (MPM).
    International Journal for Numerical Methods in Engineering 76(6), 922-948, https://doi.org/10.1002/nme.2360
    """
    if not 0 < 2 * math.pi * abs(amplitude) < 1:
        raise UsageError(f"the amplitude of the full wave must be below 1/(2 pi) and not zero, not {amplitude!r}")
    motion = FullWave(amplitude, NeoHookean(youngs_modulus, density))
    fixed = Velocity(Constant(0.0))
    return VerificationProblem(
        problem=Problem(
            name=f"steffen-{amplitude:g}",
            lower=(0.0,),
            upper=(1.0,),
            material=motion.material,
            boundary={"x-": fixed, "x+": fixed},
            end_time=periods * 2 * math.pi / motion.frequency,
            initial=initial_deformation(motion),
            body_force=FieldOf(motion, "force"),
            outputs=outputs,
        ),
        exact=ExactSolution(fields=fields_of(motion), citation=CITATION),
        exposes="Quadrature and cell-crossing errors of the basis, with regions in compression and in tension at once.",
        equations=(
            r"\rho\, \partial_{tt} u = \partial_X P + \rho b, \quad P = \frac{E}{2} \left(F-\frac{1}{F}\right), \quad F = 1+\partial_X u",
            r"u(X,0) = A \sin(2\pi X), \quad \partial_t u(X,0) = 0, \quad u(0,t) = u(1,t) = 0",
            r"b = c^2 \pi^2 u \left(1 + \frac{2}{F^2}\right)",
            r"u = A \sin(2\pi X) \cos(\pi c t), \quad c = \sqrt{E/\rho}",
        ),
    )
