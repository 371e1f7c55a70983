"""Properties of the loaded bar that do not depend on its formula: characteristics, reflections, energy, integrals of the loads."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad

from mpmverify.exact.elastic_bar import RampLoad, SineLoad, SmoothPulse, StepLoad, elastic_bar

positive = st.floats(0.2, 5.0)
amplitudes = st.floats(-3.0, 3.0).filter(lambda a: abs(a) > 1e-3)
loads = st.one_of(
    st.builds(StepLoad, amplitudes),
    st.builds(RampLoad, amplitudes, positive),
    st.builds(SmoothPulse, amplitudes, st.floats(1.3, 3.0), st.floats(0.05, 0.2)),
    st.builds(SineLoad, amplitudes, positive),
)
bars = st.builds(
    lambda load, length, modulus, density: elastic_bar(
        load, length=length, youngs_modulus=modulus, density=density, end_time=9 * length * math.sqrt(density / modulus)
    ),
    loads,
    positive,
    positive,
    positive,
)


def fields(verification):
    problem, exact = verification.problem, verification.exact.fields
    material = problem.material
    return exact["stress"], exact["velocity"], problem.upper[0], material.wave_speed, material.density * material.wave_speed


@given(bars, st.floats(0, 8), st.floats(0.01, 0.4), st.sampled_from([1, -1]))
def test_characteristics(bar, start, offset, direction):
    """The invariant sigma - rho c v is constant along x - ct and sigma + rho c v along x + ct, across every front of the other family."""
    assume(abs(start - round(start)) > 1e-6)  # else the ray may lie on a front, where the value depends on round-off
    stress, velocity, L, c, impedance = fields(bar)
    travelled = L * np.linspace(offset, 0.98, 40)
    x, t = (travelled if direction > 0 else L - travelled)[:, None], start * L / c + travelled / c
    invariant = np.einsum("iij->i", stress(x, t) - direction * impedance * velocity(x, t))
    assert np.ptp(invariant) <= 1e-11 * abs(bar.problem.boundary["x+"].value.amplitude)


@given(bars)
def test_displacement_is_the_integral_of_velocity_across_fronts(bar):
    """The increments of u are bounded by |v|, so u does not jump; u_t = v away from the fronts is tested in test_exact.py."""
    _, velocity, L, c, impedance = fields(bar)
    t = np.linspace(0, bar.problem.end_time, 4001)
    x = L * np.array([[0.0], [0.31], [0.77], [1.0]])
    increments = np.abs(np.diff(bar.exact.fields["displacement"](x, t), axis=0))
    round_off = 1e-14 * abs(bar.problem.boundary["x+"].value.amplitude) * L / (impedance * c)
    assert increments.max() <= (t[1] - t[0]) * np.abs(velocity(x, t)).max() * 1.01 + round_off


@given(bars)
def test_nothing_moves_ahead_of_the_first_front(bar):
    *_, L, c, _ = fields(bar)
    x = L * np.linspace(0, 0.69, 20)[:, None]
    for field in bar.exact.fields.values():
        assert not field(x, np.array([-1.0, 0.0, 0.3 * L / c])).any()


@pytest.mark.parametrize(("length", "modulus", "density", "p0"), [(1.0, 1.0, 1.0, 1e-6), (2.5, 7.0, 3.0, -2.0)])
def test_step_load_gives_a_triangular_end_displacement_and_doubles_the_stress_at_the_fixed_end(length, modulus, density, p0):
    bar = elastic_bar(StepLoad(p0), length=length, youngs_modulus=modulus, density=density)
    transit = length * math.sqrt(density / modulus)
    t = transit * np.linspace(0.013, 15.983, 1601)
    end = bar.exact.fields["displacement"](np.array([[length]]), t)[:, 0, 0]
    sawtooth = np.abs(np.mod(t / transit + 2, 4) - 2) / 2
    assert np.allclose(end, 2 * p0 * length / modulus * sawtooth, rtol=0, atol=1e-12 * abs(p0 * length / modulus))
    fixed = bar.exact.fields["stress"](np.array([[0.0]]), t)[:, 0, 0]
    assert np.allclose(fixed, np.where(np.floor((t / transit + 1) / 2) % 2 == 1, 2 * p0, 0.0), rtol=0, atol=1e-14 * abs(p0))


def test_default_end_times_leave_the_wave_inside_the_bar():
    x = np.array([[0.0], [0.3], [0.9], [1.0]])
    step = elastic_bar(StepLoad(1.0))
    assert np.allclose(step.exact.fields["stress"](x, np.array([step.problem.end_time]))[0, :, 0], [2, 2, 1, 1])
    pulse = elastic_bar(SmoothPulse(1.0))
    ends = np.array([[0.0], [1.0]])
    assert np.abs(pulse.exact.fields["stress"](ends, np.array([pulse.problem.end_time]))).max() < 1e-15
    middle = pulse.exact.fields["stress"](np.array([[0.5]]), np.array([pulse.problem.end_time]))
    assert np.isclose(middle, -1)  # reflection at the loaded end changes the sign, at the fixed end it does not


@given(st.builds(SmoothPulse, amplitudes, st.floats(1.3, 2.0), st.floats(0.15, 0.2)), positive, st.floats(0.1, 0.9))
def test_energy_is_the_work_of_the_load(load, modulus, fraction):
    bar = elastic_bar(load, youngs_modulus=modulus)
    stress, velocity, L, c, _ = fields(bar)
    t = np.linspace(0, fraction * (load.centre + 3 * L / c), 4001)
    x = np.linspace(0, L, 2001)[:, None]
    density = velocity(x, t[-1:]) ** 2 / 2 + stress(x, t[-1:]) ** 2 / (2 * modulus)
    power = load(t) * velocity(np.array([[L]]), t)[:, 0, 0]
    energy, work = np.trapezoid(density[0, :, 0], x[:, 0]), np.trapezoid(power, t)
    assert abs(energy - work) <= 1e-4 * max(np.abs(density).max() * L, np.abs(power).max() * t[-1]) + 1e-30


@given(loads, st.floats(-1.0, 6.0))
def test_integral_of_the_load(load, end):
    pieces = np.unique(np.clip([0, *np.linspace(0, 6, 25), getattr(load, "duration", 0)], 0, max(end, 0)))
    exact = sum(quad(lambda t: load(np.array([t]))[0], a, b)[0] for a, b in itertools.pairwise(pieces))
    assert abs(load.integral(np.array([end]))[0] - exact) <= 1e-9 * abs(load.amplitude)
    assert load(np.array([-1e-9]))[0] == 0
    assert load.integral(np.array([-1.0, 0.0])).tolist() == [0, 0]


def test_values_of_the_loads():
    t = np.array([0.0, 0.15, 0.3, 0.5, 2.0])
    assert StepLoad(3.0)(t).tolist() == [3.0] * 5
    assert np.allclose(RampLoad(3.0, 0.3)(t), [0, 1.5, 3, 3, 3])
    assert np.allclose(SmoothPulse(3.0, 0.5, 0.08)(t[[0, 3]] + [0, 0.08]), [0, 3 / math.e], rtol=1e-12, atol=1e-15)
    assert np.allclose(SineLoad(3.0, math.pi)(t), 3 * np.sin(math.pi * t))
