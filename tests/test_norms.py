"""Norms: weights as in integrals, the axioms of a norm, and NaN for values that are not finite."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from mpmverify.criteria.norms import NORMS, compare, errors, l1, l2, linf, magnitude, norms, onset
from mpmverify.errors import UsageError
from mpmverify.exact import ExactSolution
from mpmverify.solution import Solution, Work

L1, L2, LINF, L2_MAX = (NORMS.index(name) for name in ("L1", "L2", "Linf", "L2-max"))
LIGHT = settings(max_examples=25)
SIZES = st.tuples(st.integers(1, 4), st.integers(1, 6), st.integers(1, 3))
VALUES = st.floats(-1e6, 1e6).map(lambda value: round(value, 6))


@st.composite
def fields(draw, count=1):
    """`count` fields (T, P, components) of one shape, and positive weights (T, P)."""
    shape = draw(SIZES)
    weight = draw(hnp.arrays(float, shape[:2], elements=st.floats(1e-3, 1e3)))
    return *(draw(hnp.arrays(float, shape, elements=VALUES)) for _ in range(count)), weight


def solution(values, *, weight=None, time=(0.0, 1.0), reference=None, quantity="u") -> Solution:
    values = np.asarray(values, dtype=float)
    reference = np.linspace(0, 1, values.shape[1])[:, None] if reference is None else reference
    weight = np.ones(values.shape[:2]) if weight is None else weight
    position = np.broadcast_to(reference, (len(time), *reference.shape))
    return Solution(np.array(time), 0.1, reference, position, weight, {quantity: values}, {}, Work())


def test_hand_computed_norms_of_two_vectors():
    values = np.array([[[30.0, 40.0], [0.0, 0.0]], [[3.0, 4.0], [0.0, 12.0]]])
    weight = np.array([[0.25, 1.0], [0.5, 2.0]])
    measure = 0.25 + 1.0  # of the body at the start
    expected = [(0.5 * 5 + 2 * 12) / measure, np.sqrt((0.5 * 25 + 2 * 144) / measure), 12.0, np.sqrt(0.25 * 2500 / measure)]
    np.testing.assert_allclose(norms(values, weight), expected, rtol=1e-15)


@LIGHT
@given(fields())
def test_weights_enter_linearly(data):
    values, weight = data
    halves = np.concatenate([weight, weight], axis=1) / 2
    np.testing.assert_allclose(norms(np.concatenate([values, values], axis=1), halves), norms(values, weight), rtol=1e-12)
    np.testing.assert_allclose(l1(magnitude(values), 4 * weight), 4 * l1(magnitude(values), weight), rtol=1e-12)
    np.testing.assert_allclose(l2(magnitude(values), 4 * weight), 2 * l2(magnitude(values), weight), rtol=1e-12)


@LIGHT
@given(fields())
def test_norms_are_means_over_the_body_and_do_not_depend_on_its_size(data):
    values, weight = data
    np.testing.assert_allclose(norms(values, 4 * weight), norms(values, weight), rtol=1e-12)
    uniform = np.broadcast_to(values[:, :1], values.shape)
    steady = np.broadcast_to(weight[:1], weight.shape)
    amplitude = np.linalg.norm(values[:, 0], axis=1)
    expected = [amplitude[-1], amplitude[-1], amplitude[-1], amplitude.max()]
    np.testing.assert_allclose(norms(uniform, steady), expected, rtol=1e-12)


@LIGHT
@given(
    st.lists(st.integers(-9, 9), min_size=1, max_size=5),
    st.floats(-5, 5).map(lambda left: round(left, 3)),
    st.floats(0.1, 5).map(lambda width: round(width, 3)),
)
def test_gauss_weights_integrate_the_square_of_a_polynomial(coefficients, left, width):
    polynomial = np.polynomial.Polynomial(coefficients)
    points, weight = np.polynomial.legendre.leggauss(len(coefficients) + 1)
    x, w = left + width * (points + 1) / 2, weight * width / 2
    integral = (polynomial**2).integ()
    terms = np.polynomial.Polynomial(np.abs(coefficients)) ** 2
    round_off = 1e-13 * max(1.0, terms.integ()(abs(left) + width))
    assert l2(polynomial(x)[None], w[None])[0] ** 2 == pytest.approx(
        integral(left + width) - integral(left), rel=1e-9, abs=round_off
    )


@LIGHT
@given(fields(), st.floats(-1e3, 1e3))
def test_norms_are_homogeneous(data, factor):
    values, weight = data
    np.testing.assert_allclose(norms(factor * values, weight), abs(factor) * norms(values, weight), rtol=1e-9, atol=1e-150)


@LIGHT
@given(fields(count=2))
def test_norms_satisfy_the_triangle_inequality(data):
    a, b, weight = data
    bound = norms(a, weight) + norms(b, weight)
    assert np.all(norms(a + b, weight) <= bound * (1 + 1e-12) + 1e-150)


@LIGHT
@given(fields())
def test_only_the_zero_field_has_a_zero_norm(data):
    values, weight = data
    assert np.all(norms(np.zeros_like(values), weight) == 0)
    assert np.all((norms(values, weight) > 0)[[L1, L2, LINF]] == bool(np.any(values[-1])))


@LIGHT
@given(fields(), st.integers(0, 10**6))
def test_norms_do_not_depend_on_the_order_of_the_points_nor_on_a_rotation_of_the_components(data, seed):
    values, weight = data
    generator = np.random.default_rng(seed)
    shuffled = generator.permutation(values.shape[1])
    rotation, _ = np.linalg.qr(generator.standard_normal((values.shape[2], values.shape[2])))
    expected = norms(values, weight)
    np.testing.assert_allclose(norms(values[:, shuffled], weight[:, shuffled]), expected, rtol=1e-10, atol=1e-150)
    np.testing.assert_allclose(norms(values @ rotation, weight), expected, rtol=1e-9, atol=1e-9)


@LIGHT
@given(fields())
def test_l2_max_is_the_largest_over_the_outputs_and_the_others_are_final(data):
    values, weight = data
    table = norms(values, weight)
    share = weight / weight[0].sum()
    assert table[L2_MAX] == l2(magnitude(values), share).max() >= table[L2]
    np.testing.assert_array_equal(
        table[[L1, L2, LINF]], [l1(magnitude(values), share)[-1], l2(magnitude(values), share)[-1], linf(magnitude(values))[-1]]
    )


@LIGHT
@given(fields(), st.sampled_from([np.nan, np.inf, -np.inf]), st.data())
def test_every_norm_is_non_finite_if_a_final_value_is(data, bad, draw):
    values, weight = data
    point, component = draw.draw(st.tuples(*(st.integers(0, size - 1) for size in values.shape[1:])))
    values[-1, point, component] = bad
    assert not np.any(np.isfinite(norms(values, weight)))


@LIGHT
@given(fields(), st.sampled_from([np.nan, np.inf]), st.data())
def test_l2_max_is_non_finite_if_any_value_is(data, bad, draw):
    values, weight = data
    values[draw.draw(st.tuples(*(st.integers(0, size - 1) for size in values.shape)))] = bad
    assert not np.isfinite(norms(values, weight)[L2_MAX])


def test_nan_is_not_hidden_by_a_larger_number():
    values = np.array([[[1e100], [np.nan], [1e100]]])
    assert np.isnan(linf(magnitude(values))[0])
    assert np.isnan(l1(magnitude(values), np.ones((1, 3)))[0])


@LIGHT
@given(fields(), st.sampled_from([np.nan, np.inf, -1e-3, "zero"]), st.data())
def test_invalid_weights_make_every_norm_nan(data, bad, draw):
    values, weight = data
    time, point = draw.draw(st.tuples(*(st.integers(0, size - 1) for size in weight.shape)))
    if bad == "zero":
        weight[time] = 0
    else:
        weight[time, point] = bad
    assert np.all(np.isnan(norms(values, weight)))


def shifted(X, t):
    """A travelling wave, (T, P, 1)."""
    return np.sin(3 * X[None, :, :] - 2 * t[:, None, None])


WAVE = ExactSolution({"u": shifted}, "")
X = np.linspace(0, 1, 9)[:, None]
T = np.array([0.0, 0.4, 1.0])


def test_the_exact_field_has_no_error_and_its_size_over_the_run_is_returned():
    weight = np.full((3, 9), 1 / 9)
    error, size = errors(solution(shifted(X, T), time=T, reference=X, weight=weight), WAVE)["u"]
    assert np.all(error == 0)
    by_time = [norms(shifted(X, T)[k : k + 1], weight[k : k + 1]) for k in range(len(T))]
    np.testing.assert_array_equal(size, np.max(by_time, axis=0))


def test_a_solution_three_times_too_large_has_a_relative_error_of_two():
    """The error is divided by the size of the exact field, not of the numerical one, and not of what is left at the final time."""

    def fading(X, t):
        return np.cos(0.5 * np.pi * t)[:, None, None] * (1 + X[None])

    error, size = errors(solution(3 * fading(X, T), time=T, reference=X), ExactSolution({"u": fading}, ""))["u"]
    assert error[L2_MAX] / size[L2_MAX] == pytest.approx(2, rel=1e-12)
    assert np.all(error[[L1, L2, LINF]] / size[[L1, L2, LINF]] < 1e-15)


def test_a_lag_of_one_step_gives_the_error_of_one_step():
    step = 1e-6
    weight = np.linspace(0.1, 2, 27).reshape(3, 9)
    error, _ = errors(solution(shifted(X, T - step), time=T, reference=X, weight=weight), WAVE)["u"]
    slope = 2 * np.cos(3 * X[None] - 2 * T[:, None, None])
    np.testing.assert_allclose(error, step * norms(slope, weight), rtol=1e-5)


def test_fields_are_compared_at_reference_positions():
    moved = Solution(T, 0.1, X, shifted(X, T) + 7, np.ones((3, 9)), {"u": shifted(X, T)}, {}, Work())
    assert np.all(errors(moved, WAVE)["u"][0] == 0)
    elsewhere = solution(shifted(X, T), time=T, reference=X + 0.01)
    assert np.all(errors(elsewhere, WAVE)["u"][0] > 0)


def test_only_quantities_that_both_solutions_have_are_compared():
    both = ExactSolution({"u": shifted, "stress": shifted}, "")
    assert set(errors(solution(shifted(X, T), time=T, reference=X), both)) == {"u"}
    assert errors(solution(shifted(X, T), time=T, reference=X, quantity="velocity"), both) == {}


@pytest.mark.parametrize(
    ("values", "weight"),
    [
        (np.zeros((1, 9, 1)), None),
        (np.zeros((3, 1, 1)), np.ones((3, 9))),
        (np.zeros((3, 9, 2)), None),
        (np.zeros((9, 9)), np.ones((3, 9))),
        (np.zeros((3, 9, 1)), np.ones(9)),
        (np.zeros((3, 9, 1)), np.ones((3, 1))),
        (np.zeros((3, 9, 1)), np.ones((1, 9))),
    ],
)
def test_a_shape_that_numpy_would_broadcast_is_refused(values, weight):
    with pytest.raises(UsageError, match="a solver must return"):
        errors(solution(values, time=T, reference=X, weight=weight), WAVE)


def test_a_solution_without_points_is_refused():
    empty = solution(np.zeros((3, 0, 1)), time=T, reference=np.zeros((0, 1)))
    with pytest.raises(UsageError, match="at least one point"):
        errors(empty, WAVE)


def test_the_onset_is_the_first_time_at_which_an_error_is_more_than_a_tenth_of_its_largest():
    size, time = np.array([0.0, 0.09, 0.2, 1.0, 0.5]), np.arange(5) / 10
    assert onset(size, time) == 0.2
    assert np.isnan(onset(0 * size, time))
    assert np.isnan(onset(size * np.nan, time))


def test_the_onset_of_every_error_is_a_metric_unless_there_is_no_error():
    right = WAVE.fields["u"](X, T)
    late = right + 0.01 * np.arange(len(T))[:, None, None]
    assert compare(solution(late, time=T, reference=X), WAVE)[1] == {"onset_u": T[1]}
    assert compare(solution(right, time=T, reference=X), WAVE)[1] == {}
