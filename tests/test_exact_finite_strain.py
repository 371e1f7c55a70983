"""Stress and body force of hyperelastic bodies, checked by means that do not use their formulas: the energies, and differences."""

import itertools

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from test_exact import difference

from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.clamped_layer import clamped_layer
from mpmverify.exact.finite_strain import body_force, cauchy_stress, cofactor, logarithm
from mpmverify.exact.periodic_waves import periodic_waves
from mpmverify.exact.slip_box import slip_box
from mpmverify.problem import Fixed, NeoHookean, Velocity
from mpmverify.problem.material import Hencky, NeoHookeanSplit, SaintVenantKirchhoff, Yeoh

CONSTANTS = (7.0, 2.0, 0.3)
LAWS = [
    NeoHookean(*CONSTANTS),
    NeoHookeanSplit(*CONSTANTS),
    Hencky(*CONSTANTS),
    SaintVenantKirchhoff(*CONSTANTS),
    Yeoh(*CONSTANTS, second=-0.5, third=2.0),
]
every_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
PAIRS = {1: ((0, 0),), 2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))}
seeds, dimensions = st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3])


def energy(law, stretches):
    """Return W per reference volume (...) of the three principal stretches (..., 3), as `mpmverify.problem.material` states it."""
    lame, mu = law.lame_lambda, law.shear_modulus
    J = np.prod(stretches, axis=-1)
    square = np.sum(stretches**2, axis=-1)
    volumetric = (lame + 2 * mu / 3) / 2 * ((J**2 - 1) / 2 - np.log(J))
    x = J ** (-2 / 3) * square - 3
    if isinstance(law, Hencky):
        return lame / 2 * np.log(J) ** 2 + mu * np.sum(np.log(stretches) ** 2, axis=-1)
    if isinstance(law, SaintVenantKirchhoff):
        green = (stretches**2 - 1) / 2
        return lame / 2 * np.sum(green, axis=-1) ** 2 + mu * np.sum(green**2, axis=-1)
    if isinstance(law, Yeoh):
        return volumetric + mu / 2 * x + law.second * x**2 + law.third * x**3
    if isinstance(law, NeoHookeanSplit):
        return volumetric + mu / 2 * x
    return mu / 2 * (square - 3 - 2 * np.log(J)) + lame / 2 * np.log(J) ** 2


def piola(law, F):
    """Return P = sum_i dW/dlambda_i n_i N_i^T (..., dim, dim) of F = sum_i lambda_i n_i N_i^T; dW/dlambda_i by complex steps."""
    n, stretches, N = np.linalg.svd(F)
    dimension = F.shape[-1]
    full = np.concatenate([stretches, np.ones((*F.shape[:-2], 3 - dimension))], axis=-1)
    slopes = np.stack([energy(law, full + 1e-40j * e).imag / 1e-40 for e in np.eye(3)[:dimension]], axis=-1)
    return np.einsum("...ik,...k,...kj->...ij", n, slopes, N)


def random_gradient(seed, dimension, count=20, size=0.25):
    return np.random.default_rng(seed).uniform(-size, size, (count, dimension, dimension))


def largest(*terms):
    return max(np.max(np.abs(term), initial=0.0) for term in terms)


def tensor(components):
    dimension = {1: 1, 3: 2, 6: 3}[components.shape[-1]]
    full = np.zeros((*components.shape[:-1], dimension, dimension))
    for c, (i, j) in enumerate(PAIRS[dimension]):
        full[..., i, j] = full[..., j, i] = components[..., c]
    return full


@every_law
@given(seed=seeds, dimension=dimensions)
def test_the_stress_is_the_derivative_of_the_energy(law, seed, dimension):
    H = random_gradient(seed, dimension)
    F = np.eye(dimension) + H
    sigma = piola(law, F) @ np.swapaxes(F, 1, 2) / np.linalg.det(F)[:, None, None]
    np.testing.assert_allclose(tensor(cauchy_stress(law, H)), sigma, rtol=0, atol=1e-12 * law.youngs_modulus)


@every_law
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_small_strain_gives_the_stress_of_hooke_without_cancellation(law, dimension):
    H = 1e-9 * random_gradient(3, dimension)
    hooke = law.lame_lambda * np.trace(H, axis1=1, axis2=2)[:, None, None] * np.eye(dimension)
    hooke += law.shear_modulus * (H + np.swapaxes(H, 1, 2))
    np.testing.assert_allclose(tensor(cauchy_stress(law, H)), hooke, rtol=0, atol=1e-7 * largest(hooke))


@given(seed=seeds, dimension=dimensions)
def test_the_logarithm_is_exact_to_round_off_for_stretches_from_a_half_to_two(seed, dimension):
    rng = np.random.default_rng(seed)
    Q, _ = np.linalg.qr(rng.standard_normal((dimension, dimension)))
    logs = 2 * rng.uniform(-np.log(2), np.log(2), dimension)
    b = (Q * np.exp(logs)) @ Q.T
    found = logarithm((b - np.eye(dimension))[..., None])[..., 0]
    np.testing.assert_allclose(found, (Q * logs) @ Q.T, rtol=0, atol=1e-14)


@given(seed=seeds, dimension=dimensions)
def test_the_logarithm_of_a_complex_step_is_its_derivative(seed, dimension):
    """The derivative in a direction is a block of the logarithm of a block matrix (Higham, 2008, theorem 3.6)."""
    e, de = (A + A.T for A in random_gradient(seed, dimension, 2, 0.15))
    b = np.eye(dimension) + e
    block = scipy.linalg.logm(np.block([[b, de], [np.zeros_like(b), b]]))[:dimension, dimension:]
    found = logarithm((e + 1e-40j * de)[..., None])[..., 0].imag / 1e-40
    np.testing.assert_allclose(found, block, rtol=0, atol=1e-13)


@given(seed=seeds, dimension=dimensions)
def test_cofactors(seed, dimension):
    F = np.eye(dimension) + random_gradient(seed, dimension)
    found = np.moveaxis(cofactor(np.moveaxis(F, 0, -1)), -1, 0)
    expected = np.linalg.det(F)[:, None, None] * np.swapaxes(np.linalg.inv(F), 1, 2)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


MOTIONS = {type(law).__name__: slip_box(law, strain=0.2) for law in LAWS}
MOTIONS |= {f"{type(law).__name__}, cuboid": slip_box(law, 3, strain=0.15) for law in LAWS}
MOTIONS |= {f"{type(law).__name__}, bar": slip_box(law, 1, strain=0.4) for law in LAWS}
MOTIONS |= {
    "layer": clamped_layer(LAWS[2], strain=0.2),
    "layer in 3D": clamped_layer(LAWS[4], 3, strain=0.15),
    "periodic": periodic_waves(LAWS[3], strain=0.15),
    "periodic in 3D": periodic_waves(LAWS[1], (1, -1, 1), strain=0.1),
}
every_motion = pytest.mark.parametrize("verification", MOTIONS.values(), ids=list(MOTIONS))


def points(problem, count=30):
    return np.random.default_rng(1).uniform(problem.lower, problem.upper, (count, problem.dimension))


@every_motion
def test_momentum_is_balanced(verification):
    """P is the derivative of the energy at a deformation gradient from differences; its divergence is one of differences, too."""
    problem, law, fields = verification.problem, verification.problem.material, verification.exact.fields
    X, t = points(problem), np.random.default_rng(2).uniform(0, problem.end_time, 5)
    axes, delta = np.eye(problem.dimension), 0.006

    def stress(Y):
        F = [difference(lambda s, e=e: fields["displacement"](Y + s * e, t), delta) for e in axes]
        return piola(law, axes + np.stack(F, axis=-1))

    divergence = sum(difference(lambda s, e=e: stress(X + s * e) @ e, delta) for e in axes)
    inertia = law.density * difference(lambda s: fields["velocity"](X, t + s), 0.002 * problem.end_time)
    terms = inertia, divergence, law.density * problem.body_force(X, t)
    assert largest(terms[0] - terms[1] - terms[2]) <= 1e-8 * largest(*terms)
    assert min(map(largest, terms)) > 1e-2 * largest(*terms), "every term contributes"


@every_motion
def test_fields_follow_from_the_displacement(verification):
    problem, law, fields = verification.problem, verification.problem.material, verification.exact.fields
    X, t = points(problem), np.random.default_rng(2).uniform(0, problem.end_time, 5)
    axes = np.eye(problem.dimension)
    v = fields["velocity"](X, t)
    assert largest(difference(lambda s: fields["displacement"](X, t + s), 0.004 * problem.end_time) - v) <= 1e-9 * largest(v)
    H = np.stack([difference(lambda s, e=e: fields["displacement"](X + s * e, t), 0.004) for e in axes], axis=-1)
    assert largest(H.reshape(*H.shape[:2], -1) - fields["displacement_gradient"](X, t)) <= 1e-9
    J = np.linalg.det(axes + H)
    assert J.min() > 0
    sigma = piola(law, axes + H) @ np.swapaxes(axes + H, -1, -2) / J[..., None, None]
    assert largest(tensor(fields["stress"](X, t)) - sigma) <= 1e-9 * largest(sigma)
    for quantity, field in fields.items():
        start = problem.initial_field(quantity, X)
        np.testing.assert_allclose(field(X, np.zeros(1))[0], start, rtol=0, atol=1e-15 * largest(start))


@every_motion
def test_boundary_conditions_hold_at_finite_strain(verification):
    problem, fields = verification.problem, verification.exact.fields
    t = np.random.default_rng(2).uniform(0, problem.end_time, 9)
    scale = {quantity: largest(field(points(problem, 200), t)) for quantity, field in fields.items()}
    for k, side in itertools.product(range(problem.dimension), "-+"):
        condition, X = problem.boundary["xyz"[k] + side], points(problem)
        X[:, k] = (problem.lower if side == "-" else problem.upper)[k]
        if isinstance(condition, Velocity | Fixed):
            held = [k] if isinstance(condition, Velocity) else range(problem.dimension)
            assert largest(fields["displacement"](X, t)[..., held]) <= 1e-13 * scale["displacement"]
        if isinstance(condition, Velocity):
            shear = [i for i in range(problem.dimension) if i != k]
            assert largest(tensor(fields["stress"](X, t))[..., k, shear]) <= 1e-13 * scale["stress"]


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_force_is_that_of_the_closed_form_of_a_neo_hookean_body(dimension):
    verification = axis_aligned(dimension)
    motion, X = verification.problem.body_force.motion, points(verification.problem)
    t = np.random.default_rng(2).uniform(0, verification.problem.end_time, 5)
    u = motion.displacement(X, t)
    second = np.zeros((*u.shape, dimension, dimension))
    for i in range(dimension):
        second[..., i, i, i] = -(np.pi**2) * u[..., i]
    found = body_force(motion.material, motion.gradient(X, t), second, -(motion.frequency**2) * u)
    expected = motion.force(X, t)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * largest(expected))


@every_law
def test_the_force_of_a_small_motion_vanishes(law):
    """It does so with the square of the strain, because the motion is free at small strain."""
    force = []
    for strain in (1e-3, 1e-4):
        problem = slip_box(law, strain=strain).problem
        force.append(largest(problem.body_force(points(problem), np.linspace(0, problem.end_time, 5))))
    assert force[0] / force[1] == pytest.approx(100, rel=0.02)
