"""Student's t without SciPy is that of SciPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import stdtr, stdtrit
from scipy.stats import t as student_t

from mpmverify.convergence.student import Mixture, student, student_probability, student_quantile


@given(st.lists(st.integers(1, 60), min_size=1, max_size=9), st.floats(-40, 40))
def test_the_probability(degrees_of_freedom, t):
    n = np.array(degrees_of_freedom, dtype=float)
    # SciPy 1.17 is wrong by up to 1e-11 near t = 0 for one degree of freedom, where the probability has a closed form.
    expected = np.where(n == 1, 0.5 + np.arctan(t) / np.pi, stdtr(n, t))
    assert student_probability(n, np.full(len(n), t)) == pytest.approx(expected, abs=1e-14)


@given(st.integers(1, 60), st.floats(-40, 40))
def test_the_density(degrees_of_freedom, t):
    _, density = student(degrees_of_freedom, np.array([t]))
    np.testing.assert_allclose(density, student_t.pdf(t, degrees_of_freedom), rtol=1e-9)


@pytest.mark.parametrize("n", range(1, 8))
@pytest.mark.parametrize("t", [1e100, 1e160, 1e300, np.inf])
def test_far_away_the_probability_is_0_or_1(n, t):
    below, density = student(n, np.array([-t, t]))
    np.testing.assert_allclose(below, [0, 1], atol=1e-15)
    np.testing.assert_array_equal(density < 1e-100, True)


PART = st.tuples(st.integers(1, 9), st.floats(-3, 3), st.floats(1e-3, 3), st.floats(0.01, 1))


@given(st.lists(PART, min_size=1, max_size=5), st.floats(0.05, 0.99))
def test_the_interval_of_a_mixture_leaves_the_same_on_either_side(parts, confidence):
    freedom, middle, scale, weight = np.array(parts).T
    weight /= weight.sum()
    low, high = Mixture(freedom, middle, scale, weight).interval(confidence)
    outside = [float(stdtr(freedom, side * (end - middle) / scale) @ weight) for side, end in ((1, low), (-1, high))]
    np.testing.assert_allclose(outside, 0.5 - confidence / 2, atol=1e-6)


@given(st.integers(1, 60), st.floats(0.01, 0.9999))
def test_the_quantile(degrees_of_freedom, confidence):
    expected = stdtrit(degrees_of_freedom, 0.5 + confidence / 2)
    assert student_quantile(degrees_of_freedom, confidence) == pytest.approx(expected, rel=1e-9)
