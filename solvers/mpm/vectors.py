"""Vectors as tuples of numbers or lanes."""

import operator
from functools import reduce

from ..tracing import maximum, traced

# Numbers and lanes of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"

Vector = tuple[float, ...]
TINY = 1e-200
DIMENSION = {1: 1, 4: 2, 9: 3}
"""Dimension of a row-major tensor by its number of components."""


@traced
def axpy(a, x, y):
    """Sum a x + y of vectors."""
    return tuple(a * p + q for p, q in zip(x, y, strict=True))


@traced
def scale(a, x):
    """Product a x with a vector."""
    return tuple(a * p for p in x)


@traced
def by_components(x, y):
    """Products of the components of vectors."""
    return tuple(p * q for p, q in zip(x, y, strict=True))


@traced
def less(x, a):
    """Components of a vector minus a value."""
    return tuple(p - a for p in x)


@traced
def dot(x, y):
    """Product x . y of vectors."""
    return reduce(operator.add, [p * q for p, q in zip(x, y, strict=True)])


@traced
def cross(x: Vector, v: Vector) -> Vector:
    """Product x cross v: its component out of the plane in two dimensions, 0 in one."""
    if len(x) == 1:
        return (0.0,)
    if len(x) == 2:
        return (x[0] * v[1] - x[1] * v[0],)
    return tuple(x[i - 2] * v[i - 1] - x[i - 1] * v[i - 2] for i in range(3))


@traced
def axial(T: Vector) -> Vector:
    """Sum of x cross v, as `cross` gives it, from the row-major sum of v x^T."""
    if len(T) == 1:
        return (0.0,)
    return (T[2] - T[1],) if len(T) == 4 else (T[7] - T[5], T[2] - T[6], T[3] - T[1])


@traced
def columns(T: Vector, factor: Vector) -> tuple[Vector, ...]:
    """Columns of a row-major tensor, each times its factor."""
    return tuple(scale(a, T[k :: len(factor)]) for k, a in enumerate(factor))


@traced
def with_mass(m: float, v: Vector) -> Vector:
    """Mass and momentum, (m, m v)."""
    return (m, *scale(m, v))


@traced
def constant(a: float, like: Vector) -> Vector:
    """Tuple of a, as long as `like`."""
    return (a,) * len(like)


@traced
def quotient(a: float, x: Vector) -> Vector:
    """Each a/x; 0 where a and x are 0."""
    return tuple(a / maximum(p, TINY) for p in x)


@traced
def null(like: Vector) -> tuple[Vector, Vector, Vector]:
    """Null vector, tensor and symmetric tensor of the dimension of a vector."""
    d = len(like)
    return (0.0,) * d, (0.0,) * d**2, (0.0,) * (d * (d + 1) // 2)


@traced
def identity(like: Vector) -> Vector:
    """Row-major identity of the dimension of a tensor."""
    d = DIMENSION[len(like)]
    return tuple(1.0 if i == j else 0.0 for i in range(d) for j in range(d))


@traced
def dyad(v: Vector, a: Vector) -> Vector:
    """Row-major tensor v a^T."""
    return tuple(p * q for p in v for q in a)


@traced
def combination(T: tuple[Vector, ...], a: Vector) -> Vector:
    """Sum of vectors T_k (d, d) times a_k."""
    return tuple(dot(a, components) for components in zip(*T, strict=True))


@traced
def by_columns(T: Vector, factor: Vector) -> Vector:
    """Row-major tensor with each column times its factor."""
    return tuple(component * factor[k % len(factor)] for k, component in enumerate(T))
