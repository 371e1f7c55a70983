"""Tensors as tuples of numbers or lanes, in one, two and three dimensions.

A tensor is a row-major tuple, (xx,), (xx, xy, yx, yy) or nine components; a symmetric one is (xx,), (xx, yy, xy) or
(xx, yy, zz, xy, yz, zx), a shear component standing for both of its places and not doubled.
"""

import operator
from functools import reduce
from math import pi

from ..tracing import acos, asinh, atanh, cos, log, maximum, minimum, sqrt, traced, where
from .vectors import DIMENSION, cross, dot

# Numbers and lanes of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"

Tensor = tuple[float, ...]
Symmetric = tuple[float, ...]
PLACES = {
    1: ((0, 0),),
    3: ((0, 0), (1, 1), (0, 1)),
    6: ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)),
}
"""Row and column of each component of a symmetric tensor, by the number of components."""
SYMMETRIC = {1: PLACES[1], 2: PLACES[3], 3: PLACES[6]}
"""The same, by dimension."""


@traced
def det(F: Tensor) -> float:
    """Determinant."""
    if len(F) == 1:
        return F[0]
    if len(F) == 4:
        return F[0] * F[3] - F[1] * F[2]
    return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6])


@traced
def deform(dL: Tensor, F: Tensor) -> Tensor:
    """(I + dL) F: the deformation gradient after the increment dL = dt dv/dx."""
    d = DIMENSION[len(F)]
    return tuple(
        reduce(operator.add, [dL[d * i + k] * F[d * k + j] for k in range(d)], F[d * i + j]) for i in range(d) for j in range(d)
    )


@traced
def left_cauchy_green(F: Tensor) -> Symmetric:
    """Left Cauchy-Green tensor b = F F^T."""
    d = DIMENSION[len(F)]
    return tuple(dot(F[d * i : d * i + d], F[d * j : d * j + d]) for i, j in SYMMETRIC[d])


@traced
def sym(L: Tensor) -> Symmetric:
    """(L + L^T)/2."""
    d = DIMENSION[len(L)]
    return tuple(L[d * i + j] if i == j else 0.5 * (L[d * i + j] + L[d * j + i]) for i, j in SYMMETRIC[d])


@traced
def full(A: Symmetric) -> Tensor:
    """All components of a symmetric tensor."""
    d, place = dimension(A), {frozenset(ij): k for k, ij in enumerate(PLACES[len(A)])}
    return tuple(A[place[frozenset((i, j))]] for i in range(d) for j in range(d))


@traced
def cofactor(F: Tensor) -> Tensor:
    """J F^-T without a division: its rows are cross products of the rows of F."""
    if len(F) == 1:
        return (1.0,)
    if len(F) == 4:
        return (F[3], -F[2], -F[1], F[0])
    a, b, c = F[:3], F[3:6], F[6:]
    return (*cross(b, c), *cross(c, a), *cross(a, b))


@traced
def first_piola_kirchhoff(sigma: Symmetric, F: Tensor) -> Tensor:
    """P = J sigma F^-T."""
    d, A, C = DIMENSION[len(F)], full(sigma), cofactor(F)
    return tuple(dot(A[d * i : d * i + d], C[j::d]) for i in range(d) for j in range(d))


@traced
def dimension(A: Symmetric) -> int:
    """Number of normal components that are stored."""
    return {1: 1, 3: 2, 6: 3}[len(A)]


@traced
def trace(A: Symmetric) -> float:
    """Sum of the normal components that are stored."""
    return reduce(operator.add, A[: dimension(A)])


@traced
def ddot(A: Symmetric, B: Symmetric) -> float:
    """A : B."""
    d = dimension(A)
    normal = dot(A[:d], B[:d])
    return normal + 2 * dot(A[d:], B[d:]) if d > 1 else normal


@traced
def shifted(p: float, q: float, A: Symmetric) -> Symmetric:
    """Sum p I + q A."""
    d = dimension(A)
    return tuple(p + q * x if k < d else q * x for k, x in enumerate(A))


@traced
def combined(p: float, A: Symmetric, q: float, B: Symmetric) -> Symmetric:
    """Sum p A + q B."""
    return tuple(p * x + q * y for x, y in zip(A, B, strict=True))


@traced
def squared(A: Symmetric) -> Symmetric:
    """A A."""
    return left_cauchy_green(full(A))


@traced
def logarithm(b: Symmetric, J: float) -> Symmetric:
    """Logarithm of b = F F^T with J = det F.

    Notes
    -----
    In two dimensions ln b = ln J I + asinh(r/J)/r (b - m I), where m +- r are the eigenvalues of b and m^2 - r^2 = J^2. There is
    no difference of near numbers, however small or large the strain.
    """
    if len(b) == 1:
        return (2 * log(J),)
    if len(b) == 3:
        m, half = 0.5 * (b[0] + b[1]), 0.5 * (b[0] - b[1])
        r = sqrt(half * half + b[2] * b[2])
        q = where(r > 0, asinh(r / J) / r, 1 / J)
        return shifted(log(J) - q * m, q, b)
    return interpolated_logarithm(b)


@traced
def interpolated_logarithm(b: Symmetric) -> Symmetric:
    """Logarithm in three dimensions, by Newton's interpolation of ln at the eigenvalues x >= y >= z of b.

    Notes
    -----
    ln b = ln x I + [x, y] (b - x I) + [x, y, z] (b - x I)(b - y I) with the divided differences of ln. Its error is
    proportional to the product of the errors of the nodes x, y and z: where two eigenvalues nearly meet, the trigonometric formula
    loses half of their digits and the interpolation none. Eigenvectors are not needed.

    References
    ----------
    Smith, 1961, doi:10.1145/355578.366316 (eigenvalues); Higham, Functions of Matrices, 2008, section 1.2.2.
    """
    x, y, z = eigenvalues(b)
    xy, yz = divided_difference(x, y), divided_difference(y, z)
    xyz = where(x > z, (xy - yz) / (x - z), 0.0)  # b - x I vanishes with x - z
    return combined(xyz, squared(b), 1.0, shifted(log(x) - x * xy + x * y * xyz, xy - (x + y) * xyz, b))


@traced
def divided_difference(x: float, y: float) -> float:
    """(ln x - ln y)/(x - y), or its limit 1/x."""
    return where(x > y, 2 * atanh((x - y) / (x + y)) / (x - y), 1 / x)


@traced
def eigenvalues(b: Symmetric) -> tuple[float, float, float]:
    """Eigenvalues in descending order of a symmetric tensor in three dimensions."""
    m = trace(b) / 3
    deviator = shifted(-m, 1.0, b)
    p = sqrt(ddot(deviator, deviator) / 6)
    cosine = where(p > 0, 0.5 * det(full(shifted(0.0, 1 / p, deviator))), 1.0)
    angle = acos(minimum(maximum(cosine, -1.0), 1.0)) / 3
    x, z = m + 2 * p * cos(angle), m + 2 * p * cos(angle + 2 * pi / 3)
    return x, 3 * m - x - z, z
