"""Fits of fields to the particles of a cell, by Taylor polynomials about its middle; their values at points of Gauss."""

import math
from typing import NamedTuple

from mpmverify.problem import Array

from .compilation import jit
from .memory import row
from .tracing import traced
from .vectors import Vector, axpy, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

DETERMINED = 1e-3
"""Least part of a function's sum of squares over as many particles in all of a cell that those before it do not explain; below, it is
left out."""
MEAN, MEAN_SQUARE = 1 / 12, 1 / 180
"""Of x^2 over a cell about its middle, and of the square of x^2 - 1/12."""
TWO, THREE = math.sqrt(1 / 12), math.sqrt(3 / 20)
"""Distance of the points of two and three of Gauss from the middle of a cell."""


FITTED, OPEN, COUNT, SUMS = range(4)
"""Columns of the sums of a cell, see `Parts`."""


class Parts(NamedTuple):
    """Numbers of k Taylor functions, of f fields, and of those, the first, that are conserved; where the sums of a cell begin.

    Before all others come whether it is fitted, whether it lies at a loaded face, and how many particles it has. Then come the sums of
    what is conserved, mass, momentum and body force, `products` of the functions with each other (k, k), and `densities`, products
    with the fields (k, f): what is conserved, per volume, and minus the stress by columns.
    """

    functions: int
    fields: int
    conserved: int
    products: int
    densities: int


@traced
def parts_of(taylor: Vector, zero: Vector) -> Parts:
    """Parts of the sums of a cell for as many Taylor functions as one tuple has, in as many dimensions as a vector has."""
    d, k = len(zero), len(taylor)
    conserved = 1 + 2 * d
    return Parts(k, conserved + d * d, conserved, SUMS + conserved, SUMS + conserved + k * k)


@traced
def taylor(width, xi: Vector):
    """Taylor functions at a place from the lower corner of a cell, in cells (d,): 1, x, ..., and but for hats x^2 - 1/12, x y, ..."""
    x = xi[0] - 0.5
    one = 0.0 * x + 1.0
    if len(xi) == 1:
        return (one, x) if len(width) == 2 else (one, x, x * x - MEAN)
    y = xi[1] - 0.5
    if len(xi) == 2:
        return (one, x, y) if len(width) == 2 else (one, x, y, x * x - MEAN, x * y, y * y - MEAN)
    z = xi[2] - 0.5
    if len(width) == 2:
        return one, x, y, z
    return one, x, y, z, x * x - MEAN, y * y - MEAN, z * z - MEAN, x * y, y * z, z * x


@jit
def factor(cell: Array, parts: Parts, d: int) -> int:
    """Cholesky factor of the products of the functions in their place, and of how many whole degrees are determined: their functions."""
    A, k = parts.products, parts.functions
    for i in range(k):
        rest = whole = cell[A + k * i + i]
        for j in range(i):
            value = cell[A + k * i + j]
            for other in range(j):
                value -= cell[A + k * i + other] * cell[A + k * j + other]
            value /= cell[A + k * j + j]
            cell[A + k * i + j] = value
            rest -= value * value
        if i > 0:  # particles that gather in the middle of the cell have next to no slope to tell
            whole = max(whole, cell[A] * cell[A] * (MEAN if i <= d else MEAN_SQUARE))
        if not rest > DETERMINED * whole:
            return 1 + d if i > d else min(i, 1)
        cell[A + k * i + i] = math.sqrt(rest)
    return k


@jit
def solve(cell: Array, parts: Parts, determined: int, volume: float) -> None:
    """Coefficients of the fits in the place of the products with the fields; those of functions that are not determined are zero.

    The first, which is the mean over the cell, of what is conserved is its sum over the volume.
    """
    A, k, B, stride = parts.products, parts.functions, parts.densities, parts.fields
    for c in range(parts.fields):
        for i in range(determined):
            for j in range(i):
                cell[B + stride * i + c] -= cell[A + k * i + j] * cell[B + stride * j + c]
            cell[B + stride * i + c] /= cell[A + k * i + i]
        for i in range(determined - 1, -1, -1):
            for j in range(i + 1, determined):
                cell[B + stride * i + c] -= cell[A + k * j + i] * cell[B + stride * j + c]
            cell[B + stride * i + c] /= cell[A + k * i + i]
        for i in range(determined, k):
            cell[B + stride * i + c] = 0.0
    for c in range(parts.conserved):
        cell[B + c] = cell[SUMS + c] / volume


@jit
def keep_positive(cell: Array, parts: Parts) -> None:
    """Means in the place of the fits of what is conserved, where the density might not be positive all over the cell.

    No Taylor function is larger than a half there.
    """
    B, stride, reach = parts.densities, parts.fields, 0.0
    for i in range(1, parts.functions):
        reach += 0.5 * abs(cell[B + stride * i])
    if not reach < cell[B]:
        for i in range(1, parts.functions):
            for c in range(parts.conserved):
                cell[B + stride * i + c] = 0.0


@traced
def fitted(cells: Array, c: int, first: int, stride: int, functions, like):
    """Values of fits of a cell where its functions have these values, from a field on, as many as `like` has."""
    value = scale(0.0, like)
    for i in range(len(functions)):
        value = axpy(functions[i], row(cells, (c, first + stride * i), like), value)
    return value


@traced
def fitted_columns(cells: Array, c: int, first: int, stride: int, functions, zero: Vector):
    """The same of a tensor, by columns."""
    d = len(zero)
    return tuple(fitted(cells, c, first + d * k, stride, functions, zero) for k in range(d))


@jit
def gauss_points(width):
    """Points on [0, 1] and their weights: exact for hats and linear fits, and for cubic splines and quadratic fits."""
    if len(width) == 2:
        return (0.5 - TWO, 0.5 + TWO), (0.5, 0.5)
    return (0.5 - THREE, 0.5, 0.5 + THREE), (5 / 18, 4 / 9, 5 / 18)


@jit
def gauss_point(width, number: int, like: Vector):
    """Point of a cell (d,) in cells from its lower corner, and the weight of its products; numbered with x fastest."""
    points, weights = gauss_points(width)
    count = len(points)
    i, j = number % count, number // count % count
    if len(like) == 1:
        return (points[i],), weights[i]
    if len(like) == 2:
        return (points[i], points[j]), weights[i] * weights[j]
    k = number // count**2
    return (points[i], points[j], points[k]), weights[i] * weights[j] * weights[k]
