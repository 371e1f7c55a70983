"""P and S modes of a bar, a rectangle or a cuboid between slip walls, of any elastic or viscoelastic material."""

import math

from mpmverify.errors import UsageError
from mpmverify.exact.plane_waves import between_walls, motion_of, p_and_s, plane_wave_problem
from mpmverify.exact.solution import VerificationProblem
from mpmverify.problem import Constant, LinearElastic, Velocity

CITATION = (
    "Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, chapter 5 (P and S waves, and their reflection at a mixed "
    "boundary); viscoelastic amplitudes: Christensen R. M. (1982). Theory of Viscoelasticity. Academic Press; at finite strain a "
    "manufactured motion"
)
SIDES, LOWER, ACROSS = (1.0, 1.5, 2.0), (0.25, -0.5, 1.0), (1.0, -0.4, 0.7)
"""Sides [m] and lower corner [m] of the box, and the direction that the S mode takes in it."""


def slip_box(
    material: LinearElastic,
    dimension: int = 2,
    *,
    strain: float = 1e-5,
    periods: float = 1.3,
    outputs: int = 32,
) -> VerificationProblem:
    """Box between rollers with one P mode and, but in a bar, one S mode, which starts strained and moving.

    Parameters
    ----------
    material : LinearElastic
        Any of its kinds. At small strain the modes are free. A hyperelastic body follows the same motion under a body force.
    dimension : {1, 2, 3}
        Bar, rectangle or cuboid, with sides 1, 1.5 and 2 m away from the origin. The shears of the cuboid all differ.
    strain : float
        Amplitude of the displacement gradient of each mode [1].
    periods : float
        Final time in periods of the P mode.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the dimension is not 1, 2 or 3, or the strain is too large for a hyperelastic body; see `motion_of`.

    Notes
    -----
    Both modes are u_i = d_i sin(k_i x_i) prod_{j != i} cos(k_j x_j) with k_i = pi/L_i, counted from the lower corner: d is parallel to k
    in the P mode, u = grad prod_j cos(k_j x_j), and perpendicular to it in the S mode. On every wall u_i = 0 and, with it, du_i/dx_j = 0
    and du_j/dx_i = 0: F is diagonal in its row and column, so that the wall is free of shear for every isotropic law.

    References
    ----------
    Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford.
    """
    if dimension not in (1, 2, 3):
        raise UsageError(f"a slip-wall box has 1, 2 or 3 dimensions, not {dimension!r}")
    lower, sides = LOWER[:dimension], SIDES[:dimension]
    k = tuple(math.pi / side for side in sides)
    phases = [-a * b for a, b in zip(k, lower, strict=True)]
    if dimension == 1:
        waves = between_walls((strain / k[0],), k, phases, 0.9)
    else:
        p, s = p_and_s(k, ACROSS[:dimension], strain)
        waves = (*between_walls(p, k, phases, 0.9), *between_walls(s, k, phases, -0.6))
    return plane_wave_problem(
        f"slip-box-{dimension}d-{type(material).__name__}-{strain:g}",
        motion_of(material, waves),
        lower,
        tuple(a + side for a, side in zip(lower, sides, strict=True)),
        {axis + side: Velocity(Constant(0.0)) for axis in "xyz"[:dimension] for side in "-+"},
        periods=periods,
        outputs=outputs,
        citation=CITATION,
        exposes="Errors of either elastic constant, of shear, of the law of a material, and of rollers.",
        equations=(
            r"u_i = 0, \quad \sigma_{ij} = 0 \quad (j \ne i) \quad \text{at } x_i = 0, L_i",
            r"u_i = \sum_{P,S} q(t)\, d_i \sin(k_i x_i) \prod_{j \ne i} \cos(k_j x_j), \quad k_i = \frac{\pi}{L_i}, \quad "
            r"d_P \parallel k, \quad d_S \perp k",
        ),
    )
