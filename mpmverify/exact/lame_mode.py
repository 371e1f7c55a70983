"""Lame mode: an S mode of a square whose faces are free of traction, whatever the first elastic constant."""

import math

from mpmverify.errors import UsageError
from mpmverify.exact.finite_strain import KIRCHHOFF
from mpmverify.exact.plane_waves import PlaneWaves, between_walls, plane_wave_problem
from mpmverify.exact.solution import VerificationProblem
from mpmverify.problem import Constant, LinearElastic, Traction

CITATION = (
    "Lamé G. (1852). Leçons sur la théorie mathématique de l'élasticité des corps solides. Bachelier; Graff K. F. (1975). Wave Motion "
    "in Elastic Solids. Clarendon Press, chapter 8 (Lamé modes of a plate)"
)


def lame_mode(
    material: LinearElastic,
    half_waves: int = 1,
    *,
    side: float = 1.5,
    strain: float = 1e-5,
    periods: float = 1.3,
    outputs: int = 32,
) -> VerificationProblem:
    """Free square in its Lame mode, which starts strained and moving.

    Parameters
    ----------
    material : LinearElastic
        Elastic or viscoelastic at small strain.
    half_waves : int
        Number n of half waves along a side.
    side : float
        L [m].
    strain : float
        Amplitude of the displacement gradient [1].
    periods : float
        Final time in periods of the mode.
    outputs : int
        Number of output intervals.

    Raises
    ------
    UsageError
        If the body is hyperelastic: its surfaces would be free to first order only.

    Notes
    -----
    u = A (cos kx sin ky, -sin kx cos ky) q(t), k = n pi/L, swings with omega = sqrt(2) k c_S: sigma_xy = 0 everywhere, and
    sigma_xx = -sigma_yy = -2 mu k A sin kx sin ky q vanishes on every face. The mode does not change volumes, so that lambda has no part.

    References
    ----------
    Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford.
    """
    if type(material) in KIRCHHOFF:
        raise UsageError(f"the Lame mode leaves the faces of a body free at small strain only, not {material!r}")
    k = half_waves * math.pi / side
    d = strain / (math.sqrt(2) * k)
    waves = between_walls((-d, d), (k, k), (math.pi / 2, math.pi / 2), 0.8)
    free = Traction(Constant(0.0))
    return plane_wave_problem(
        f"lame-mode-{half_waves}-{type(material).__name__}-{strain:g}",
        PlaneWaves(material, waves),
        (0.0, 0.0),
        (side, side),
        dict.fromkeys(("x-", "x+", "y-", "y+"), free),
        periods=periods,
        outputs=outputs,
        citation=CITATION,
        exposes="Errors of shear and at free surfaces.",
        equations=(
            r"\sigma_{xx} = \sigma_{xy} = 0 \text{ at } x = 0, L, \quad \sigma_{yy} = \sigma_{xy} = 0 \text{ at } y = 0, L",
            r"u = A\, q(t)\, (\cos kx \sin ky,\, -\sin kx \cos ky), \quad k = \frac{n\pi}{L}, \quad \omega = \sqrt{2}\, k c_S",
        ),
    )
