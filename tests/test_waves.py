"""Measurements on waves recover the angle and growth of a mode, the delay and gain of a pulse, and the position of a front."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mpmverify.criteria.measurements import amplitude, delay_and_gain, modal_history, step_factor
from mpmverify.exact.waves import front, jump

LIGHT = settings(max_examples=60)


def scattered(seed, count=400):
    """Uneven sample points on [0, 1] and the weights of the trapezoid rule on them."""
    x = np.sort(np.random.default_rng(seed).uniform(0, 1, count))
    x[[0, -1]] = 0, 1
    weight = np.zeros(count)
    weight[:-1] += np.diff(x) / 2
    weight[1:] += np.diff(x) / 2
    return x, weight


# Modes.


@LIGHT
@given(st.integers(1, 12), st.floats(0, 2 * math.pi), st.floats(0.1, 10))
def test_modal_history_recovers_the_coefficients_of_a_wave(cycles, phase, size):
    x, k = (np.arange(64) + 0.5) / 64, 2 * math.pi * cycles
    found = modal_history(size * np.cos(k * x - phase)[None], x, np.full(64, 1 / 64), k)
    assert np.allclose(found, [[size * math.cos(phase), size * math.sin(phase)]], rtol=0, atol=1e-13 * size)
    other = modal_history(size * np.cos(k * x - phase)[None], x, np.full(64, 1 / 64), k + 2 * math.pi)
    assert np.abs(other).max() < 1e-13 * size


def test_sums_over_uneven_points_use_their_weights():
    x, weight = scattered(0, 4000)
    found = modal_history(np.cos(6 * math.pi * x)[None], x, weight, 6 * math.pi)
    assert np.allclose(found, [[1, 0]], atol=1e-3)
    assert abs(modal_history(np.cos(6 * math.pi * x)[None], x, np.ones(4000), 6 * math.pi)[0, 0] - 1) > 1e-3
    assert amplitude(np.cos(6 * math.pi * x), weight) == pytest.approx(math.sqrt(0.5), abs=1e-3)


@LIGHT
@given(st.floats(0.05, 3.0), st.floats(0.85, 1.02), st.floats(0, 6.28), st.floats(1e-12, 1e12), st.integers(8, 60))
def test_angle_and_growth_of_a_damped_oscillation_are_recovered(angle, growth, phase, size, steps):
    n = np.arange(steps)
    travelling = size * growth ** n[:, None] * np.stack([np.cos(angle * n - phase), np.sin(angle * n - phase)], axis=-1)
    expected = growth * np.exp(1j * angle)
    assert abs(step_factor(travelling) / expected - 1) < 1e-13 / min(angle, math.pi - angle) ** 2
    standing = travelling[:, :1]
    assume(abs(math.cos(phase)) > 1e-3)
    assert abs(step_factor(standing) / expected - 1) < 1e-10 / min(angle, math.pi - angle) ** 2


@LIGHT
@given(st.floats(0.1, 2.5), st.integers(0, 2**32 - 1))
def test_noise_changes_the_angle_by_no_more_than_documented(angle, seed):
    noise = 1e-8 * np.random.default_rng(seed).standard_normal(200)
    found = np.angle(step_factor((np.cos(angle * np.arange(200)) + noise)[:, None]))
    assert abs(found - angle) < 1e-8 / min(angle, math.pi - angle) ** 2


@pytest.mark.parametrize(
    "history",
    [
        np.zeros((20, 2)),
        np.ones((20, 2)),
        0.9 ** np.arange(20.0)[:, None],
        np.cos(np.arange(4.0))[:, None],
        np.zeros((0, 2)),
        np.where(np.arange(20) == 7, np.nan, np.cos(np.arange(20)))[:, None],
        np.where(np.arange(20) == 7, np.inf, np.cos(np.arange(20)))[:, None],
    ],
    ids=["zero", "constant", "one real factor", "short", "empty", "nan", "inf"],
)
def test_the_step_factor_is_nan_without_an_oscillation(history):
    assert np.isnan(step_factor(history))


# Pulses.


def pulse(x, width=0.08):
    return lambda delay: np.exp(-(((x - 0.5 + delay) / width) ** 2))


@LIGHT
@given(st.floats(-0.2, 0.2), st.floats(0.2, 3), st.floats(0.05, 0.15), st.integers(0, 99))
def test_delay_and_gain_of_a_pulse_are_recovered(delay, gain, width, seed):
    x, weight = scattered(seed)
    field = pulse(x, width)
    assert delay_and_gain(gain * field(delay), weight, field, 0.25, 1e-4) == pytest.approx((delay, gain), rel=1e-9, abs=1e-11)


@LIGHT
@given(st.integers(0, 99), st.floats(-0.05, 0.05))
def test_the_fit_is_best_in_the_weighted_norm(seed, offset):
    x, weight = scattered(seed)
    field = pulse(x)
    values = field(0.01) + 0.05 * np.sin(40 * x) * x
    delay, gain = delay_and_gain(values, weight, field, 0.25, 1e-4)
    best = amplitude(values - gain * field(delay), weight)
    for near in (delay + 1e-3, delay - 1e-3, delay + offset):
        assert best <= amplitude(values - gain * field(near), weight) + 1e-15
    assert delay_and_gain(values, weight**2, field, 0.25, 1e-4)[0] != pytest.approx(delay, abs=1e-8)


def test_delay_and_gain_are_nan_without_a_pulse():
    x, weight = scattered(0)
    field = pulse(x)
    for values in (0 * x, -field(0), x * np.nan, np.where(x > 0.7, np.inf, field(0)), np.exp(-(((x - 0.01) / 0.02) ** 2))):
        assert np.isnan(delay_and_gain(values, weight, field, 0.1, 1e-4)).all()
    assert np.isnan(delay_and_gain(field(0), weight * np.nan, field, 0.1, 1e-4)).all()
    assert np.isnan(delay_and_gain(field(0), weight, lambda d: 0 * x, 0.1, 1e-4)).all()


# Fronts.


@LIGHT
@given(
    st.floats(0.2, 0.8), st.floats(0.01, 0.1), st.floats(-2, 2), st.floats(0.1, 5), st.sampled_from([-1, 1]), st.integers(0, 99)
)
def test_a_smooth_front_is_located_within_the_sample_spacing(place, width, base, size, sign, seed):
    x, _ = scattered(seed)
    values = base + sign * size * np.tanh((x - place) / width) / 2
    shuffled = np.random.default_rng(seed).permutation(len(x))
    assert front(x[shuffled], values[shuffled], base) == pytest.approx(place, abs=np.diff(x).max() / 4)


@LIGHT
@given(st.floats(0.3, 0.7), st.floats(-0.49, 0.49), st.floats(0.01, 0.1))
def test_oscillations_behind_a_front_do_not_move_it(place, size, length):
    """The amplitude of the oscillations is at most half of the jump."""
    x = (np.arange(1000) + 0.5) / 1000
    behind = x < place
    values = np.where(behind, 1 + size * np.cos(2 * math.pi * (place - x) / length), 0.0)
    assert front(x, values, 0.5) == pytest.approx(place, abs=1e-3)


def test_noise_at_the_crossing_counts_equally_on_both_sides():
    x = np.arange(9.0)
    assert front(x, np.array([2, 2, 2, 0, 2, 0, 0, 0, 0.0]), 1.0) == pytest.approx(3.5)


@pytest.mark.parametrize(
    "values", [np.ones(9), np.zeros(9), np.r_[0, 0, 2, 2, 2, 0, 0, 0, 0], np.r_[0, np.nan, np.full(7, 2.0)]]
)
def test_the_position_is_nan_without_a_front(values):
    assert math.isnan(front(np.arange(9.0), values, 1.0))


@LIGHT
@given(st.floats(0.1, 0.9), st.floats(-3, 3), st.floats(-3, 3), st.integers(0, 99))
def test_a_jump_is_located_to_round_off(place, left, right, seed):
    assume(abs(left - right) > 1e-3)
    x, _ = scattered(seed, 50)
    found, level = jump(lambda x: np.where(x < place, left, right), x)
    assert found == pytest.approx(place, abs=1e-14)
    assert level == pytest.approx((left + right) / 2)


def test_a_profile_without_a_jump_has_none():
    x, _ = scattered(0)
    assert np.isnan(jump(np.ones_like, x)).all()
    assert np.isnan(jump(lambda x: x * np.nan, x)).all()
