"""Conservation to round-off by all variants of the material point method: bases x transfers x dimensions."""

import itertools

import numpy as np
import pytest
from arrays import assert_close
from from_python import functions_of, moments_of_inertia, one_strip

from mpmverify.problem import Constant, Discretisation, LinearElastic, NeoHookean, Periodic, Problem, Traction
from mpmverify.solvers.mpm import APIC, FLIP, TPIC, MaterialPoint, blend, fmpm, passes, xpic
from mpmverify.solvers.mpm.affine import Gradient, Uniform
from mpmverify.solvers.mpm.basis import BASES
from mpmverify.solvers.mpm.faces import node_positions
from mpmverify.solvers.mpm.state import PASSED, Step
from mpmverify.solvers.mpm.transfers import TRANSFERS
from mpmverify.solvers.tracing import Compiled, cond

particles_to_grid, grid_to_particles = passes.particles_to_grid, passes.grid_to_particles
FREE = Traction(Constant(0.0))
VARIANTS = {
    basis: [
        MaterialPoint(schedule, by, basis, formulation)
        for by, schedule, formulation in itertools.product(
            (*TRANSFERS, blend(0.7), xpic(3), fmpm(2)), ("USF", "USL", "MUSL"), ("updated", "total")
        )
    ]
    for basis in ("linear", "quadratic")
}
WITHOUT_AFFINE = [variant for variant in VARIANTS["linear"] if not variant.transfer.affine]
OTHERS = [
    MaterialPoint(schedule, by, basis)
    for basis, schedule, by in (
        ("mls-quadratic", "USL", APIC),
        ("ugimp", "USF", FLIP),
        ("ugimp", "MUSL", APIC),
        ("cpgimp", "MUSL", FLIP),
        ("cpgimp", "USL", fmpm(2)),
        ("cpdi", "MUSL", FLIP),
        ("cpdi", "USL", xpic(2)),
    )
]
MATERIALS = {"quadratic": NeoHookean(1.0, 1.0, 0.2)}
ELASTIC = LinearElastic(1.0, 1.0, 0.3)


@Compiled
def passed(back, *state):
    """Status of a pass to the grid, or back to the particles."""
    return cond(back, lambda: grid_to_particles(*state), lambda: particles_to_grid(*state))


def in_dimensions(*variants_and_dimensions):
    """Each variant in its dimensions."""
    return pytest.mark.parametrize(
        ("variant", "dimension"),
        [
            pytest.param(variant, dimension, id=f"{variant.name}-{dimension}d")
            for variants, dimensions in variants_and_dimensions
            for variant in variants
            for dimension in dimensions
        ],
    )


class Random:
    """Velocities towards the middle with a small random part, so that no particle leaves the grid."""

    def __init__(self, seed, dimension):
        self.seed, self.dimension = seed, dimension

    def __call__(self, X):
        inwards = -0.2 * (X - X.mean(axis=0)) / np.ptp(X, axis=0)
        return inwards + 0.02 * np.random.default_rng(self.seed).normal(size=X.shape)


def box(dimension, material, seed, faces=FREE, end_time=0.8):
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    return Problem(
        "box",
        (0.5,) * dimension,
        (4.5,) * dimension,
        material,
        dict.fromkeys(names, faces),
        end_time,
        {"velocity": Random(seed, dimension)},
    )


def by_axis(solution, name, dimension):
    names = [name] if dimension == 1 else [f"{name}_{axis}" for axis in "xyz"[:dimension]]
    return np.stack([solution.histories[entry] for entry in names], axis=1)


@pytest.mark.parametrize("faces", [FREE, Periodic()], ids=["free", "periodic"])
@in_dimensions((WITHOUT_AFFINE, (1, 3)), (VARIANTS["quadratic"] + OTHERS, (2,)))
def test_mass_and_linear_momentum(variant, faces, dimension):
    seed = len(variant.name) + dimension
    problem = box(dimension, MATERIALS.get(variant.basis, ELASTIC), seed, faces)
    solution = variant.solve(problem, Discretisation(1.0, 0.3, 2, jitter=0.3, seed=seed))
    assert solution.outcome.completed, str(solution.outcome)
    mass, momentum = solution.histories["mass"], by_axis(solution, "momentum", dimension)
    assert_close(mass, 4.0**dimension, rel=1e-13)
    scale = np.sqrt(2 * mass * solution.histories["kinetic_energy"]).max()
    assert_close(momentum - momentum[0], by_axis(solution, "impulse", dimension), abs=1e-13 * scale)
    assert_close(by_axis(solution, "impulse", dimension), 0, abs=1e-13 * scale)


# One pass on particles anywhere in the box, of any velocity, stress and affine part.


def cloud(variant, dimension, seed):
    """State of a variant with random particles in a free box, and its nodes' positions."""
    random = np.random.default_rng(seed)
    problem, at = box(dimension, ELASTIC, seed), Discretisation(1.0, 0.3, 2)
    axes = variant._axes(problem, at)
    grid = variant._grid(axes, at)
    count = 60
    X = random.uniform(0.5, 4.5, (count, dimension))
    particles = variant._particles(problem, X, random.uniform(0.1, 1.0, count))
    particles.velocity[:] = random.normal(size=X.shape)
    particles.affine[:] = random.normal(size=particles.affine.shape)
    particles.stress[:] = random.normal(size=particles.stress.shape)
    positions = node_positions(axes)
    nodes = variant._nodes(axes, problem)
    return variant._scheme(problem), grid, particles, nodes, positions


def to_grid(scheme, grid, particles, nodes):
    strips, body = one_strip(grid, particles), np.zeros((0, 0, 0))
    assert passed(False, scheme, grid, particles, nodes, strips, 0, Step(body, 0, 1, 0.01, True, True, True)) == PASSED


def moment(x, v):
    """Antisymmetric sum of x v^T - v x^T: the angular momentum, or a torque, in any dimension."""
    outer = np.einsum("pi,pj->ij", x, v)
    return outer - outer.T


def affine_moment(scheme, grid, particles):
    """Angular momentum m (B - B^T) of the affine parts, where TPIC keeps B D^-1."""
    dimension = len(grid.lower)
    if isinstance(scheme.affine, Uniform):
        return np.zeros((dimension, dimension))
    B = particles.affine.reshape(-1, dimension, dimension).copy()
    if isinstance(scheme.affine, Gradient):
        for p in range(len(B)):
            B[p] *= moments_of_inertia(scheme, grid, particles, p)
    total = np.einsum("p,pij->ji", particles.mass, B)  # v = B (x_I - x): x v^T has the rows of x, the columns of v
    return total - total.T


OF_PARTICLES = [basis for basis in BASES if not basis.startswith("tls-")]
"""What Taylor least squares gives the grid is no sum over particles, and has a table of its own with its tests."""
BY_TABLE = (*TRANSFERS, blend(0.7))
NOT_AFFINE = [MaterialPoint("USL", by, basis) for by in BY_TABLE if not by.affine for basis in OF_PARTICLES]
"""Compiled once for each basis and dimension; a pass of XPIC or FMPM is one of PIC."""
AFFINE = [MaterialPoint("USL", by, basis) for by in BY_TABLE if by.affine for basis in OF_PARTICLES if basis != "cpdi"]
BY_TURNS = list(
    zip(
        (by for by in BY_TABLE if by.affine),
        itertools.cycle(["linear", "quadratic"]),
        itertools.cycle(["quadratic", "linear"]),
        strict=False,
    )
)
IN_SPACE = [MaterialPoint("USL", by, basis) for by, basis, _ in BY_TURNS]
ON_A_LINE = [MaterialPoint("USL", by, basis) for by, _, basis in BY_TURNS]
"""Any two of basis, transfer and dimension meet: affine transfers with every basis in the plane, elsewhere with one basis each.

The conservation of an affine transfer goes by products of functions along the axes, each of which `NOT_AFFINE` meets in all dimensions.
"""
turning = in_dimensions((NOT_AFFINE, (2, 3)), (AFFINE, (2,)), (IN_SPACE, (3,)))
clouds = in_dimensions((NOT_AFFINE, (1, 2, 3)), (AFFINE, (2,)), (IN_SPACE, (3,)), (ON_A_LINE, (1,)))


@clouds
def test_particles_to_grid_keeps_mass_and_linear_and_angular_momentum(variant, dimension):
    scheme, grid, particles, nodes, positions = cloud(variant, dimension, seed=dimension)
    to_grid(scheme, grid, particles, nodes)
    momentum, m = nodes.inertia[1:].T, particles.mass[:, None]
    assert nodes.inertia[0].sum() == pytest.approx(m.sum(), rel=1e-14)
    assert momentum.sum(axis=0) == pytest.approx((m * particles.velocity).sum(axis=0), abs=1e-12)
    expected = moment(particles.position, m * particles.velocity) + affine_moment(scheme, grid, particles)
    assert moment(positions, momentum) == pytest.approx(expected, abs=1e-11)


@clouds
def test_internal_forces_have_no_sum_and_no_torque(variant, dimension):
    scheme, grid, particles, nodes, positions = cloud(variant, dimension, seed=10 + dimension)
    to_grid(scheme, grid, particles, nodes)
    scale = np.abs(nodes.internal).sum()
    assert nodes.internal.sum(axis=1) == pytest.approx(0, abs=1e-14 * scale)
    assert moment(positions, nodes.internal.T) == pytest.approx(0, abs=1e-13 * scale)


def stepped(variant, dimension, seed, acceleration):
    """A cloud before and after a pass from the grid to the particles, with any acceleration of the grid."""
    scheme, grid, particles, nodes, positions = cloud(variant, dimension, seed)
    to_grid(scheme, grid, particles, nodes)
    mass = nodes.inertia[0].copy()
    nodes.velocity[:] = np.divide(nodes.inertia[1:], mass, out=np.zeros_like(nodes.velocity), where=mass > 0)
    before = particles.velocity.copy(), nodes.velocity.copy()
    nodes.acceleration[:] = acceleration * np.random.default_rng(seed).normal(size=nodes.velocity.shape) * (mass > 0)
    dt, x = 0.01, particles.position.copy()
    nodes.velocity[:] += dt * nodes.acceleration
    momentum = (mass * nodes.velocity).T
    strips, body = one_strip(grid, particles), np.zeros((0, 0, 0))
    assert passed(True, scheme, grid, particles, nodes, strips, 0, Step(body, 0, 1, dt, True, True, True)) == PASSED
    return scheme, grid, particles, nodes, positions, mass, momentum, x, before, dt


@clouds
def test_grid_to_particles_keeps_linear_momentum(variant, dimension):
    *_, particles, _, _, _, momentum, _, before, dt = stepped(variant, dimension, 20 + dimension, 1.0)
    found = (particles.mass[:, None] * particles.velocity).sum(axis=0)
    assert found == pytest.approx(momentum.sum(axis=0), abs=1e-12)
    assert dt > 0
    assert not np.array_equal(before[0], particles.velocity)


@turning
def test_apic_keeps_angular_momentum_over_a_step_and_others_do_not(variant, dimension):
    """About the old places, since the grid is where it was; x_p + dt v_p moves along the momentum of APIC and PIC itself."""
    scheme, grid, particles, _, positions, _, momentum, x, *_ = stepped(variant, dimension, 30 + dimension, 1.0)
    found = moment(x, particles.mass[:, None] * particles.velocity) + affine_moment(scheme, grid, particles)
    lost = np.abs(found - moment(positions, momentum)).max()
    if variant.transfer is APIC:
        assert lost < 1e-11
    elif variant.transfer is not TPIC:
        assert lost > 1e-5


@in_dimensions(([MaterialPoint("USL", FLIP, basis) for basis in OF_PARTICLES], (1, 2, 3)))
def test_flip_loses_the_energy_of_the_lumped_less_the_consistent_mass(variant, dimension):
    """dK_particles - dK_grid = -(1/2) dv^T (M_lumped - M_consistent) dv <= 0."""
    scheme, grid, particles, nodes, positions, mass, _, x, before, dt = stepped(variant, dimension, 40, 3.0)
    there = particles._replace(state=particles.state.copy())
    there.position[:], there.F[:] = x, np.eye(dimension).ravel()[: there.F.shape[1]]
    N = np.stack([functions_of(scheme, grid, there, positions, p)[0] for p in range(len(x))])
    consistent = N.T @ (particles.mass[:, None] * N)
    dv = dt * nodes.acceleration
    dK_particles = (particles.mass[:, None] * (particles.velocity**2 - before[0] ** 2)).sum() / 2
    dK_grid = (mass * (nodes.velocity**2 - before[1] ** 2)).sum() / 2
    lost = -np.einsum("ci,ij,cj->", dv, np.diag(mass) - consistent, dv) / 2
    assert dK_particles - dK_grid == pytest.approx(lost, rel=1e-9)
    assert lost < 0
