"""Taylor least squares: exactness of fits, conservation in the transfer to the grid, and convergence with cell crossing."""

from dataclasses import replace

import numpy as np
import pytest
from from_python import one_strip
from scipy.interpolate import BSpline

from mpmverify.criteria.norms import NORMS, errors
from mpmverify.errors import UsageError
from mpmverify.exact.steffen import steffen
from mpmverify.problem import Constant, Discretisation, Fixed, LinearElastic, NeoHookean, Periodic, Problem, Traction
from mpmverify.problem.shapes import Disk
from mpmverify.solvers.mpm import APIC, FLIP, PIC, MaterialPoint, fmpm, sweeps, xpic
from mpmverify.solvers.mpm.basis import BASES
from mpmverify.solvers.mpm.faces import node_positions
from mpmverify.solvers.mpm.state import PASSED, Step
from mpmverify.solvers.tracing import Compiled

to_grid = Compiled(sweeps.IN_TURN.to_grid)
RECONSTRUCTED = tuple(name for name in BASES if name.startswith("tls-"))
CELLS, H = 3, 0.5
bases = pytest.mark.parametrize("basis", RECONSTRUCTED)
BAR = steffen()
in_dimensions = pytest.mark.parametrize("dimension", [1, 2, 3])


def box(dimension, faces, **more):
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    upper = (CELLS * H,) * dimension
    return Problem("box", (0.0,) * dimension, upper, NeoHookean(1.0, 2.0), dict.fromkeys(names, faces), 0.2, **more)


def cloud(basis, dimension, faces, per_cell=16, seed=3, formulation="updated"):
    """Scheme, grid, random particles in each cell with random volume, velocity and stress, nodes, and node positions."""
    variant, problem, random = (
        MaterialPoint("USL", FLIP, basis, formulation),
        box(dimension, faces),
        np.random.default_rng(seed),
    )
    axes = variant._axes(problem, at := Discretisation(H, 0.3, 2))
    cells = np.stack(np.meshgrid(*[np.arange(CELLS)] * dimension), axis=-1).reshape(-1, dimension)
    X = H * (np.repeat(cells, per_cell, axis=0) + random.uniform(size=(len(cells) * per_cell, dimension)))
    particles = variant._particles(problem, X, random.uniform(0.1, 1.0, len(X)))
    particles.velocity[:] = random.normal(size=X.shape)
    particles.stress[:] = random.normal(size=particles.stress.shape)
    particles.F[:] += 0.2 * random.normal(size=particles.F.shape)
    return variant._scheme(problem), variant._grid(axes, at), particles, variant._nodes(axes, problem), node_positions(axes)


def spread(scheme, grid, particles, nodes, body=None, forces=True):
    loads = np.zeros((0, 0, 0)) if body is None else body[None]
    strips = one_strip(grid, particles)
    assert to_grid(scheme, grid, particles, nodes, strips, 0, Step(loads, 0, 1, 0.01, True, forces, True)) == PASSED


def monomials(x, degree):
    """All monomials up to a total degree (points, functions)."""
    dimension = x.shape[1]
    powers = [p for p in np.ndindex(*[degree + 1] * dimension) if sum(p) <= degree]
    return np.stack([np.prod(x ** np.array(p), axis=1) for p in powers], axis=1)


def quadrature(degree, dimension):
    """Gauss points and weights, and there the values and derivatives along each axis of all grid functions, by scipy's splines."""
    points, weights = np.polynomial.legendre.leggauss(6)
    x = (H * (np.arange(CELLS)[:, None] + (points + 1) / 2)).ravel()
    knots = H * np.clip(np.arange(-degree, CELLS + degree + 1), 0, CELLS)
    splines = BSpline(knots, np.eye(CELLS + degree), degree)
    place = np.stack(np.meshgrid(*[x] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    weight = np.prod(np.stack(np.meshgrid(*[np.tile(H * weights / 2, CELLS)] * dimension, indexing="ij")), axis=0).ravel()
    values, slopes = splines(x), splines.derivative()(x)

    def products(derived):
        result = np.ones((1, 1))
        for k in reversed(range(dimension)):  # x fastest among the nodes, slowest among the points
            result = np.einsum("an,bm->banm", result, slopes if k == derived else values)
            result = result.reshape(result.shape[0] * result.shape[1], -1)
        return result

    return place, weight, products(None), [products(k) for k in range(dimension)]


@bases
@in_dimensions
def test_internal_forces_are_exact_for_a_stress_that_the_fit_reproduces(basis, dimension):
    scheme, grid, particles, nodes, _ = cloud(basis, dimension, Fixed())
    degree = min(BASES[basis].degree, 2)
    place, weight, _, dN = quadrature(BASES[basis].degree, dimension)
    coefficients = np.random.default_rng(1).normal(size=(monomials(place, degree).shape[1], particles.stress.shape[1]))
    particles.stress[:] = monomials(particles.position, degree) @ coefficients
    sigma = monomials(place, degree) @ coefficients
    spread(scheme, grid, particles, nodes)
    where = {1: [[0]], 2: [[0, 2], [2, 1]], 3: [[0, 3, 5], [3, 1, 4], [5, 4, 2]]}[dimension]
    for c in range(dimension):
        exact = -sum(np.einsum("g,g,gi->i", weight, sigma[:, where[c][k]], dN[k]) for k in range(dimension))
        assert nodes.internal[c] == pytest.approx(exact, abs=1e-12 * np.abs(sigma).max())


@bases
@in_dimensions
@pytest.mark.parametrize("per_cell", [1, 2, 16])
def test_mass_momentum_and_forces_are_conserved_for_any_number_of_particles(basis, dimension, per_cell):
    scheme, grid, particles, nodes, positions = cloud(basis, dimension, Periodic() if per_cell == 2 else Fixed(), per_cell)
    m, body = particles.mass[:, None], np.random.default_rng(2).normal(size=particles.position.shape)
    spread(scheme, grid, particles, nodes, body)
    assert nodes.cells[:, 0].all()
    assert nodes.inertia[0].sum() == pytest.approx(m.sum(), rel=1e-13)
    assert nodes.inertia[1:].sum(axis=1) == pytest.approx((m * particles.velocity).sum(axis=0), abs=1e-11)
    assert nodes.external.sum(axis=1) == pytest.approx((m * body).sum(axis=0), abs=1e-11)
    assert nodes.internal.sum(axis=1) == pytest.approx(0, abs=1e-13 * np.abs(nodes.internal).sum())
    outer = positions.T @ nodes.internal.T
    assert outer - outer.T == pytest.approx(0, abs=1e-12 * np.abs(nodes.internal).sum())


@in_dimensions
def test_a_rigid_velocity_is_reproduced_and_a_projection_without_forces_adds_none(dimension):
    scheme, grid, particles, nodes, _ = cloud("tls-linear", dimension, Fixed())
    particles.velocity[:] = np.arange(1.0, 1 + dimension)
    spread(scheme, grid, particles, nodes, forces=False)
    assert nodes.inertia[1:] == pytest.approx(particles.velocity[0][:, None] * nodes.inertia[0], rel=1e-12)
    assert not nodes.internal.any()
    assert not nodes.external.any()


@pytest.mark.parametrize("basis", ["tls-linear", "tls-cubic", "cubic"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_that_store_j_only_give_the_same_nodal_values(basis, dimension):
    scheme, grid, particles, nodes, _ = cloud(basis, dimension, Fixed())
    spread(scheme, grid, particles, nodes)
    problem = replace(box(dimension, Fixed()), material=LinearElastic(1.0, 2.0))
    variant, at = MaterialPoint("USL", FLIP, basis), Discretisation(H, 0.3, 2)
    alone = variant._particles(problem, particles.reference, particles.volume)
    alone.velocity[:], alone.stress[:], alone.mass[:] = particles.velocity, particles.stress, particles.mass
    alone.F[:, 0] = np.linalg.det(particles.F.reshape(-1, dimension, dimension))
    others = variant._nodes(variant._axes(problem, at), problem)
    spread(variant._scheme(problem), grid, alone, others)
    for name in ("inertia", "internal"):
        assert getattr(others, name) == pytest.approx(getattr(nodes, name), rel=1e-11, abs=1e-11)


@bases
def test_nodal_masses_are_positive_for_a_density_that_varies_within_cells(basis):
    """The density falls from ten times to a tenth across each cell, and the particles fill a small part of it."""
    scheme, grid, particles, nodes, _ = cloud(basis, 2, Fixed())
    across = particles.position[:, 0] / H % 1
    particles.F[:] = np.eye(2).ravel()
    particles.F[:, 0] = 10 ** (2 * across - 1)
    particles.mass[:] /= 40
    particles.volume[:] /= 40
    spread(scheme, grid, particles, nodes)
    assert nodes.cells[:, 0].all()
    assert nodes.inertia[0].min() > 0
    assert nodes.inertia[0].sum() == pytest.approx(particles.mass.sum(), rel=1e-13)


def test_particles_close_to_the_centre_of_a_cell_determine_no_slope():
    scheme, grid, particles, nodes, _ = cloud("tls-quadratic", 1, Fixed(), per_cell=3)
    particles.position[:, 0] = H * (np.repeat([0.5, 1.5, 2.5], 3) + 1e-6 * np.tile([-1.0, 0.0, 1.0], 3))
    spread(scheme, grid, particles, nodes)
    assert np.abs(nodes.inertia[1]).max() < np.abs(particles.mass * particles.velocity[:, 0]).sum()


def test_cells_at_a_loaded_face_or_beside_an_empty_cell_are_not_fitted():
    problem = box(2, Fixed())
    loaded = replace(problem, boundary=problem.boundary | {"y+": Traction(Constant(0.0))})
    joined = replace(problem, boundary=problem.boundary | {"x-": Periodic(), "x+": Periodic()})
    for body, without, fitted in (
        (loaded, None, [[1, 1, 1], [1, 1, 1], [0, 0, 0]]),
        (problem, [0, 0], [[0, 0, 1], [0, 1, 1], [1, 1, 1]]),
        (joined, [0, 0], [[0, 0, 0], [0, 1, 1], [1, 1, 1]]),
    ):
        variant = MaterialPoint("USL", FLIP, "tls-linear")
        axes = variant._axes(body, at := Discretisation(H, 0.3, 2))
        X = H * (np.stack(np.meshgrid(*[np.arange(2 * CELLS) / 2 + 0.25] * 2), axis=-1).reshape(-1, 2))
        X = X if without is None else X[(without != X // H).any(axis=1)]
        particles, nodes = variant._particles(body, X, np.full(len(X), H * H / 4)), variant._nodes(axes, body)
        spread(variant._scheme(body), variant._grid(axes, at), particles, nodes)
        assert np.array_equal(nodes.cells[:, 0].reshape(CELLS, CELLS), fitted)


@bases
@in_dimensions
def test_a_linear_body_force_is_integrated_exactly_with_particles_at_gauss_points(basis, dimension):
    """Two points per cell along each axis."""
    scheme, grid, particles, nodes, _ = cloud(basis, dimension, Fixed(), per_cell=2**dimension)
    corner = np.stack(np.meshgrid(*[[-1, 1]] * dimension), axis=-1).reshape(-1, dimension) / np.sqrt(12)
    particles.position[:] = H * (np.floor(particles.position / H) + 0.5 + np.tile(corner, (CELLS**dimension, 1)))
    particles.volume[:], particles.mass[:] = (H / 2) ** dimension, 2 * (H / 2) ** dimension
    particles.F[:] = np.eye(dimension).ravel()
    slope = np.random.default_rng(4).normal(size=(dimension, dimension))
    spread(scheme, grid, particles, nodes, particles.position @ slope)
    place, weight, N = quadrature(BASES[basis].degree, dimension)[:3]
    assert nodes.external == pytest.approx((2 * np.einsum("g,gi,gc->ci", weight, N, place @ slope)), abs=1e-12)
    assert nodes.inertia[0] == pytest.approx(2 * weight @ N, abs=1e-12)


def test_a_body_of_a_shape_is_refused():
    disk = box(2, Traction(Constant(0.0)), shape=Disk((0.75, 0.75), 0.5))
    with pytest.raises(UsageError, match="bodies that fill the cells"):
        MaterialPoint("USL", FLIP, "tls-linear").solve(disk, Discretisation(H, 0.3, 4))


@in_dimensions
def test_without_a_fitted_cell_the_transfer_is_that_of_the_linear_basis(dimension):
    """Every cell is at a loaded face or, in the middle, empty, so that no cell is fitted."""
    both = []
    for name in ("tls-linear", "linear"):
        scheme, grid, particles, nodes, _ = cloud(name, dimension, Traction(Constant(0.0)))
        cell = (particles.position // H).astype(int)
        elsewhere = np.flatnonzero((cell != 1).any(axis=1))
        numbers = np.arange(len(elsewhere))
        parts = particles.reference[elsewhere], particles.state[elsewhere]
        chosen = type(particles)(numbers, *parts, numbers.copy(), particles.deformation)
        spread(scheme, grid, chosen, nodes, particles.velocity[elsewhere])
        both.append(nodes)
    assert not both[0].cells[:, 0].any()
    for name in ("inertia", "internal", "external"):
        assert np.array_equal(getattr(both[0], name), getattr(both[1], name))


def displacement_errors(basis, formulation="updated", schedule="USL", levels=(8, 16, 32, 64)):
    found = []
    for cells in levels:
        solution = MaterialPoint(schedule, FLIP, basis, formulation).solve(BAR.problem, Discretisation(1 / cells, 0.3, 4))
        assert solution.outcome.completed, str(solution.outcome)
        found.append(errors(solution, BAR.exact)["displacement"][0][NORMS.index("L2-max")])
    return np.array(found)


@pytest.mark.parametrize("schedule", ["USL", "MUSL"])
def test_with_cell_crossing_the_fitted_linear_basis_converges(schedule):
    """The plain hat diverges from 16 cells on: Wobbes and others, 2019, doi:10.1002/nme.5956."""
    hats, fitted = displacement_errors("linear", schedule=schedule), displacement_errors("tls-linear", schedule=schedule)
    assert hats[3] > hats[1]
    assert (fitted[1:] < fitted[:-1] / 2).all()
    assert fitted[3] < hats[3] / 30


@pytest.mark.parametrize("basis", RECONSTRUCTED[:2])
@pytest.mark.parametrize("schedule", ["USL", "MUSL"])
def test_without_cell_crossing_convergence_is_of_second_order(basis, schedule):
    found = displacement_errors(basis, "total", schedule)
    assert np.log2(found[:-1] / found[1:]) == pytest.approx(2, abs=0.2)


@pytest.mark.parametrize("schedule", ["USL", "MUSL"])
@pytest.mark.parametrize("dimension", [1, 2])
def test_mass_is_conserved_over_steps_and_momentum_is_not_declared(schedule, dimension):
    variant = MaterialPoint(schedule, PIC, "tls-linear")
    moving = {"velocity": lambda X: 0.1 * np.cos(np.pi * X / (CELLS * H))}
    solution = variant.solve(box(dimension, Periodic(), initial=moving), Discretisation(H, 0.3, 4, jitter=0.3, seed=1))
    assert solution.outcome.completed, str(solution.outcome)
    assert solution.histories["mass"] == pytest.approx((CELLS * H) ** dimension * 2, rel=1e-13)
    assert variant.conserves == {"mass"}


@pytest.mark.parametrize(("schedule", "transfer"), [("USF", FLIP), ("USL", APIC), ("MUSL", xpic(2)), ("USL", fmpm(2))], ids=str)
def test_an_unsupported_schedule_or_transfer_is_refused(schedule, transfer):
    with pytest.raises(UsageError, match="goes with PIC, FLIP or a blend"):
        MaterialPoint(schedule, transfer, "tls-linear")
