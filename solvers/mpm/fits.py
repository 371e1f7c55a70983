"""Fits of fields to the particles of a cell, by Taylor polynomials about its middle; their values at points of Gauss."""

import math
import operator
from functools import reduce
from typing import NamedTuple

from mpmverify.problem import Array

from ..tracing import Variable, absolute, for_range, load_row, logical_not, maximum, minimum, sqrt, traced, when, where
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


FITTED, OPEN, POPULATION, SUMS = range(4)
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


@traced
def factor(cell: Array, parts: Parts, d: int) -> int:
    """Cholesky factor of the products of the functions in their place, and of how many whole degrees are determined: their functions."""
    A, k = parts.products, parts.functions
    determined = Variable(k, cell.shape[0])
    with for_range(0, k, like=cell) as i, when(determined.value >= k):
        square = cell[A + k * i + i]
        rest = Variable(square)
        with for_range(0, i) as j:
            value = Variable(cell[A + k * i + j])
            with for_range(0, j) as other:
                value.value -= cell[A + k * i + other] * cell[A + k * j + other]
            value.value /= cell[A + k * j + j]
            cell[A + k * i + j] = value.value
            rest.value -= value.value * value.value
        # Particles that gather in the middle of the cell have next to no slope to tell.
        usual = cell[A] * cell[A] * where(i > d, MEAN_SQUARE, MEAN)
        enough = rest.value > DETERMINED * where(i > 0, maximum(square, usual), square)
        determined.value = where(enough, k, where(i > d, 1 + d, minimum(i, 1)))
        with when(enough):
            cell[A + k * i + i] = sqrt(rest.value)
    return determined.value


@traced
def solve(cell: Array, parts: Parts, determined: int, volume: float) -> None:
    """Coefficients of the fits in the place of the products with the fields; those of functions that are not determined are zero.

    The first, which is the mean over the cell, of what is conserved is its sum over the volume.
    """
    A, k, B, stride = parts.products, parts.functions, parts.densities, parts.fields
    with for_range(0, parts.fields, like=cell) as c:
        with for_range(0, determined) as i:
            with for_range(0, i) as j:
                cell[B + stride * i + c] -= cell[A + k * i + j] * cell[B + stride * j + c]
            cell[B + stride * i + c] /= cell[A + k * i + i]
        with for_range(0, determined) as solved:
            i = determined - 1 - solved
            with for_range(i + 1, determined) as j:
                cell[B + stride * i + c] -= cell[A + k * j + i] * cell[B + stride * j + c]
            cell[B + stride * i + c] /= cell[A + k * i + i]
        with for_range(determined, k) as i:
            cell[B + stride * i + c] = 0.0
    with for_range(0, parts.conserved, like=cell) as c:
        cell[B + c] = cell[SUMS + c] / volume


@traced
def keep_positive(cell: Array, parts: Parts) -> None:
    """Means in the place of the fits of what is conserved, where the density might not be positive all over the cell.

    No Taylor function is larger than a half there.
    """
    B, stride = parts.densities, parts.fields
    reach = reduce(operator.add, [0.5 * absolute(cell[B + stride * i]) for i in range(1, parts.functions)])
    with (
        when(logical_not(reach < cell[B])),
        for_range(1, parts.functions, like=cell) as i,
        for_range(0, parts.conserved, like=cell) as c,
    ):
        cell[B + stride * i + c] = 0.0


@traced
def fitted(cells: Array, c: int, first: int, stride: int, functions, like):
    """Values of fits of a cell where its functions have these values, from a field on, as many as `like` has."""
    value = scale(0.0, like)
    for i in range(len(functions)):
        value = axpy(functions[i], load_row(cells, (c, first + stride * i), like), value)
    return value


@traced
def fitted_columns(cells: Array, c: int, first: int, stride: int, functions, zero: Vector):
    """The same of a tensor, by columns."""
    d = len(zero)
    return tuple(fitted(cells, c, first + d * k, stride, functions, zero) for k in range(d))


@traced
def gauss_points(width):
    """Points on [0, 1] and their weights: exact for hats and linear fits, and for cubic splines and quadratic fits."""
    if len(width) == 2:
        return (0.5 - TWO, 0.5 + TWO), (0.5, 0.5)
    return (0.5 - THREE, 0.5, 0.5 + THREE), (5 / 18, 4 / 9, 5 / 18)


@traced
def gauss_point(width, number: int, like: Vector):
    """Point of a cell (d,) in cells from its lower corner, and the weight of its products; numbered with x fastest."""
    points, weights = gauss_points(width)
    count, d = len(points), len(like)
    along = [number // count**k % count for k in range(d)]
    return tuple(numbered(points, i) for i in along), reduce(operator.mul, [numbered(weights, i) for i in along])


@traced
def numbered(items, i: int):
    """One of a tuple of numbers."""
    return where(i < 1, items[0], numbered(items[1:], i - 1)) if len(items) > 1 else items[0]
