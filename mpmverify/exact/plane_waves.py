"""Sums of plane P and S waves in elastic and viscoelastic bodies, and the same motions at finite strain."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import KIRCHHOFF, body_force, cauchy_stress, independent, shifted, trace
from mpmverify.exact.motion import AtStart, FieldOf, fields_of
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, BoundaryCondition, LinearElastic, Problem
from mpmverify.problem.material import KelvinVoigt, Maxwell

POINTS = 4096
"""Number of points and times whose force is evaluated at once: their tensors fit a cache."""
ELASTIC = r"\sigma = \lambda\, \mathrm{tr}(\varepsilon) I + 2\mu\, \varepsilon"
LAWS: Mapping[type[LinearElastic], str] = {
    KelvinVoigt: r"\sigma = C : (\varepsilon + \theta \dot\varepsilon)",
    Maxwell: r"\dot\sigma = C : \dot\varepsilon - \sigma/\tau",
}
"""Law as LaTeX of the materials that are not elastic at small strain."""


@dataclass(frozen=True)
class PlaneWave:
    """The standing wave u = d sin(k . X + phi) q(t), with q(0) = cos(psi) and q'(0) = -omega sin(psi).

    Parameters
    ----------
    polarisation : tuple of float
        d [m]: parallel to k in a P wave, perpendicular to k in an S wave.
    wavenumber : tuple of float
        k [rad/m].
    phase : float
        phi [rad].
    start : float
        psi [rad].

    Raises
    ------
    UsageError
        If d is zero, or neither parallel nor perpendicular to k.
    """

    polarisation: tuple[float, ...]
    wavenumber: tuple[float, ...]
    phase: float = 0.0
    start: float = 0.0

    def __post_init__(self) -> None:
        sizes = math.hypot(*self.polarisation) * math.hypot(*self.wavenumber)
        if not sizes or min(abs(self.cosine), 1 - abs(self.cosine)) > 1e-12:
            raise UsageError(f"a plane wave must have a polarisation parallel or perpendicular to its wavenumber: {self!r}")

    @property
    def cosine(self) -> float:
        """Cosine of the angle between d and k: -1 or 1 in a P wave, 0 in an S wave."""
        along = sum(d * k for d, k in zip(self.polarisation, self.wavenumber, strict=True))
        return along / math.hypot(*self.polarisation) / math.hypot(*self.wavenumber)

    @property
    def strain(self) -> float:
        """Amplitude |d| |k| of the displacement gradient [1]."""
        return math.hypot(*self.polarisation) * math.hypot(*self.wavenumber)

    def frequency(self, law: LinearElastic) -> float:
        """Return omega = c |k| [rad/s] of an elastic body, with the speed c of P or of S waves."""
        return (law.wave_speed if abs(self.cosine) > 0.5 else law.shear_wave_speed) * math.hypot(*self.wavenumber)

    def amplitudes(self, law: LinearElastic, t: Array) -> tuple[Array, Array, Array]:
        """Return q, q' and the amplitude s of the stress s C : sym(d k^T) cos(k . X + phi), (T,) each, at times (T,) [s].

        Raises
        ------
        UsageError
            If a viscous body does not oscillate at this wavenumber.

        Notes
        -----
        The balance of momentum is q'' = -omega^2 s for every law; s = q in an elastic body. In a Kelvin-Voigt body s = q + theta q',
        and q'' + theta omega^2 q' + omega^2 q = 0. In a Maxwell body s' = q' - s/tau, hence s'' + s'/tau + omega^2 s = 0 and
        q = q(0) + s - s(0) - [q' - q'(0)]/(tau omega^2); here s(0) = q(0).
        """
        omega = self.frequency(law)
        q0, r0 = math.cos(self.start), -omega * math.sin(self.start)
        if isinstance(law, Maxwell):
            tau = law.relaxation_time
            s, rate = damped(omega, 1 / (2 * tau), q0, r0 - q0 / tau, t)
            r = rate + s / tau
            return s - (r - r0) / (tau * omega**2), r, s
        theta = law.retardation_time if isinstance(law, KelvinVoigt) else 0.0
        q, r = damped(omega, theta * omega**2 / 2, q0, r0, t)
        return q, r, q + theta * r


def damped(omega: float, g: float, y0: float, rate: float, t: Array) -> tuple[Array, Array]:
    """Return y and y' of y'' + 2 g y' + omega^2 y = 0 with y(0) = y0 and y'(0) = rate, at times (T,) [s].

    Raises
    ------
    UsageError
        If g >= omega: the solution does not oscillate.
    """
    if g >= omega:
        raise UsageError(f"a wave of {omega:g} rad/s does not oscillate with a damping of {g:g} 1/s: lower the viscosity")
    w = math.sqrt(omega**2 - g**2)
    decay, cos, sin = np.exp(-g * t), np.cos(w * t), np.sin(w * t)
    return decay * (y0 * cos + (rate + g * y0) / w * sin), decay * (rate * cos - (omega**2 * y0 + g * rate) / w * sin)


@dataclass(frozen=True)
class PlaneWaves:
    """A sum of plane waves at small strain, a `Motion`.

    Parameters
    ----------
    material : LinearElastic
        Elastic or viscoelastic material.
    waves : tuple of PlaneWave
        The waves.
    """

    material: LinearElastic
    waves: tuple[PlaneWave, ...]

    def _sum(self, X: Array, amplitudes: Sequence[Array], order: int) -> Array:
        """Return the derivatives of some order by X (T, P, dim, ...) of waves whose amplitudes in time are given (T,)."""
        values, tensors = [], []
        for wave, amplitude in zip(self.waves, amplitudes, strict=True):
            values.append(np.multiply.outer(amplitude, np.sin(X @ wave.wavenumber + wave.phase + order * np.pi / 2)))
            tensor = np.array(wave.polarisation)
            for _ in range(order):
                tensor = np.multiply.outer(tensor, wave.wavenumber)
            tensors.append(tensor)
        return np.tensordot(np.stack(values, axis=-1), np.stack(tensors), axes=1)

    def _at(self, t: Array, which: int) -> list[Array]:
        return [wave.amplitudes(self.material, t)[which] for wave in self.waves]

    def displacement(self, X: Array, t: Array) -> Array:
        return self._sum(X, self._at(t, 0), 0)

    def velocity(self, X: Array, t: Array) -> Array:
        return self._sum(X, self._at(t, 1), 0)

    def gradient(self, X: Array, t: Array) -> Array:
        return self._sum(X, self._at(t, 0), 1)

    def stress(self, X: Array, t: Array) -> Array:
        law = self.material
        H = np.moveaxis(self._sum(X, self._at(t, 2), 1), (-2, -1), (0, 1))
        sigma = shifted(law.lame_lambda * trace(H), law.shear_modulus * (H + np.swapaxes(H, 0, 1)))
        return np.moveaxis(independent(sigma), 0, -1)


@dataclass(frozen=True)
class FiniteWaves(PlaneWaves):
    """The motion of elastic plane waves imposed on a hyperelastic body at finite strain, where it needs a body force."""

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force b = u_tt - Div P/rho (T, P, dim) [m/s^2], see `body_force`."""
        some = max(1, POINTS // len(X))
        return np.concatenate([self._force(X, t[k : k + some]) for k in range(0, len(t), some)])

    def _force(self, X: Array, t: Array) -> Array:
        law, q = self.material, self._at(t, 0)
        acceleration = [-(wave.frequency(law) ** 2) * amplitude for wave, amplitude in zip(self.waves, q, strict=True)]
        return body_force(law, self._sum(X, q, 1), self._sum(X, q, 2), self._sum(X, acceleration, 0))


def p_and_s(wavenumber: Sequence[float], across: Sequence[float], strain: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the polarisation [m] of a P wave and of an S wave of one wavenumber [rad/m], each with the same strain amplitude [1].

    Parameters
    ----------
    wavenumber : sequence of float
        k [rad/m].
    across : sequence of float
        Direction of the S wave; its part along k is taken off.
    strain : float
        |d| |k| of each wave.
    """
    k, d = np.array(wavenumber), np.array(across, dtype=float)
    d = d - (d @ k) / (k @ k) * k
    return tuple((strain / (k @ k) * k).tolist()), tuple((strain / np.sqrt((k @ k) * (d @ d)) * d).tolist())


def between_walls(
    polarisation: Sequence[float], wavenumber: Sequence[float], phases: Sequence[float], start: float
) -> tuple[PlaneWave, ...]:
    """Return u_i = d_i sin(theta_i) times cos(theta_j) of all other axes, theta_j = k_j X_j + phi_j, as a sum of plane waves.

    The waves are a plane wave and its mirror images in walls normal to the axes, 2^(dim - 1) in all.
    """
    signs = [(1, *rest) for rest in itertools.product((1, -1), repeat=len(wavenumber) - 1)]

    def image(sign: tuple[int, ...]) -> PlaneWave:
        d = tuple(s * a / len(signs) for s, a in zip(sign, polarisation, strict=True))
        k = tuple(s * a for s, a in zip(sign, wavenumber, strict=True))
        return PlaneWave(d, k, sum(s * a for s, a in zip(sign, phases, strict=True)), start)

    return tuple(image(sign) for sign in signs)


def plane_wave_problem(
    name: str,
    motion: PlaneWaves,
    lower: tuple[float, ...],
    upper: tuple[float, ...],
    boundary: Mapping[str, BoundaryCondition],
    *,
    periods: float,
    outputs: int,
    citation: str,
    exposes: str,
    equations: tuple[str, str],
) -> VerificationProblem:
    """Return the problem of a body that starts in a motion, which may be strained and moving.

    Parameters
    ----------
    periods : float
        Final time in periods of the first wave.
    equations : tuple of str
        Boundary conditions, and the motion, as LaTeX; the other equations follow from the motion.
    """
    law, fields, finite = motion.material, fields_of(motion), isinstance(motion, FiniteWaves)
    balance = (
        (r"\rho\, \partial_{tt} u = \mathrm{Div}\, P + \rho b", r"b = \partial_{tt} u - \mathrm{Div}\, P(I + \nabla u)/\rho")
        if finite
        else (r"\rho\, \partial_{tt} u = \mathrm{div}\, \sigma", LAWS.get(type(law), ELASTIC))
    )
    return VerificationProblem(
        problem=Problem(
            name=name,
            lower=lower,
            upper=upper,
            material=law,
            boundary=boundary,
            end_time=periods * 2 * math.pi / motion.waves[0].frequency(law),
            initial={quantity: AtStart(field) for quantity, field in fields.items()},
            body_force=FieldOf(motion, "force") if finite else None,
            outputs=outputs,
        ),
        exact=ExactSolution(fields=fields, citation=citation),
        exposes=exposes,
        equations=(*balance, *equations),
    )


def motion_of(material: LinearElastic, waves: tuple[PlaneWave, ...]) -> PlaneWaves:
    """Return the waves in a body, at finite strain if its law is one of finite strain.

    Raises
    ------
    UsageError
        If the strain amplitudes of all waves sum to 1 or more at finite strain, where J might not stay positive.
    """
    if type(material) not in KIRCHHOFF:
        return PlaneWaves(material, waves)
    total = sum(wave.strain for wave in waves)
    if total >= 1:
        raise UsageError(f"the strain amplitudes of the waves must sum to less than 1 at finite strain, not to {total:g}")
    return FiniteWaves(material, waves)
