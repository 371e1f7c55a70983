"""Von Neumann stability limits of the material point method in one dimension, for fixed particle positions away from the ends."""

from functools import partial

import numpy as np

from mpmverify.exact.dispersion import symbols
from mpmverify.problem import Array

SAMPLES = 2048
"""Number of phase angles of the coarse search for the minimum."""


def squared_limit(theta: Array, ppc: int, *, schedule: str, degree: int, terms: int = 0, full_mass: bool = True) -> Array:
    """Return the square of the Courant number (n,) [1] up to which the mode of each phase angle is stable.

    Parameters
    ----------
    theta : Array
        Phase angles k h (n,) [rad], in (0, pi].
    ppc : int
        Particles per cell, at (i + 1/2)/ppc.
    schedule : {"USF", "USL", "MUSL"}
        Stress-update schedule; must be USL if `terms` is not 0.
    degree : {1, 2, 3}
        Degree of the B-splines.
    terms : int
        Number k of terms of FMPM(k) or XPIC(k), 1 for PIC; 0 for FLIP.
    full_mass : bool
        Whether the series is FMPM, not XPIC; not used for FLIP.

    Notes
    -----
    A and D are the `symbols` and q = nu_C^2 D. One step multiplies velocity and strain by a matrix of trace T and determinant d. Its
    eigenvalues stay in the unit circle if d <= 1 and |T| <= 1 + d; as q grows, -T <= 1 + d is violated first:

    - USL, FLIP: T = 2 - q, d = 1 - q (1 - A), hence q <= 4/(2 - A); dissipative;
    - USF and MUSL, FLIP: T = 2 - A q, d = 1, hence q <= 4/A; energy-conserving;
    - USL, FMPM(k): w <- R (A w - q e), e <- e + w, with R = [1 - (1 - A)^k]/A: T = 1 + R A - R q, d = R A, hence
      q <= 2 (1 + R A)/R;
    - USL, XPIC(k): w <- R A w - A q e, e <- e + (w - q e), both from the old values: T = 1 + R A - q, d = R A - q A (R - 1), hence
      q <= 2 (1 + R A)/[1 + A (R - 1)].

    References
    ----------
    Bardenhagen S. G. (2002). Energy conservation error in the material point method for solid mechanics. Journal of
    Computational Physics 180(1), 383-403, https://doi.org/10.1006/jcph.2002.7103, on the energy of the schedules. The limits are own
    derivations, given in the notes.
    """
    A, D = symbols(theta, ppc, degree)
    with np.errstate(divide="ignore"):
        if terms:
            R = sum((1 - A) ** j for j in range(terms))
            return np.asarray(2 * (1 + R * A) / (D * (R if full_mass else 1 + A * (R - 1))))
        return np.asarray(4 / (D * (2 - A)) if schedule == "USL" else 4 / (A * D))


def courant_limit(ppc: int, *, schedule: str, degree: int, terms: int = 0, full_mass: bool = True) -> float:
    """Return the Courant number up to which every mode is stable [1]; for the parameters see `squared_limit`."""
    from scipy.optimize import minimize_scalar  # takes a third of a second, which most studies do without

    squared = partial(squared_limit, ppc=ppc, schedule=schedule, degree=degree, terms=terms, full_mass=full_mass)
    theta = np.pi * np.arange(1, SAMPLES + 1) / SAMPLES
    nearest, width = theta[np.argmin(squared(theta))], np.pi / SAMPLES
    # The limit is symmetric about pi, so the bracket may extend beyond it.
    found = minimize_scalar(
        lambda t: float(squared(np.array([t]))[0]), bounds=(nearest - width, nearest + width), method="bounded"
    )
    return float(np.sqrt(min(found.fun, squared(theta).min())))


BASES = {"linear": 1, "quadratic": 2, "cubic": 3}
"""Degree of the B-splines by basis."""
TRANSFERS = {"flip": (0, False), "pic": (1, False), "xpic2": (2, False), "fmpm2": (2, True), "fmpm4": (4, True)}
"""`terms` and `full_mass` by transfer."""
LIMITS = {
    f"mpm-tl-{basis}-{schedule.lower()}-{transfer}": partial(
        courant_limit, schedule=schedule, degree=degree, terms=terms, full_mass=full_mass
    )
    for basis, degree in BASES.items()
    for transfer, (terms, full_mass) in TRANSFERS.items()
    for schedule in (("USL",) if terms else ("USF", "USL", "MUSL"))
}
"""Stability limit by solver name, as a function of the particles per cell."""
