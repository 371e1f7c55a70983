"""Dispersion relations of the schemes for elastic waves on a uniform mesh.

Each relation gives the complex factor z by which one step multiplies the mode of phase angle theta = k h: arg z = omega dt is the
phase advance, |z| the growth per step. The exact factor is exp(i nu_C theta). Of a conjugate pair, z has the positive frequency.
"""

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from mpmverify.exact.amplification import two_step_taylor_galerkin
from mpmverify.exact.waves import front, oscillating_root
from mpmverify.problem import Array

Relation = Callable[[Array, float, int], NDArray[np.complex128]]
"""Phase angles k h (n,) [rad], Courant number c dt/h, particles per cell -> factor z of one step (n,)."""


def linear_elements(theta: Array, mass: str) -> Array:
    """Return (omega h/c)^2 = 4 sin^2(theta/2)/m(theta), (n,), of linear elements in space alone (semi-discrete).

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
    """Relation of linear elements with Newmark's rule, gamma = 1/2.

    Parameters
    ----------
    theta, courant, ppc : Array, float, int
        See `Relation`; `ppc` is ignored.
    mass : {"lumped", "consistent"}
    beta : float
        0 for central differences, 1/4 for the average acceleration.

    Notes
    -----
    4 sin^2(omega dt/2) = q/(1 + beta q) with q = nu_C^2 (omega h/c)^2 of the semi-discrete system; |z| = 1 where it is stable.

    References
    ----------
    T. J. R. Hughes, The Finite Element Method, Prentice-Hall 1987, section 9.1.
    """
    q = courant**2 * linear_elements(theta, mass)
    return oscillating_root(2 - q / (1 + beta * q), np.ones_like(q))


def quadratic_elements(theta: Array, courant: float, ppc: int, *, mass: str) -> NDArray[np.complex128]:
    """Relation of quadratic elements with central differences: the acoustic branch, at a phase angle k h per element.

    Parameters
    ----------
    theta, courant, ppc : Array, float, int
        See `Relation`; `ppc` is ignored.
    mass : {"lumped", "consistent"}

    Notes
    -----
    The amplitudes a of a wave at end nodes and at middle nodes obey K(theta) a = (omega h/c)^2 M(theta) a. The lower of the two
    eigenvalues belongs to the acoustic branch.

    References
    ----------
    T. J. R. Hughes, The Finite Element Method, Prentice-Hall 1987, section 9.1.
    """
    K = np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3
    M = np.diag([1, 4, 1]) / 6 if mass == "lumped" else np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30

    def entries(matrix: Array) -> tuple[Array, float, Array]:
        """Return the entries (end, end), (middle, middle) and (end, middle) of the 2 x 2 matrix of a wave."""
        end = matrix[0, 0] + matrix[2, 2] + 2 * matrix[0, 2] * np.cos(theta)
        return end, matrix[1, 1], 2 * matrix[0, 1] * np.cos(theta / 2)

    (k0, k1, k2), (m0, m1, m2) = entries(K), entries(M)
    a, b, c = m0 * m1 - m2**2, k0 * m1 + k1 * m0 - 2 * k2 * m2, k0 * k1 - k2**2
    q = courant**2 * 2 * c / (b + np.sqrt(b**2 - 4 * a * c))
    return oscillating_root(2 - q, np.ones_like(q))


def taylor_galerkin(theta: Array, courant: float, ppc: int, *, passes: int) -> NDArray[np.complex128]:
    """Relation of two-step Taylor-Galerkin: it advects each characteristic, so z is the conjugate of the amplification factor.

    Parameters
    ----------
    theta, courant, ppc : Array, float, int
        See `Relation`; `ppc` is ignored.
    passes : int
        Passes of the mass iteration; 1 is the lumped mass.

    References
    ----------
    Donea J. (1984). A Taylor-Galerkin method for convective transport problems. International Journal for Numerical Methods in
    Engineering 20(1), 101-119, https://doi.org/10.1002/nme.1620200108
    """
    return np.conj(two_step_taylor_galerkin(theta, courant, passes))


def symbols(theta: Array, ppc: int, degree: int) -> tuple[Array, Array]:
    """Return the Fourier symbols A and D (n,) of the transfers between particles and grid, for B-splines away from the ends.

    A = mean_p |sum_I N_I e^{i theta I}|^2 belongs to the transfer of velocity to the particles and back, and
    D = mean_p |sum_I h N'_I e^{i theta I}|^2 to the gradient and divergence.

    Parameters
    ----------
    theta : Array
        Phase angles k h (n,) [rad].
    ppc : int
        Particles per cell, at (i + 1/2)/ppc.
    degree : {1, 2, 3}
        Degree of the B-splines.
    """
    x = (np.arange(ppc) + 0.5) / ppc
    if degree == 1:
        N, dN = np.stack([1 - x, x]), np.stack([-np.ones(ppc), np.ones(ppc)])
    elif degree == 3:
        y = 1 - x
        N = np.stack([y**3, 4 - 3 * x**2 * (2 - x), 4 - 3 * y**2 * (2 - y), x**3]) / 6
        dN = np.stack([-(y**2), -x * (4 - 3 * x), y * (4 - 3 * y), x**2]) / 2
    else:
        N, dN = np.stack([(1 - x) ** 2, 1 + 2 * x * (1 - x), x**2]) / 2, np.stack([x - 1, 1 - 2 * x, x])
    wave = np.exp(1j * theta[:, None] * np.arange(degree + 1))
    return np.mean(np.abs(wave @ N) ** 2, axis=1), np.mean(np.abs(wave @ dN) ** 2, axis=1)


def material_point(theta: Array, courant: float, ppc: int, *, schedule: str, degree: int) -> NDArray[np.complex128]:
    """Relation of the material point method with FLIP and lumped mass, for particles fixed at (i + 1/2)/ppc in every cell.

    Parameters
    ----------
    theta, courant, ppc : Array, float, int
        See `Relation`.
    schedule : {"USF", "USL", "MUSL"}
        Stress-update schedule.
    degree : {1, 2}
        Degree of the B-splines.

    Notes
    -----
    A transfer to the particles and back multiplies a velocity increment of the grid by A; gradient and divergence together give D,
    see `symbols`. With q = nu_C^2 D, the scaled nodal velocity w = v dt and a strain measure e obey

    USF, MUSL: e <- e + w before the force, then w <- w - A q e: trace 2 - A q, determinant 1;
    USL:       w <- w - A q e and e <- e + (w - q e), both from the old values: trace 2 - q, determinant 1 - q (1 - A).

    The part of the particle velocities that maps to zero on the grid stays with the particles and does not affect the stress.

    References
    ----------
    S. G. Bardenhagen, Energy conservation error in the material point method for solid mechanics, Journal of Computational
    Physics 180 (2002) 383-403, https://doi.org/10.1006/jcph.2002.7103, on the energy of the schedules. The relation is an own
    derivation, given in the notes.
    """
    A, D = symbols(theta, ppc, degree)
    q = courant**2 * D
    if schedule == "USL":
        return oscillating_root(2 - q, 1 - q * (1 - A))
    return oscillating_root(2 - A * q, np.ones_like(q))


RELATIONS: dict[str, Relation] = {
    "fem-p1-lumped-cd": partial(newmark, mass="lumped", beta=0.0),
    "fem-p1-consistent-cd": partial(newmark, mass="consistent", beta=0.0),
    "fem-p1-lumped-newmark": partial(newmark, mass="lumped", beta=0.25),
    "fem-p1-consistent-newmark": partial(newmark, mass="consistent", beta=0.25),
    "fem-p2-lumped-cd": partial(quadratic_elements, mass="lumped"),
    "fem-p2-consistent-cd": partial(quadratic_elements, mass="consistent"),
    "tg-lumped": partial(taylor_galerkin, passes=1),
    "tg-consistent-3": partial(taylor_galerkin, passes=3),
}
"""Relations by solver name; those of updated Lagrangian solvers hold at infinitesimal amplitude."""
RELATIONS |= {
    f"mpm-{formulation}-{basis}-{schedule.lower()}-flip": partial(material_point, schedule=schedule, degree=degree)
    for formulation in ("ul", "tl")
    for degree, basis in ((1, "linear"), (2, "quadratic"))
    for schedule in ("USF", "USL", "MUSL")
}


def leading_errors(relation: str, courant: float, ppc: int = 1) -> tuple[float, float]:
    """Return the leading errors of a scheme for long waves: of second order in the phase, of fourth order in the modulus.

    Parameters
    ----------
    relation : str
        Name in `RELATIONS`.
    courant : float
        nu_C [1].
    ppc : int
        Particles per cell.

    Returns
    -------
    (float, float)
        The coefficient `lag` in omega/(c k) = 1 - lag theta^2 + O(theta^4), negative if the waves are too fast; and `loss` in
        |z| = 1 - loss nu_C theta^4 + O(theta^6).
    """
    theta = np.array([0.1, 0.05])
    z = RELATIONS[relation](theta, courant, ppc)
    lag = (1 - np.angle(z) / (courant * theta)) / theta**2
    loss = -np.log(np.abs(z)) / (courant * theta**4)
    return float((4 * lag[1] - lag[0]) / 3), float((4 * loss[1] - loss[0]) / 3)


def mode_error(relation: str, theta: float, courant: float, steps: int, ppc: int = 1) -> float:
    """Return the largest error of a mode over some steps, relative to its amplitude: max |z^n - exp(i n nu_C theta)|.

    Parameters
    ----------
    relation : str
        Name in `RELATIONS`.
    theta : float
        k h [rad].
    courant : float
        nu_C [1].
    steps : int
        Number of steps.
    ppc : int
        Particles per cell.
    """
    (z,) = RELATIONS[relation](np.array([theta]), courant, ppc)
    n = np.arange(steps + 1)
    exact = np.exp(1j * math.copysign(courant * theta, np.angle(z)) * n)
    return float(np.max(np.abs(z**n - exact)))


@cache
def front_lag(relation: str, courant: float, steps: int, ppc: int = 1) -> float:
    """Return the distance, in cells, by which the middle of a numerical front lags behind the exact jump after some steps.

    Parameters
    ----------
    relation : str
        Name in `RELATIONS`.
    courant : float
        nu_C [1].
    steps : int
        Number n of steps.
    ppc : int
        Particles per cell.

    Notes
    -----
    Each Fourier mode of a jump on a long periodic grid is multiplied by its factor z^n, in a frame that moves with the wave. To leading
    order the front is the integral of an Airy function, which lags by a fraction of its width (3 lag nu_C n)^(1/3) cells.
    """
    cells = 2 ** math.ceil(math.log2(8 * (64 + courant * steps)))
    node = np.arange(cells)
    ring = np.where(node < cells // 2, 1.0, 0.0)
    ring[[0, cells // 2]] = 0.5
    theta = 2 * np.pi * np.arange(cells // 2 + 1) / cells
    factors = (np.conj(RELATIONS[relation](theta, courant, ppc)) * np.exp(1j * courant * theta)) ** steps
    values = np.fft.irfft(np.fft.rfft(ring) * factors, cells)
    half = slice(cells // 4, 3 * cells // 4)
    return cells // 2 - front(node[half], values[half], 0.5)
