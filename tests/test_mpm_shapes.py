"""Bodies of a given shape: exact parts of cells, layouts of particles, free surfaces that cut cells, loads, several bodies."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.convergence.order_verdict import verdict
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria.norms import NORMS, errors
from mpmverify.errors import UsageError
from mpmverify.exact.ring import expanding_ring
from mpmverify.problem import (
    Block,
    Bodies,
    Constant,
    Discretisation,
    Disk,
    Fixed,
    LinearElastic,
    NeoHookean,
    Problem,
    Ring,
    Traction,
    Velocity,
)
from mpmverify.problem.particles import SLIVER, place_particles
from mpmverify.solvers.mpm import APIC, FLIP, GAUSS, REGULAR, Layout, MaterialPoint, fmpm, offset

CENTERS = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
DISKS = st.builds(Disk, CENTERS, st.floats(0.05, 0.7))
RINGS = st.builds(
    lambda center, outer, part: Ring(center, part * outer, outer), CENTERS, st.floats(0.05, 0.7), st.floats(0.1, 0.95)
)
SHAPES = DISKS | RINGS
LAYOUTS = st.sampled_from([REGULAR, GAUSS, offset(0.3), offset(-0.49)])
MATERIAL = NeoHookean(1.0, 1.0, 0.3)
ELASTIC = LinearElastic(1.0, 1.0, 0.3)
FREE = dict.fromkeys(("x-", "x+", "y-", "y+"), Traction())


def swelling(X):
    """Velocity with translation, stretch and rotation."""
    return 0.05 * np.stack([X[:, 0] * X[:, 1] - X[:, 1] + 0.5, X[:, 1] + X[:, 0] - 0.2], axis=1)


def body(shape, faces=FREE):
    return Problem("body", (-1.0, -1.0), (1.0, 1.0), MATERIAL, faces, 1.0, {"velocity": swelling}, outputs=8, shape=shape)


def boxes(n):
    """Corners of n x n boxes on [-1, 1] x [-1, 1]."""
    ends = np.linspace(-1, 1, n + 1)
    return tuple(np.stack([x.ravel() for x in np.meshgrid(side, side)], axis=1) for side in (ends[:-1], ends[1:]))


# Parts of shapes.


@given(SHAPES, st.integers(1, 40))
def test_parts_on_a_grid_sum_to_the_body_and_stay_in_their_boxes(shape, n):
    lower, upper = boxes(n)
    area, centroid = shape.parts(lower, upper)
    assert area.sum() == pytest.approx(shape.measure, rel=1e-13)
    assert area @ (centroid - shape.center) / shape.measure == pytest.approx(0, abs=1e-14)
    box = (2 / n) ** 2
    assert ((area >= 0) & (area <= box * (1 + 1e-13))).all()
    real = area > 1e-6 * box
    assert (np.abs(centroid - (lower + upper) / 2)[real] <= 1 / n + 1e-9).all()


@given(SHAPES, st.integers(1, 20))
def test_parts_of_boxes_that_no_circle_cuts_are_whole_or_empty(shape, n):
    lower, upper = boxes(n)
    nearest = np.hypot(*np.clip(shape.center, lower, upper).T - np.array(shape.center)[:, None])
    farthest = np.hypot(*np.maximum(np.abs(lower - shape.center), np.abs(upper - shape.center)).T)
    inner, outer = (shape.inner, shape.outer) if isinstance(shape, Ring) else (0.0, shape.radius)
    area, centroid = shape.parts(lower, upper)
    whole = (nearest >= inner) & (farthest < outer)
    assert area[whole] == pytest.approx((2 / n) ** 2, rel=1e-13)
    assert centroid[whole] == pytest.approx(((lower + upper) / 2)[whole], abs=1e-13)
    assert area[(nearest > outer) | (farthest < inner)] == pytest.approx(0, abs=1e-17)


def test_parts_of_a_circle_in_closed_form():
    """A quarter, a half, and a segment of the disk."""
    disk, r = Disk((0.25, -0.5), 0.5), 0.5
    lower = np.array([[0.25, -0.5], [0.25, -2.0], [-1.0, -0.5 + r / 2]])
    area, centroid = disk.parts(lower, np.array([[2.0, 2.0], [2.0, 1.0], [1.0, 1.0]]))
    segment, height = r**2 * (math.pi / 3 - math.sqrt(3) / 4), r / 2
    assert area == pytest.approx([math.pi * r**2 / 4, math.pi * r**2 / 2, segment], rel=1e-14)
    of_quarter = 4 * r / (3 * math.pi)
    of_segment = 2 * (r**2 - height**2) ** 1.5 / (3 * segment)
    expected = [[of_quarter, of_quarter], [of_quarter, 0.0], [0.0, of_segment]]
    assert centroid - disk.center == pytest.approx(np.array(expected), abs=1e-14)


@given(SHAPES, st.tuples(*[st.floats(-1, 1)] * 4))
def test_parts_agree_with_the_chords(shape, corners):
    """The area is the integral of the chord within the box, here by the midpoint rule."""
    (x0, x1), (y0, y1) = sorted(corners[:2]), sorted(corners[2:])
    x = x0 + (x1 - x0) * (np.arange(20_000) + 0.5) / 20_000 - shape.center[0]

    def chord(radius):
        half = np.sqrt(np.maximum(radius**2 - x**2, 0))
        return np.maximum(np.minimum(y1 - shape.center[1], half) - np.maximum(y0 - shape.center[1], -half), 0)

    inside = chord(shape.outer) - chord(shape.inner) if isinstance(shape, Ring) else chord(shape.radius)
    area, _ = shape.parts(np.array([[x0, y0]]), np.array([[x1, y1]]))
    assert area[0] == pytest.approx(inside.mean() * (x1 - x0), abs=1e-6)


@given(st.integers(1, 3), st.integers(1, 12), st.data())
def test_parts_of_a_block_sum_to_it_and_stay_in_their_boxes(dimension, n, data):
    ends = [sorted(data.draw(st.lists(st.floats(-1, 1), min_size=2, max_size=2, unique=True))) for _ in range(dimension)]
    block = Block(tuple(a for a, _ in ends), tuple(b for _, b in ends))
    side = np.linspace(-1, 1, n + 1)
    lower, upper = (
        np.stack([x.ravel() for x in np.meshgrid(*[corner] * dimension)], axis=1) for corner in (side[:-1], side[1:])
    )
    measure, centroid = block.parts(lower, upper)
    middle = (np.array(block.lower) + block.upper) / 2
    assert measure.sum() == pytest.approx(block.measure, rel=1e-12, abs=1e-300)
    assert measure @ centroid == pytest.approx(block.measure * middle, abs=1e-13)
    there = measure > 0
    assert ((lower <= centroid) & (centroid <= upper))[there].all()
    assert block.contains(centroid[there]).all()


DISK, RING = Disk((0.0, 0.0), 0.25), Ring((0.0, 0.0), 0.5, 0.75)


@pytest.mark.parametrize(
    ("one", "other", "apart"),
    [
        (DISK, Disk((0.5, 0.0), 0.25), True),
        (DISK, Disk((0.49, 0.0), 0.25), False),
        (DISK, Disk((0.0, 0.0), 0.1), False),
        (DISK, RING, True),
        (RING, Disk((0.3, 0.0), 0.25), False),
        (RING, Ring((0.1, 0.0), 0.2, 0.4), True),
        (DISK, Block((0.25, -0.5), (0.5, 0.5)), True),
        (DISK, Block((0.24, -0.5), (0.5, 0.5)), False),
        (DISK, Block((0.2, 0.2), (0.5, 0.5)), True),
        (DISK, Block((-1.0, -1.0), (1.0, 1.0)), False),
        (RING, Block((-0.3, -0.4), (0.3, 0.4)), True),
        (RING, Block((-0.3, -0.4), (0.3, 0.41)), False),
        (Block((0.0,), (0.5,)), Block((0.5,), (1.0,)), True),
        (Block((0.0,), (0.5,)), Block((0.4,), (1.0,)), False),
        (Block((0.0,) * 3, (1.0,) * 3), Block((0.0, 1.0, 0.0), (1.0, 2.0, 1.0)), True),
        (Block((0.0,) * 3, (1.0,) * 3), Block((0.5,) * 3, (2.0,) * 3), False),
    ],
)
def test_several_bodies_may_touch_but_not_overlap(one, other, apart):
    for bodies in ((one, other), (other, one)):
        if apart:
            assert Bodies(bodies).measure == pytest.approx(one.measure + other.measure, rel=1e-15)
        else:
            with pytest.raises(UsageError, match="may touch but not overlap"):
                Bodies(bodies)


# Particles.


@given(SHAPES, st.integers(2, 16), st.integers(1, 4), LAYOUTS, st.sampled_from([0.0, 0.49]))
def test_particles_sum_to_the_measure_of_the_body_and_none_is_too_small(shape, cells, ppc, layout, jitter):
    at = Discretisation(2 / cells, 0.5, ppc, jitter=jitter)
    place, volume = place_particles(body(shape), at, layout)
    assert volume.sum() == pytest.approx(shape.measure, rel=1e-13)
    assert (np.abs(place) <= 1).all()
    _, ends = layout.in_cell(ppc)
    assert volume.min() > 0
    if len(volume) > 9:
        assert volume.min() >= SLIVER * (at.h * np.diff(ends).min()) ** 2
    if layout is REGULAR and not jitter:
        assert volume @ (place - shape.center) / shape.measure == pytest.approx(0, abs=1e-13)


@given(st.integers(1, 5), st.integers(1, 3), st.integers(1, 3))
def test_gauss_points_integrate_polynomials_of_degree_2_ppc_minus_1(ppc, dimension, cells):
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    box = Problem("box", (0.0,) * dimension, (1.0,) * dimension, MATERIAL, dict.fromkeys(names, Traction()), 1.0)
    place, volume = place_particles(box, Discretisation(1 / cells, 0.5, ppc), GAUSS)
    assert len(volume) == (cells * ppc) ** dimension
    degree = 2 * ppc - 1
    assert volume @ (place**degree).prod(axis=1) == pytest.approx(1 / (degree + 1) ** dimension, rel=1e-13)


@given(st.floats(-0.49, 0.49), st.integers(1, 4))
def test_an_offset_moves_every_particle_by_its_share_of_the_spacing(share, ppc):
    box, at = replace(body(None), shape=None), Discretisation(0.5, 0.5, ppc)
    (still, volume), (moved, same) = place_particles(box, at), place_particles(box, at, offset(share))
    assert moved - still == pytest.approx(np.full_like(still, share * 0.5 / ppc), abs=1e-15)
    assert np.array_equal(same, volume)


def test_the_name_of_a_solver_tells_its_layout():
    layouts = (REGULAR, GAUSS, offset(0.25), offset(-0.25))
    names = [MaterialPoint(layout=layout).name for layout in layouts]
    assert names[0] == MaterialPoint().name == "mpm-ul-linear-musl-flip"
    assert names[1:] == [f"{names[0]}-{end}" for end in ("gauss", "offset0.25", "offset-0.25")]


# Free surfaces that cut cells.


@pytest.mark.parametrize("layout", [REGULAR, GAUSS, offset(0.25)], ids=lambda layout: layout.name)
@pytest.mark.parametrize("transfer", [FLIP, APIC, fmpm(2)], ids=lambda transfer: transfer.name)
@pytest.mark.parametrize("formulation", ["updated", "total"])
def test_a_free_disk_conserves_mass_and_momentum(transfer, formulation, layout):
    disk = body(Disk((0.05, -0.1), 0.5))
    solver = MaterialPoint("MUSL", transfer, "quadratic", formulation, layout=layout)
    solution = solver.solve(disk, Discretisation(1 / 8, 0.3, 2))
    assert solution.outcome.completed, str(solution.outcome)
    histories = solution.histories
    assert histories["mass"] == pytest.approx(MATERIAL.density * disk.measure, rel=1e-13)
    scale = math.sqrt(2 * disk.measure * histories["kinetic_energy"].max())
    for axis in "xy":
        assert histories[f"momentum_{axis}"] == pytest.approx(histories[f"momentum_{axis}"][0], abs=1e-13 * scale)
        assert histories[f"impulse_{axis}"] == pytest.approx(0, abs=1e-13 * scale)
    assert solution.weight[0].sum() == pytest.approx(disk.measure, rel=1e-13)


def spin(particles):
    """Angular momentum of particles with their affine parts B."""
    x, v, B = particles.position, particles.velocity, particles.affine
    return particles.mass @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0] + B[:, 2] - B[:, 1])


@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
def test_a_free_disk_conserves_angular_momentum_with_apic(schedule, monkeypatch):
    states = []

    def kept(self, *args):
        states.append(particles := original(self, *args))
        return particles

    original = MaterialPoint._particles
    monkeypatch.setattr(MaterialPoint, "_particles", kept)
    solver = MaterialPoint(schedule, APIC, "quadratic")
    disk, at = body(Disk((0.05, -0.1), 0.5)), Discretisation(1 / 8, 0.3, 2)
    solution = solver.solve(disk, at)
    assert solution.outcome.completed
    begun = solver._particles(disk, *place_particles(disk, at))
    assert np.abs(states[0].affine).max() > 1e-4
    scale = begun.mass @ np.linalg.norm(begun.position, axis=1)
    assert spin(states[0]) == pytest.approx(spin(begun), abs=1e-13 * scale)
    assert solution.histories["angular_momentum"] == pytest.approx(spin(begun), abs=1e-13 * scale)


@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize(
    ("schedule", "transfer", "basis"), [("MUSL", FLIP, "linear"), ("USF", FLIP, "linear"), ("USL", APIC, "quadratic")]
)
def test_a_surface_just_beyond_a_line_of_nodes_causes_no_error(schedule, transfer, basis, formulation):
    """The energy changes in proportion to the radius, and no particle has a spurious stress."""
    solver, at = MaterialPoint(schedule, transfer, basis, formulation), Discretisation(1 / 8, 0.3, 2)
    exact = solver.solve(body(Disk((0.0, 0.0), 0.5)), at)
    energy, stress = (exact.histories["kinetic_energy"], np.abs(exact.fields["stress"]).max())
    for beyond in 10.0 ** np.arange(-3, -9, -1):
        solution = solver.solve(body(Disk((0.0, 0.0), 0.5 + beyond)), at)
        assert solution.outcome.completed, str(solution.outcome)
        assert solution.histories["kinetic_energy"] == pytest.approx(energy, rel=10 * beyond)
        assert np.abs(solution.fields["stress"]).max() < 1.2 * stress


def test_linear_functions_converge_at_second_order_on_the_ring():
    ring, solver = expanding_ring(outputs=16), MaterialPoint(formulation="total")
    h, found = [2 / cells for cells in (16, 32, 48, 64)], []
    for size in h:
        error, scale = errors(solver.solve(ring.problem, Discretisation(size, 0.3, 2)), ring.exact)["displacement"]
        found.append(error[NORMS.index("L2-max")] / scale[NORMS.index("L2-max")])
    judged, reason = verdict(h, found, band=(1.8, 2.2))
    assert judged is Verdict.PASS, reason


def test_conditions_at_nodes_without_particles_have_no_effect():
    at, disk = Discretisation(1 / 8, 0.3, 2), Disk((0.0, 0.0), 0.5)
    free, held = (MaterialPoint().solve(body(disk, faces), at) for faces in (FREE, dict.fromkeys(FREE, Fixed())))
    assert np.array_equal(free.position, held.position)


# Tractions on part of a face.


@pytest.mark.parametrize(
    ("basis", "dimension"), [("linear", 2), ("cubic", 2), ("cpdi", 2), ("linear", 3), ("quadratic", 3), ("cpdi", 3)]
)
def test_a_traction_loads_the_part_of_a_face_that_bodies_touch(dimension, basis):
    """Two blocks whose edges are not on lines of nodes: the impulse is load times area times time."""
    rest, names = (0.8,) * (dimension - 2), [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    blocks = (
        Block((0.3, 0.125, *(0.1 for _ in rest)), (1.0, 0.4, *rest)),
        Block((0.5, 0.6, *(0.2 for _ in rest)), (1.0, 0.8, *rest)),
    )
    area = 0.275 * 0.7 ** (dimension - 2) + 0.2 * 0.6 ** (dimension - 2)
    faces = dict.fromkeys(names, Traction()) | {"x+": Traction(Constant(-1e-3))}
    problem = Problem("loaded", (0.0,) * dimension, (1.0,) * dimension, ELASTIC, faces, 0.2, shape=Bodies(blocks))
    solution = MaterialPoint("MUSL", FLIP, basis).solve(problem, Discretisation(0.125, 0.3, 2))
    assert solution.outcome.completed, str(solution.outcome)
    time, impulse = solution.histories["time"], solution.histories["impulse_x"]
    assert impulse == pytest.approx(-1e-3 * area * time, abs=1e-15)
    assert solution.histories["momentum_x"] == pytest.approx(impulse, abs=1e-15)


@pytest.mark.parametrize("formulation", ["updated", "total"])
def test_a_loaded_block_within_its_box_is_a_bar(formulation):
    """Poisson's ratio is zero and the sides are on lines of nodes, so that the empty cells beside it have no effect."""
    slender, load = NeoHookean(1.0, 1.0, 0.0), Traction(Constant(0.05))
    bar = Problem("bar", (0.0,), (1.0,), slender, {"x-": Velocity(), "x+": load}, 0.7, outputs=4)
    faces = {"x-": Velocity(), "x+": load, "y-": Traction(), "y+": Traction()}
    block = Problem("block", (0.0, 0.0), (1.0, 1.0), slender, faces, 0.7, outputs=4, shape=Block((0.0, 0.25), (1.0, 0.625)))
    solver, at = MaterialPoint("MUSL", FLIP, "linear", formulation), Discretisation(0.125, 0.3, 2)
    one, two = (solver.solve(problem, at) for problem in (bar, block))
    along = np.searchsorted(one.reference[:, 0], two.reference[:, 0] - 1e-9)
    for name, values in one.fields.items():
        assert two.fields[name][:, :, :1] == pytest.approx(values[:, along], abs=1e-14)


# Several bodies.


@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_bodies_that_touch_move_as_one(dimension, formulation):
    """Two blocks that fill the box have the particles and the motion of one body.

    The material and the scheme are those that other tests compile in the same dimension.
    """
    law, transfer, basis = (MATERIAL, APIC, "quadratic") if dimension == 2 else (ELASTIC, FLIP, "linear")
    lower, upper = (-1.0,) * dimension, (1.0,) * dimension
    faces = {axis + side: Traction() for axis in "xyz"[:dimension] for side in "-+"}
    whole = Problem("whole", lower, upper, law, faces, 0.4, {"velocity": lambda X: 0.1 * np.sin(X)}, outputs=4)
    halves = replace(whole, shape=Bodies((Block(lower, (0.0, *upper[1:])), Block((0.0, *lower[1:]), upper))))
    solver, at = MaterialPoint("USL", transfer, basis, formulation), Discretisation(0.25, 0.3, 2)
    one, two = (solver.solve(problem, at) for problem in (whole, halves))
    order = np.lexsort(two.reference.T)
    assert two.reference[order] == pytest.approx(one.reference[np.lexsort(one.reference.T)], abs=1e-15)
    for name, values in one.fields.items():
        assert two.fields[name][:, order] == pytest.approx(values[:, np.lexsort(one.reference.T)], abs=1e-13)


def flying(X):
    """Velocity of bodies on the left and the right towards each other."""
    return np.where(X[:, :1] < 0, [0.2, 0.05], [-0.2, 0.05])


def test_bodies_without_a_common_node_do_not_interact():
    one, other = Disk((-0.5, 0.1), 0.3), Ring((0.5, -0.1), 0.1, 0.35)
    solver, at = MaterialPoint("USL", APIC, "quadratic"), Discretisation(1 / 16, 0.3, 2)
    both, *alone = (solver.solve(body(shape), at) for shape in (Bodies((one, other)), one, other))
    count = len(alone[0].reference)
    for part, solution in zip((slice(count), slice(count, None)), alone, strict=True):
        assert np.array_equal(both.reference[part], solution.reference)
        for name, values in solution.fields.items():
            assert both.fields[name][:, part] == pytest.approx(values, abs=1e-14 * np.abs(values).max())


@pytest.mark.parametrize("transfer", [FLIP, APIC], ids=lambda transfer: transfer.name)
def test_colliding_disks_exchange_momentum_and_conserve_its_sum(transfer):
    """The disks stay mirror images of each other; each reverses its motion along x and keeps that along y."""
    disks = Bodies((Disk((-0.375, 0.0), 0.25), Disk((0.375, 0.0), 0.25)))
    problem = replace(body(disks), initial={"velocity": flying}, end_time=3.0, outputs=12)
    solver, at = MaterialPoint("MUSL", transfer, "quadratic"), Discretisation(1 / 16, 0.3, 2)
    solution = solver.solve(problem, at)
    assert solution.outcome.completed, str(solution.outcome)
    left = solution.reference[:, 0] < 0
    mass, v = MATERIAL.density * solution.weight[0], solution.fields["velocity"]
    momentum = [np.einsum("p,tpk->tk", mass[side], v[:, side]) for side in (left, ~left)]
    scale = np.abs(momentum[0]).max()
    assert momentum[0] + momentum[1] == pytest.approx(np.array([[0.0, 2 * momentum[0][0, 1]]] * 13), abs=1e-12 * scale)
    assert momentum[0][:, 1] == pytest.approx(momentum[1][:, 1], abs=1e-10 * scale)
    assert momentum[0][0, 0] == pytest.approx(0.2 * disks.measure / 2 * MATERIAL.density, rel=1e-12)
    assert momentum[0][-1, 0] < -0.3 * momentum[0][0, 0]


# Bad input.


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: offset(0.5), "offset"),
        (lambda: offset(math.nan), "offset"),
        (lambda: Layout("mine", offset=-0.6), "offset"),
        (lambda: Bodies(()), "give one or more bodies"),
        (lambda: Bodies((Block((0.0,), (1.0,)), Disk((2.0, 0.0), 0.5))), "bodies of the same dimension"),
        (lambda: Block((0.0, 0.0), (1.0, 0.0)), "the upper above the lower"),
        (lambda: Block((0.0,), (1.0, 1.0)), "two corners"),
        (lambda: Block((0.0,), (math.inf,)), "finite"),
        (lambda: body(Block((0.0, 0.0), (1.1, 1.0))), "must lie in the box, in its dimension"),
        (lambda: body(Bodies((Block((0.0,), (0.5,)),))), "must lie in the box, in its dimension"),
        (lambda: MaterialPoint(layout="gauss"), "the layout of a material point solver"),
        (
            lambda: MaterialPoint().solve(
                body(Disk((0.5, 0.0), 0.5), FREE | {"x+": Traction(Constant(1.0))}), Discretisation(0.25, 0.5)
            ),
            "no traction on faces that no side of a body lies against",
        ),
    ],
)
def test_bad_input_is_refused(call, said):
    with pytest.raises(UsageError, match=said):
        call()
