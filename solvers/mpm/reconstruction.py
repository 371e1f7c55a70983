"""Taylor least squares: fields are fitted to the particles of each cell, and the integrals of the fits go to the grid.

A fit is a Taylor polynomial about the middle of the cell, with the means of its terms subtracted: of the first degree for hats, else of
the second, or of a lower one where the particles of the cell do not determine more. The fits of the conserved densities (mass, momentum,
body force) have the sum over the particles as their integral, and are constant where the density might not be positive. In a cell at a
loaded face, or beside an empty one, particles are points of quadrature with their volumes, as with the other bases.

References
----------
Wobbes, Moller, Galavi and Vuik, 2019, doi:10.1002/nme.5956.
"""

import math
import operator
from collections.abc import Mapping
from functools import reduce

import numpy as np

from mpmverify.problem import Array, Traction

from ..tracing import (
    add_sums,
    cond,
    for_range,
    for_strides,
    load_row,
    load_rows,
    logical_not,
    maximum,
    reduce_sum,
    traced,
    when,
    where,
)
from .basis import Axis, Basis
from .deformation import force_columns, strain_and_stress
from .fits import (
    FITTED,
    OPEN,
    POPULATION,
    SUMS,
    factor,
    fitted,
    fitted_columns,
    gauss_point,
    gauss_points,
    keep_positive,
    parts_of,
    solve,
    taylor,
)
from .order import Strips
from .places import cell_number
from .splines import ONE
from .state import PASSED, Grid, Nodes, Particles, Scheme, Step, columns_of
from .stencil import Group, group, places
from .tensors import det
from .vectors import null, scale, with_mass

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"


def cells_of(axes: tuple[Axis, ...], basis: Basis, boundary: Mapping[str, object]) -> Array:
    """Zero sums of all cells (C, K), x fastest; none where the basis fits nothing."""
    if not basis.kind.fitted:
        return np.zeros((0, 0))
    d = len(axes)
    parts = parts_of((0.0,) * math.comb(d + min(basis.degree, 2), d), (0.0,) * d)
    cells = np.zeros((*(axis.cells for axis in reversed(axes)), parts.densities + parts.functions * parts.fields))
    for face, condition in boundary.items():
        if isinstance(condition, Traction):
            at_face = np.moveaxis(cells, d - 1 - "xyz".index(face[0]), 0)[0 if face[1] == "-" else -1]
            at_face[..., OPEN] = 1.0
    return cells.reshape(-1, cells.shape[-1])


@traced
def cell_along(grid: Grid, number: int):
    """Numbers along the axes (d,) of the cell of a number."""
    along = []
    for cells in grid.cells[:-1]:
        along.append(number % cells)
        number = number // cells
    return (*along, number)


@traced
def add_products(cell: Array, first: int, stride: int, functions, values) -> None:
    """Add the sums over particles of products of functions with values, a row of `stride` entries for each function."""
    for i in range(len(functions)):
        add_sums(cell, first + stride * i, functions[i], values)


@traced
def add_to_cell(scheme: Scheme, grid: Grid, particles: Particles, some: Group, cell: Array, step: Step) -> None:
    """Add a group of particles to the sums of their cell; body force and stress only if `step.forces`."""
    zero, d, state = null(grid.lower)[0], len(grid.lower), particles.state
    column = columns_of(zero, particles.deformation)
    F, sigma = strain_and_stress(particles, some.numbers, zero)
    m, V0 = load_rows(state, some.numbers, column.mass, (0.0, 0.0))
    V = where(scheme.total, V0, V0 * det(F))
    functions = taylor(grid.width, some.offset)
    parts, there = parts_of(functions, zero), scale(some.present, functions)
    cell[POPULATION] += reduce_sum(some.present)
    add_products(cell, parts.products, parts.functions, there, functions)
    inertia = with_mass(m, load_rows(state, some.numbers, column.velocity, zero))
    add_sums(cell, SUMS, some.present, inertia)
    add_products(cell, parts.densities, parts.fields, scale(1 / V, there), inertia)
    with when(step.forces & (step.body.shape[0] > 0) & logical_not(scheme.nodal_body)):
        weight = scale(m, load_rows(step.body[step.load], places(particles, some.numbers), 0, zero))
        add_sums(cell, SUMS + 1 + d, some.present, weight)
        add_products(cell, parts.densities + 1 + d, parts.fields, scale(1 / V, there), weight)
    with when(step.forces):
        minus_stress = force_columns(scheme, V0 / V, sigma, F, zero)
        for k in range(d):
            add_products(cell, parts.densities + parts.conserved + d * k, parts.fields, there, minus_stress[k])


@traced
def fit_cells(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int, step: Step) -> int:
    """A pass over the particles that adds up the sums of their cells; a particle off the grid is left to `particles_to_grid`."""
    end = strips.particles[s + 1]
    with for_strides(strips.particles[s], end) as (p, advance):
        some = group(scheme, grid, particles, p, end)
        with when(some.size > 0):
            cell = nodes.cells[cell_number(grid, some.first)]
            add_to_cell(scheme, grid, particles, some, cell, step)
        advance(maximum(some.size, 1))
    return PASSED


@traced
def spread_cell(grid: Grid, nodes: Nodes, c: int, volume: float, forces: bool) -> None:
    """Add the integrals of the fits of a cell, times the functions of the grid or their gradients, to the nodes."""
    zero = null(grid.lower)[0]
    d, first = len(zero), cell_along(grid, c)
    with for_range(0, len(gauss_points(grid.width)[0]) ** d, like=c) as number:
        xi, weight = gauss_point(grid.width, number, zero)
        functions = scale(weight * volume, taylor(grid.width, xi))
        parts = parts_of(functions, zero)
        at, B, stride = grid.kind.support(grid, first, xi, None), parts.densities, parts.fields
        at.spread(grid, nodes.inertia, 0, fitted(nodes.cells, c, B, stride, functions, with_mass(0.0, zero)))
        with when(forces):
            at.spread(grid, nodes.external, 0, fitted(nodes.cells, c, B + 1 + d, stride, functions, zero))
            minus_stress = fitted_columns(nodes.cells, c, B + parts.conserved, stride, functions, zero)
            at.spread_tensor(grid, nodes.internal, 0, minus_stress)


@traced
def enclosed(grid: Grid, cells: Array, c: int) -> bool:
    """Whether a cell and its neighbours across all faces have particles; a held end of the grid needs no neighbour."""
    there, stride = (cells[c, OPEN] <= 0) & (cells[c, POPULATION] > 0), 1
    for count, periodic in zip(grid.cells, grid.periodic, strict=True):
        i = c // stride % count
        below = where(i > 0, c - stride, where(periodic, c + stride * (count - 1), c))
        above = where(i < count - 1, c + stride, where(periodic, c - stride * (count - 1), c))
        there = there & (cells[below, POPULATION] > 0) & (cells[above, POPULATION] > 0)
        stride = stride * count
    return there


@traced
def spread_fits(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int, step: Step) -> int:
    """A pass over the cells of a strip: enclosed cells are fitted, and add mass, momentum and, if `step.forces`, forces to the grid.

    The sums are then set to zero, but for the number of particles, which other strips may need, and the mark of fitted cells, which the
    passes over the particles need.
    """
    zero, d = grid.lower, len(grid.lower)
    volume, row_of_cells = reduce(operator.truediv, (grid.scale,) * d, 1.0), reduce(operator.mul, grid.cells[:-1], 1)
    parts = parts_of(taylor(grid.width, zero), zero)
    with for_range(strips.rows[s] * row_of_cells, strips.rows[s + 1] * row_of_cells) as c:
        cell = nodes.cells[c]
        determined = cond(enclosed(grid, nodes.cells, c), lambda: factor(cell, parts, d), 0)
        cell[FITTED] = where(determined > 0, 1.0, 0.0)
        with when(determined > 0):
            solve(cell, parts, determined, volume)
            keep_positive(cell, parts)
            spread_cell(grid, nodes, c, volume, step.forces)
        with for_range(SUMS, cell.shape[0]) as k:
            cell[k] = 0.0
    return PASSED


@traced
def not_fitted(grid: Grid, nodes: Nodes, some: Group):
    """1 for each particle of a group that is a point of quadrature, else 0: no particle of a fitted cell is."""
    if not grid.kind.fitted:
        return some.present
    (fitted,) = load_row(nodes.cells, (cell_number(grid, some.first), FITTED), ONE)
    return some.present * (1.0 - fitted)
