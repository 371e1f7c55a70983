"""Analysis of error series: orders of power laws, intervals under noise, floors, classification, and the verdict."""

import math

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence import ROUND_OFF, Classification, analyse, fit_floor, fit_order, pairwise_orders, verdict
from mpmverify.convergence.verdict import Verdict
from mpmverify.errors import UsageError

LIGHT = settings(max_examples=25)
HALVED = 2.0 ** -np.arange(8)


@st.composite
def ladders(draw, least=3, most=8):
    """Distinct sizes (n,) at unequal ratios, coarsest first."""
    ratios = draw(st.lists(st.floats(1.2, 4), min_size=least - 1, max_size=most - 1))
    return draw(st.floats(1e-3, 1e3)) / np.cumprod([1.0, *ratios])


ORDERS = st.floats(0.3, 4)
CONSTANTS = st.floats(1e-3, 1e3)


def power_law(h, order, finest=1e-8):
    return finest * (h / h.min()) ** order


@LIGHT
@given(ladders(), ORDERS, st.randoms(use_true_random=False))
def test_the_order_of_a_power_law_is_found_at_any_ratios_and_in_any_order_of_levels(h, order, random):
    shuffled = random.sample(range(len(h)), len(h))
    series = analyse(h[shuffled], power_law(h, order)[shuffled])
    assert series.h.tolist() == sorted(h.tolist(), reverse=True)
    np.testing.assert_allclose(series.pairwise, order, rtol=1e-9)
    assert series.fit is not None
    assert series.fit.order == pytest.approx(order, rel=1e-9)
    assert series.fit.low - 1e-9 <= order <= series.fit.high + 1e-9
    assert series.fit.constant * h[0] ** order == pytest.approx(power_law(h, order)[0], rel=1e-6)
    assert series.classification is Classification.ASYMPTOTIC
    assert series.kept.all()
    assert series.dropped == ()


def test_orders_use_the_sizes_and_not_the_indices_of_levels():
    """A first-order series with ratios 4 and 2: orders computed from indices would be 1.5 on average."""
    series = analyse([0.125, 1.0, 0.25], [0.125, 1.0, 0.25])
    np.testing.assert_allclose(series.pairwise, [1, 1])
    assert series.fit is not None
    assert series.fit.order == pytest.approx(1)


@LIGHT
@given(ladders(4), st.lists(st.floats(-1, 1), min_size=8, max_size=8), st.floats(1e-2, 1e2), st.floats(1e-3, 1e3))
def test_orders_do_not_depend_on_the_units_of_error_and_size(h, scatter, error_unit, length_unit):
    error = power_law(h, 1.5, finest=1e-6) * np.exp(scatter[: len(h)])
    one, other = analyse(h, error), analyse(h * length_unit, error * error_unit)
    assert one.fit is not None
    assert other.fit is not None
    np.testing.assert_allclose(other.pairwise, one.pairwise, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(other.kept, one.kept)
    assert other.classification is one.classification
    np.testing.assert_allclose(
        [other.fit.order, other.fit.low, other.fit.high], [one.fit.order, one.fit.low, one.fit.high], rtol=1e-6, atol=1e-8
    )


@LIGHT
@given(ladders(1), st.lists(st.sampled_from([0.0, 1e-14, 1e-3, 0.2, 1.0, np.nan, np.inf]), min_size=8, max_size=8), st.data())
def test_permuting_the_levels_changes_nothing(h, errors, data):
    error = np.array(errors[: len(h)])
    shuffled = data.draw(st.permutations(range(len(h))))
    one, other = analyse(h, error), analyse(h[shuffled], error[shuffled])
    np.testing.assert_array_equal(one.pairwise, other.pairwise)
    np.testing.assert_array_equal(one.kept, other.kept)
    assert (one.fit, one.floor, one.classification, one.dropped) == (
        other.fit,
        other.floor,
        other.classification,
        other.dropped,
    )


@LIGHT
@given(ladders(1), st.lists(st.sampled_from([0.0, 1e-14, 1e-5, 1e-3, 0.2, 1.0, np.nan, np.inf]), min_size=8, max_size=8))
def test_every_dropped_level_is_named_with_the_reason(h, errors):
    series = analyse(h, np.array(errors[: len(h)]))
    if series.classification is Classification.NON_FINITE:
        assert not series.kept.any()
        assert any("every level" in sentence for sentence in series.dropped)
        bad = ~np.isfinite(series.error)
    else:
        bad = ~series.kept
        assert len(series.dropped) == bad.sum()
    for size in series.h[bad]:
        assert any(sentence.startswith(f"h={size:g}: ") for sentence in series.dropped)


@pytest.mark.parametrize(("levels", "noise"), [(3, 0.02), (5, 0.2), (8, 0.1)])
def test_the_interval_of_a_fit_covers_the_true_order_with_its_nominal_probability(levels, noise):
    """0.95 within three standard deviations of 800 draws."""
    generator = np.random.default_rng(levels)
    h = HALVED[:levels]
    fits = [fit_order(h, power_law(h, 2.0) * np.exp(noise * generator.standard_normal(levels))) for _ in range(800)]
    assert 0.927 <= np.mean([fit.low <= 2 <= fit.high for fit in fits]) <= 0.973


@pytest.mark.parametrize(("levels", "noise"), [(3, 0.01), (4, 0.01), (5, 0.02), (8, 0.1)])
def test_the_interval_of_an_analysis_covers_the_true_order(levels, noise):
    """0.95 within three standard deviations of 300 draws on either side; hardly any level is dropped."""
    generator = np.random.default_rng(levels)
    h = HALVED[:levels]
    found = [analyse(h, power_law(h, 2.0) * np.exp(noise * generator.standard_normal(levels))) for _ in range(300)]
    covered = [0.025 <= series.estimate.step_below(2.0) <= 0.975 for series in found]
    assert np.mean(covered) >= 0.907
    assert np.mean([not series.kept.all() for series in found]) < 0.05


def test_two_levels_give_an_order_without_an_interval():
    fit = fit_order(np.array([1.0, 0.5]), np.array([1.0, 0.25]))
    assert (fit.order, fit.low, fit.high) == (pytest.approx(2), -math.inf, math.inf)


def test_a_fit_whose_constant_overflows_still_has_an_order():
    fit = fit_order(np.array([1e-6, 5e-7, 2.5e-7]), np.array([1.0, 2.0**-76, 2.0**-152]))
    assert fit.order == pytest.approx(76)
    assert fit.constant == math.inf


@LIGHT
@given(
    st.floats(1.0, 4),
    st.floats(-8, -1).map(lambda exponent: 10**exponent),
    CONSTANTS,
    st.floats(1e-3, 1e3),
    st.integers(5, 8),
)
def test_fit_floor_recovers_the_floor_and_the_order(order, floor, constant, unit, levels):
    h = unit * HALVED[:levels]
    error = floor + constant * floor * (h / h[levels // 2]) ** order
    fit = fit_floor(h, error)
    assert fit.floor == pytest.approx(floor, rel=0.02)
    assert fit.order == pytest.approx(order, abs=0.02)
    assert fit.constant * h[0] ** fit.order == pytest.approx(error[0] - floor, rel=0.02)
    assert fit.residual < 1e-3


def test_errors_that_no_floor_fits_have_an_infinite_residual():
    error = np.array([1e-9, 6e5, 1.0, 1.0])
    assert fit_floor(HALVED[:4], error).residual == np.inf
    assert analyse(HALVED[:4], error).floor is None


@LIGHT
@given(st.floats(1.0, 4), st.floats(1e-9, 1e-2), st.integers(5, 8))
def test_a_series_with_a_floor_is_classified_so(order, floor, levels):
    h = HALVED[:levels]
    series = analyse(h, floor * (1 + (h / h[-3]) ** order))
    assert series.classification is Classification.OTHER_FLOOR
    assert series.floor is not None
    assert series.floor.floor == pytest.approx(floor, rel=0.05)
    assert series.floor.order == pytest.approx(order, abs=0.1)
    assert series.kept.all()


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (HALVED**2, Classification.ASYMPTOTIC),
        (HALVED[:3] ** 0.5, Classification.ASYMPTOTIC),
        (np.full(6, 0.3), Classification.STAGNANT),
        (0.3 * HALVED[:6] ** 0.1, Classification.STAGNANT),
        (0.3 * HALVED[:6] ** -0.1, Classification.STAGNANT),
        (0.3 * HALVED[:6] ** -0.3, Classification.DIVERGENT),
        (1e-3 / HALVED[:5], Classification.DIVERGENT),
        (np.array([1e-1, 1e-2, 1e-3, 1e-4, 1e2]), Classification.DIVERGENT),
        (np.array([0.4, 0.1, 0.05, 0.06, 0.12]), Classification.DIVERGENT),
        (np.array([1.0, 0.3, 0.25, 0.05, 0.045, 0.003]), Classification.PRE_ASYMPTOTIC),
        (np.full(4, 1e-14), Classification.EXACT),
        (np.zeros(4), Classification.EXACT),
        (np.array([1e-5, 1e-11, 0.0]), Classification.ROUND_OFF_FLOOR),
        (np.array([1.0, np.nan, 0.1, 0.05]), Classification.NON_FINITE),
        (np.array([np.inf, 0.1, 0.05]), Classification.NON_FINITE),
        (np.array([np.nan]), Classification.NON_FINITE),
        (np.array([1.0, 0.25]), Classification.TOO_SHORT),
        (np.array([0.25]), Classification.TOO_SHORT),
    ],
)
def test_classification(error, kind):
    assert analyse(HALVED[: len(error)], error).classification is kind


@pytest.mark.parametrize("rate", [0.8, 3.0])
def test_superconvergence_depends_on_the_expected_band(rate):
    error = HALVED**rate
    assert analyse(HALVED, error).classification is Classification.ASYMPTOTIC
    above = analyse(HALVED, error, expected=(rate - 0.5, rate - 0.2)).classification
    assert above is Classification.SUPERCONVERGENT
    assert analyse(HALVED, error, expected=(rate - 0.5, rate + 0.2)).classification is Classification.ASYMPTOTIC


@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.99])
def test_the_ends_of_an_interval_are_quantiles_of_the_order(confidence):
    series = analyse(HALVED[:6], HALVED[:6] ** 2 * [1.3, 1.02, 0.98, 1.03, 1, 0.99], confidence=confidence)
    for end, below in ((series.fit.low, 0.5 - confidence / 2), (series.fit.high, 0.5 + confidence / 2)):
        assert series.estimate.step_below(end) == pytest.approx(below, abs=1e-4)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_sizes_over_a_hundred_decades_have_no_interval():
    h = 10.0 ** np.linspace(-2, -190, 9)
    fit = analyse(h, np.geomspace(1, 1e-3, 9)).fit
    assert np.isnan([fit.low, fit.high]).all()


def test_pre_asymptotic_coarse_levels_are_dropped_and_named():
    error = HALVED**2
    error[:2] = [0.3, 0.22]
    series = analyse(HALVED, error)
    assert series.kept.tolist() == [False, False] + [True] * 6
    assert [sentence.split(":")[0] for sentence in series.dropped] == ["h=1", "h=0.5"]
    assert all("pre-asymptotic" in sentence for sentence in series.dropped)
    assert series.fit is not None
    assert series.fit.order == pytest.approx(2)


def test_no_level_is_dropped_for_a_tiny_deviation():
    for relative in (1e-15, 1e-9, 1e-4):
        assert analyse(HALVED, HALVED**2 * (1 + relative * (HALVED == 1))).kept.all()


@LIGHT
@given(ladders(), st.lists(st.floats(-3, 3), min_size=8, max_size=8))
def test_above_round_off_only_the_coarsest_levels_are_dropped_and_three_are_kept(h, scatter):
    series = analyse(h, np.maximum(np.exp(scatter[: len(h)]), 2 * ROUND_OFF))
    kept = np.flatnonzero(series.kept)
    assert kept[-1] == len(h) - 1
    assert np.all(np.diff(kept) == 1)
    assert len(kept) >= 3


def test_levels_at_round_off_are_dropped_at_any_position():
    error = HALVED**4
    error[[3, 7]] = [0.0, ROUND_OFF]
    series = analyse(HALVED, error)
    assert np.flatnonzero(~series.kept).tolist() == [3, 7]
    assert all("round-off" in sentence for sentence in series.dropped)
    assert analyse(HALVED, error, round_off=1e-30).kept[-1]


def test_pairwise_orders_are_nan_where_an_error_is_zero_or_not_finite():
    orders = pairwise_orders(HALVED[:6], np.array([1.0, 0.5, 0.0, 0.25, np.inf, 0.1]))
    np.testing.assert_array_equal(np.isnan(orders), [False, True, True, True, True])
    assert orders[0] == pytest.approx(1)


@pytest.mark.parametrize("levels", [5, 6, 8, 12])
@pytest.mark.parametrize("falls", [False, True])
def test_the_order_of_an_alternating_error_is_found(levels, falls):
    """Odd and even levels lie on two parallel lines, or on two curves that meet."""
    h = 2.0 ** -np.arange(levels)
    error = h**2 * (1 + 0.4 * (h if falls else 1) * (-1.0) ** np.arange(levels))
    series = analyse(h, error)
    assert series.fit.order == pytest.approx(2, abs=0.1)
    assert verdict(h, error, band=(1.75, 2.25))[0] is Verdict.PASS
    assert verdict(h, error, band=(2.75, 3.25))[0] is Verdict.FAIL


def test_an_alternating_error_on_four_levels_is_inconclusive():
    error = HALVED[:4] ** 2 * [1, 3, 1, 3]
    assert verdict(HALVED[:4], error, band=(1.8, 2.2))[0] is Verdict.INCONCLUSIVE


@LIGHT
@given(
    st.floats(0.5, 3), st.sampled_from([0.5, 1.0, 1.5, 2.0]), st.floats(0.02, 0.9), st.sampled_from([-1, 1]), st.integers(6, 10)
)
def test_the_order_of_the_finest_step_is_found_where_a_further_term_bends_the_series(order, more, share, sign, levels):
    h = 2.0 ** -np.arange(levels)
    error = h**order * (1 + sign * share * h**more)
    series = analyse(h, error)
    assert series.fit.order == pytest.approx(series.pairwise[-1], abs=0.03)
    below, above = series.estimate.below(order - 0.15), series.estimate.above(order + 0.15)
    assert below.limit < 0.5
    assert above.limit < 0.5


@LIGHT
@given(ladders(4, 9), ORDERS, st.floats(-4, 4), st.floats(-4, 4))
def test_probabilities_of_an_order_are_consistent(h, order, one, other):
    estimate = analyse(h, power_law(h, order)).estimate
    low, high = sorted((one, other))
    assert estimate.weight.sum() == pytest.approx(1)
    below, above = estimate.below(low), estimate.above(low)
    np.testing.assert_allclose(np.array(below[:3]) + above[:3], 1)
    assert below.both <= min(below.finest, below.limit) + 1e-12
    assert np.all(np.array(below) <= np.array(estimate.below(high)) + 1e-12)
    assert estimate.step_below(low) == pytest.approx(below.step)


@LIGHT
@given(ladders(3, 9), ORDERS, st.floats(1.1, 4), st.integers(1, 4))
def test_the_most_probable_law_predicts_further_levels(h, order, ratio, more):
    further = h[-1] / ratio ** np.arange(more + 1)
    estimate = analyse(h, power_law(h, order)).estimate
    np.testing.assert_allclose(estimate.predict(further), power_law(further, order, 1e-8 / ratio ** (more * order)), rtol=1e-6)


@pytest.mark.parametrize(("more", "share"), [(1.1, 0.2), (2.6, 0.15)])
@pytest.mark.parametrize("seed", range(8))
def test_levels_beyond_a_change_of_the_sign_of_the_error_tell_its_order(more, share, seed):
    """E = |A h^1.5 - B h^q|: its magnitude follows the law on both sides of the change; only the level next to it tells nothing."""
    x = 2.0 ** np.arange(9, -1, -1)
    law = 1e-4 * x**1.5 * np.abs(1 - share * (x / 4) ** more)
    error = law * np.exp(0.01 * np.random.default_rng(seed).standard_normal(len(x)))
    assert [verdict(x, error, band=band)[0] for band in ((1.34, 1.66), (1.86, 2.2), (0.8, 1.14))] == ["PASS", "FAIL", "FAIL"]
    series = analyse(x, error)
    assert series.kept.all()
    change = np.abs(1 - share * (x / 4) ** more)
    np.testing.assert_allclose(series.estimate.predict(x)[change > 0.2], law[change > 0.2], rtol=0.15)


@pytest.mark.parametrize(("last", "plunges"), [(0.0, True), (1e-13, True), (2.0**-14, False)])
def test_an_error_that_drops_to_round_off_in_one_step_plunges(last, plunges):
    error = np.append(HALVED[:7] ** 2, last)
    assert analyse(HALVED, error).plunges(2.2) is plunges


def test_an_error_that_reaches_round_off_at_the_expected_order_does_not_plunge():
    series = analyse(HALVED[:6], 1e-2 * HALVED[:6] ** 8)
    assert not series.kept.all()
    assert not series.plunges(8.2)


@pytest.mark.parametrize(
    ("h", "error"),
    [
        ([], []),
        ([1.0, 0.5], [1.0]),
        ([[1.0, 0.5]], [[1.0, 0.5]]),
        ([1.0, 0.0], [1.0, 0.5]),
        ([1.0, -0.5], [1.0, 0.5]),
        ([1.0, math.nan], [1.0, 0.5]),
        ([math.inf, 0.5], [1.0, 0.5]),
        ([1.0, 0.5], [1.0, -0.5]),
    ],
)
def test_invalid_series_are_refused(h, error):
    with pytest.raises(UsageError):
        analyse(h, error)


@pytest.mark.parametrize("bad", [[1j, 1.0], np.array([1j, 1.0]), ["a", "b"], [[1.0], [1.0, 2.0]]])
def test_entries_that_are_not_real_numbers_are_refused(bad):
    for arguments in ((bad, [1.0, 0.5]), ([1.0, 0.5], bad)):
        with pytest.raises(UsageError, match="real numbers"):
            analyse(*arguments)


# Containers of numbers.

SIZES, ERRORS = [0.125, 1.0, 0.25, 0.5], [0.03, 2.1, 0.11, 0.5]
TABLE = pd.DataFrame({"h": SIZES, "error": ERRORS})
LEVELS = xr.Dataset({"error": ("level", ERRORS)}, coords={"h": ("level", SIZES), "dt": ("level", [1, 2, 3, 4])})


@pytest.mark.parametrize(
    "arguments",
    [
        (tuple(SIZES), ERRORS),
        (np.array(SIZES), np.array(ERRORS)),
        (np.array(SIZES, dtype=object), np.ma.masked_array(ERRORS)),
        (TABLE["h"], TABLE["error"]),
        (TABLE.set_index("h")["error"],),
        (TABLE["h"].astype("Float64"), TABLE["error"].astype("Float64")),
        (LEVELS["h"], LEVELS["error"]),
        (LEVELS["error"],),
        (LEVELS["error"].swap_dims(level="h").drop_vars("dt"),),
        (xr.DataArray(ERRORS, dims="cell_size", coords={"cell_size": SIZES}),),
    ],
)
def test_all_containers_give_the_same_series(arguments):
    one, other = analyse(*arguments), analyse(SIZES, ERRORS)
    np.testing.assert_array_equal(one.h, other.h)
    np.testing.assert_array_equal(one.error, other.error)
    assert one.fit == other.fit


@pytest.mark.parametrize("series", [SIZES, np.array(SIZES), xr.DataArray(ERRORS, dims="level"), TABLE])
def test_errors_without_sizes_are_refused(series):
    with pytest.raises(UsageError):
        analyse(series)


def test_masked_and_missing_errors_are_not_finite():
    masked = np.ma.masked_array([1.0, 0.25, 1 / 16, 1 / 64], mask=[False, True, False, False])
    assert analyse(HALVED[:4], masked).classification is Classification.NON_FINITE
    missing = pd.Series([1.0, None, 1 / 16, 1 / 64], index=HALVED[:4])
    assert verdict(missing, band=(1.8, 2.2))[0] is Verdict.ERROR


# The verdict.


@pytest.mark.parametrize(
    ("error", "band", "expected"),
    [
        (HALVED**2, (1.8, 2.2), Verdict.PASS),
        (HALVED**1, (1.8, 2.2), Verdict.FAIL),
        (HALVED**3, (1.8, 2.2), Verdict.FAIL),
        (HALVED**1.8 * np.resize([1, 1.02, 0.99, 1.01], 8), (1.8, 2.2), Verdict.INCONCLUSIVE),
        (HALVED**2, None, Verdict.INCONCLUSIVE),
        (HALVED**-2, None, Verdict.FAIL),
        (np.full(8, 0.3), None, Verdict.FAIL),
        (1e-2 + HALVED**3, None, Verdict.FAIL),
        (HALVED**14.0, None, Verdict.FAIL),
        (np.where(HALVED == 0.25, np.nan, HALVED**2), (1.8, 2.2), Verdict.ERROR),
        (np.where(HALVED == 0.25, np.inf, HALVED**2), None, Verdict.ERROR),
    ],
)
def test_verdict_on_a_series(error, band, expected):
    found, reason = verdict(HALVED, error, band=band)
    assert found is expected
    assert reason


def test_without_a_band_the_reason_gives_the_order_and_says_that_nothing_passes():
    _, reason = verdict(HALVED, HALVED**2)
    assert reason.startswith("order 2.000, interval [1.999, 2.001] from 8 levels (asymptotic)")
    assert reason.endswith("without a band to expect it in, no order passes")


@pytest.mark.parametrize(
    "band", [(2.2, 1.8), (2.0, 2.0), (math.nan, 2.2), (1.8, math.nan), (1,), (), (1, 2, 3), 2.0, "12", "second"]
)
def test_an_invalid_band_is_refused(band):
    with pytest.raises(UsageError, match="band"):
        verdict(HALVED, HALVED**2, band=band)


@LIGHT
@given(ladders(1), st.floats(0, 1e-3), st.floats(-3, 3))
def test_an_error_is_exact_where_the_largest_one_is_within_the_tolerance(h, tolerance, excess):
    error = np.linspace(0, 1, len(h)) * tolerance * 10**excess
    found, reason = verdict(h, error, exact=tolerance)
    assert found is (Verdict.PASS if error.max() <= tolerance else Verdict.FAIL)
    assert f"{error.max():.2e}" in reason


def test_errors_at_round_off_are_named_exact_and_pass_only_where_that_is_demanded():
    for error in (np.zeros(4), np.full(4, 1e-15)):
        found, reason = verdict(HALVED[:4], error, band=(1.8, 2.2))
        assert found is Verdict.INCONCLUSIVE
        assert reason.startswith("exact: ")
        assert verdict(HALVED[:4], error, exact=1e-14)[0] is Verdict.PASS
    assert verdict([1, 0.5], [0.0, np.nan], exact=1e-14)[0] is Verdict.ERROR


@pytest.mark.parametrize("arguments", [{"exact": -1.0}, {"exact": math.nan}, {"exact": 1e-12, "band": (1.8, 2.2)}])
def test_an_invalid_tolerance_is_refused(arguments):
    with pytest.raises(UsageError, match="exact error"):
        verdict(HALVED, HALVED**2, **arguments)


@pytest.mark.parametrize("size", [np.nextafter(0.1, 1), 0.1 * (1 - 9e-7)])
def test_sizes_that_differ_only_in_the_last_digits_count_as_equal(size):
    series = analyse([0.4, 0.2, 0.1, size], [16, 4, 1, 1.1])
    assert len(set(series.h)) == 3
    assert "from 4 errors at 3 sizes" in verdict([0.4, 0.2, 0.1, size], [16, 4, 1, 1.1], band=(1, 3))[1]
    assert verdict([0.4, 0.2, 0.1, 0.1 * (1 - 1e-3)], [16, 4, 1, 1 - 2e-3], band=(1.8, 2.2))[0] is Verdict.PASS


@pytest.mark.parametrize(("h", "error"), [([10**400, 1, 2], [1, 2, 3]), ([4, 2, 1], [10**400, 1, 2])])
def test_a_number_that_overflows_a_float_is_refused(h, error):
    with pytest.raises(UsageError, match="must be real numbers"):
        verdict(h, error)
