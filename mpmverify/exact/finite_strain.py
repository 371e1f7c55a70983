"""Isotropic hyperelastic bodies: the Cauchy stress of a deformation, and the body force that makes a motion exact.

The force is the exact derivative of the stress along the motion, by complex steps, so that one motion serves every law.
"""

import itertools
import operator
from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any

import numpy as np

from mpmverify.problem import Array, LinearElastic, NeoHookean
from mpmverify.problem.material import Hencky, NeoHookeanSplit, SaintVenantKirchhoff, Yeoh
from mpmverify.problem.quantities import SYMMETRIC

STEP = 1e-40
"""Imaginary step of the derivatives: its square vanishes beside 1, so that nothing is truncated and nothing cancels."""
ABSCISSAE, WEIGHTS = np.polynomial.legendre.leggauss(16)
"""Gauss-Legendre rule of `logarithm`, on [-1, 1]."""

# Arrays may be complex. Tensors have their two indices first, so that every operation runs over whole arrays of points.
Tensor = Any


def volume_change(gradient: Tensor) -> Any:
    """Return J - 1 (...) [1] of a displacement gradient (..., dim, dim).

    J - 1 is the sum of the principal minors of H, without the cancellation of det F - 1.
    """
    H, axes = np.moveaxis(gradient, (-2, -1), (0, 1)), range(gradient.shape[-1])
    return reduce(operator.add, [minor(H, some, some) for order in axes for some in itertools.combinations(axes, order + 1)])


def minor(H: Tensor, rows: tuple[int, ...], columns: tuple[int, ...]) -> Any:
    """Determinant of some rows and columns of a tensor (dim, dim, ...)."""
    if len(rows) == 1:
        return H[rows[0], columns[0]]
    others = [minor(H, rows[1:], columns[:k] + columns[k + 1 :]) for k in range(len(columns))]
    return reduce(operator.add, [(-1) ** k * H[rows[0], columns[k]] * other for k, other in enumerate(others)])


def cofactor(F: Tensor) -> Tensor:
    """Cofactors J F^-T of a tensor (dim, dim, ...)."""
    axes, found = range(len(F)), np.ones_like(F)
    for i, j in itertools.product(axes, repeat=2) if len(F) > 1 else ():
        found[i, j] = (-1) ** (i + j) * minor(F, tuple(k for k in axes if k != i), tuple(k for k in axes if k != j))
    return found


def logarithm(e: Tensor) -> Tensor:
    """Return ln(I + e) of a symmetric tensor (dim, dim, ...) [1].

    Notes
    -----
    ln(I + e) is the integral of e (I + s e)^-1 over s from 0 to 1. By the theorem of Cayley and Hamilton the inverse is a polynomial in
    e, whose coefficients the Gauss-Legendre rule integrates to round-off while the stretches lie between 1/2 and 2. Neither eigenvalues
    nor their differences are needed, and nothing cancels where e is small.

    References
    ----------
    Higham, Functions of Matrices, 2008, sections 11.1 and 11.4, doi:10.1137/1.9780898717778.
    """
    square = dot(e, e)
    first = trace(e)
    second = (first * first - trace(square)) / 2
    third = minor(e, (0, 1, 2), (0, 1, 2)) if len(e) == 3 else 0 * first
    integrals = np.zeros((3, *first.shape), dtype=e.dtype)  # of s^n over the determinant of I + s e, n = 0, 1, 2
    for s, weight in zip((1 + ABSCISSAE) / 2, WEIGHTS / 2, strict=True):
        share = weight / (1 + s * (first + s * (second + s * third)))
        integrals += np.multiply.outer(s ** np.arange(3), share)
    zeroth, linear, quadratic = integrals
    return shifted(third * quadratic, (zeroth + first * linear) * e - linear * square)


def dot(A: Tensor, B: Tensor) -> Tensor:
    """Return A_ik B_kj of tensors (dim, dim, ...)."""
    return sum(A[:, k, None] * B[k] for k in range(len(B)))


def trace(A: Tensor) -> Any:
    """Return A_kk of a tensor (dim, dim, ...)."""
    return np.einsum("kk...->...", A)


def shifted(value: Any, A: Tensor) -> Tensor:
    """Return A + value I of a tensor (dim, dim, ...) and numbers (...)."""
    found = np.array(A)
    found[range(len(A)), range(len(A))] += value
    return found


# Laws: the Kirchhoff stress tau = J sigma (dim, dim, ...) [Pa] of J - 1 (...) and e = b - I (dim, dim, ...) [1], b = F F^T. In less than
# three dimensions the other stretches are 1.


def neo_hookean(law: NeoHookean, change: Any, e: Tensor) -> Tensor:
    """Return tau = lambda ln(J) I + mu (b - I)."""
    return shifted(law.lame_lambda * np.log1p(change), law.shear_modulus * e)


def hencky(law: Hencky, change: Any, e: Tensor) -> Tensor:
    """Return tau = lambda ln(J) I + mu ln b."""
    return shifted(law.lame_lambda * np.log1p(change), law.shear_modulus * logarithm(e))


def saint_venant_kirchhoff(law: SaintVenantKirchhoff, change: Any, e: Tensor) -> Tensor:
    """Return tau = F S F^T = [lambda tr(b - I)/2 I + mu (b - I)] b."""
    inner = shifted(law.lame_lambda * trace(e) / 2, law.shear_modulus * e)
    return inner + dot(inner, e)


def neo_hookean_split(law: NeoHookeanSplit, change: Any, e: Tensor) -> Tensor:
    """Return tau = K (J^2 - 1)/2 I + mu J^(-2/3) dev b."""
    return uncoupled(law, law.shear_modulus, change, e)


def yeoh(law: Yeoh, change: Any, e: Tensor) -> Tensor:
    """Return the stress of the split neo-Hookean law with mu replaced by 2 dW/dx, x = J^(-2/3) tr b - 3."""
    x = isochoric(change) * (trace(e) + 3) - 3
    return uncoupled(law, law.shear_modulus + 4 * law.second * x + 6 * law.third * x * x, change, e)


def uncoupled(law: LinearElastic, shear: Any, change: Any, e: Tensor) -> Tensor:
    """Return K (J^2 - 1)/2 I + shear J^(-2/3) dev b, where shear (...) may vary with the strain."""
    bulk = law.lame_lambda + 2 * law.shear_modulus / 3
    shape = shear * isochoric(change)
    return shifted(bulk / 2 * change * (2 + change) - shape * trace(e) / 3, shape * e)


def isochoric(change: Any) -> Any:
    """Return J^(-2/3) of J - 1."""
    return np.exp(-2 / 3 * np.log1p(change))


KIRCHHOFF: Mapping[type[LinearElastic], Callable[..., Tensor]] = {
    NeoHookean: neo_hookean,
    NeoHookeanSplit: neo_hookean_split,
    Hencky: hencky,
    SaintVenantKirchhoff: saint_venant_kirchhoff,
    Yeoh: yeoh,
}
"""Kirchhoff stress of every hyperelastic material."""


def kirchhoff_stress(law: LinearElastic, H: Tensor) -> tuple[Any, Tensor]:
    """Return J - 1 and the Kirchhoff stress [Pa] of a displacement gradient (dim, dim, ...)."""
    change = volume_change(np.moveaxis(H, (0, 1), (-2, -1)))
    strain = H + np.swapaxes(H, 0, 1) + dot(H, np.swapaxes(H, 0, 1))  # b - I, without cancellation
    return change, KIRCHHOFF[type(law)](law, change, strain)


def cauchy_stress(law: LinearElastic, gradient: Array) -> Array:
    """Return the Cauchy stress (..., components) [Pa] of a displacement gradient.

    Parameters
    ----------
    law : LinearElastic
        A material of `KIRCHHOFF`.
    gradient : Array
        H (..., dim, dim) [1].

    References
    ----------
    Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2008, chapter 6; Yeoh, 1993, doi:10.5254/1.3538343.
    """
    change, tau = kirchhoff_stress(law, np.moveaxis(gradient, (-2, -1), (0, 1)))
    return np.moveaxis(independent(tau / (1 + change)), 0, -1)


def independent(symmetric: Tensor) -> Tensor:
    """Return the independent components (components, ...) of a symmetric tensor (dim, dim, ...), in the order of `SYMMETRIC`."""
    pairs = SYMMETRIC.get(len(symmetric), ("xx",))
    return np.stack([symmetric["xyz".index(pair[0]), "xyz".index(pair[1])] for pair in pairs])


def body_force(law: LinearElastic, gradient: Array, second: Array, acceleration: Array) -> Array:
    """Return the body force b = u_tt - Div P/rho (T, P, dim) [m/s^2] for which a motion is exact.

    Parameters
    ----------
    law : LinearElastic
        A material of `KIRCHHOFF`.
    gradient : Array
        H (T, P, dim, dim) [1].
    second : Array
        d^2 u_i/dX_j dX_k (T, P, dim, dim, dim) [1/m].
    acceleration : Array
        u_tt (T, P, dim) [m/s^2].

    Notes
    -----
    (Div P)_i is the sum over j of dP_ij/dX_j, the derivative of P = tau F^-T in the direction dH/dX_j: the imaginary part of
    P(H + i s dH/dX_j) over s.

    References
    ----------
    Squire W., Trapp G. (1998). Using complex variables to estimate derivatives of real functions. SIAM Review 40(1), 110-112,
    doi:10.1137/S003614459631241X.
    """
    H = np.ascontiguousarray(np.moveaxis(gradient, (-2, -1), (0, 1)))
    along = np.ascontiguousarray(np.moveaxis(second, (-1, -3, -2), (0, 1, 2)))
    divergence = np.zeros(H.shape[1:])
    for j, slope in enumerate(along):
        moved = H + 1j * STEP * slope
        change, tau = kirchhoff_stress(law, moved)
        column = sum(tau[:, k] * normal for k, normal in enumerate(cofactor(shifted(1.0, moved))[:, j])) / (1 + change)
        divergence += column.imag / STEP
    return acceleration - np.moveaxis(divergence, 0, -1) / law.density
