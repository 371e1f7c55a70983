"""Periodic elastic bar (a ring) with a standing wave of every wavelength that a grid resolves."""

import math
from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact.motion import AtStart
from mpmverify.exact.solution import ExactSolution, VerificationProblem
from mpmverify.problem import Array, Problem
from mpmverify.problem.boundary import Periodic
from mpmverify.problem.material import LinearElastic


@dataclass(frozen=True)
class Modes:
    """Sum of standing waves n = 1 to N on a ring, all with the same strain amplitude.

    Parameters
    ----------
    count : int
        Number N of waves.
    strain : float
        Strain amplitude e0 of each wave [1].
    length, wave_speed : float
        L [m], c [m/s].
    """

    count: int
    strain: float
    length: float
    wave_speed: float

    def waves(self, X: Array, t: Array) -> tuple[Array, Array, Array]:
        """Return the wavenumbers k (N,) [rad/m], and the phases k X + phi (1, P, N) and k c t (T, 1, N) [rad]."""
        n = np.arange(1, self.count + 1, dtype=float)
        k: Array = 2 * np.pi * n / self.length
        return k, (X * k + np.pi * n**2 / self.count + np.pi / 2)[None], self.wave_speed * t[:, None, None] * k

    def displacement(self, X: Array, t: Array) -> Array:
        """Return sum_n e0/k cos(k c t) sin(k X + phi) (T, P, 1) [m]."""
        k, phase, kct = self.waves(X, t)
        return np.sum(self.strain / k * np.cos(kct) * np.sin(phase), axis=2, keepdims=True)

    def velocity(self, X: Array, t: Array) -> Array:
        """Return -sum_n c e0 sin(k c t) sin(k X + phi) (T, P, 1) [m/s]."""
        _, phase, kct = self.waves(X, t)
        return -self.wave_speed * self.strain * np.sum(np.sin(kct) * np.sin(phase), axis=2, keepdims=True)

    def gradient(self, X: Array, t: Array) -> Array:
        """Return sum_n e0 cos(k c t) cos(k X + phi) (T, P, 1) [1]."""
        _, phase, kct = self.waves(X, t)
        return self.strain * np.sum(np.cos(kct) * np.cos(phase), axis=2, keepdims=True)


@dataclass(frozen=True)
class ModesField:
    """One field of `Modes`, "displacement", "velocity" or "gradient", times a factor: (P, 1) [m], (T,) [s] -> (T, P, 1)."""

    modes: Modes
    kind: str
    factor: float = 1.0

    def __call__(self, X: Array, t: Array) -> Array:
        return self.factor * np.asarray(getattr(self.modes, self.kind)(X, t))


def ring_modes(
    cells: int = 40,
    *,
    length: float = 2.0,
    youngs_modulus: float = 9.0,
    density: float = 4.0,
    strain: float = 1e-4,
    crossings: float = 25.0,
) -> VerificationProblem:
    """Periodic bar released from rest in a sum of standing waves with wavelengths from L to two cells and equal strain.

    Parameters
    ----------
    cells : int
        Even number of cells of the grid; its shortest wave, of two cells, is the last one in the sum.
    length, youngs_modulus, density : float
        L [m], E [Pa], rho [kg/m^3].
    strain : float
        Strain amplitude of each wave [1].
    crossings : float
        Final time in units of L/c, which takes cells * crossings/nu_C steps.

    Raises
    ------
    UsageError
        If the number of cells is not positive and even.

    Notes
    -----
    The phases pi n^2/N + pi/2 prevent the waves from adding up at one point. The strain of the shortest wave is largest at the
    middles of the cells. The final time is not a multiple of a period.
    """
    if cells < 2 or cells % 2:
        raise UsageError(
            f"the number of cells of the ring must be positive and even, not {cells!r}: its shortest wave has two cells"
        )
    material = LinearElastic(youngs_modulus, density)
    modes = Modes(cells // 2, strain, length, material.wave_speed)
    displacement, velocity, gradient, stress = (
        ModesField(modes, "displacement"),
        ModesField(modes, "velocity"),
        ModesField(modes, "gradient"),
        ModesField(modes, "gradient", youngs_modulus),
    )
    return VerificationProblem(
        problem=Problem(
            name=f"ring-modes-{cells}",
            lower=(0.0,),
            upper=(length,),
            material=material,
            boundary={"x-": Periodic(), "x+": Periodic()},
            end_time=crossings * length / material.wave_speed / math.sqrt(1.001),
            initial={
                "displacement": AtStart(displacement),
                "displacement_gradient": AtStart(gradient),
                "stress": AtStart(stress),
            },
            outputs=1,
        ),
        exact=ExactSolution(
            fields={"displacement": displacement, "velocity": velocity, "stress": stress},
            citation="d'Alembert's solution of the wave equation, as a sum of its standing waves.",
        ),
        exposes="The largest Courant number at which no mode of the grid grows.",
        equations=(
            r"\rho\, \partial_{tt} u = E\, \partial_{xx} u, \quad \sigma = E\, \partial_x u",
            r"u(0,t) = u(L,t), \quad \sigma(0,t) = \sigma(L,t)",
            r"u = \sum_{n=1}^{N} \frac{e_0}{k_n} \cos(k_n c t) \sin(k_n x + \varphi_n), \quad k_n = \frac{2n\pi}{L}, \quad "
            r"\varphi_n = \frac{\pi n^2}{N} + \frac{\pi}{2}",
        ),
    )
