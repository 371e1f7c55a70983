"""Manufactured standing wave in a linear elastic bar with a moved end, a loaded end and a body force."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, BoundaryCondition, LinearElastic, Problem, Traction, Velocity

CITATION = "Salari K., Knupp P. (2000). Code verification by the method of manufactured solutions. Sandia report SAND2000-1444"


@dataclass(frozen=True)
class Sinusoid:
    """a sin(omega t + phase) + offset, a `History`; omega in rad/s."""

    amplitude: float
    omega: float
    phase: float = 0.0
    offset: float = 0.0

    def __call__(self, t: Array) -> Array:
        return self.amplitude * np.sin(self.omega * t + self.phase) + self.offset

    def scaled(self, factor: float) -> "Sinusoid":
        return dataclasses.replace(self, amplitude=factor * self.amplitude, offset=factor * self.offset)

    def integral(self, t: Array) -> Array:
        return self.amplitude / self.omega * (math.cos(self.phase) - np.cos(self.omega * t + self.phase)) + self.offset * t


@dataclass(frozen=True)
class SineProfile:
    """a sin(k X + phase): (P, 1) [m] -> (P, 1); k in rad/m."""

    amplitude: float
    wavenumber: float
    phase: float

    def __call__(self, X: Array) -> Array:
        return self.amplitude * np.sin(self.wavenumber * X + self.phase)


@dataclass(frozen=True)
class StandingWave:
    """A profile in space times a function of time: (P, 1) [m], (T,) [s] -> (T, P, 1)."""

    profile: SineProfile
    history: Sinusoid

    def __call__(self, X: Array, t: Array) -> Array:
        return self.history(t)[:, None, None] * self.profile(X)[None]


def driven_bar(
    loaded: str = "x+",
    *,
    start: float = 0.0,
    amplitude: float = 1e-6,
    lower: float = 0.5,
    length: float = 1.6,
    youngs_modulus: float = 3.0,
    density: float = 2.0,
    poissons_ratio: float = 0.3,
) -> VerificationProblem:
    """Linear elastic bar with the manufactured displacement u = G sin(k X + phi) [sin(omega t + psi) - sin(psi)].

    No parameter is 0 or 1, no end is at rest or free, and there is no symmetry. Terms that vanish or cancel for a bar with unit
    properties therefore do not vanish here.

    Parameters
    ----------
    loaded : {"x-", "x+"}
        Face with a prescribed traction; the other face has a prescribed velocity.
    start : float
        psi [rad]; if it is not zero, the initial acceleration is not zero.
    amplitude : float
        G [m].
    lower, length : float
        Position of the face x- and length of the bar [m].
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1]; the strain is uniaxial, with the modulus lambda + 2 mu.

    Raises
    ------
    UsageError
        If the loaded face is not "x-" or "x+".

    Notes
    -----
    rho u_tt = (lambda + 2 mu) u_XX + rho b gives b = (c^2 k^2 - omega^2) u - omega^2 G sin(psi) sin(k X + phi) with
    c^2 = (lambda + 2 mu)/rho.

    References
    ----------
    Salari K., Knupp P. (2000). Code verification by the method of manufactured solutions. SAND2000-1444.
    """
    if loaded not in ("x-", "x+"):
        raise UsageError(f"the loaded face of a bar is x- or x+, not {loaded!r}")
    material = LinearElastic(youngs_modulus, density, poissons_ratio)
    modulus = material.lame_lambda + 2 * material.shear_modulus
    c, k, phase = material.wave_speed, 1.3 * math.pi / length, 0.4
    omega = 0.8 * c * k
    profile, stress_profile = SineProfile(1.0, k, phase), SineProfile(modulus * k, k, phase + math.pi / 2)
    offset = -amplitude * math.sin(start)
    history, rate = Sinusoid(amplitude, omega, start, offset), Sinusoid(amplitude * omega, omega, start + math.pi / 2)

    def at(face: str) -> Array:
        return np.array([[lower + (length if face == "x+" else 0.0)]])

    moved = "x-" if loaded == "x+" else "x+"
    boundary: dict[str, BoundaryCondition] = {
        moved: Velocity(rate.scaled(float(profile(at(moved))[0, 0]))),
        loaded: Traction(history.scaled(float(stress_profile(at(loaded))[0, 0]))),
    }
    return VerificationProblem(
        problem=Problem(
            name=f"driven-bar-loaded-at-{loaded}" + ("-accelerated" if start else ""),
            lower=(lower,),
            upper=(lower + length,),
            material=material,
            boundary=boundary,
            end_time=(1.45 if start else 1.3) * 2 * math.pi / omega,
            initial={"velocity": SineProfile(rate.amplitude * math.cos(start), k, phase)},
            body_force=StandingWave(
                profile, Sinusoid(amplitude * (c * c * k * k - omega * omega), omega, start, offset * (c * k) ** 2)
            ),
        ),
        exact=ExactSolution(
            fields={
                "displacement": StandingWave(profile, history),
                "velocity": StandingWave(profile, rate),
                "stress": StandingWave(stress_profile, history),
            },
            citation=CITATION,
        ),
        exposes="Errors at moved and loaded ends, in the time at which data are evaluated, in the body force, and in terms that vanish "
        "for unit properties.",
        equations=(
            r"\rho\, \partial_{tt} u = (\lambda + 2\mu)\, \partial_{XX} u + \rho b, \quad \sigma = (\lambda + 2\mu)\, \partial_X u",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = \omega G \cos\psi \sin(k X + \varphi)",
            r"u \text{ and } \sigma \text{ as given at the moved and at the loaded end}",
            r"b = (c^2 k^2 - \omega^2)\, u - \omega^2 G \sin\psi \sin(k X + \varphi), \quad c = \sqrt{(\lambda + 2\mu)/\rho}",
            r"u = G \sin(k X + \varphi)\, [\sin(\omega t + \psi) - \sin\psi]",
        ),
    )
