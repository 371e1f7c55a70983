"""Bodies of a shape in the material point method: exact parts of the cells, free surfaces that cut them, layouts of particles."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.convergence.judging import verdict
from mpmverify.errors import UsageError
from mpmverify.exact.ring import expanding_ring
from mpmverify.norms import NORMS, errors
from mpmverify.problem import Constant, Discretisation, Disk, Fixed, NeoHookean, Problem, Ring, Traction
from mpmverify.solvers.mpm import APIC, FLIP, GAUSS, REGULAR, Layout, MaterialPoint, fmpm, offset
from mpmverify.solvers.mpm.layout import SLIVER, place_particles
from mpmverify.verdict import Verdict

CENTERS = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
DISKS = st.builds(Disk, CENTERS, st.floats(0.05, 0.7))
RINGS = st.builds(
    lambda center, outer, part: Ring(center, part * outer, outer), CENTERS, st.floats(0.05, 0.7), st.floats(0.1, 0.95)
)
SHAPES = DISKS | RINGS
LAYOUTS = st.sampled_from([REGULAR, GAUSS, offset(0.3), offset(-0.49)])
MATERIAL = NeoHookean(1.0, 1.0, 0.3)
FREE = dict.fromkeys(("x-", "x+", "y-", "y+"), Traction())


def swelling(X):
    """A velocity of translation, stretch and turn."""
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
def test_parts_of_boxes_that_no_circle_cuts_are_all_or_nothing(shape, n):
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
    """A quarter, a half, and the segment that a side cuts off."""
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
    """Area of a box as the integral of the chord within it, by the midpoint rule."""
    (x0, x1), (y0, y1) = sorted(corners[:2]), sorted(corners[2:])
    x = x0 + (x1 - x0) * (np.arange(20_000) + 0.5) / 20_000 - shape.center[0]

    def chord(radius):
        half = np.sqrt(np.maximum(radius**2 - x**2, 0))
        return np.maximum(np.minimum(y1 - shape.center[1], half) - np.maximum(y0 - shape.center[1], -half), 0)

    inside = chord(shape.outer) - chord(shape.inner) if isinstance(shape, Ring) else chord(shape.radius)
    area, _ = shape.parts(np.array([[x0, y0]]), np.array([[x1, y1]]))
    assert area[0] == pytest.approx(inside.mean() * (x1 - x0), abs=1e-6)


# Particles.


@given(SHAPES, st.integers(2, 16), st.integers(1, 4), LAYOUTS, st.sampled_from([0.0, 0.49]))
def test_particles_have_the_measure_of_the_body_and_none_is_a_sliver(shape, cells, ppc, layout, jitter):
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
def test_gauss_points_integrate_polynomials_of_degree_2_ppc_less_1(ppc, dimension, cells):
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


def test_layouts_have_names_of_their_own():
    layouts = (REGULAR, GAUSS, offset(0.25), offset(-0.25))
    names = [MaterialPoint(layout=layout).name for layout in layouts]
    assert names[0] == MaterialPoint().name == "mpm-ul-linear-musl-flip"
    assert names[1:] == [f"{names[0]}-{end}" for end in ("gauss", "offset0.25", "offset-0.25")]


# Free surfaces that cut cells.


@pytest.mark.parametrize("layout", [REGULAR, GAUSS, offset(0.25)], ids=lambda layout: layout.name)
@pytest.mark.parametrize("transfer", [FLIP, APIC, fmpm(2)], ids=lambda transfer: transfer.name)
@pytest.mark.parametrize("formulation", ["updated", "total"])
def test_a_free_disk_keeps_mass_and_momentum(transfer, formulation, layout):
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
def test_a_free_disk_keeps_its_angular_momentum_with_apic(schedule, monkeypatch):
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


@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize(
    ("schedule", "transfer", "basis"), [("MUSL", FLIP, "linear"), ("USF", FLIP, "linear"), ("USL", APIC, "quadratic")]
)
def test_a_surface_just_beyond_a_line_of_nodes_does_no_harm(schedule, transfer, basis, formulation):
    """The energy follows the radius, and no particle has a stress of its own."""
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


def test_nodes_that_no_particle_reaches_may_be_held():
    at, disk = Discretisation(1 / 8, 0.3, 2), Disk((0.0, 0.0), 0.5)
    free, held = (MaterialPoint().solve(body(disk, faces), at) for faces in (FREE, dict.fromkeys(FREE, Fixed())))
    assert np.array_equal(free.position, held.position)


# Bad input.


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: offset(0.5), "offset"),
        (lambda: offset(math.nan), "offset"),
        (lambda: Layout("mine", offset=-0.6), "offset"),
        (lambda: MaterialPoint(layout="gauss"), "the layout of a material point solver"),
        (
            lambda: MaterialPoint().solve(
                body(Disk((0.0, 0.0), 0.5), FREE | {"x+": Traction(Constant(1.0))}), Discretisation(0.25, 0.5)
            ),
            "no traction on faces that the body does not touch",
        ),
    ],
)
def test_bad_input_is_refused(call, said):
    with pytest.raises(UsageError, match=said):
        call()
