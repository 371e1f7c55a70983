"""Order of the particles: sorted by cell in memory, and arranged by stencil within each strip."""

import numpy as np
import pytest
from from_python import entries, of_the_first

from mpmverify.problem import Discretisation, LinearElastic, Periodic, Problem, Traction
from mpmverify.solvers import mpm
from mpmverify.solvers.mpm import MaterialPoint, stencil
from mpmverify.solvers.mpm.order import UNSORTED, strips
from mpmverify.solvers.mpm.state import FAILED, PASSED
from mpmverify.solvers.tracing import Compiled, traced

order = entries(mpm.order)
CELLS, H = 40, 1 / 40
FAR = [np.nan, np.inf, -np.inf, 1e300, -1e300, 1e19, -1e18, -1e-300, 1.0, np.nextafter(1, 2), 2.0, -1.0]


def state(basis, face, formulation="updated", count=1003, seed=0):
    """Scheme, grid, random particles in the unit square, nodes and strips of a variant."""
    variant, at = MaterialPoint("USL", basis=basis, formulation=formulation), Discretisation(H, 0.3, 2)
    faces = dict.fromkeys(("x-", "x+", "y-", "y+"), face)
    problem = Problem("square", (0.0, 0.0), (1.0, 1.0), LinearElastic(1.0, 1.0), faces, 1.0)
    axes, X = variant._axes(problem, at), np.random.default_rng(seed).uniform(size=(count, 2))
    grid, particles = variant._grid(axes, at), variant._particles(problem, X, np.ones(count))
    shared = strips(0.0, H, (CELLS, CELLS), 4, particles, True, grid.stride[-1], True)
    return variant._scheme(problem), grid, particles, variant._nodes(axes, problem), shared


@pytest.mark.parametrize("basis", ["linear", "cubic", "cpgimp"])
@pytest.mark.parametrize("face", [Traction(), Periodic()])
@pytest.mark.parametrize("formulation", ["updated", "total"])
def test_each_strip_is_arranged_independently_and_stably_for_any_positions(basis, face, formulation):
    """Positions off the grid or not finite included: only memory of the strip is written, and no particle is lost or doubled."""
    scheme, grid, particles, nodes, shared = state(basis, face, formulation)
    random, places = np.random.default_rng(1), particles.reference if formulation == "total" else particles.position
    for p in random.choice(len(places), 400, replace=False):
        places[p, random.integers(2)] = random.choice(FAR)
    if basis == "cpgimp":
        particles.F[random.choice(len(places), 100), 0] = random.choice([*FAR, 0.0, -5.0], 100)
    count = len(shared.passed)
    inner = np.sort(np.r_[5, 5, 6, random.integers(0, len(places), count - 4)])
    shared.particles[:] = np.r_[0, inner, len(places)]
    for s in range(count):
        shared.shares[:] = -7
        assert order.arrange(scheme, grid, particles, nodes, shared, s) == PASSED
        assert (np.delete(shared.shares, s, axis=0) == -7).all()
        begin, end = shared.particles[s : s + 2]
        found = particles.order[begin:end]
        assert sorted(found) == list(range(begin, end))
        if end > begin:
            assert shared.node[begin:end].min() >= 0
            assert shared.node[begin:end].max() <= shared.shares.shape[1] - 2
        assert np.array_equal(found, begin + np.argsort(shared.node[begin:end], kind="stable"))


def test_particles_of_one_stencil_are_arranged_together_across_periodic_ends():
    scheme, grid, particles, nodes, shared = state("linear", Periodic())
    particles.position[:] += [-2.0, 3.0]
    shared.particles[1:] = len(particles.place)
    assert order.arrange(scheme, grid, particles, nodes, shared, 0) == PASSED
    rows = shared.shares.shape[1] // grid.stride[-1]
    cell = np.floor(particles.position / H).astype(int) % CELLS
    of_strip = cell[:, 1] < rows - 4
    first = cell @ [1, grid.stride[-1]]
    assert len(set(first[of_strip])) > 100
    assert np.array_equal(np.argsort(shared.node[of_strip], kind="stable"), np.argsort(first[of_strip], kind="stable"))


@traced
def group_of(scheme, grid, particles, p, end):
    some = stencil.group(scheme, grid, particles, p, end)
    return some.size, some.first, of_the_first(some.offset)


@pytest.mark.parametrize("basis", ["linear", "cubic", "cpgimp"])
def test_groups_are_the_same_outside_and_inside_a_periodic_box(basis):
    found = []
    for shift in ([0.0, 0.0], [-2.0, 3.0]):
        scheme, grid, particles, nodes, shared = state(basis, Periodic(), count=6400)
        particles.position[:] = (np.floor(particles.position / H * 64) + 0.5) / 64 * H + shift
        shared.particles[1:] = len(particles.place)
        assert order.arrange(scheme, grid, particles, nodes, shared, 0) == PASSED
        sizes, firsts, p = [], [], 0
        while p < len(particles.place):
            size, first, offset = call_group(scheme, grid, particles, p, len(particles.place))
            assert all(0 <= a < 1 for a in offset)
            sizes.append(size)
            firsts.append(first)
            p += size
        found.append((sizes, firsts))
    assert found[0] == found[1]
    assert max(found[0][0]) == 4


call_group = Compiled(group_of)


def test_sorted_particles_are_in_order_of_cells_and_keep_their_state():
    scheme, grid, particles, _, shared = state("quadratic", Periodic())
    particles.velocity[:] = particles.position
    particles.position[:, 0] += 1.0
    assert order.sort(scheme, grid, particles, shared, 7) == PASSED
    assert np.array_equal(np.sort(particles.place), np.arange(len(particles.place)))
    assert np.array_equal(particles.velocity, particles.reference[particles.place])
    cell = np.floor(particles.velocity / H).astype(int)
    assert (np.diff(cell @ [1, CELLS]) >= 0).all()
    assert np.array_equal(particles.order, np.arange(len(particles.place)))
    of_rows = np.searchsorted(cell[:, 1], shared.rows)
    assert np.array_equal(shared.particles, of_rows)
    assert shared.sorting.tolist() == [7, 1]


@pytest.mark.parametrize("where", [np.nan, np.inf, 2.0, -1e-9])
def test_a_particle_off_the_grid_fails_the_sort_and_nothing_is_moved(where):
    scheme, grid, particles, _, shared = state("linear", Traction())
    particles.position[17, 1] = where
    before = particles.state.copy()
    assert order.sort(scheme, grid, particles, shared, 7) == FAILED
    assert np.array_equal(particles.state, before, equal_nan=True)
    assert shared.sorting[0] == UNSORTED
