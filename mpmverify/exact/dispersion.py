"""Dispersion relations: how far a scheme turns, and damps, an elastic wave in one step on a uniform mesh.

Each gives the factor z of a step on the mode of phase angle theta = k h: arg z = omega dt is the angle of a step, |z| its growth.
The exact one is exp(i nu_C theta). Of a conjugate pair the factor is that of positive frequency.
"""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from mpmverify.exact.amplification import two_step_taylor_galerkin
from mpmverify.problem import Array
from mpmverify.waves import oscillation

Relation = Callable[[Array, float, int], NDArray[np.complex128]]
"""Phase angles k h (n,) [rad], Courant number c dt/h, particles per cell -> factor of a step (n,)."""


def linear_elements(theta: Array, mass: str) -> Array:
    """Semi-discrete dispersion of linear elements, (omega h/c)^2 = 4 sin^2(theta/2)/m(theta), (n,).

    Parameters
    ----------
    theta : Array
        Phase angles k h (n,) [rad].
    mass : {"lumped", "consistent"}
        m = 1, or m = (2 + cos(theta))/3.

    References
    ----------
    T. Belytschko and R. Mullen, On dispersive properties of finite element solutions, in Modern Problems in Elastic Wave
    Propagation, Wiley 1978. T. J. R. Hughes, The Finite Element Method, Prentice-Hall 1987, section 9.1.
    """
    m = (2 + np.cos(theta)) / 3 if mass == "consistent" else 1.0
    return 4 * np.sin(theta / 2) ** 2 / m


def newmark(theta: Array, courant: float, ppc: int, *, mass: str, beta: float) -> NDArray[np.complex128]:
    """Linear elements in time by Newmark's rule with gamma = 1/2.

    Parameters
    ----------
    theta, courant, ppc : Array, float, int
        As of a `Relation`; without particles, `ppc` does not matter.
    mass : {"lumped", "consistent"}
    beta : float
        0 for central differences, 1/4 for the average acceleration.

    Notes
    -----
    4 sin^2(omega dt/2) = q/(1 + beta q), with q = nu_C^2 (omega h/c)^2 of the semi-discrete system; |z| = 1 where it is stable.

    References
    ----------
    T. J. R. Hughes, The Finite Element Method, Prentice-Hall 1987, section 9.1.
    """
    q = courant**2 * linear_elements(theta, mass)
    return oscillation(2 - q / (1 + beta * q), np.ones_like(q))


def taylor_galerkin(theta: Array, courant: float, ppc: int, *, passes: int) -> NDArray[np.complex128]:
    """Two-step Taylor-Galerkin on a bar: each characteristic is advected, so z is the conjugate of the amplification factor.

    References
    ----------
    Donea J. (1984). A Taylor-Galerkin method for convective transport problems. International Journal for Numerical Methods in
    Engineering 20(1), 101-119, https://doi.org/10.1002/nme.1620200108
    """
    return np.conj(two_step_taylor_galerkin(theta, courant, passes))


def material_point(theta: Array, courant: float, ppc: int, *, schedule: str) -> NDArray[np.complex128]:
    """Material points with FLIP on the linear basis, at frozen positions (i + 1/2)/ppc in every cell.

    Parameters
    ----------
    theta, courant, ppc : Array, float, int
        As of a `Relation`.
    schedule : {"USF", "USL", "MUSL"}

    Notes
    -----
    With s(theta) = sum_I N_I e^{i theta I} at a particle, transfer to the particles and back multiplies an increment of velocity
    by A = mean_p |s_p|^2, the share that the grid sees of it; gradient and divergence together give D = mean_p |h s'_p|^2. Nodal
    velocity w = v dt and strain measure e obey, with q = nu_C^2 D,

    USF, MUSL: e <- e + w before the force, w <- w - A q e: trace 2 - A q, determinant 1;
    USL:       w <- w - A q e and e <- e + (w - q e) from the old values: trace 2 - q, determinant 1 - q (1 - A).

    A velocity that the grid does not see stays with the particles: the stress is free of it.

    References
    ----------
    S. G. Bardenhagen, Energy conservation error in the material point method for solid mechanics, Journal of Computational
    Physics 180 (2002) 383-403, https://doi.org/10.1006/jcph.2002.7103, for what the schedules do to the energy; the relation is
    derived in the notes.
    """
    xi = (np.arange(ppc) + 0.5) / ppc
    A = 1 - 2 * np.mean(xi * (1 - xi)) * (1 - np.cos(theta))
    q = courant**2 * 4 * np.sin(theta / 2) ** 2
    if schedule == "USL":
        return oscillation(2 - q, 1 - q * (1 - A))
    return oscillation(2 - A * q, np.ones_like(q))


RELATIONS: Mapping[str, Relation] = {
    "fem-p1-lumped-cd": partial(newmark, mass="lumped", beta=0.0),
    "fem-p1-consistent-cd": partial(newmark, mass="consistent", beta=0.0),
    "fem-p1-lumped-newmark": partial(newmark, mass="lumped", beta=0.25),
    "fem-p1-consistent-newmark": partial(newmark, mass="consistent", beta=0.25),
    "tg-lumped": partial(taylor_galerkin, passes=1),
    "tg-consistent-3": partial(taylor_galerkin, passes=3),
    "mpm-tl-linear-usf-flip": partial(material_point, schedule="USF"),
    "mpm-tl-linear-usl-flip": partial(material_point, schedule="USL"),
    "mpm-tl-linear-musl-flip": partial(material_point, schedule="MUSL"),
}
"""Relations by scheme."""
