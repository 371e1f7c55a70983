"""Tensors as tuples of floats, in one, two and three dimensions.

A tensor is a row-major tuple, (xx,), (xx, xy, yx, yy) or nine components; a symmetric one is (xx,), (xx, yy, xy) or
(xx, yy, zz, xy, yz, zx), a shear component standing for both of its places and not doubled. Numba knows the length of a tuple
and drops the branches of the other dimensions before it compiles.
"""

from math import acos, asinh, atanh, cos, log, pi, sqrt

from .compilation import jit

Tensor = tuple[float, ...]
Symmetric = tuple[float, ...]


@jit
def det(F: Tensor) -> float:
    """Determinant."""
    if len(F) == 1:
        return F[0]
    if len(F) == 4:
        return F[0] * F[3] - F[1] * F[2]
    return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6])


@jit
def deform(dL: Tensor, F: Tensor) -> Tensor:
    """(I + dL) F: the deformation gradient after the increment dL = dt dv/dx."""
    if len(F) == 1:
        return (F[0] + dL[0] * F[0],)
    if len(F) == 4:
        return (
            F[0] + dL[0] * F[0] + dL[1] * F[2],
            F[1] + dL[0] * F[1] + dL[1] * F[3],
            F[2] + dL[2] * F[0] + dL[3] * F[2],
            F[3] + dL[2] * F[1] + dL[3] * F[3],
        )
    return (
        F[0] + dL[0] * F[0] + dL[1] * F[3] + dL[2] * F[6],
        F[1] + dL[0] * F[1] + dL[1] * F[4] + dL[2] * F[7],
        F[2] + dL[0] * F[2] + dL[1] * F[5] + dL[2] * F[8],
        F[3] + dL[3] * F[0] + dL[4] * F[3] + dL[5] * F[6],
        F[4] + dL[3] * F[1] + dL[4] * F[4] + dL[5] * F[7],
        F[5] + dL[3] * F[2] + dL[4] * F[5] + dL[5] * F[8],
        F[6] + dL[6] * F[0] + dL[7] * F[3] + dL[8] * F[6],
        F[7] + dL[6] * F[1] + dL[7] * F[4] + dL[8] * F[7],
        F[8] + dL[6] * F[2] + dL[7] * F[5] + dL[8] * F[8],
    )


@jit
def left_cauchy_green(F: Tensor) -> Symmetric:
    """Left Cauchy-Green tensor b = F F^T."""
    if len(F) == 1:
        return (F[0] * F[0],)
    if len(F) == 4:
        return (F[0] * F[0] + F[1] * F[1], F[2] * F[2] + F[3] * F[3], F[0] * F[2] + F[1] * F[3])
    return (
        F[0] * F[0] + F[1] * F[1] + F[2] * F[2],
        F[3] * F[3] + F[4] * F[4] + F[5] * F[5],
        F[6] * F[6] + F[7] * F[7] + F[8] * F[8],
        F[0] * F[3] + F[1] * F[4] + F[2] * F[5],
        F[3] * F[6] + F[4] * F[7] + F[5] * F[8],
        F[6] * F[0] + F[7] * F[1] + F[8] * F[2],
    )


@jit
def sym(L: Tensor) -> Symmetric:
    """(L + L^T)/2."""
    if len(L) == 1:
        return (L[0],)
    if len(L) == 4:
        return (L[0], L[3], 0.5 * (L[1] + L[2]))
    return (L[0], L[4], L[8], 0.5 * (L[1] + L[3]), 0.5 * (L[5] + L[7]), 0.5 * (L[6] + L[2]))


@jit
def spin(L: Tensor) -> tuple[float, ...]:
    """(L - L^T)/2 of a velocity gradient: its component xy in two dimensions, xy, yz and zx in three, 0 in one."""
    if len(L) == 1:
        return (0.0,)
    if len(L) == 4:
        return (0.5 * (L[1] - L[2]),)
    return (0.5 * (L[1] - L[3]), 0.5 * (L[5] - L[7]), 0.5 * (L[6] - L[2]))


@jit
def full(A: Symmetric) -> Tensor:
    """All components of a symmetric tensor."""
    if len(A) == 1:
        return (A[0],)
    if len(A) == 3:
        return (A[0], A[2], A[2], A[1])
    return (A[0], A[3], A[5], A[3], A[1], A[4], A[5], A[4], A[2])


@jit
def cofactor(F: Tensor) -> Tensor:
    """J F^-T, whose rows are cross products of the rows of F, so that none is divided by."""
    if len(F) == 1:
        return (1.0,)
    if len(F) == 4:
        return (F[3], -F[2], -F[1], F[0])
    return (
        F[4] * F[8] - F[5] * F[7],
        F[5] * F[6] - F[3] * F[8],
        F[3] * F[7] - F[4] * F[6],
        F[7] * F[2] - F[8] * F[1],
        F[8] * F[0] - F[6] * F[2],
        F[6] * F[1] - F[7] * F[0],
        F[1] * F[5] - F[2] * F[4],
        F[2] * F[3] - F[0] * F[5],
        F[0] * F[4] - F[1] * F[3],
    )


@jit
def first_piola_kirchhoff(sigma: Symmetric, F: Tensor) -> Tensor:
    """P = J sigma F^-T."""
    if len(F) == 1:
        return (sigma[0],)
    if len(F) == 4:
        return (
            sigma[0] * F[3] - sigma[2] * F[1],
            sigma[2] * F[0] - sigma[0] * F[2],
            sigma[2] * F[3] - sigma[1] * F[1],
            sigma[1] * F[0] - sigma[2] * F[2],
        )
    ax, ay, az, bx, by, bz, cx, cy, cz = cofactor(F)
    xx, yy, zz, xy, yz, zx = sigma
    return (
        xx * ax + xy * bx + zx * cx,
        xx * ay + xy * by + zx * cy,
        xx * az + xy * bz + zx * cz,
        xy * ax + yy * bx + yz * cx,
        xy * ay + yy * by + yz * cy,
        xy * az + yy * bz + yz * cz,
        zx * ax + yz * bx + zz * cx,
        zx * ay + yz * by + zz * cy,
        zx * az + yz * bz + zz * cz,
    )


@jit
def dimension(A: Symmetric) -> int:
    """Number of normal components that are stored."""
    return 3 if len(A) == 6 else (2 if len(A) == 3 else 1)


@jit
def trace(A: Symmetric) -> float:
    """Sum of the normal components that are stored."""
    if len(A) == 1:
        return A[0]
    if len(A) == 3:
        return A[0] + A[1]
    return A[0] + A[1] + A[2]


@jit
def ddot(A: Symmetric, B: Symmetric) -> float:
    """A : B."""
    if len(A) == 1:
        return A[0] * B[0]
    if len(A) == 3:
        return A[0] * B[0] + A[1] * B[1] + 2 * A[2] * B[2]
    return A[0] * B[0] + A[1] * B[1] + A[2] * B[2] + 2 * (A[3] * B[3] + A[4] * B[4] + A[5] * B[5])


@jit
def shifted(p: float, q: float, A: Symmetric) -> Symmetric:
    """Sum p I + q A."""
    if len(A) == 1:
        return (p + q * A[0],)
    if len(A) == 3:
        return (p + q * A[0], p + q * A[1], q * A[2])
    return (p + q * A[0], p + q * A[1], p + q * A[2], q * A[3], q * A[4], q * A[5])


@jit
def combined(p: float, A: Symmetric, q: float, B: Symmetric) -> Symmetric:
    """Sum p A + q B."""
    if len(A) == 1:
        return (p * A[0] + q * B[0],)
    if len(A) == 3:
        return (p * A[0] + q * B[0], p * A[1] + q * B[1], p * A[2] + q * B[2])
    return (
        p * A[0] + q * B[0],
        p * A[1] + q * B[1],
        p * A[2] + q * B[2],
        p * A[3] + q * B[3],
        p * A[4] + q * B[4],
        p * A[5] + q * B[5],
    )


@jit
def squared(A: Symmetric) -> Symmetric:
    """A A."""
    return left_cauchy_green(full(A))


@jit
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
        q = asinh(r / J) / r if r > 0 else 1 / J
        return shifted(log(J) - q * m, q, b)
    return interpolated_logarithm(b)


@jit
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
    xyz = (xy - yz) / (x - z) if x > z else 0.0  # b - x I vanishes with x - z
    return combined(xyz, squared(b), 1.0, shifted(log(x) - x * xy + x * y * xyz, xy - (x + y) * xyz, b))


@jit
def divided_difference(x: float, y: float) -> float:
    """(ln x - ln y)/(x - y), or its limit 1/x."""
    return 2 * atanh((x - y) / (x + y)) / (x - y) if x > y else 1 / x


@jit
def eigenvalues(b: Symmetric) -> tuple[float, float, float]:
    """Eigenvalues in descending order of a symmetric tensor in three dimensions."""
    m = trace(b) / 3
    deviator = shifted(-m, 1.0, b)
    p = sqrt(ddot(deviator, deviator) / 6)
    if p == 0:
        return m, m, m
    angle = acos(min(1.0, max(-1.0, 0.5 * det(full(shifted(0.0, 1 / p, deviator)))))) / 3
    x, z = m + 2 * p * cos(angle), m + 2 * p * cos(angle + 2 * pi / 3)
    return x, 3 * m - x - z, z
