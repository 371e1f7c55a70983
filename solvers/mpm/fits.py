"""Least-squares fits of fields to the particles of a cell by Taylor polynomials about its middle, and their values at Gauss points."""

import math
import operator
from functools import reduce
from typing import NamedTuple

from mpmverify.problem import Array

from ..tracing import Variable, absolute, for_range, load_row, logical_not, maximum, minimum, sqrt, traced, when, where
from .vectors import Vector, axpy, scale

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

DETERMINED = 1e-3
"""A function is dropped when the functions before it explain all but this part of its sum of squares."""
MEAN, MEAN_SQUARE = 1 / 12, 1 / 180
"""Means over a cell of x^2 about its middle, and of (x^2 - 1/12)^2."""
TWO, THREE = math.sqrt(1 / 12), math.sqrt(3 / 20)
"""Distances of the outer ones of two and of three Gauss points from the middle of a cell, in cells."""


FITTED, OPEN, POPULATION, SUMS = range(4)
"""Columns of a cell: whether it is fitted, whether it lies at a loaded face, its number of particles, and the first of the sums of the
conserved densities (mass, momentum, body force)."""


class Parts(NamedTuple):
    """Numbers of functions and fields of a cell, and its columns.

    functions : int
        Number k of Taylor functions.
    fields : int
        Number f of fields: the conserved densities, then minus the stress by columns.
    conserved : int
        Number of the conserved densities.
    products : int
        First column of the sums of products of the functions (k, k).
    densities : int
        First column of the sums of products of the functions with the fields (k, f), later the coefficients of the fits.
    """

    functions: int
    fields: int
    conserved: int
    products: int
    densities: int


@traced
def parts_of(taylor: Vector, zero: Vector) -> Parts:
    """Parts of a cell for the number of Taylor functions in `taylor` and the dimension of the vector `zero`."""
    d, k = len(zero), len(taylor)
    conserved = 1 + 2 * d
    return Parts(k, conserved + d * d, conserved, SUMS + conserved, SUMS + conserved + k * k)


@traced
def taylor(width, xi: Vector):
    """Taylor functions at xi (d,) in cells from the lower corner of a cell: 1, x, ... and, except for hats, x^2 - 1/12, x y, ..."""
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
    """Replace the products of the functions by their Cholesky factor; return how many functions are determined, by whole degrees."""
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
        # Particles close to the middle of the cell hardly determine a slope: compare with particles all over the cell.
        usual = cell[A] * cell[A] * where(i > d, MEAN_SQUARE, MEAN)
        enough = rest.value > DETERMINED * where(i > 0, maximum(square, usual), square)
        determined.value = where(enough, k, where(i > d, 1 + d, minimum(i, 1)))
        with when(enough):
            cell[A + k * i + i] = sqrt(rest.value)
    return determined.value


@traced
def solve(cell: Array, parts: Parts, determined: int, volume: float) -> None:
    """Replace the products with the fields by the coefficients of the fits, 0 for functions that are not determined.

    The first coefficient is the mean over the cell; for conserved densities it is their sum over the volume.
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
    """Replace the fits of the conserved densities by their means where the mass density might not be positive all over the cell.

    No Taylor function is larger than 1/2 there.
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
    """Values of the fits of as many fields as `like` has, from column `first` on, where the functions have these values."""
    value = scale(0.0, like)
    for i in range(len(functions)):
        value = axpy(functions[i], load_row(cells, (c, first + stride * i), like), value)
    return value


@traced
def fitted_columns(cells: Array, c: int, first: int, stride: int, functions, zero: Vector):
    """Columns of a tensor of fits, as `fitted`."""
    d = len(zero)
    return tuple(fitted(cells, c, first + d * k, stride, functions, zero) for k in range(d))


@traced
def gauss_points(width):
    """Gauss points on [0, 1] and their weights, exact for hats times linear fits, else for cubic splines times quadratic fits."""
    if len(width) == 2:
        return (0.5 - TWO, 0.5 + TWO), (0.5, 0.5)
    return (0.5 - THREE, 0.5, 0.5 + THREE), (5 / 18, 4 / 9, 5 / 18)


@traced
def gauss_point(width, number: int, like: Vector):
    """Gauss point of a number, x fastest, in cells from the lower corner of a cell (d,), and its weight."""
    points, weights = gauss_points(width)
    count, d = len(points), len(like)
    along = [number // count**k % count for k in range(d)]
    return tuple(numbered(points, i) for i in along), reduce(operator.mul, [numbered(weights, i) for i in along])


@traced
def numbered(items, i: int):
    """Item i of a tuple of numbers, for a number i of compiled code."""
    return where(i < 1, items[0], numbered(items[1:], i - 1)) if len(items) > 1 else items[0]
