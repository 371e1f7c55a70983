"""Von Neumann limits of stability of the material point method in one dimension, at frozen positions away from the ends."""

from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from mpmverify.exact.dispersion import symbols
from mpmverify.problem import Array

SAMPLES = 2048
"""Phase angles among which the least is looked for first."""


def squared_limit(theta: Array, ppc: int, *, schedule: str, degree: int, terms: int = 0, full_mass: bool = True) -> Array:
    """Square of the Courant number up to which the mode of a phase angle is stable (n,) [1].

    Parameters
    ----------
    theta : Array
        Phase angles k h (n,) [rad], in (0, pi].
    ppc : int
        Particles per cell, at (i + 1/2)/ppc.
    schedule : {"USF", "USL", "MUSL"}
        USL with a series.
    degree : {1, 2, 3}
        Of the B-splines.
    terms : int
        k of FMPM(k) or XPIC(k), 1 for PIC; 0 for FLIP.
    full_mass : bool
        Whether a series is that of FMPM.

    Notes
    -----
    With A and D of `symbols`, and q = nu_C^2 D, a step multiplies velocity and strain by a matrix of trace T and determinant d; its
    eigenvalues stay within the unit circle while d <= 1 and |T| <= 1 + d, of which -T <= 1 + d is the one that q breaks:

    - USL, FLIP: T = 2 - q, d = 1 - q (1 - A), hence q <= 4/(2 - A): dissipative;
    - USF and MUSL, FLIP: T = 2 - A q, d = 1, hence q <= 4/A: conserving;
    - USL, FMPM(k): w <- R (A w - q e), e <- e + w, with R = [1 - (1 - A)^k]/A: T = 1 + R A - R q, d = R A, hence
      q <= 2 (1 + R A)/R;
    - USL, XPIC(k): w <- R A w - A q e, e <- e + (w - q e) from the old values: T = 1 + R A - q, d = R A - q A (R - 1), hence
      q <= 2 (1 + R A)/[1 + A (R - 1)].

    References
    ----------
    Bardenhagen S. G. (2002). Energy conservation error in the material point method for solid mechanics. Journal of
    Computational Physics 180(1), 383-403, https://doi.org/10.1006/jcph.2002.7103, for what the schedules do to the energy; the
    limits are derived in the notes.
    """
    A, D = symbols(theta, ppc, degree)
    with np.errstate(divide="ignore"):
        if terms:
            R = sum((1 - A) ** j for j in range(terms))
            return np.asarray(2 * (1 + R * A) / (D * (R if full_mass else 1 + A * (R - 1))))
        return np.asarray(4 / (D * (2 - A)) if schedule == "USL" else 4 / (A * D))


def courant_limit(ppc: int, *, schedule: str, degree: int, terms: int = 0, full_mass: bool = True) -> float:
    """Courant number up to which every mode is stable [1]; parameters as of `squared_limit`."""
    of = partial(squared_limit, ppc=ppc, schedule=schedule, degree=degree, terms=terms, full_mass=full_mass)
    theta = np.pi * np.arange(1, SAMPLES + 1) / SAMPLES
    least, width = theta[np.argmin(of(theta))], np.pi / SAMPLES
    # The limit repeats itself beyond pi, mirrored: a least value at pi is an inner one.
    found = minimize_scalar(lambda t: float(of(np.array([t]))[0]), bounds=(least - width, least + width), method="bounded")
    return float(np.sqrt(min(found.fun, of(theta).min())))


BASES = {"linear": 1, "quadratic": 2, "cubic": 3}
TRANSFERS = {"flip": (0, False), "pic": (1, False), "xpic2": (2, False), "fmpm2": (2, True), "fmpm4": (4, True)}
LIMITS = {
    f"mpm-tl-{basis}-{schedule.lower()}-{transfer}": partial(
        courant_limit, schedule=schedule, degree=degree, terms=terms, full_mass=full_mass
    )
    for basis, degree in BASES.items()
    for transfer, (terms, full_mass) in TRANSFERS.items()
    for schedule in (("USL",) if terms else ("USF", "USL", "MUSL"))
}
"""Limit by scheme, a function of the particles per cell."""
