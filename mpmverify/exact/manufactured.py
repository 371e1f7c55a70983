"""Manufactured standing wave of finite amplitude in a neo-Hookean bar."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.exact.vibration import SineField
from mpmverify.problem import Array, Constant, NeoHookean, Problem, Velocity

CITATION = (
    "de Vaucorbeil A., Nguyen V. P., Hutchinson C. R. (2020). A Total-Lagrangian Material Point Method for solid mechanics "
    "problems involving large deformations. Computer Methods in Applied Mechanics and Engineering 360, 112783, "
    "doi:10.1016/j.cma.2019.112783"
)


@dataclass(frozen=True)
class Motion:
    """The motion on [0, 1]; its fields, the subclasses, map (P, 1) [m], (T,) [s] -> (T, P, 1).

    Parameters
    ----------
    amplitude : float
        G [m].
    material : NeoHookean
        Material; c = sqrt(E/rho) for any Poisson's ratio.
    """

    amplitude: float
    material: NeoHookean

    @property
    def speed(self) -> float:
        """Speed c = sqrt(E/rho) [m/s]."""
        return math.sqrt(self.material.youngs_modulus / self.material.density)

    def displacement(self, X: Array, t: Array) -> Array:
        """Return the displacement u = G sin(pi X) sin(c pi t) [m]."""
        return self.amplitude * np.sin(np.pi * X[None]) * np.sin(self.speed * np.pi * t[:, None, None])

    def gradient(self, X: Array, t: Array) -> Array:
        """Return the deformation gradient F = 1 + pi G cos(pi X) sin(c pi t) [1]."""
        return 1 + np.pi * self.amplitude * np.cos(np.pi * X[None]) * np.sin(self.speed * np.pi * t[:, None, None])


@dataclass(frozen=True)
class ManufacturedDisplacement(Motion):
    """Displacement u = G sin(pi X) sin(c pi t) [m]."""

    def __call__(self, X: Array, t: Array) -> Array:
        return self.displacement(X, t)


@dataclass(frozen=True)
class ManufacturedVelocity(Motion):
    """Velocity v = G c pi sin(pi X) cos(c pi t) [m/s]."""

    def __call__(self, X: Array, t: Array) -> Array:
        omega = self.speed * np.pi
        return self.amplitude * omega * np.sin(np.pi * X[None]) * np.cos(omega * t[:, None, None])


@dataclass(frozen=True)
class ManufacturedStress(Motion):
    """Stress P = lambda ln(F)/F + mu (F - 1/F) [Pa]; in uniaxial strain the Cauchy stress equals it."""

    def __call__(self, X: Array, t: Array) -> Array:
        F = self.gradient(X, t)
        return self.material.lame_lambda * np.log(F) / F + self.material.shear_modulus * (F - 1 / F)


@dataclass(frozen=True)
class ManufacturedForce(Motion):
    """Body force b = (pi^2 u/rho) [lambda (1 - ln F)/F^2 + mu (1 + 1/F^2) - E] [m/s^2], from rho u_tt = P_X + rho b."""

    def __call__(self, X: Array, t: Array) -> Array:
        F, law = self.gradient(X, t), self.material
        stiffness = law.lame_lambda * (1 - np.log(F)) / F**2 + law.shear_modulus * (1 + 1 / F**2)
        return np.pi**2 * self.displacement(X, t) / law.density * (stiffness - law.youngs_modulus)


def manufactured(
    amplitude: float = 1e-4,
    *,
    youngs_modulus: float = 1e7,
    density: float = 1000.0,
    poissons_ratio: float = 0.0,
    end_time: float = 0.02,
    outputs: int = 128,
) -> VerificationProblem:
    """Neo-Hookean bar on [0, 1] with fixed ends, and the body force for which a standing wave is the exact solution.

    Parameters
    ----------
    amplitude : float
        G [m]. At 1e-4 no particle leaves its cell; at 0.05 particles cross cells.
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1].
    end_time : float
        Final time [s]. After the default, one period, the displacement is zero: judge the maximum over time.
    outputs : int
        Number of output intervals; the default gives the maximum over time of the error norm to four digits.

    Raises
    ------
    UsageError
        If G is zero, or pi |G| >= 1, where F would not stay positive.

    References
    ----------
    de Vaucorbeil A., Nguyen V. P., Hutchinson C. R. (2020). A Total-Lagrangian Material Point Method for solid mechanics
    problems involving large deformations. Computer Methods in Applied Mechanics and Engineering 360, 112783,
    https://doi.org/10.1016/j.cma.2019.112783
    """
    if not 0 < math.pi * abs(amplitude) < 1:
        raise UsageError(f"the amplitude of the manufactured motion must be below 1/pi and not zero, not {amplitude!r}")
    material = NeoHookean(youngs_modulus, density, poissons_ratio)
    motion = (amplitude, material)
    fixed = Velocity(Constant(0.0))
    return VerificationProblem(
        problem=Problem(
            name=f"manufactured-{amplitude:g}",
            lower=(0.0,),
            upper=(1.0,),
            material=material,
            boundary={"x-": fixed, "x+": fixed},
            end_time=end_time,
            initial={"velocity": SineField(amplitude * math.pi * Motion(*motion).speed, math.pi)},
            body_force=ManufacturedForce(*motion),
            outputs=outputs,
        ),
        exact=ExactSolution(
            fields={
                "displacement": ManufacturedDisplacement(*motion),
                "velocity": ManufacturedVelocity(*motion),
                "stress": ManufacturedStress(*motion),
            },
            citation=CITATION,
        ),
        exposes="Errors of large deformation: cell crossing, quadrature, the constitutive law and the body force.",
        equations=(
            r"\rho\, \partial_{tt} u = \partial_X P + \rho b",
            r"P = \lambda \frac{\ln F}{F} + \mu \left(F-\frac{1}{F}\right), \quad F = 1+\partial_X u",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = \pi c G \sin(\pi X), \quad u(0,t) = u(1,t) = 0",
            r"b = \frac{\pi^2 u}{\rho} \left[\lambda \frac{1-\ln F}{F^2} + \mu \left(1+\frac{1}{F^2}\right) - E\right]",
            r"u = G \sin(\pi X) \sin(\pi c t), \quad c = \sqrt{E/\rho}",
        ),
    )
