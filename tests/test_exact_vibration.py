"""Properties of standing waves that do not depend on their formulas: period, energy, orthogonality; and the manufactured bar."""

import math

import numpy as np
import sympy
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.exact.manufactured import manufactured
from mpmverify.exact.vibration import axial_vibration

positive = st.floats(0.2, 50.0)
ends = st.sampled_from(["fixed-fixed", "fixed-free", "periodic"])
vibrations = st.builds(
    axial_vibration,
    st.integers(1, 6),
    ends,
    length=positive,
    youngs_modulus=positive,
    density=positive,
    v0=st.floats(0.01, 1.0),
)


def midpoints(length, count=400):
    return (np.arange(count)[:, None] + 0.5) * length / count


@given(vibrations)
def test_energy_is_constant_and_alternates_between_kinetic_and_strain(verification):
    problem, fields = verification.problem, verification.exact.fields
    law, X = problem.material, midpoints(problem.upper[0])
    t = problem.end_time / 1.1 * np.linspace(0, 1, 41)
    kinetic = law.density / 2 * (fields["velocity"](X, t) ** 2).mean(axis=(1, 2))
    strain = (fields["stress"](X, t) ** 2).mean(axis=(1, 2)) / (2 * law.youngs_modulus)
    assert np.allclose(kinetic + strain, kinetic[0], rtol=1e-12)
    assert np.allclose(strain[[0, 20, 40]], 0, atol=1e-12 * kinetic[0])
    assert np.allclose(kinetic[[10, 30]], 0, atol=1e-12 * kinetic[0])


@given(vibrations)
def test_mode_shapes_are_orthogonal_to_the_next_mode_and_repeat_after_a_period(verification):
    problem, fields = verification.problem, verification.exact.fields
    family, mode = problem.name.removeprefix("vibration-").rsplit("-", 1)
    X, t = midpoints(problem.upper[0]), np.array([0.13, 1.13]) * problem.end_time / 1.1
    following = axial_vibration(int(mode) + 1, family, length=problem.upper[0])
    assert abs(np.mean(problem.initial["velocity"](X) * following.problem.initial["velocity"](X))) < 1e-12
    for field in fields.values():
        first, second = field(X, t)
        assert np.allclose(first, second, rtol=0, atol=1e-11 * np.abs(first).max())


@given(vibrations)
def test_mode_n_has_n_minus_one_nodes_inside_the_bar(verification):
    """Mode n of a periodic bar has 2n half waves, hence 2n - 1 nodes."""
    problem = verification.problem
    half_waves = int(problem.name.rsplit("-", 1)[1]) * (2 if "periodic" in problem.name else 1)
    shape = problem.initial["velocity"](midpoints(problem.upper[0]))[:, 0]
    assert np.count_nonzero(shape[1:] * shape[:-1] < 0) == half_waves - 1


def test_the_parameters_of_the_literature_give_a_period_of_five_seconds():
    problem = axial_vibration().problem
    assert math.isclose(problem.end_time, 5.5)
    assert problem.initial["velocity"](np.array([[12.5]])) == 0.1


@given(st.floats(0.01, 0.3), positive, positive, st.floats(-0.4, 0.45), st.floats(0.01, 0.99), st.floats(0.0, 3.0))
def test_body_force_is_the_one_that_sympy_derives_from_the_motion(amplitude, modulus, density, poisson, x, time):
    """The force is b = u_tt - P_X/rho with P = dW/dF."""
    problem = manufactured(amplitude, youngs_modulus=modulus, density=density, poissons_ratio=poisson).problem
    law = problem.material
    derived = BODY_FORCE(x, time, amplitude, modulus, density, law.shear_modulus, law.lame_lambda)
    given_force = problem.body_force(np.array([[x]]), np.array([time]))[0, 0, 0]
    assert abs(given_force - derived) <= 1e-9 * amplitude * (modulus + law.shear_modulus + abs(law.lame_lambda)) / density


def body_force():
    X, t, G, E, rho, mu, lame, f = sympy.symbols("X t G E rho mu lambda F", positive=True)
    u = G * sympy.sin(sympy.pi * X) * sympy.sin(sympy.sqrt(E / rho) * sympy.pi * t)
    energy = mu / 2 * (f**2 - 1 - 2 * sympy.log(f)) + lame / 2 * sympy.log(f) ** 2
    stress = sympy.diff(energy, f).subs(f, 1 + sympy.diff(u, X))
    return sympy.lambdify((X, t, G, E, rho, mu, lame), sympy.diff(u, t, 2) - sympy.diff(stress, X) / rho)


BODY_FORCE = body_force()


def test_a_small_manufactured_motion_is_the_first_mode_of_the_linear_bar():
    amplitude, t, X = 1e-7, np.linspace(0, 0.02, 33), midpoints(1.0, 20)
    verification = manufactured(amplitude)
    linear = axial_vibration(length=1.0, youngs_modulus=1e7, density=1000.0, v0=amplitude * math.pi * 100.0).exact.fields
    for quantity, field in verification.exact.fields.items():
        scale = np.abs(linear[quantity](X, t)).max()
        assert np.allclose(field(X, t), linear[quantity](X, t), rtol=0, atol=1e-6 * scale)
    inertia = (math.pi * 100.0) ** 2 * amplitude
    assert np.abs(verification.problem.body_force(X, t)).max() < 1e-6 * inertia


def test_the_manufactured_bar_is_undeformed_after_a_period():
    verification = manufactured(0.05)
    X = midpoints(1.0, 20)
    displacement = verification.exact.fields["displacement"](X, np.array([0.0, 0.005, 0.02]))
    assert np.allclose(displacement[[0, 2]], 0, atol=1e-15)
    assert np.allclose(displacement[1], 0.05 * np.sin(math.pi * X))
