"""Free shear wave of any amplitude in a neo-Hookean layer between two clamped faces."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import cauchy_stress
from mpmverify.exact.motion import fields_of, initial_velocity
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Fixed, NeoHookean, Periodic, Problem

CITATION = (
    "Transverse waves of finite amplitude are linear in a neo-Hookean body: Boulanger P., Hayes M. (1992). Finite-amplitude waves in "
    "deformed Mooney-Rivlin materials. Quarterly Journal of Mechanics and Applied Mathematics 45(4), 575-593, "
    "doi:10.1093/qjmam/45.4.575; here J = 1, and own derivation"
)


@dataclass(frozen=True)
class ShearOfLayer:
    """The motion u_i = A_i sin(pi X) sin(pi c_s t) of a layer 0 < X < 1 m along its faces, a `Motion`; X is the first axis.

    Parameters
    ----------
    amplitudes : tuple of float
        A_i of the axes along the faces [m].
    material : NeoHookean
        Material; c_s is the speed of S waves.
    """

    amplitudes: tuple[float, ...]
    material: NeoHookean

    @property
    def frequency(self) -> float:
        """Angular frequency pi c_s/(1 m) [rad/s]."""
        return math.pi * self.material.shear_wave_speed

    @property
    def direction(self) -> Array:
        """Amplitude along every axis, 0 across the faces (dim,) [m]."""
        return np.array([0.0, *self.amplitudes])

    def displacement(self, X: Array, t: Array) -> Array:
        return np.sin(self.frequency * t)[:, None, None] * np.sin(np.pi * X[None, :, :1]) * self.direction

    def velocity(self, X: Array, t: Array) -> Array:
        rate = self.frequency * np.cos(self.frequency * t)[:, None, None]
        return rate * np.sin(np.pi * X[None, :, :1]) * self.direction

    def gradient(self, X: Array, t: Array) -> Array:
        """Return H, of which the first column alone is not zero: pi A_i cos(pi X) sin(pi c_s t) (T, P, dim, dim) [1]."""
        H = np.zeros((len(t), len(X), X.shape[1], X.shape[1]))
        H[..., 0] = np.pi * np.sin(self.frequency * t)[:, None, None] * np.cos(np.pi * X[None, :, :1]) * self.direction
        return H

    def stress(self, X: Array, t: Array) -> Array:
        return cauchy_stress(self.material, self.gradient(X, t))

    def force(self, X: Array, t: Array) -> Array:
        """Return the body force, which is zero: Div P = mu u_XX = rho u_tt (T, P, dim) [m/s^2]."""
        return np.zeros((len(t), *X.shape))


def clamped_shear(
    dimension: int = 2,
    amplitudes: tuple[float, ...] = (0.5, -0.3),
    *,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    poissons_ratio: float = 0.3,
    periods: float = 0.1,
    outputs: int = 8,
) -> VerificationProblem:
    """Neo-Hookean layer, clamped on the two faces across x and joined along the other axes, that swings along its faces.

    Parameters
    ----------
    dimension : {2, 3}
        The layer is 1 m thick; its box is a square or a cube.
    amplitudes : tuple of float
        Amplitude along y and z [m]; the defaults carry material points through the joined ends.
    youngs_modulus, density, poissons_ratio : float
        E [Pa], rho [kg/m^3], nu [1]; the motion does not depend on nu.
    periods : float
        Final time in periods 2/c_s, when neither displacement nor velocity is near zero.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3, or every amplitude is zero.

    Notes
    -----
    F = I + g e_x^T with g along the faces, so that J = 1, P = mu (g e_x^T + e_x g^T) and the wave equation is linear for any
    amplitude. A face that holds its normal component alone would let the layer slip: its shear stress is largest there.
    """
    if dimension not in (2, 3):
        raise UsageError(f"a layer has 2 or 3 dimensions, not {dimension!r}")
    if not any(amplitudes[: dimension - 1]):
        raise UsageError(f"one of the amplitudes along the faces must not be zero: {amplitudes!r}")
    motion = ShearOfLayer(amplitudes[: dimension - 1], NeoHookean(youngs_modulus, density, poissons_ratio))
    return VerificationProblem(
        problem=Problem(
            name=f"clamped-shear-{dimension}d-{amplitudes[0]:g}",
            lower=(0.0,) * dimension,
            upper=(1.0,) * dimension,
            material=motion.material,
            boundary={axis + side: Fixed() if axis == "x" else Periodic() for axis in "xyz"[:dimension] for side in "-+"},
            end_time=periods * 2 / motion.material.shear_wave_speed,
            initial=initial_velocity(motion),
            outputs=outputs,
        ),
        exact=ExactSolution(fields=fields_of(motion), citation=CITATION),
        exposes="A clamped face that slips, and rows of particles that pass the joined ends at different velocities.",
        equations=(
            r"\rho\, \partial_{tt} u = \mathrm{Div}\, P, \quad P = \lambda \ln(J) F^{-T} + \mu (F - F^{-T})",
            r"u(X,0) = 0, \quad \partial_t u(X,0) = \pi c_s A \sin(\pi X)",
            r"u = 0 \text{ at } X = 0, 1, \quad \text{periodic along the faces}",
            r"u_i = A_i \sin(\pi X) \sin(\pi c_s t), \quad c_s = \sqrt{\mu/\rho}, \quad A_x = 0",
        ),
    )
