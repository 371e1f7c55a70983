"""Manufactured axis-aligned displacement of a neo-Hookean square or cube."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import FieldOf, fields_of, initial_deformation, initial_velocity
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Constant, NeoHookean, Problem, Velocity

CITATION = (
    "Wallstedt P. C., Guilkey J. E. (2008). An evaluation of explicit time integration schemes for use with the generalized "
    "interpolation material point method. Journal of Computational Physics 227(22), 9628-9642, doi:10.1016/j.jcp.2008.07.019"
)


@dataclass(frozen=True)
class AxisAligned:
    """The motion u_i = A sin(pi X_i) sin(c pi t + phi_i) of the unit box, a `Motion`.

    Parameters
    ----------
    amplitude : float
        A [m].
    material : NeoHookean
        Material; c = sqrt(E/rho) for any Poisson's ratio.
    dimension : int
        Number of axes; the phases are phi_i = 2 pi i/dimension, i = 0, 1, ...
    """

    amplitude: float
    material: NeoHookean
    dimension: int

    @property
    def frequency(self) -> float:
        """Angular frequency c pi [rad/s]."""
        return math.pi * math.sqrt(self.material.youngs_modulus / self.material.density)

    def phases(self, t: Array) -> Array:
        """Return the phases c pi t + phi_i (T, 1, dim) [rad]."""
        return self.frequency * t[:, None, None] + 2 * np.pi * np.arange(self.dimension) / self.dimension

    def displacement(self, X: Array, t: Array) -> Array:
        return self.amplitude * np.sin(np.pi * X[None]) * np.sin(self.phases(t))

    def velocity(self, X: Array, t: Array) -> Array:
        return self.amplitude * self.frequency * np.sin(np.pi * X[None]) * np.cos(self.phases(t))

    def elongation(self, X: Array, t: Array) -> Array:
        """Return the elongation F_ii - 1 = pi A cos(pi X_i) sin(c pi t + phi_i) along each axis (T, P, dim) [1]."""
        return np.pi * self.amplitude * np.cos(np.pi * X[None]) * np.sin(self.phases(t))

    def gradient(self, X: Array, t: Array) -> Array:
        return self.elongation(X, t)[..., None] * np.eye(self.dimension)

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force b_i = pi^2 u_i [mu/rho - c^2 - (lambda (ln J - 1) - mu)/(rho F_ii^2)] (T, P, dim) [m/s^2]."""
        law, stretch = self.material, 1 + self.elongation(X, t)
        mu, lame, rho = law.shear_modulus, law.lame_lambda, law.density
        log_J = np.log(math.prod(stretch[..., i] for i in range(self.dimension)))[..., None]
        stiffness = mu / rho - law.youngs_modulus / rho - (lame * (log_J - 1) - mu) / (rho * stretch**2)
        return np.pi**2 * self.displacement(X, t) * stiffness


def axis_aligned(
    dimension: int = 2,
    amplitude: float = 0.05,
    *,
    youngs_modulus: float = 1e4,
    density: float = 1.0,
    poissons_ratio: float = 0.3,
    periods: float = 1.1,
    outputs: int = 32,
) -> VerificationProblem:
    """Neo-Hookean unit square or cube between rollers, with a standing wave along each axis; the waves differ in phase.

    Parameters
    ----------
    dimension : {2, 3}
        Square or cube. The square starts undeformed, the cube deformed.
    amplitude : float
        A [m].
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1]; the defaults are those of the literature, mu = 3846.15 Pa and a bulk modulus of 8333.33 Pa.
    periods : float
        Final time in periods 2/c. At 1.1 periods neither displacement nor velocity is near zero.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3, A is zero, or pi |A| >= 1, where J would not stay positive.

    Notes
    -----
    Material lines along the axes stay aligned with them: F is diagonal, there is no shear, and rollers on all faces are exact.

    References
    ----------
    Wallstedt P. C., Guilkey J. E. (2008). An evaluation of explicit time integration schemes for use with the generalized
    interpolation material point method. Journal of Computational Physics 227(22), 9628-9642,
    https://doi.org/10.1016/j.jcp.2008.07.019
    """
    if dimension not in (2, 3):
        raise UsageError(
            f"axis-aligned displacement has 2 or 3 dimensions, not {dimension!r}: use the manufactured bar in one dimension"
        )
    if not 0 < math.pi * abs(amplitude) < 1:
        raise UsageError(f"the amplitude of axis-aligned displacement must be below 1/pi and not zero, not {amplitude!r}")
    motion = AxisAligned(amplitude, NeoHookean(youngs_modulus, density, poissons_ratio), dimension)
    roller = Velocity(Constant(0.0))
    phases = r"0, \pi" if dimension == 2 else r"0, \tfrac{2\pi}{3}, \tfrac{4\pi}{3}"
    return VerificationProblem(
        problem=Problem(
            name=f"axis-aligned-{dimension}d-{amplitude:g}",
            lower=(0.0,) * dimension,
            upper=(1.0,) * dimension,
            material=motion.material,
            boundary={axis + side: roller for axis in "xyz"[:dimension] for side in "-+"},
            end_time=periods * 2 * math.pi / motion.frequency,
            initial=initial_velocity(motion) | ({} if dimension == 2 else initial_deformation(motion)),
            body_force=FieldOf(motion, "force"),
            outputs=outputs,
        ),
        exact=ExactSolution(fields=fields_of(motion), citation=CITATION),
        exposes="Errors of large deformation in several dimensions without shear: cell crossing, quadrature, volume and body force.",
        equations=(
            r"\rho\, \partial_{tt} u = \mathrm{Div}\, P + \rho b",
            r"P = \lambda \ln(J) F^{-T} + \mu (F - F^{-T}), \quad F_{ii} = 1 + \pi A \cos(\pi X_i) \sin(\pi c t + \varphi_i)",
            r"u_i(X,0) = A \sin(\pi X_i) \sin\varphi_i, \quad \partial_t u_i(X,0) = \pi c A \sin(\pi X_i) \cos\varphi_i",
            r"u_i = 0, \quad \sigma_{ij} = 0 \quad (j \ne i) \quad \text{at } X_i = 0, 1",
            r"b_i = \pi^2 u_i \left[\frac{\mu}{\rho} - c^2 - \frac{\lambda (\ln J - 1) - \mu}{\rho F_{ii}^2}\right]",
            r"u_i = A \sin(\pi X_i) \sin(\pi c t + \varphi_i), \quad c = \sqrt{E/\rho}, \quad \varphi = " + phases,
        ),
    )
