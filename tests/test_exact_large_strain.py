"""Closed forms of large deformation, checked by means that do not use their formulas.

Deformation gradients are finite differences of the displacement, and the stress is the derivative of the energy, by complex steps.
With these the balance of momentum is checked, and every other field is compared with the one derived from the displacement.
"""

import dataclasses
import itertools
import math
import pickle

import numpy as np
import pytest
from arrays import assert_times_are_independent
from latex2mathml.converter import convert
from test_exact import difference

from mpmverify.errors import UsageError
from mpmverify.exact import ring, vortex
from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.finite_strain import cauchy_stress, volume_change
from mpmverify.exact.ring import expanding_ring
from mpmverify.exact.steffen import steffen
from mpmverify.exact.vortex import generalised_vortex
from mpmverify.problem import Disk, Fixed, NeoHookean, Ring, Velocity

PROBLEMS = {
    "steffen": steffen(),
    "steffen, other": steffen(-0.12, youngs_modulus=3.0, density=2.0),
    "square": axis_aligned(2),
    "cube": axis_aligned(3),
    "square, other": axis_aligned(2, -0.2, youngs_modulus=3.0, density=2.0, poissons_ratio=-0.2),
    "cube, other": axis_aligned(3, 0.25, youngs_modulus=3.0, density=2.0, poissons_ratio=0.1),
    "ring": expanding_ring(),
    "ring, other": expanding_ring(-0.3, youngs_modulus=3.0, density=2.0, end_time=3.0),
    "vortex": generalised_vortex(),
    "vortex, other": generalised_vortex(-0.4, youngs_modulus=3.0, density=2.0, poissons_ratio=-0.2, end_time=3.7),
}
PAIRS = {1: [(0, 0)], 2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]}
"""Row and column of each component of a stress, as `Solution` orders them."""
every_problem = pytest.mark.parametrize("verification", PROBLEMS.values(), ids=PROBLEMS.keys())


def points(problem, count, seed=1, margin=0.0):
    """Return random points of the body (P, dim), at least a margin away from its surface."""
    generator = np.random.default_rng(seed)
    X = generator.uniform(problem.lower, problem.upper, (400 * count, problem.dimension))
    if problem.shape is None:
        middle, half = np.add(problem.lower, problem.upper) / 2, np.array(problem.lengths) / 2
        return (middle + (X - middle) * (1 - margin / half))[:count]
    body = Ring(problem.shape.center, problem.shape.inner + margin, problem.shape.outer - margin)
    return X[body.contains(X)][:count]


def times(problem, count=7):
    return np.random.default_rng(2).uniform(0, problem.end_time, count)


def energy(F, law):
    """Return the energy W (...) given in `NeoHookean`, from all nine entries of F (..., 3, 3); F may be complex."""
    log_J = np.log(np.linalg.det(F))
    return law.shear_modulus / 2 * (np.sum(F * F, axis=(-1, -2)) - 3 - 2 * log_J) + law.lame_lambda / 2 * log_J**2


def piola(F, law):
    """Return P = dW/dF (..., dim, dim) by complex steps; in plane strain F_33 = 1."""
    dimension, step = F.shape[-1], 1e-40
    full = np.zeros((*F.shape[:-2], 3, 3), dtype=complex) + np.eye(3)
    full[..., :dimension, :dimension] = F
    P = np.zeros(F.shape)
    for i, j in itertools.product(range(dimension), repeat=2):
        moved = full.copy()
        moved[..., i, j] += 1j * step
        P[..., i, j] = energy(moved, law).imag / step
    return P


def deformation_gradient(field, X, t, delta):
    """Return F (T, P, dim, dim) by differences of the displacement."""
    axes = np.eye(X.shape[1])
    columns = [difference(lambda s, e=e: field(X + s * e, t), delta) for e in axes]
    return axes + np.stack(columns, axis=-1)


def scale_of(*terms):
    return max(np.max(np.abs(term)) for term in terms)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_stress_is_the_derivative_of_the_energy(dimension):
    law = NeoHookean(7.0, 2.0, 0.3)
    H = np.random.default_rng(3).uniform(-0.3, 0.3, (50, dimension, dimension))
    F = np.eye(dimension) + H
    J, inverse = np.linalg.det(F)[:, None, None], np.swapaxes(np.linalg.inv(F), 1, 2)
    P = piola(F, law)
    expected = law.lame_lambda * np.log(J) * inverse + law.shear_modulus * (F - inverse)
    np.testing.assert_allclose(P, expected, rtol=0, atol=1e-13 * scale_of(P))
    sigma = P @ np.swapaxes(F, 1, 2) / J
    found = cauchy_stress(law, H)
    for k, (i, j) in enumerate(PAIRS[dimension]):
        np.testing.assert_allclose(found[:, k], sigma[:, i, j], rtol=0, atol=1e-13 * scale_of(sigma))


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_small_change_of_volume_has_no_cancellation(dimension):
    H = np.random.default_rng(5).normal(size=(50, dimension, dimension))
    assert volume_change(H) == pytest.approx(np.linalg.det(np.eye(dimension) + H) - 1, rel=1e-12, abs=1e-12)
    small = 1e-12 * H
    trace = np.trace(small, axis1=-2, axis2=-1)
    quadratic = 0.5 * (trace**2 - np.trace(small @ small, axis1=-2, axis2=-1))
    assert volume_change(small) == pytest.approx(trace + quadratic, rel=1e-14, abs=1e-27)


def test_the_stress_of_a_rotated_body_is_rotated():
    law, H = NeoHookean(7.0, 2.0, 0.3), np.random.default_rng(4).uniform(-0.3, 0.3, (20, 3, 3))
    Q, _ = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))
    Q *= np.sign(np.linalg.det(Q))

    def full(components):
        sigma = np.zeros((20, 3, 3))
        for k, (i, j) in enumerate(PAIRS[3]):
            sigma[:, i, j] = sigma[:, j, i] = components[:, k]
        return sigma

    turned = full(cauchy_stress(law, Q @ (np.eye(3) + H) - np.eye(3)))
    np.testing.assert_allclose(turned, Q @ full(cauchy_stress(law, H)) @ Q.T, rtol=0, atol=1e-12)


@every_problem
def test_momentum_is_balanced(verification):
    problem, law, u = verification.problem, verification.problem.material, verification.exact.fields["displacement"]
    delta = 0.004
    X, t = points(problem, 40, margin=10 * delta), times(problem)
    dt = 0.002 * problem.end_time
    velocity = verification.exact.fields["velocity"]
    acceleration = difference(lambda s: velocity(X, t + s), dt)
    divergence = sum(
        difference(lambda s, e=e: piola(deformation_gradient(u, X + s * e, t, delta), law) @ e, delta)
        for e in np.eye(problem.dimension)
    )
    terms = law.density * acceleration, divergence, law.density * problem.body_force(X, t)
    assert scale_of(terms[0] - terms[1] - terms[2]) <= 1e-9 * scale_of(*terms)
    assert min(scale_of(term) for term in terms) > 1e-3 * scale_of(*terms), "every term contributes"


@every_problem
def test_fields_follow_from_the_displacement(verification):
    problem, fields, law = verification.problem, verification.exact.fields, verification.problem.material
    X, t, dimension = points(problem, 100), times(problem), verification.problem.dimension
    u = fields["displacement"]
    velocity = difference(lambda s: u(X, t + s), 0.004 * problem.end_time)
    assert scale_of(velocity - fields["velocity"](X, t)) <= 1e-10 * scale_of(velocity)
    F = deformation_gradient(u, X, t, 0.002)
    gradient = fields["displacement_gradient"](X, t).reshape(F.shape)
    assert scale_of(F - np.eye(dimension) - gradient) <= 1e-10
    J = np.linalg.det(F)
    assert J.min() > 0
    sigma = piola(F, law) @ np.swapaxes(F, -1, -2) / J[..., None, None]
    stress = fields["stress"](X, t)
    assert stress.shape[-1] == len(PAIRS[dimension])
    for k, (i, j) in enumerate(PAIRS[dimension]):
        assert scale_of(stress[..., k] - sigma[..., i, j]) <= 1e-9 * scale_of(sigma)


@every_problem
def test_initial_conditions(verification):
    problem, X = verification.problem, points(verification.problem, 100)
    assert set(problem.initial) <= set(verification.exact.fields)
    for quantity, field in verification.exact.fields.items():
        scale = scale_of(field(X, np.linspace(0, problem.end_time, 50)))
        start = problem.initial_field(quantity, X)
        np.testing.assert_allclose(field(X, np.zeros(1))[0], start, rtol=0, atol=1e-14 * scale)


@pytest.mark.parametrize("name", [name for name in PROBLEMS if PROBLEMS[name].problem.shape is None])
def test_faces_are_rollers(name):
    problem, fields = PROBLEMS[name].problem, PROBLEMS[name].exact.fields
    t, dimension = times(problem, 20), problem.dimension
    scale = {quantity: scale_of(field(points(problem, 100), t)) for quantity, field in fields.items()}
    for k, (side, corner) in itertools.product(range(dimension), (("-", problem.lower), ("+", problem.upper))):
        assert isinstance(problem.boundary["xyz"[k] + side], Velocity)
        assert not problem.boundary["xyz"[k] + side].value(t).any()
        X = points(problem, 50)
        X[:, k] = corner[k]
        for quantity in ("displacement", "velocity"):
            assert scale_of(fields[quantity](X, t)[..., k]) <= 1e-13 * scale[quantity]
        shear = [n for n, pair in enumerate(PAIRS[dimension]) if k in pair and pair != (k, k)]
        assert not fields["stress"](X, t)[..., shear].any()


@pytest.mark.parametrize("name", ["steffen", "square", "cube"])
def test_no_field_vanishes_at_the_final_time(name):
    """The rings are judged over all times, because their displacement is zero at the final time of the literature."""
    problem, fields = PROBLEMS[name].problem, PROBLEMS[name].exact.fields
    X, t = points(problem, 200), np.linspace(0, problem.end_time, 200)
    for field in fields.values():
        norms = np.sqrt(np.mean(field(X, t) ** 2, axis=(1, 2)))
        assert norms[-1] > 0.05 * norms.max()


@pytest.mark.parametrize("name", [name for name in PROBLEMS if PROBLEMS[name].problem.shape is not None])
def test_surfaces_of_rings_are_free_and_stay_within_the_box(name):
    problem, exact = PROBLEMS[name].problem, PROBLEMS[name].exact
    t, angle = np.linspace(0, problem.end_time, 41), np.linspace(0, 2 * np.pi, 37)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    scale = scale_of(exact.fields["stress"](points(problem, 100), t))
    for radius in (problem.shape.inner, problem.shape.outer):
        X = problem.shape.center + radius * normal
        H = exact.fields["displacement_gradient"](X, t).reshape(len(t), len(X), 2, 2)
        traction = piola(np.eye(2) + H, problem.material) @ normal[None, :, :, None]
        assert scale_of(traction) <= 1e-12 * scale
        x = X + exact.fields["displacement"](X, t)
        assert np.all((x > problem.lower) & (x < problem.upper))


@pytest.mark.parametrize("name", ["ring", "vortex", "vortex, other"])
def test_fields_of_rings_are_rotation_symmetric(name):
    problem, exact = PROBLEMS[name].problem, PROBLEMS[name].exact
    X, t = points(problem, 60), times(problem)
    Q = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    for field in (exact.fields["displacement"], exact.fields["velocity"], problem.body_force):
        np.testing.assert_allclose(field(X @ Q.T, t), field(X, t) @ Q.T, rtol=0, atol=1e-12 * scale_of(field(X, t)))


def test_permuting_the_axes_of_the_cube_is_a_shift_in_time():
    """The phases of the axes differ by a third of a period."""
    problem, exact = PROBLEMS["cube"].problem, PROBLEMS["cube"].exact
    X, t, third = points(problem, 60), times(problem), 2 / 3 / 100.0
    for quantity in ("displacement", "velocity"):
        field = exact.fields[quantity]
        now, later = field(X, t), field(X[:, [1, 2, 0]], t + third)
        np.testing.assert_allclose(later, now[..., [1, 2, 0]], rtol=0, atol=1e-12 * scale_of(now))


def test_the_vortex_is_simple_shear_in_polar_components():
    problem, field = PROBLEMS["vortex"].problem, PROBLEMS["vortex"].exact.fields
    X, t, mu = points(problem, 60), times(problem), problem.material.shear_modulus
    R = np.hypot(*X.T)
    F = np.eye(2) + field["displacement_gradient"](X, t).reshape(len(t), len(X), 2, 2)
    assert np.allclose(np.linalg.det(F), 1, rtol=0, atol=1e-13)
    x = X + field["displacement"](X, t)
    np.testing.assert_allclose(np.hypot(x[..., 0], x[..., 1]), np.broadcast_to(R, x.shape[:2]), rtol=1e-14)
    xx, yy, xy = np.moveaxis(field["stress"](X, t), -1, 0)
    cos, sin = x[..., 0] / R, x[..., 1] / R
    slope = np.sin(np.pi * t)[:, None] * (-64 * (R - 1) + 1024 * (R - 1) ** 3)
    radial = cos**2 * xx + sin**2 * yy + 2 * sin * cos * xy
    shear = sin * cos * (yy - xx) + (cos**2 - sin**2) * xy
    np.testing.assert_allclose(radial, 0, rtol=0, atol=1e-12 * scale_of(xx))
    np.testing.assert_allclose(shear, mu * R * slope, rtol=0, atol=1e-12 * scale_of(xx))
    np.testing.assert_allclose(xx + yy, mu * (R * slope) ** 2, rtol=0, atol=1e-12 * scale_of(xx))


@pytest.mark.parametrize("poissons_ratio", [-0.2, 0.3])
def test_the_force_of_a_small_motion_is_that_of_linear_elasticity(poissons_ratio):
    """The axes are uncoupled: rho b_i = rho u_tt - (lambda + 2 mu) d_ii u_i."""
    problem = axis_aligned(2, 1e-7, poissons_ratio=poissons_ratio).problem
    law, X, t = problem.material, points(problem, 60), times(problem)
    u = axis_aligned(2, 1e-7, poissons_ratio=poissons_ratio).exact.fields["displacement"](X, t)
    linear = np.pi**2 * u * (law.lame_lambda + 2 * law.shear_modulus - law.youngs_modulus) / law.density
    np.testing.assert_allclose(problem.body_force(X, t), linear, rtol=0, atol=1e-5 * scale_of(linear))


@pytest.mark.parametrize("sign", [-1, 1])
def test_stretches_of_a_ring_just_below_the_largest_amplitude_are_positive(sign):
    verification = expanding_ring(sign * 0.999 * ring.MAX_AMPLITUDE)
    R = np.linspace(ring.INNER, ring.OUTER, 201)
    X = np.stack([R, 0 * R], axis=1)
    t = np.linspace(0, verification.problem.end_time, 401)
    F = 1 + verification.exact.fields["displacement_gradient"](X, t)[..., [0, 3]]
    assert 0 < F.min() < 2e-3


def test_the_force_is_finite_at_every_node_of_a_grid():
    for verification in (expanding_ring(), generalised_vortex()):
        nodes = np.stack(np.meshgrid(*[np.linspace(-1, 1, 9)] * 2), axis=-1).reshape(-1, 2)
        force = verification.problem.body_force(nodes, np.linspace(0, 1, 9) * verification.problem.end_time)
        assert np.isfinite(force).all()


def test_the_published_constants():
    square, vortex_ring = axis_aligned(2).problem.material, generalised_vortex().problem.material
    bulk = square.lame_lambda + 2 / 3 * square.shear_modulus
    assert (square.shear_modulus, bulk) == (pytest.approx(3846.15, abs=0.01), pytest.approx(8333.33, abs=0.01))
    assert (vortex_ring.shear_modulus, vortex_ring.lame_lambda) == (
        pytest.approx(384.615, abs=1e-3),
        pytest.approx(577, abs=0.1),
    )
    assert expanding_ring().exact.fields["displacement"](np.array([[0.6, 0.0]]), np.array([0.005]))[0, 0] == pytest.approx(
        [0.1, 0]
    )


@every_problem
def test_fields_are_finite_values_of_the_declared_shape(verification):
    problem, X = verification.problem, points(verification.problem, 9)
    t = np.array([0.0, 0.5, 1.0, 40.3]) * problem.end_time
    for quantity, field in verification.exact.fields.items():
        assert field(X, t).shape == (4, *problem.initial_field(quantity, X).shape)
        assert np.isfinite(field(X, t)).all()
        assert_times_are_independent(field, X, t, 2)
    assert problem.body_force(X, t).shape == (4, *X.shape)


@every_problem
def test_problems_are_frozen_and_picklable_and_their_equations_render_as_mathml(verification):
    assert pickle.loads(pickle.dumps(verification)) == verification
    assert hash(verification.problem.body_force)
    for value in (*verification.problem.initial.values(), *verification.exact.fields.values()):
        assert value.__dataclass_params__.frozen
    assert verification.exposes.endswith(".")
    assert len(verification.equations) >= 4
    for equation in verification.equations:
        mathml = convert(equation)
        assert "\\" not in mathml
        assert "merror" not in mathml


RING = expanding_ring().problem
SQUARE = axis_aligned(2).problem


@pytest.mark.parametrize("shape", [Disk((0.3, -0.2), 0.5), Ring((0.1, 0.2), 0.3, 0.7)])
def test_the_measure_of_a_shape_is_the_share_of_points_in_it(shape):
    side = (np.arange(1000) + 0.5) / 500 - 1
    X = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    assert 4 * np.mean(shape.contains(X)) == pytest.approx(shape.measure, rel=1e-3)
    assert dataclasses.replace(RING, shape=shape).measure == shape.measure
    assert shape.contains(np.array(shape.center)[None])[0] == isinstance(shape, Disk)


def test_without_a_shape_the_body_is_the_box():
    assert SQUARE.measure == 1
    assert dataclasses.replace(RING, shape=None).measure == 4


def test_a_face_may_be_clamped():
    assert dataclasses.replace(SQUARE, boundary=dict(SQUARE.boundary) | {"x-": Fixed()}).boundary["x-"] == Fixed()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: steffen(0.16), "amplitude"),
        (lambda: steffen(math.nan), "amplitude"),
        (lambda: axis_aligned(1), "2 or 3 dimensions, not 1: use the manufactured bar in one dimension"),
        (lambda: axis_aligned(2, 0.32), "amplitude"),
        (lambda: axis_aligned(3, 0.0), "amplitude"),
        (lambda: expanding_ring(0.386), "amplitude"),
        (lambda: expanding_ring(-0.386), "amplitude"),
        (lambda: expanding_ring(math.inf), "amplitude"),
        (lambda: generalised_vortex(0.0), "amplitude"),
        (lambda: generalised_vortex(math.inf), "amplitude"),
        *(
            (lambda shape=shape, values=values: shape((0.0, 0.0), *values), "radi")
            for shape, values in (
                (Disk, (0.0,)), (Disk, (math.inf,)), (Ring, (0.0, 1.0)), (Ring, (1.0, 1.0)), (Ring, (0.5, math.nan)),
            )
        ),
        (lambda: Disk((0.0,), 1.0), "a center of two finite coordinates"),
        (lambda: Ring((0.0, math.nan), 0.5, 1.0), "a center of two finite coordinates"),
        (lambda: dataclasses.replace(RING, shape=Disk((0.0, 0.0), 1.001)), "must lie in the box, in its dimension"),
        (lambda: dataclasses.replace(RING, shape=Ring((0.5, 0.0), 0.3, 0.6)), "must lie in the box, in its dimension"),
        (lambda: dataclasses.replace(steffen().problem, shape=Disk((0.5, 0.5), 0.1)), "must lie in the box, in its dimension"),
        (lambda: dataclasses.replace(axis_aligned(3).problem, shape=Disk((0.5, 0.5), 0.1)), "must lie in the box, in its dimension"),
        (lambda: dataclasses.replace(SQUARE, initial={"speed": abs}), "the initial 'speed' is unknown: known are u, displacement"),
        (lambda: dataclasses.replace(SQUARE, boundary={}), "one boundary condition for each of x\\+, x-, y\\+, y-"),
        (lambda: dataclasses.replace(SQUARE, lower=(0.0,) * 4, upper=(1.0,) * 4), "one to three sides"),
    ],
)  # fmt: skip
def test_invalid_arguments_raise_a_usage_error(make, message):
    with pytest.raises(UsageError, match=message):
        make()


def test_the_shapes_of_ring_problems_have_the_radii_of_their_formulas():
    assert RING.shape == Ring((0.0, 0.0), ring.INNER, ring.OUTER)
    assert generalised_vortex().problem.shape == Ring((0.0, 0.0), vortex.INNER, vortex.OUTER)
