"""P and S modes of a layer between clamped faces."""

import math

from mpmverify.errors import UsageError
from mpmverify.exact.plane_waves import PlaneWave, motion_of, plane_wave_problem
from mpmverify.exact.slip_box import CITATION
from mpmverify.exact.solution import VerificationProblem
from mpmverify.problem import Fixed, LinearElastic, Periodic

LOWER, THICKNESS, WIDTH = 0.25, 1.0, 0.5
"""Lower face, thickness and periodic width of the layer [m]."""


def clamped_layer(
    material: LinearElastic, dimension: int = 2, *, strain: float = 1e-5, periods: float = 1.3, outputs: int = 32
) -> VerificationProblem:
    """Layer that is clamped at its lower and upper face and periodic across, with a P mode and, in each direction across, an S mode.

    Parameters
    ----------
    material : LinearElastic
        Any of its kinds; a hyperelastic body follows the motion under a body force.
    dimension : {2, 3}
        Dimension of the layer; its normal is the last axis.
    strain : float
        Amplitude of the displacement gradient of each mode [1].
    periods : float
        Final time in periods of the P mode.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 2 or 3, or the strain is too large for a hyperelastic body; see `motion_of`.

    Notes
    -----
    Every component of the displacement is q(t) sin(k y) with the coordinate y along the normal, counted from the lower face: the P mode
    has k = 2 pi/L, the S modes pi/L and 3 pi/L. A face that holds only its normal component lets the S modes slip.

    References
    ----------
    Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford.
    """
    if dimension not in (2, 3):
        raise UsageError(f"a clamped layer has 2 or 3 dimensions, not {dimension!r}: use the axial vibration in one dimension")

    def mode(axis: int, half_waves: int, start: float) -> PlaneWave:
        k, d = half_waves * math.pi / THICKNESS, [0.0] * dimension
        d[axis] = strain / k
        return PlaneWave(tuple(d), (*[0.0] * (dimension - 1), k), -k * LOWER, start)

    waves = (mode(dimension - 1, 2, 0.9), mode(0, 1, -0.6), *([mode(1, 3, 0.3)] if dimension == 3 else []))
    across, normal = "xyz"[: dimension - 1], "xyz"[dimension - 1]
    return plane_wave_problem(
        f"clamped-layer-{dimension}d-{type(material).__name__}-{strain:g}",
        motion_of(material, waves),
        (*[0.0] * (dimension - 1), LOWER),
        (*[WIDTH] * (dimension - 1), LOWER + THICKNESS),
        {normal + side: Fixed() for side in "-+"} | {axis + side: Periodic() for axis in across for side in "-+"},
        periods=periods,
        outputs=outputs,
        citation=CITATION,
        exposes="A clamped face that does not hold every component, and errors of shear and of either elastic constant.",
        equations=(
            r"u = 0 \quad \text{at } y = 0, L; \quad u \text{ periodic across}",
            r"u_i = q_i(t)\, d_i \sin(k_i y), \quad k_i = \frac{n_i \pi}{L}",
        ),
    )
