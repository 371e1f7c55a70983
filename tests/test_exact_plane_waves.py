"""Plane P and S waves at small strain: their balance of momentum, law, initial and boundary conditions, by differences."""

import math

import numpy as np
import pytest
from arrays import assert_times_are_independent
from latex2mathml.converter import convert
from test_exact import difference

from mpmverify.errors import UsageError
from mpmverify.exact.clamped_layer import clamped_layer
from mpmverify.exact.lame_mode import lame_mode
from mpmverify.exact.periodic_waves import periodic_waves
from mpmverify.exact.plane_waves import PlaneWave, PlaneWaves, between_walls, damped
from mpmverify.exact.slip_box import slip_box
from mpmverify.problem import Fixed, LinearElastic, NeoHookean, Periodic, Traction, Velocity
from mpmverify.problem.material import KelvinVoigt, Maxwell, PlaneStress

CONSTANTS = (7.0, 2.0, 0.3)
LAWS = {
    "elastic": LinearElastic(*CONSTANTS),
    "auxetic": LinearElastic(3.0, 0.5, -0.2),
    "plane stress": PlaneStress(*CONSTANTS),
    "kelvin-voigt": KelvinVoigt(*CONSTANTS, viscosity=0.3),
    "maxwell": Maxwell(*CONSTANTS, relaxation_time=0.9),
}
PROBLEMS = {f"{name}, box": slip_box(law) for name, law in LAWS.items()}
PROBLEMS |= {f"{name}, cuboid": slip_box(law, 3) for name, law in LAWS.items() if name != "plane stress"}
PROBLEMS |= {f"{name}, bar": slip_box(law, 1) for name, law in LAWS.items() if name != "plane stress"}
PROBLEMS |= {f"{name}, layer": clamped_layer(law) for name, law in LAWS.items()}
PROBLEMS |= {f"{name}, lame": lame_mode(law, 2, side=0.7) for name, law in LAWS.items()}
PROBLEMS |= {
    "elastic, layer in 3D": clamped_layer(LAWS["elastic"], 3),
    "maxwell, layer in 3D": clamped_layer(LAWS["maxwell"], 3),
    "elastic, periodic": periodic_waves(LAWS["elastic"]),
    "auxetic, periodic": periodic_waves(LAWS["auxetic"], (2, 1)),
    "plane stress, periodic": periodic_waves(LAWS["plane stress"], (0, 1)),
    "elastic, periodic in 3D": periodic_waves(LAWS["elastic"], (1, -1, 2)),
}
every_problem = pytest.mark.parametrize("verification", PROBLEMS.values(), ids=list(PROBLEMS))
PAIRS = {1: ((0, 0),), 2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))}


def points(problem, count=60):
    return np.random.default_rng(1).uniform(problem.lower, problem.upper, (count, problem.dimension))


def times(problem, count=7):
    return np.random.default_rng(2).uniform(0, problem.end_time, count)


def largest(*terms):
    return max(np.max(np.abs(term), initial=0.0) for term in terms)


def tensor(components):
    """Return symmetric tensors (..., dim, dim) of their independent components."""
    dimension = {1: 1, 3: 2, 6: 3}[components.shape[-1]]
    full = np.zeros((*components.shape[:-1], dimension, dimension))
    for c, (i, j) in enumerate(PAIRS[dimension]):
        full[..., i, j] = full[..., j, i] = components[..., c]
    return full


def slopes(field, X, t, delta=0.004):
    """Return the derivatives by position (T, P, ..., dim) of a field, by differences."""
    return np.stack([difference(lambda s, e=e: field(X + s * e, t), delta) for e in np.eye(X.shape[1])], axis=-1)


def rate(field, X, t, problem):
    return difference(lambda s: field(X, t + s), 0.004 * problem.end_time)


def hooke(law, gradient):
    """Return lambda tr(eps) I + mu (H + H^T)."""
    spherical = law.lame_lambda * np.trace(gradient, axis1=-2, axis2=-1)[..., None, None] * np.eye(gradient.shape[-1])
    return spherical + law.shear_modulus * (gradient + np.swapaxes(gradient, -1, -2))


@every_problem
def test_momentum_is_balanced_without_a_body_force(verification):
    problem, fields = verification.problem, verification.exact.fields
    X, t = points(problem), times(problem)
    inertia = problem.material.density * rate(fields["velocity"], X, t, problem)
    gradient = slopes(lambda Y, s: tensor(fields["stress"](Y, s)), X, t)
    assert problem.body_force is None
    assert largest(inertia - np.einsum("tpijj->tpi", gradient)) <= 1e-9 * largest(inertia)


@every_problem
def test_the_stress_obeys_the_law(verification):
    problem, fields, law = verification.problem, verification.exact.fields, verification.problem.material
    X, t = points(problem), times(problem)
    strain, strain_rate = slopes(fields["displacement"], X, t), slopes(fields["velocity"], X, t)
    stress = tensor(fields["stress"](X, t))
    if isinstance(law, Maxwell):
        left = tensor(rate(fields["stress"], X, t, problem)) + stress / law.relaxation_time
        right = hooke(law, strain_rate)
    else:
        theta = law.viscosity / (law.density * law.wave_speed**2) if isinstance(law, KelvinVoigt) else 0.0
        left, right = stress, hooke(law, strain + theta * strain_rate)
    assert largest(left - right) <= 1e-9 * largest(left)


@every_problem
def test_velocity_and_gradient_are_derivatives_of_the_displacement(verification):
    problem, fields = verification.problem, verification.exact.fields
    X, t = points(problem), times(problem)
    v, H = fields["velocity"](X, t), fields["displacement_gradient"](X, t)
    assert largest(rate(fields["displacement"], X, t, problem) - v) <= 1e-9 * largest(v)
    assert largest(slopes(fields["displacement"], X, t).reshape(H.shape) - H) <= 1e-9 * largest(H)


@every_problem
def test_bodies_start_strained_and_moving_with_an_acceleration(verification):
    problem, fields, X = verification.problem, verification.exact.fields, points(verification.problem)
    assert set(problem.initial) == set(fields)
    t = np.linspace(0, problem.end_time, 50)
    for quantity, field in fields.items():
        start = problem.initial_field(quantity, X)
        np.testing.assert_allclose(field(X, np.zeros(1))[0], start, rtol=0, atol=1e-15 * largest(start))
        size = np.sqrt(np.mean(field(X, t) ** 2, axis=(1, 2)))
        assert size[0] > 0.1 * size.max(), quantity
        assert size[-1] > 0.05 * size.max(), quantity
    acceleration = rate(fields["velocity"], X, t, problem)
    assert largest(acceleration[0]) > 0.1 * largest(acceleration)


@every_problem
def test_boundary_conditions(verification):
    problem, fields = verification.problem, verification.exact.fields
    t = times(problem, 20)
    scale = {quantity: largest(field(points(problem, 200), t)) for quantity, field in fields.items()}
    for face, condition in problem.boundary.items():
        k = "xyz".index(face[0])
        X = points(problem)
        X[:, k] = (problem.lower if face[1] == "-" else problem.upper)[k]
        if isinstance(condition, Periodic):
            opposite = X.copy()
            opposite[:, k] = (problem.upper if face[1] == "-" else problem.lower)[k]
            for quantity, field in fields.items():
                assert largest(field(X, t) - field(opposite, t)) <= 1e-13 * scale[quantity]
            continue
        traction = tensor(fields["stress"](X, t))[..., k]
        others = [i for i in range(problem.dimension) if i != k]
        if isinstance(condition, Traction):
            assert largest(traction) <= 1e-13 * scale["stress"]
            continue
        held = [k] if isinstance(condition, Velocity) else range(problem.dimension)
        for quantity in ("displacement", "velocity"):
            assert largest(fields[quantity](X, t)[..., held]) <= 1e-13 * scale[quantity]
        if isinstance(condition, Velocity):
            assert largest(traction[..., others]) <= 1e-13 * scale["stress"]
        else:
            assert isinstance(condition, Fixed)
            assert all(largest(traction[..., i]) > 0.1 * largest(traction) for i in range(problem.dimension))


def test_the_modes_of_a_slip_wall_box_are_those_of_the_potentials():
    """P: u = grad[cos(kx x) cos(ky y)]; S: u = (psi_y, -psi_x), psi = sin(kx x) sin(ky y)."""
    kx, ky = k = (1.3, 0.7)
    X, t = np.random.default_rng(3).uniform(-2, 2, (50, 2)), np.zeros(1)
    x, y = X.T
    potential = -np.stack([kx * np.sin(kx * x) * np.cos(ky * y), ky * np.cos(kx * x) * np.sin(ky * y)], axis=1)
    stream = np.stack([ky * np.sin(kx * x) * np.cos(ky * y), -kx * np.cos(kx * x) * np.sin(ky * y)], axis=1)
    for d, expected in (((-kx, -ky), potential), ((ky, -kx), stream)):
        motion = PlaneWaves(LAWS["elastic"], between_walls(d, k, (0.0, 0.0), 0.0))
        np.testing.assert_allclose(motion.displacement(X, t)[0], expected, rtol=0, atol=1e-14)


def test_the_lame_mode_is_that_of_the_literature():
    verification = lame_mode(LAWS["elastic"], side=1.5)
    X, t = points(verification.problem), times(verification.problem)
    k, law = math.pi / 1.5, LAWS["elastic"]
    shape = np.stack([np.cos(k * X[:, 0]) * np.sin(k * X[:, 1]), -np.sin(k * X[:, 0]) * np.cos(k * X[:, 1])], axis=1)
    swing = np.cos(math.sqrt(2) * k * law.shear_wave_speed * t + 0.8)[:, None, None]
    np.testing.assert_allclose(
        verification.exact.fields["displacement"](X, t), 1e-5 / (math.sqrt(2) * k) * swing * shape, rtol=0, atol=1e-19
    )
    other = lame_mode(LinearElastic(2 * law.shear_modulus, law.density, 0.0), side=1.5)
    np.testing.assert_allclose(
        other.exact.fields["stress"](X, t), verification.exact.fields["stress"](X, t), rtol=0, atol=1e-17
    )


def test_the_amplitudes_of_viscous_waves_are_those_of_the_literature():
    """Kelvin-Voigt released from rest, and Maxwell struck without stress."""
    k, t = 2.0, np.linspace(0, 3, 30)
    law = LAWS["kelvin-voigt"]
    g = law.viscosity * k**2 / (2 * law.density)
    w = math.sqrt((law.wave_speed * k) ** 2 - g**2)
    q, _, _ = PlaneWave((1.0, 0.0), (k, 0.0)).amplitudes(law, t)
    np.testing.assert_allclose(q, np.exp(-g * t) * (np.cos(w * t) + g / w * np.sin(w * t)), rtol=0, atol=1e-14)
    law = LAWS["maxwell"]
    tau, W = law.relaxation_time, math.sqrt((law.shear_wave_speed * k) ** 2 - 1 / (4 * law.relaxation_time**2))
    _, v, _ = PlaneWave((0.0, 1.0), (k, 0.0), start=-math.pi / 2).amplitudes(law, t)
    expected = law.shear_wave_speed * k * np.exp(-t / (2 * tau)) * (np.cos(W * t) + np.sin(W * t) / (2 * tau * W))
    np.testing.assert_allclose(v, expected, rtol=0, atol=1e-13)


def test_a_travelling_wave_keeps_its_profile():
    verification = periodic_waves(LAWS["elastic"], (1, 0))
    X, law = points(verification.problem), LAWS["elastic"]
    later = np.array([0.1])
    p_wave = PlaneWaves(law, verification.exact.fields["displacement"].motion.waves[:2])
    now = p_wave.displacement(X, np.zeros(1))
    shifted = p_wave.displacement(X + 0.1 * law.wave_speed * np.eye(2)[0], later)
    np.testing.assert_allclose(shifted, now, rtol=0, atol=1e-14 * largest(now))


def test_the_shears_of_the_cuboid_differ():
    verification = slip_box(LAWS["elastic"], 3)
    X, t = points(verification.problem, 500), times(verification.problem)
    shears = verification.exact.fields["stress"](X, t)[..., 3:].reshape(-1, 3)
    sizes = np.sqrt(np.mean(shears**2, axis=0))
    assert sizes.min() > 0.2 * sizes.max()
    for a, b in ((0, 1), (1, 2), (2, 0)):
        assert np.max(np.abs(np.abs(shears[:, a]) - np.abs(shears[:, b]))) > 0.3 * sizes.max()


@every_problem
def test_fields_have_the_declared_shape_and_equations_render(verification):
    problem, X = verification.problem, points(verification.problem, 9)
    t = np.array([0.0, 0.5, 1.0, 40.3]) * problem.end_time
    for quantity, field in verification.exact.fields.items():
        assert field(X, t).shape == (4, *problem.initial_field(quantity, X).shape)
        assert np.isfinite(field(X, t)).all()
        assert_times_are_independent(field, X, t, 2)
    assert all(convert(equation) for equation in verification.equations)


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda: PlaneWave((1.0, 0.5), (1.0, 0.0)), "parallel or perpendicular"),
        (lambda: PlaneWave((0.0, 0.0), (1.0, 0.0)), "parallel or perpendicular"),
        (lambda: PlaneWave((1.0, 0.0), (0.0, 0.0)), "parallel or perpendicular"),
        (lambda: slip_box(LAWS["elastic"], 4), "1, 2 or 3 dimensions"),
        (lambda: clamped_layer(LAWS["elastic"], 4), "2 or 3 dimensions"),
        (lambda: periodic_waves(LAWS["elastic"], (1,)), "two or three sides"),
        (lambda: periodic_waves(LAWS["elastic"], (0, 0)), "not all of them zero"),
        (lambda: periodic_waves(LAWS["maxwell"]), "elastic body"),
        (lambda: lame_mode(NeoHookean(*CONSTANTS)), "small strain only"),
        (lambda: slip_box(NeoHookean(*CONSTANTS), strain=0.5), "less than 1"),
        (lambda: damped(1.0, 1.0, 1.0, 0.0, np.zeros(1)), "does not oscillate"),
    ],
)
def test_refusals(make, why):
    with pytest.raises(UsageError, match=why):
        make()
