"""Properties of the basis along an axis that hold for every degree, clamped and periodic, the end cells included."""

import numpy as np
import pytest
from from_python import callable_from_python
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.solvers.mpm import basis
from mpmverify.solvers.mpm.basis import DEGREES, spline_axis
from mpmverify.solvers.mpm.faces import integrals

along, affine_along = callable_from_python(basis.along), callable_from_python(basis.affine_along)
degrees = st.sampled_from(sorted(DEGREES.values()))
axes = st.tuples(st.integers(1, 9), degrees, st.booleans())
local = st.floats(0, 1, exclude_max=True)
LOWER, H = -1.0, 0.25


def axis(choices):
    cells, degree, periodic = choices
    return spline_axis(LOWER, H, cells, degree, periodic), (0.0,) * (degree + 1)


def functions(choices, place):
    """All functions of an axis, and their derivatives, at a place from 0 to 1 along it."""
    found, width = axis(choices)
    first, N, dN = along(found, place * found.cells, 1 / H, width)
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


@given(axes)
def test_integrals_are_those_of_a_fine_quadrature(choices):
    cells, degree, periodic = choices
    points, weights = np.polynomial.legendre.leggauss(4)
    expected = np.zeros(cells + degree)
    for cell in range(cells):
        for xi, weight in zip((points + 1) / 2, weights / 2, strict=True):
            expected += H * weight * functions(choices, (cell + xi) / cells)[0]
    if periodic:  # each ghost lies over the function that it repeats, several times where the axis is short
        np.add.at(expected, np.arange(cells, cells + degree) % cells, expected[cells:])
    own = slice(cells if periodic else None)
    assert integrals(axis(choices)[0], H)[own] == pytest.approx(expected[own], abs=1e-14)


@given(axes, st.floats(1e-3, 1 - 1e-3))
def test_affine_functions_have_no_sum_and_the_first_moment_one(choices, xi):
    found, width = axis(choices)
    s = found.cells // 2 + xi
    first, N, _ = along(found, s, 1 / H, width)
    e, D = affine_along(found, s, 1 / H, N)
    offset = found.nodes[first : first + len(N)] - (LOWER + H * s)
    assert sum(e) == pytest.approx(0, abs=1e-11 / H)
    assert np.dot(e, offset) == pytest.approx(1, rel=1e-12)
    assert pytest.approx(np.dot(N, offset**2), rel=1e-12) == D


@pytest.mark.parametrize(("degree", "inertia"), [(2, 1 / 4), (3, 1 / 3)])
def test_inside_the_moment_of_inertia_is_that_of_the_spline(degree, inertia):
    found, width = axis((9, degree, True))
    for s in (4.0, 4.3, 4.99):
        assert affine_along(found, s, 1 / H, along(found, s, 1 / H, width)[1])[1] == pytest.approx(inertia * H**2)
