"""Properties of the clamped B-splines that hold for every degree, the end cells included."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.solvers.mpm.basis import basis, greville

degrees = st.sampled_from([1, 2])
grids = st.integers(1, 6).flatmap(lambda cells: st.tuples(st.integers(0, cells - 1), st.just(cells)))
local = st.floats(0, 1)


@given(local, grids, degrees)
def test_partition_of_unity_and_positivity(xi, grid, degree):
    values = basis(xi, *grid, degree)
    assert sum(values[:3]) == pytest.approx(1, abs=1e-15)
    assert sum(values[3:]) == pytest.approx(0, abs=1e-15)
    assert min(values[:3]) >= -1e-16


@given(local, grids, degrees)
def test_linear_completeness(xi, grid, degree):
    cell, cells = grid
    nodes = np.append(greville(0.0, 1.0, cells, degree), np.zeros(2))[cell : cell + 3]
    values = np.array(basis(xi, cell, cells, degree))
    assert values[:3] @ nodes == pytest.approx(cell + xi, abs=1e-14)
    assert values[3:] @ nodes == pytest.approx(1, abs=1e-14)


@given(st.floats(1e-3, 1 - 1e-3), grids, degrees)
def test_gradients_are_differences_of_the_values(xi, grid, degree):
    step = 1e-5
    above, below, here = (np.array(basis(x, *grid, degree)) for x in (xi + step, xi - step, xi))
    assert here[3:] == pytest.approx((above[:3] - below[:3]) / (2 * step), abs=1e-9)


@given(grids, degrees)
def test_values_and_the_gradients_of_degree_2_are_continuous_across_cells(grid, degree):
    cell, cells = grid
    if cell + 1 < cells:
        left, right = np.array(basis(1.0, cell, cells, degree)), np.array(basis(0.0, cell + 1, cells, degree))
        assert left[1:3] == pytest.approx(right[:2], abs=1e-15)
        assert left[0] == pytest.approx(0, abs=1e-15)
        if degree == 2:
            assert left[4:] == pytest.approx(right[3:5], abs=1e-15)


@given(st.integers(1, 6), degrees)
def test_the_basis_interpolates_at_the_ends(cells, degree):
    assert basis(0.0, 0, cells, degree)[:3] == (1, 0, 0)
    assert basis(1.0, cells - 1, cells, degree)[degree] == 1


@pytest.mark.parametrize("degree", [1, 2])
def test_nodes_span_the_grid(degree):
    nodes = greville(-1.0, 0.5, 4, degree)
    assert len(nodes) == 4 + degree
    assert (nodes[0], nodes[-1]) == (-1, 1)
    assert np.all(np.diff(nodes) > 0)
