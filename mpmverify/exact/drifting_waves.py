"""Manufactured waves in a neo-Hookean bar, square or cube that drifts through its joined ends."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import FieldOf, fields_of, initial_velocity
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, NeoHookean, Periodic, Problem

CITATION = (
    "Own derivation, by the method of manufactured solutions: Roache P. J. (2002). Code verification by the method of manufactured "
    "solutions. Journal of Fluids Engineering 124(1), 4-10, doi:10.1115/1.1436090"
)


@dataclass(frozen=True)
class DriftingWaves:
    """The motion u_i = V_i t + A_i (1 - cos(omega t)) sin(2 pi X_j) of the unit box, a `Motion`.

    Axis j follows axis i, so that the waves are shears; in one dimension j = i, and the wave is one of stretch.

    Parameters
    ----------
    amplitudes : tuple of float
        A_i [m].
    drift : tuple of float
        V_i [m/s].
    material : NeoHookean
        Material; omega = 2 pi c_s/(1 m) with the speed c_s of S waves.
    """

    amplitudes: tuple[float, ...]
    drift: tuple[float, ...]
    material: NeoHookean

    @property
    def frequency(self) -> float:
        """Angular frequency omega [rad/s]."""
        return 2 * math.pi * self.material.shear_wave_speed

    @property
    def following(self) -> Array:
        """Matrix (dim, dim) that is 1 where axis j follows axis i, and else 0 [1]."""
        return np.roll(np.eye(len(self.amplitudes)), 1, axis=1)

    def phase(self, t: Array) -> Array:
        """Return omega t (T, 1, 1) [rad]."""
        return self.frequency * t[:, None, None]

    def wave(self, X: Array) -> Array:
        """Return A_i sin(2 pi X_j) (1, P, dim) [m]."""
        return np.asarray(self.amplitudes) * np.sin(2 * np.pi * X @ self.following.T)[None]

    def displacement(self, X: Array, t: Array) -> Array:
        return np.asarray(self.drift) * t[:, None, None] + (1 - np.cos(self.phase(t))) * self.wave(X)

    def velocity(self, X: Array, t: Array) -> Array:
        return np.asarray(self.drift) + self.frequency * np.sin(self.phase(t)) * self.wave(X)

    def slopes(self, X: Array, t: Array) -> Array:
        """Return H_ij = 2 pi A_i (1 - cos(omega t)) cos(2 pi X_j) by row i (T, P, dim) [1]; the rest of each row is zero."""
        return (1 - np.cos(self.phase(t))) * (
            2 * np.pi * np.asarray(self.amplitudes) * np.cos(2 * np.pi * X @ self.following.T)
        )

    def gradient(self, X: Array, t: Array) -> Array:
        return self.slopes(X, t)[..., None] * self.following

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def cofactors(self, slopes: Array) -> list[list[Array]]:
        """Return the cofactors C = J F^-T [1] of F = I + H, of the slopes by row (dim, T, P)."""
        one = np.ones_like(slopes[0])
        if len(slopes) == 1:
            return [[one]]
        if len(slopes) == 2:
            a, b = slopes
            return [[one, -b], [-a, one]]
        a, b, c = slopes
        return [[one, b * c, -c], [-a, one, a * c], [a * b, -b, one]]

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force b (T, P, dim) [m/s^2].

        With the cofactors C, whose divergence is zero, P = mu F + phi(J) C where phi = (lambda ln J - mu)/J, and
        rho b = rho u_tt - mu Laplace(u) - phi'(J) C grad J. Here dJ/dX_j = C_ij dH_ij/dX_j, and J = 1 + H_ij C_ij, for any i and
        its j.
        """
        lame, mu, rho = self.material.lame_lambda, self.material.shear_modulus, self.material.density
        slopes = np.moveaxis(self.slopes(X, t), -1, 0)
        axes, curvature = range(len(slopes)), -((2 * np.pi) ** 2) * (1 - np.cos(self.phase(t))) * self.wave(X)
        C = self.cofactors(slopes)
        slope_of_J = [C[j - 1][j] * curvature[..., j - 1] for j in axes]
        change = slopes[-1] * C[-1][0]
        slope_of_phi = (lame * (1 - np.log1p(change)) + mu) / (1 + change) ** 2
        along = np.stack([slope_of_phi * sum(C[i][j] * slope_of_J[j] for j in axes) for i in axes], axis=-1)
        acceleration = self.frequency**2 * np.cos(self.phase(t)) * self.wave(X)
        return np.asarray(acceleration - (mu * curvature + along) / rho)


def drifting_waves(
    dimension: int = 3,
    amplitudes: tuple[float, ...] = (0.03, 0.02, 0.01),
    drift: tuple[float, ...] = (1.5, -0.9, 0.7),
    *,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    poissons_ratio: float = 0.3,
    periods: float = 0.3,
    outputs: int = 16,
) -> VerificationProblem:
    """Neo-Hookean unit bar, square or cube with joined ends and a wave along each axis, which drifts at a constant velocity.

    Parameters
    ----------
    dimension : {1, 2, 3}
        Of the amplitudes and velocities the first ones are taken.
    amplitudes : tuple of float
        A_i [m]; different ones tell the shears apart.
    drift : tuple of float
        V_i [m/s].
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1].
    periods : float
        Final time in periods 1 m/c_s of an S wave.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 1, 2 or 3, an amplitude is zero, or the slopes are so large that J would not stay positive.

    Notes
    -----
    The body starts undeformed, with an acceleration that is not zero. Ends are joined along every axis, so that no boundary condition
    adds an error. J = 1 + H_11 in one dimension, 1 - H_12 H_21 in two and 1 + H_12 H_23 H_31 in three.
    """
    if dimension not in (1, 2, 3):
        raise UsageError(f"drifting waves have 1, 2 or 3 dimensions, not {dimension!r}")
    amplitudes, drift = amplitudes[:dimension], drift[:dimension]
    if not 0 < math.prod(4 * math.pi * abs(A) for A in amplitudes) < 1:
        raise UsageError(
            f"the product of the slopes 4 pi A_i must be below 1 and not zero: change the amplitudes {amplitudes!r}"
        )
    motion = DriftingWaves(amplitudes, drift, NeoHookean(youngs_modulus, density, poissons_ratio))
    return VerificationProblem(
        problem=Problem(
            name=f"drifting-waves-{dimension}d-{amplitudes[0]:g}",
            lower=(0.0,) * dimension,
            upper=(1.0,) * dimension,
            material=motion.material,
            boundary={axis + side: Periodic() for axis in "xyz"[:dimension] for side in "-+"},
            end_time=periods / motion.material.shear_wave_speed,
            initial=initial_velocity(motion),
            body_force=FieldOf(motion, "force"),
            outputs=outputs,
        ),
        exact=ExactSolution(fields=fields_of(motion), citation=CITATION),
        exposes="Exchanged axes and components of shear, and errors of particles that pass cells and joined ends.",
        equations=(
            r"\rho\, \partial_{tt} u = \mathrm{Div}\, P + \rho b",
            r"P = \mu F + \phi(J)\, C, \quad C = J F^{-T}, \quad \phi = \frac{\lambda \ln J - \mu}{J}, \quad F = I + \nabla u",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = V, \quad u \text{ and } P \text{ periodic}",
            r"\rho b = \rho\, \partial_{tt} u - \mu \nabla^2 u - \phi'(J)\, C\, \nabla J",
            r"u_i = V_i t + A_i (1-\cos\omega t) \sin(2\pi X_j), \quad \omega = 2\pi \sqrt{\mu/\rho}, \quad j = i+1 "
            r"\text{ (cyclic)}",
        ),
    )
