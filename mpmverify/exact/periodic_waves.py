"""Plane P and S waves that travel through a periodic box."""

import math
from collections.abc import Sequence

from mpmverify.errors import UsageError
from mpmverify.exact.plane_waves import PlaneWave, motion_of, p_and_s, plane_wave_problem
from mpmverify.exact.slip_box import ACROSS, CITATION, LOWER, SIDES
from mpmverify.exact.solution import VerificationProblem
from mpmverify.problem import LinearElastic, Periodic
from mpmverify.problem.material import KelvinVoigt, Maxwell


def travelling(polarisation: Sequence[float], wavenumber: Sequence[float], phase: float) -> tuple[PlaneWave, ...]:
    """Return d sin(k . X - omega t + phi) of an elastic body as two standing waves."""
    d, k = tuple(polarisation), tuple(wavenumber)
    return PlaneWave(d, k, phase), PlaneWave(d, k, phase + math.pi / 2, math.pi / 2)


def periodic_waves(
    material: LinearElastic,
    waves: Sequence[int] = (1, -1),
    *,
    strain: float = 1e-5,
    periods: float = 1.3,
    outputs: int = 32,
) -> VerificationProblem:
    """Periodic box through which a P wave travels in a direction, and an S wave against it.

    Parameters
    ----------
    material : LinearElastic
        An elastic material; a hyperelastic body follows the motion under a body force.
    waves : sequence of int
        Numbers n_i of waves along the two or three sides, of lengths 1, 1.5 and 2 m: they choose the direction k_i = 2 pi n_i/L_i.
    strain : float
        Amplitude of the displacement gradient of each wave [1].
    periods : float
        Final time in periods of the P wave.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If there are not two or three numbers of waves or all are zero, the material is viscous, or the strain is too large for a
        hyperelastic body; see `motion_of`.

    References
    ----------
    Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford.
    """
    dimension = len(waves)
    if dimension not in (2, 3) or not any(waves):
        raise UsageError(f"give the numbers of waves along two or three sides, not all of them zero: {waves!r}")
    if isinstance(material, KelvinVoigt | Maxwell):
        raise UsageError(f"a travelling wave of constant amplitude needs an elastic body, not {material!r}")
    lower, sides = LOWER[:dimension], SIDES[:dimension]
    k = tuple(2 * math.pi * n / side for n, side in zip(waves, sides, strict=True))
    p, s = p_and_s(k, ACROSS[:dimension], strain)
    motion = motion_of(material, (*travelling(p, k, 0.4), *travelling(s, [-a for a in k], 1.1)))
    return plane_wave_problem(
        f"periodic-waves-{'-'.join(map(str, waves))}-{type(material).__name__}-{strain:g}",
        motion,
        lower,
        tuple(a + side for a, side in zip(lower, sides, strict=True)),
        {axis + side: Periodic() for axis in "xyz"[:dimension] for side in "-+"},
        periods=periods,
        outputs=outputs,
        citation=CITATION,
        exposes="Errors at joined ends, of either elastic constant, and of waves oblique to the grid.",
        equations=(
            r"u \text{ periodic along every axis}",
            r"u = d_P \sin(k \cdot x - \omega_P t + \varphi_P) + d_S \sin(-k \cdot x - \omega_S t + \varphi_S), \quad "
            r"k_i = \frac{2\pi n_i}{L_i}",
        ),
    )
