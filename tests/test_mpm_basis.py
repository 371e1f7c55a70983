"""Basis functions: properties along an axis for every degree, clamped and periodic, and of every basis in 1D, 2D and 3D."""

import itertools

import numpy as np
import pytest
from from_python import along, functions_of, functions_or_none, moment_along
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpmverify.problem import Constant, Discretisation, LinearElastic, Periodic, Problem, Traction
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.mpm.basis import BASES, Basis, grid_of, spline_axis
from mpmverify.solvers.mpm.faces import ghosts, integrals, node_positions
from mpmverify.solvers.mpm.splines import Splines

degrees = st.sampled_from([1, 2, 3])
axes = st.tuples(st.integers(1, 9), degrees, st.booleans())
local = st.floats(0, 1, exclude_max=True)
LOWER, H = -1.0, 0.25


def axis(choices):
    cells, degree, periodic = choices
    found = spline_axis(LOWER, H, cells, degree, periodic)
    return found, grid_of((found,), H, Basis(Splines(), degree, degree + 1), ghosts((found,)), 0.25, False)


def functions(choices, place):
    """All functions of an axis, and their derivatives, at a place from 0 to 1 along it."""
    found, grid = axis(choices)
    first, N, dN = along(grid, place * found.cells)
    values, gradients = np.zeros(len(found.nodes)), np.zeros(len(found.nodes))
    values[first : first + len(N)], gradients[first : first + len(N)] = N, dN
    return values, gradients


@given(axes, local)
def test_partition_of_unity_and_positivity(choices, place):
    values, gradients = functions(choices, place)
    assert values.sum() == pytest.approx(1, abs=1e-14)
    assert gradients.sum() == pytest.approx(0, abs=1e-13 / H)
    assert values.min() >= -1e-15


@given(axes, local)
def test_linear_completeness(choices, place):
    found, _ = axis(choices)
    values, gradients = functions(choices, place)
    assert values @ found.nodes == pytest.approx(LOWER + H * place * found.cells, abs=1e-13)
    assert gradients @ found.nodes == pytest.approx(1, abs=1e-12)


@given(axes, st.floats(1e-3, 1 - 1e-3))
def test_gradients_are_differences_of_the_values(choices, xi):
    cells, step = choices[0], 1e-6
    cell = cells // 2
    above, below, here = (functions(choices, (cell + at) / cells) for at in (xi + step, xi - step, xi))
    assert here[1] == pytest.approx((above[0] - below[0]) / (2 * step * H), abs=1e-7 / H)


@given(axes, st.data())
def test_values_are_continuous_across_cells_and_gradients_from_degree_2_on(choices, data):
    cells, degree, _ = choices
    if cells > 1:
        edge = data.draw(st.integers(1, cells - 1)) / cells
        left, right = functions(choices, np.nextafter(edge, 0)), functions(choices, np.nextafter(edge, 1))
        assert left[0] == pytest.approx(right[0], abs=1e-13)
        if degree > 1:
            assert left[1] == pytest.approx(right[1], abs=1e-12 / H)


@given(st.integers(1, 9), degrees)
def test_a_clamped_basis_interpolates_at_its_ends(cells, degree):
    first, last = functions((cells, degree, False), 0.0)[0], functions((cells, degree, False), 1.0)[0]
    assert first == pytest.approx(np.eye(cells + degree)[0], abs=1e-15)
    assert last == pytest.approx(np.eye(cells + degree)[-1], abs=1e-14)
    nodes = axis((cells, degree, False))[0].nodes
    assert (nodes[0], nodes[-1]) == (LOWER, LOWER + H * cells)
    assert np.all(np.diff(nodes) > 0)


@given(st.integers(4, 9), degrees, st.floats(1e-6, 1 - 1e-6))
def test_a_periodic_basis_repeats_itself_from_cell_to_cell(cells, degree, xi):
    here, there = (functions((cells, degree, True), (cell + xi) / cells) for cell in (0, 1))
    assert here[0][:-1] == pytest.approx(there[0][1:], abs=1e-13)
    assert here[1][:-1] == pytest.approx(there[1][1:], abs=1e-12 / H)


@given(axes, st.tuples(st.floats(0, 1), st.floats(0, 1)).map(sorted))
def test_integrals_over_any_part_of_the_axis_are_exact(choices, part):
    """Compared with Gauss quadrature in each cell."""
    cells, degree, periodic = choices
    a, b = (cells * end for end in part)
    points, weights = np.polynomial.legendre.leggauss(4)
    expected = np.zeros(cells + degree)
    for cell in range(cells):
        low, high = np.clip((a, b), cell, cell + 1)
        for s, weight in zip(low + (high - low) * (points + 1) / 2, (high - low) * weights / 2, strict=True):
            expected += H * weight * functions(choices, s / cells)[0]
    if periodic:  # add each ghost to the function that it repeats; on a short axis a function has several ghosts
        np.add.at(expected, np.arange(cells, cells + degree) % cells, expected[cells:])
    own, found = slice(cells if periodic else None), axis(choices)[0]
    assert integrals(found, H, found.lower + H * a, found.lower + H * b)[own] == pytest.approx(expected[own], abs=1e-14)


@given(axes, st.floats(0, 1, exclude_max=True))
def test_first_moments_sum_to_zero_and_give_the_moment_of_inertia(choices, xi):
    found, grid = axis(choices)
    s = found.cells // 2 + xi
    first, N, _ = along(grid, s)
    moment, D = moment_along(grid, s)
    offset = (found.nodes[first : first + len(N)] - LOWER) / H - s
    assert moment.sum() == pytest.approx(0, abs=1e-14)
    assert moment @ offset == pytest.approx(D, rel=1e-12)
    assert N @ offset**2 == pytest.approx(D, rel=1e-12)


@pytest.mark.parametrize(("degree", "inertia"), [(2, 1 / 4), (3, 1 / 3)])
def test_in_inner_cells_the_moment_of_inertia_is_that_of_a_uniform_spline(degree, inertia):
    _, grid = axis((9, degree, True))
    for s in (4.0, 4.3, 4.99):
        assert moment_along(grid, s)[1] == pytest.approx(inertia)


# All bases in one, two and three dimensions, by the functions that the transfer passes call.

CELLS = 4


def body(dimension, face):
    faces = dict.fromkeys([name + side for name in "xyz"[:dimension] for side in "-+"], face)
    return Problem("box", (LOWER,) * dimension, (LOWER + CELLS * H,) * dimension, LinearElastic(1.0, 1.0), faces, 1.0)


def particle(basis, dimension, place, F, face=None):
    """Scheme, grid, one particle with deformation gradient F (d, d) at `place` (d,) in units of the box, and node positions."""
    variant, problem = MaterialPoint(basis=basis), body(dimension, face or Traction(Constant(0.0)))
    X = LOWER + CELLS * H * np.array([place], dtype=float)
    particles = variant._particles(problem, X, np.ones(1))
    if particles.F.shape[1] == np.size(F):  # a basis that needs J only is not affected by F
        particles.F[0] = np.ravel(F)
    axes, at = variant._axes(problem, Discretisation(H, 0.3, 2)), Discretisation(H, 0.3, 2)
    return variant._scheme(problem), variant._grid(axes, at), particles, node_positions(axes)


OF_THEIR_OWN = [name for name in BASES if not name.startswith("tls")]
"""Bases with functions of their own; Taylor least squares uses those of the splines."""
all_bases, all_dimensions = pytest.mark.parametrize("basis", OF_THEIR_OWN), pytest.mark.parametrize("dimension", [1, 2, 3])


@st.composite
def domains(draw, dimension):
    """A place in the box, and a general deformation gradient."""
    place = draw(st.tuples(*[st.floats(0.02, 0.98)] * dimension))
    H = draw(arrays(float, (dimension, dimension), elements=st.floats(-0.3, 0.3)))
    return place, np.eye(dimension) + H


@all_dimensions
@all_bases
@given(data=st.data())
@settings(max_examples=30)
def test_every_basis_is_complete_to_first_order_and_positive(basis, dimension, data):
    """Sum N = 1, sum dN/dx = 0, sum N x_I = x_p, sum x_I dN/dx = identity, and N >= 0."""
    place, F = data.draw(domains(dimension))
    scheme, grid, particles, nodes = particle(basis, dimension, place, F)
    N, dN = functions_of(scheme, grid, particles, nodes, 0)
    assert N.sum() == pytest.approx(1, abs=1e-13)
    assert N.min() >= -1e-14
    assert pytest.approx(particles.position[0], abs=1e-13) == nodes.T @ N
    assert dN.sum(axis=0) == pytest.approx(0, abs=1e-11)
    assert nodes.T @ dN == pytest.approx(np.eye(dimension), abs=1e-11)


@all_dimensions
@pytest.mark.parametrize("basis", [name for name in OF_THEIR_OWN if not name.startswith("mls") and name != "cpdi"])
@given(data=st.data())
@settings(max_examples=20)
def test_gradients_are_the_derivatives_of_the_functions(basis, dimension, data):
    """Away from the kinks of the functions; gradients of moving least squares and of CPDI are not derivatives by design."""
    place, _ = data.draw(domains(dimension))
    step = 1e-6
    edges = np.outer([0.0, 0.25, 0.5, 0.75], np.ones(dimension)) + (np.array(place) * CELLS)
    assume(np.abs((edges * 4) - np.round(edges * 4)).min() > 0.01)
    scheme, grid, particles, nodes = particle(basis, dimension, place, np.eye(dimension))
    _, dN = functions_of(scheme, grid, particles, nodes, 0)
    for k in range(dimension):
        ends = []
        for side in (-step, step):
            particles.position[0] = LOWER + CELLS * H * np.array(place)
            particles.position[0, k] += side
            ends.append(functions_of(scheme, grid, particles, nodes, 0)[0])
        assert (ends[1] - ends[0]) / (2 * step) == pytest.approx(dN[:, k], abs=1e-5 / H)


@given(st.floats(0.1, 0.9), st.floats(0.6, 1.4))
def test_gimp_functions_are_averages_of_the_hat_over_the_domain(place, stretch):
    """In one dimension CPDI has the gradient of cpGIMP."""
    points, weights = np.polynomial.legendre.leggauss(40)
    for name, half in (("ugimp", 0.25 * H), ("cpgimp", 0.25 * H * stretch)):
        scheme, grid, particles, nodes = particle(name, 1, [place], [[stretch]])
        found, gradient = functions_of(scheme, grid, particles, nodes, 0)
        x, expected = particles.position[0, 0], np.zeros(len(nodes))
        cuts = np.unique(np.clip(np.concatenate([nodes[:, 0], [x - half, x + half]]), x - half, x + half))
        for a, b in itertools.pairwise(cuts):
            at = (a + b) / 2 + (b - a) / 2 * points
            hats = np.clip(1 - np.abs(at[:, None] - nodes[:, 0]) / H, 0, None)
            expected += (b - a) / 2 * weights @ hats / (2 * half)
        assert found == pytest.approx(expected, abs=1e-13)
    assert functions_of(*particle("cpdi", 1, [place], [[stretch]]), 0)[1] == pytest.approx(gradient[:-1], abs=1e-10)


@pytest.mark.parametrize("basis", ["ugimp", "cpgimp", "cpdi"])
@pytest.mark.parametrize("place", [0.01, 0.9, 0.99])
def test_a_domain_extends_across_periodic_ends(basis, place):
    """The functions are those of a particle half a box away, whose domain extends across inner cells."""
    scheme, grid, particles, nodes = particle(basis, 1, [place], np.eye(1), Periodic())
    N, dN = functions_of(scheme, grid, particles, nodes, 0)
    np.add.at(N, grid.ghosts[:, 1], N[grid.ghosts[:, 0]])
    np.add.at(dN, grid.ghosts[:, 1], dN[grid.ghosts[:, 0]])
    inner = functions_of(*particle(basis, 1, [(place + 0.5) % 1.0], np.eye(1)), 0)
    shifted = np.roll(np.arange(CELLS), CELLS // 2)
    assert N[:CELLS][shifted] == pytest.approx(inner[0][1 : 1 + CELLS], abs=1e-13)
    assert dN[:CELLS][shifted] == pytest.approx(inner[1][1 : 1 + CELLS], abs=1e-11)


def test_a_domain_longer_than_two_cells_is_not_supported():
    scheme, grid, particles, nodes = particle("cpdi", 2, [0.5, 0.5], [[3.0, 0.9], [0.0, 1.0]])
    assert functions_or_none(scheme, grid, particles, nodes, 0)
    for too_long in (1.1, np.nan):
        particles.F[0, 1] = too_long
        assert functions_or_none(scheme, grid, particles, nodes, 0) is None
