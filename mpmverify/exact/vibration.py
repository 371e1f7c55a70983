"""Axial vibration of an elastic bar in one eigenmode."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, BoundaryCondition, Constant, LinearElastic, Periodic, Problem, Traction, Velocity

CITATION = (
    "Bardenhagen S. G. (2002). Energy conservation error in the material point method for solid mechanics. Journal of "
    "Computational Physics 180(1), 383-403, doi:10.1006/jcph.2002.7103; with both ends fixed: Tielen R., Wobbes E., Möller M., "
    "Beuth L. (2017). A high order material point method. Procedia Engineering 175, 265-272, doi:10.1016/j.proeng.2017.01.022"
)


@dataclass(frozen=True)
class SineField:
    """a sin(k X): (P, 1) [m] -> (P, 1)."""

    amplitude: float
    wavenumber: float

    def __call__(self, X: Array) -> Array:
        return self.amplitude * np.sin(self.wavenumber * X)


@dataclass(frozen=True)
class Mode:
    """One eigenmode; its fields, the subclasses, map (P, 1) [m], (T,) [s] -> (T, P, 1).

    Parameters
    ----------
    v0 : float
        Velocity amplitude [m/s].
    wavenumber : float
        beta [rad/m].
    wave_speed : float
        c [m/s].
    """

    v0: float
    wavenumber: float
    wave_speed: float

    def phases(self, X: Array, t: Array) -> tuple[Array, Array]:
        """Return beta x (1, P, 1) and beta c t (T, 1, 1) [rad]."""
        return self.wavenumber * X[None], self.wavenumber * self.wave_speed * t[:, None, None]


@dataclass(frozen=True)
class ModeDisplacement(Mode):
    """Displacement u = v0/(beta c) sin(beta c t) sin(beta x) [m]."""

    def __call__(self, X: Array, t: Array) -> Array:
        bx, bct = self.phases(X, t)
        return self.v0 / (self.wavenumber * self.wave_speed) * np.sin(bct) * np.sin(bx)


@dataclass(frozen=True)
class ModeVelocity(Mode):
    """Velocity v = v0 cos(beta c t) sin(beta x) [m/s]."""

    def __call__(self, X: Array, t: Array) -> Array:
        bx, bct = self.phases(X, t)
        return self.v0 * np.cos(bct) * np.sin(bx)


@dataclass(frozen=True)
class ModeStress(Mode):
    """Stress sigma = E v0/c sin(beta c t) cos(beta x) [Pa]; E in Pa."""

    youngs_modulus: float

    def __call__(self, X: Array, t: Array) -> Array:
        bx, bct = self.phases(X, t)
        return self.youngs_modulus * self.v0 / self.wave_speed * np.sin(bct) * np.cos(bx)


FIXED, FREE, PERIODIC = Velocity(Constant(0.0)), Traction(Constant(0.0)), Periodic()
END_CONDITIONS: Mapping[str, tuple[BoundaryCondition, BoundaryCondition, float, float, str, str]] = {
    "fixed-fixed": (FIXED, FIXED, 1, 0.0, r"u(0,t) = 0, \quad u(L,t) = 0", r"\frac{n\pi}{L}"),
    "fixed-free": (FIXED, FREE, 1, -0.5, r"u(0,t) = 0, \quad \sigma(L,t) = 0", r"\frac{(2n-1)\pi}{2L}"),
    "periodic": (PERIODIC, PERIODIC, 2, 0.0, r"u(0,t) = u(L,t), \quad \sigma(0,t) = \sigma(L,t)", r"\frac{2n\pi}{L}"),
}
"""By ends: conditions at x = 0 and L; a and b, where mode n has a n + b half waves; the conditions and beta as LaTeX."""


def axial_vibration(
    mode: int = 1,
    ends: Literal["fixed-fixed", "fixed-free", "periodic"] = "fixed-fixed",
    *,
    length: float = 25.0,
    youngs_modulus: float = 100.0,
    density: float = 1.0,
    v0: float = 0.1,
    periods: float = 1.1,
    outputs: int = 32,
    exposes: str = "Drift of the energy, phase error and damping over many steps.",
) -> VerificationProblem:
    """Undeformed bar, fixed at x = 0 or periodic, with the initial velocity of an eigenmode.

    The defaults are those of the literature, with a strain amplitude v0/c of 1 %. A code for large deformation needs a smaller v0
    to converge to this linear solution.

    Parameters
    ----------
    mode : int
        Number n of the mode: beta = n pi/L (fixed-fixed), (2n - 1) pi/(2L) (fixed-free) or 2n pi/L (periodic).
    ends : {"fixed-fixed", "fixed-free", "periodic"}
        Conditions at x = 0 and x = L.
    length, youngs_modulus, density, v0 : float
        L [m], E [Pa], rho [kg/m^3], velocity amplitude [m/s].
    periods : float
        Final time in periods 2 pi/(beta c). At 1.1 periods neither displacement nor velocity is near zero.
    outputs : int
        Number of output intervals.
    exposes : str
        The errors that the problem exposes, as one sentence.

    Raises
    ------
    UsageError
        If the mode is less than 1 or the ends are unknown.

    References
    ----------
    Bardenhagen S. G. (2002). Energy conservation error in the material point method for solid mechanics. Journal of
    Computational Physics 180(1), 383-403, https://doi.org/10.1006/jcph.2002.7103
    Tielen R., Wobbes E., Möller M., Beuth L. (2017). A high order material point method. Procedia Engineering 175, 265-272,
    https://doi.org/10.1016/j.proeng.2017.01.022
    """
    if mode < 1 or ends not in END_CONDITIONS:
        raise UsageError(f"axial vibration needs mode >= 1 and ends {', '.join(END_CONDITIONS)}, not {mode!r} and {ends!r}")
    near, far, factor, offset, conditions, latex = END_CONDITIONS[ends]
    material = LinearElastic(youngs_modulus, density)
    c, beta = material.wave_speed, (factor * mode + offset) * math.pi / length
    return VerificationProblem(
        problem=Problem(
            name=f"vibration-{ends}-{mode}",
            lower=(0.0,),
            upper=(length,),
            material=material,
            boundary={"x-": near, "x+": far},
            end_time=periods * 2 * math.pi / (beta * c),
            initial={"velocity": SineField(v0, beta)},
            outputs=outputs,
        ),
        exact=ExactSolution(
            fields={
                "displacement": ModeDisplacement(v0, beta, c),
                "velocity": ModeVelocity(v0, beta, c),
                "stress": ModeStress(v0, beta, c, youngs_modulus),
            },
            citation=CITATION,
        ),
        exposes=exposes,
        equations=(
            r"\rho\, \partial_{tt} u = E\, \partial_{xx} u, \quad \sigma = E\, \partial_x u",
            r"u(x,0) = 0, \quad \partial_t u(x,0) = v_0 \sin(\beta x)",
            conditions,
            r"u = \frac{v_0}{\beta c} \sin(\beta c t) \sin(\beta x), \quad c = \sqrt{E/\rho}, \quad \beta = " + latex,
        ),
    )
