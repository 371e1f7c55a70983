"""Vectors as tuples of numbers or lanes; numba knows their length and drops the branches of the others."""

from functools import partial, reduce

from numba.core import cgutils, types

from .compilation import jit
from .lanes import LANES, as_tuple, both, intrinsic, largest, plus, times, unpacked, value_of

# What numba calls while it compiles has types of its own.
# mypy: disable-error-code="no-untyped-def"

Vector = tuple[float, ...]
TINY = 1e-200


@intrinsic
def axpy(typingctx, a, x, y):
    """Sum a x + y of vectors."""

    def code(context, builder, sig, args):
        factor = value_of(context, builder, a, args[0])
        pairs = zip(*unpacked(builder, args[1:]), strict=True)
        return as_tuple(context, builder, sig, [plus(builder, times(builder, factor, p), q) for p, q in pairs])

    lanewise = LANES in (a, x.dtype, y.dtype)
    return types.UniTuple(LANES if lanewise else types.float64, x.count)(a, x, y), code


@intrinsic
def scale(typingctx, a, x):
    """Product a x with a vector."""

    def code(context, builder, sig, args):
        factor = value_of(context, builder, a, args[0])
        return as_tuple(context, builder, sig, [times(builder, factor, p) for p in cgutils.unpack_tuple(builder, args[1])])

    return types.UniTuple(LANES if LANES in (a, x.dtype) else types.float64, x.count)(a, x), code


@intrinsic
def by_components(typingctx, x, y):
    """Products of the components of vectors."""

    def code(context, builder, sig, args):
        pairs = zip(*unpacked(builder, args), strict=True)
        return as_tuple(context, builder, sig, [times(builder, p, q) for p, q in pairs])

    return types.UniTuple(LANES if LANES in (x.dtype, y.dtype) else types.float64, x.count)(x, y), code


@intrinsic
def less(typingctx, x, a):
    """Components of a vector less a value."""

    def code(context, builder, sig, args):
        items = cgutils.unpack_tuple(builder, args[0])
        return as_tuple(context, builder, sig, [builder.fsub(*both(builder, item, args[1])) for item in items])

    return types.UniTuple(LANES if LANES in (x.dtype, a) else types.float64, x.count)(x, a), code


@intrinsic
def dot(typingctx, x, y):
    """Product x . y of vectors."""

    def code(context, builder, sig, args):
        pairs = zip(*unpacked(builder, args), strict=True)
        return reduce(partial(plus, builder), [times(builder, p, q) for p, q in pairs])

    return (LANES if LANES in (x.dtype, y.dtype) else types.float64)(x, y), code


@jit
def cross(x: Vector, v: Vector) -> Vector:
    """Product x cross v: its component out of the plane in two dimensions, 0 in one."""
    if len(x) == 1:
        return (0.0,)
    if len(x) == 2:
        return (x[0] * v[1] - x[1] * v[0],)
    return (x[1] * v[2] - x[2] * v[1], x[2] * v[0] - x[0] * v[2], x[0] * v[1] - x[1] * v[0])


@jit
def axial(T: Vector) -> Vector:
    """Sum of x cross v over a row-major sum of v x^T, as `cross`."""
    if len(T) == 1:
        return (0.0,)
    if len(T) == 4:
        return (T[2] - T[1],)
    return (T[7] - T[5], T[2] - T[6], T[3] - T[1])


@jit
def columns(T: Vector, factor: Vector) -> tuple[Vector, ...]:
    """Columns of a row-major tensor, each times its factor."""
    if len(T) == 1:
        return ((factor[0] * T[0],),)
    if len(T) == 4:
        return (factor[0] * T[0], factor[0] * T[2]), (factor[1] * T[1], factor[1] * T[3])
    return (
        (factor[0] * T[0], factor[0] * T[3], factor[0] * T[6]),
        (factor[1] * T[1], factor[1] * T[4], factor[1] * T[7]),
        (factor[2] * T[2], factor[2] * T[5], factor[2] * T[8]),
    )


@jit
def with_mass(m: float, v: Vector) -> Vector:
    """Mass and momentum, (m, m v)."""
    if len(v) == 1:
        return (m, m * v[0])
    if len(v) == 2:
        return (m, m * v[0], m * v[1])
    return (m, m * v[0], m * v[1], m * v[2])


@jit
def constant(a: float, like: Vector) -> Vector:
    """As many times a as `like` is long."""
    if len(like) == 1:
        return (a,)
    if len(like) == 2:
        return (a, a)
    return (a, a, a)


@jit
def quotient(a: float, x: Vector) -> Vector:
    """Each a/x; nothing of nothing, at x = 0."""
    if len(x) == 1:
        return (a / largest(x[0], TINY),)
    if len(x) == 2:
        return (a / largest(x[0], TINY), a / largest(x[1], TINY))
    return (a / largest(x[0], TINY), a / largest(x[1], TINY), a / largest(x[2], TINY))


@jit
def null(like: Vector) -> tuple[Vector, Vector, Vector]:
    """Null vector, tensor and symmetric tensor of the dimension of a vector."""
    if len(like) == 1:
        return (0.0,), (0.0,), (0.0,)
    if len(like) == 2:
        return (0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit
def identity(like: Vector) -> Vector:
    """Row-major identity of the dimension of a tensor."""
    if len(like) == 1:
        return (1.0,)
    if len(like) == 4:
        return (1.0, 0.0, 0.0, 1.0)
    return (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@jit
def dyad(v: Vector, a: Vector) -> Vector:
    """Row-major tensor v a^T."""
    if len(v) == 1:
        return (v[0] * a[0],)
    if len(v) == 2:
        return (v[0] * a[0], v[0] * a[1], v[1] * a[0], v[1] * a[1])
    x, y, z = a
    return (v[0] * x, v[0] * y, v[0] * z, v[1] * x, v[1] * y, v[1] * z, v[2] * x, v[2] * y, v[2] * z)


@jit
def combination(T: tuple[Vector, ...], a: Vector) -> Vector:
    """Sum of vectors T_k (d, d) times a_k."""
    if len(T) == 1:
        return scale(a[0], T[0])
    if len(T) == 2:
        return axpy(a[0], T[0], scale(a[1], T[1]))
    return axpy(a[0], T[0], axpy(a[1], T[1], scale(a[2], T[2])))


@jit
def by_columns(T: Vector, factor: Vector) -> Vector:
    """Row-major tensor with each column times its factor."""
    if len(T) == 1:
        return (T[0] * factor[0],)
    if len(T) == 4:
        return (T[0] * factor[0], T[1] * factor[1], T[2] * factor[0], T[3] * factor[1])
    x, y, z = factor
    return (T[0] * x, T[1] * y, T[2] * z, T[3] * x, T[4] * y, T[5] * z, T[6] * x, T[7] * y, T[8] * z)
