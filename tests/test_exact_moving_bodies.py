"""Closed forms of loaded, clamped, drifting, translating and spinning bodies, checked by means that do not use their formulas."""

import itertools
import pickle

import numpy as np
import pytest
from latex2mathml.converter import convert
from test_exact import difference
from test_exact_large_strain import PAIRS, deformation_gradient, piola, scale_of

from mpmverify.errors import UsageError
from mpmverify.exact.clamped_shear import clamped_shear
from mpmverify.exact.drifting_waves import drifting_waves
from mpmverify.exact.pushed_block import pushed_block
from mpmverify.exact.spinning_body import spinning_body
from mpmverify.exact.two_bodies import two_bodies
from mpmverify.problem import Block, Fixed, Periodic, Spatial, Traction

OTHER = {"youngs_modulus": 3.0, "density": 2.0, "poissons_ratio": -0.2}
FINITE = {
    "ring": drifting_waves(1),
    "square": drifting_waves(2),
    "cube": drifting_waves(3),
    "ring, other": drifting_waves(1, (-0.05,), (-0.4,), **OTHER),
    "square, other": drifting_waves(2, (0.08, -0.05), (0.0, 0.3), **OTHER),
    "cube, other": drifting_waves(3, (0.08, -0.05, 0.06), (0.0, 0.0, 0.0), **OTHER),
    "layer, plane": clamped_shear(2),
    "layer, space": clamped_shear(3),
    "layer, other": clamped_shear(3, (-0.1, 0.2), **OTHER),
    "blocks, plane": two_bodies(2),
    "blocks, space": two_bodies(3),
    "disk": spinning_body(),
    "cube, spinning": spinning_body(3),
    "disk, other": spinning_body(spin=-0.8, radians=2.0, **OTHER),
}
PUSHED = {"pushed, plane": pushed_block(2), "pushed, space": pushed_block(3, youngs_modulus=3.0, density=2.0)}
PUSHED |= {f"{name}, {d}D": pushed_block(d, name) for d in (2, 3) for name in ("joined", "pair")}
PROBLEMS = FINITE | PUSHED
finite = pytest.mark.parametrize("verification", FINITE.values(), ids=FINITE.keys())
pushed = pytest.mark.parametrize("verification", PUSHED.values(), ids=PUSHED.keys())
every = pytest.mark.parametrize("verification", PROBLEMS.values(), ids=PROBLEMS.keys())
DELTA = 0.004


def points(problem, count=40, margin=10 * DELTA):
    """Random points of the body at least a margin away from its surface (P, dim)."""
    X = np.random.default_rng(1).uniform(problem.lower, problem.upper, (100 * count, problem.dimension))
    around = [X + margin * np.array(step) for step in itertools.product((-1, 1), repeat=problem.dimension)]
    if problem.shape is None:
        kept = [np.all((problem.lower <= Y) & (problem.upper >= Y), axis=1) for Y in around]
    else:
        kept = [problem.shape.contains(Y) for Y in around]
    return X[np.all(kept, axis=0)][:count]


def times(problem, count=7):
    return np.random.default_rng(2).uniform(0, problem.end_time, count)


def body_force(verification, X, t):
    """Body force at material points (T, P, dim), which a field in space gives at their exact places."""
    problem = verification.problem
    if problem.body_force is None:
        return np.zeros((len(t), *X.shape))
    if not isinstance(problem.body_force, Spatial):
        return problem.body_force(X, t)
    x = X + verification.exact.fields["displacement"](X, t)
    return np.stack([problem.body_force.force(here, t[k : k + 1])[0] for k, here in enumerate(x)])


@finite
def test_momentum_is_balanced(verification):
    problem, fields = verification.problem, verification.exact.fields
    law, X, t, axes = problem.material, points(problem), times(problem), np.eye(problem.dimension)
    acceleration = difference(lambda s: fields["velocity"](X, t + s), 0.002 * problem.end_time)
    divergence = sum(
        difference(lambda s, e=e: piola(deformation_gradient(fields["displacement"], X + s * e, t, DELTA), law) @ e, DELTA)
        for e in axes
    )
    terms = law.density * acceleration, divergence, law.density * body_force(verification, X, t)
    scale = max(scale_of(*terms), 1e-3 * law.youngs_modulus)
    assert scale_of(terms[0] - terms[1] - terms[2]) <= 1e-8 * scale


@finite
def test_fields_follow_from_the_displacement(verification):
    problem, fields, law = verification.problem, verification.exact.fields, verification.problem.material
    X, t, u = points(problem), times(problem), verification.exact.fields["displacement"]
    velocity = difference(lambda s: u(X, t + s), 0.004 * problem.end_time)
    assert scale_of(velocity - fields["velocity"](X, t)) <= 1e-9 * scale_of(velocity)
    F = deformation_gradient(u, X, t, 0.002)
    if "displacement_gradient" in fields:
        assert scale_of(F - np.eye(problem.dimension) - fields["displacement_gradient"](X, t).reshape(F.shape)) <= 1e-9
    J = np.linalg.det(F)
    assert J.min() > 0.3
    sigma = piola(F, law) @ np.swapaxes(F, -1, -2) / J[..., None, None]
    for k, (i, j) in enumerate(PAIRS[problem.dimension]):
        assert scale_of(fields["stress"](X, t)[..., k] - sigma[..., i, j]) <= 1e-8 * law.youngs_modulus


@pushed
def test_a_pushed_block_obeys_linear_elasticity_away_from_its_fronts(verification):
    problem, fields, law = verification.problem, verification.exact.fields, verification.problem.material
    t = 0.5 * problem.end_time * np.ones(1)
    X = points(problem, 400, margin=0.03)
    side = problem.shape.bodies[0]
    front = law.wave_speed * t[0]
    distance = np.abs(np.stack([side.upper[0] - X[:, 0], X[:, 1] - side.lower[1], *(side.upper[2:] - X[:, 2:]).T]))
    X = X[np.all(np.abs(distance - front) > 0.03, axis=0)]
    H = deformation_gradient(fields["displacement"], X, t, 0.002) - np.eye(problem.dimension)
    stress = fields["stress"](X, t)
    for k, (i, j) in enumerate(PAIRS[problem.dimension]):
        assert scale_of(law.youngs_modulus * (H[..., i, j] + H[..., j, i]) / 2 - stress[..., k]) <= 1e-9 * scale_of(stress)
    velocity = difference(lambda s: fields["displacement"](X, t + s), 0.001)
    assert scale_of(velocity - fields["velocity"](X, t)) <= 1e-9 * scale_of(velocity)
    acceleration = difference(lambda s: fields["velocity"](X, t + s), 0.001)
    pull = [difference(lambda s, e=e: fields["stress"](X + s * e, t), 0.001)[..., k] for k, e in enumerate(np.eye(X.shape[1]))]
    assert scale_of(law.density * acceleration - np.stack(pull, axis=-1)) <= 1e-8 * scale_of(law.density * acceleration)


@pushed
def test_sides_of_a_pushed_block_are_loaded_as_prescribed_and_else_free(verification):
    problem, stress = verification.problem, verification.exact.fields["stress"]
    t = np.linspace(0, problem.end_time, 9)
    for body, k, (name, end) in itertools.product(
        problem.shape.bodies, range(problem.dimension), (("-", "lower"), ("+", "upper"))
    ):
        corner, face = getattr(body, end), "xyz"[k] + name
        X = np.random.default_rng(3).uniform(body.lower, body.upper, (20, problem.dimension))
        X[:, k] = corner[k]
        on_box = corner[k] == (problem.lower if name == "-" else problem.upper)[k]
        loaded = on_box and problem.boundary[face] != Periodic()
        expected = problem.boundary[face].value(t) if loaded else np.zeros(9)
        for c, pair in enumerate(PAIRS[problem.dimension]):
            wanted = expected if pair == (k, k) else np.zeros(9)
            if k in pair:
                np.testing.assert_allclose(stress(X, t)[..., c], np.tile(wanted[:, None], 20), rtol=0, atol=1e-20)
    faces = [face for face, condition in problem.boundary.items() if condition not in (Traction(), Periodic())]
    assert len(faces) == sum(p.any() for p in verification.exact.totals["momentum"](t).T)
    for face in faces:
        sides, k = problem.touched(face), "xyz".index(face[0])
        assert len(sides) == len(problem.shape.bodies)
        area, whole = (
            sum(np.delete(np.subtract(b.upper, b.lower), k).prod() for b in blocks)
            for blocks in (sides, [Block(problem.lower, problem.upper)])
        )
        assert area < whole or Periodic() in problem.boundary.values(), "the side is a part of the face"


@every
def test_initial_conditions(verification):
    problem, X = verification.problem, points(verification.problem, margin=0.0)
    for quantity, field in verification.exact.fields.items():
        np.testing.assert_array_equal(field(X, np.zeros(1))[0], problem.initial_field(quantity, X))


@every
def test_totals_are_integrals_of_the_fields(verification):
    """Midpoints of small cells integrate the velocity; it is linear in each body but for the fronts of the pushed block."""
    problem, totals = verification.problem, verification.exact.totals
    assert bool(totals) == (problem.shape is not None and problem.body_force is None)
    t = np.linspace(0, problem.end_time, 5)
    found = dict.fromkeys(totals, 0.0)
    for body in problem.shape.bodies if totals else ():
        cells = np.stack(np.meshgrid(*[(np.arange(48) + 0.5) / 48] * problem.dimension, indexing="ij"), axis=-1)
        X = body.lower + cells.reshape(-1, problem.dimension) * np.subtract(body.upper, body.lower)
        p = verification.exact.fields["velocity"](X, t) * problem.material.density * body.measure / len(X)
        x = X + verification.exact.fields["displacement"](X, t)
        spin = np.cross(*(np.pad(vectors, [(0, 0), (0, 0), (0, 3 - problem.dimension)]) for vectors in (x, p)))
        found["momentum"] = found["momentum"] + p.sum(axis=1)
        if "angular_momentum" in totals:
            found["angular_momentum"] = found["angular_momentum"] + spin.sum(axis=1)[:, 3 - 2 * problem.dimension :]
    for stock, total in totals.items():
        np.testing.assert_allclose(total(t), found[stock][:, -total(t).shape[1] :], rtol=0, atol=2e-4 * scale_of(total(t)))


@every
def test_joined_ends_are_periodic_and_clamped_faces_at_rest(verification):
    problem, fields, t = verification.problem, verification.exact.fields, times(verification.problem)
    if problem.shape is not None:
        return
    X, axes = points(problem, margin=0.0), np.eye(problem.dimension)
    for k, e in enumerate(axes):
        condition = problem.boundary["xyz"[k] + "-"]
        for field in fields.values():
            if condition == Periodic():
                np.testing.assert_allclose(field(X + e, t), field(X, t), rtol=0, atol=1e-13 * scale_of(field(X, t)))
        if condition == Fixed():
            for place, quantity in itertools.product((0.0, 1.0), ("displacement", "velocity")):
                there = np.where(e == 1, place, X)
                assert scale_of(fields[quantity](there, t)) <= 1e-15 * scale_of(fields[quantity](X, t))


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_faces_of_the_layer_bear_a_shear_that_would_let_them_slip(dimension):
    layer = clamped_shear(dimension)
    X, t = np.full((1, dimension), 0.0), np.array([layer.problem.end_time])
    shear = layer.exact.fields["stress"](X, t)[0, 0, PAIRS[dimension].index((0, 1))]
    assert abs(shear) > 0.1 * layer.problem.material.shear_modulus


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_two_bodies_stay_apart_and_pass_the_joined_ends(dimension):
    problem = two_bodies(dimension).problem
    one, other = problem.shape.bodies
    t = np.linspace(0, problem.end_time, 11)
    X = np.array([one.lower, other.lower])
    moved = two_bodies(dimension).exact.fields["displacement"](X, t)
    low, high = np.array(one.upper) + moved[:, 0], np.array(other.lower) + moved[:, 1]
    assert np.all(high[:, 1] - low[:, 1] >= 0.5)
    inside = (
        (np.array([b.lower for b in (one, other)]) + moved)[..., 1],
        (np.array([b.upper for b in (one, other)]) + moved)[..., 1],
    )
    assert inside[0].min() > problem.lower[1]
    assert inside[1].max() < problem.upper[1]
    assert (np.array(one.upper) + moved[-1, 0])[0] > problem.upper[0]
    assert (np.array(other.lower) + moved[-1, 1])[0] < problem.lower[0]


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_drifting_particles_pass_joined_ends_and_cells(dimension):
    problem = drifting_waves(dimension)
    u = problem.exact.fields["displacement"](points(problem.problem), np.array([problem.problem.end_time]))
    assert np.all(np.abs(u) > 0.15)


def test_the_three_shears_of_the_cube_differ_and_it_starts_with_an_acceleration():
    cube = drifting_waves(3)
    X, t = points(cube.problem), np.array([cube.problem.end_time])
    H = cube.exact.fields["displacement_gradient"](X, t).reshape(-1, 3, 3)
    largest = sorted(np.abs(H).max(axis=0)[[0, 1, 2], [1, 2, 0]])
    assert largest[0] > 0.02
    assert all(b > 1.3 * a for a, b in itertools.pairwise(largest))
    assert scale_of(cube.problem.body_force(X, np.zeros(1))) > 0.1


@every
def test_problems_are_frozen_and_picklable_and_their_equations_render_as_mathml(verification):
    assert pickle.loads(pickle.dumps(verification)) == verification
    for value in (*verification.exact.fields.values(), *verification.exact.totals.values()):
        assert value.__dataclass_params__.frozen
        assert hash(value)
    assert verification.exposes.endswith(".")
    for equation in verification.equations:
        assert "merror" not in convert(equation)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: drifting_waves(4), "1, 2 or 3 dimensions, not 4"),
        (lambda: drifting_waves(2, (0.0, 0.1)), "not zero"),
        (lambda: drifting_waves(1, (0.08,)), "below 1"),
        (lambda: clamped_shear(1), "2 or 3 dimensions, not 1"),
        (lambda: clamped_shear(2, (0.0, 1.0)), "must not be zero"),
        (lambda: pushed_block(1), "2 or 3 dimensions, not 1"),
        (lambda: pushed_block(2, "row"), "corner, joined, pair, not 'row'"),
        (lambda: spinning_body(1), "2 or 3 dimensions, not 1"),
        (lambda: spinning_body(spin=0.0), "a spin that is not zero"),
        (lambda: spinning_body(radians=-1.0), "final time must be positive"),
        (lambda: two_bodies(1), "2 or 3 dimensions, not 1"),
    ],
)
def test_invalid_arguments_raise_a_usage_error(make, message):
    with pytest.raises(UsageError, match=message):
        make()
