"""Properties of the convergence package, each a function of a copy of it."""

from types import ModuleType
from typing import Any

import numpy as np

H = np.array([0.5, 0.1, 0.25, 0.04, 0.02])
"""Sizes with unequal ratios, unsorted, so that orders computed from indices are wrong."""
FINEST, COARSEST = H == 0.02, H == 0.5
BAND = (1.8, 2.2)


# Properties of the convergence package.


def same(found: Any, expected: Any, **tolerance: float) -> None:
    np.testing.assert_allclose(found, expected, **({"rtol": 1e-9} | tolerance))


def orders_use_the_sizes(c: ModuleType) -> None:
    for order in (-1.5, 0.7, 2.0):
        series = c.analyse(H, 3e-3 * H**order)
        same(series.pairwise, order)
        same(series.fit.order, order)
        same(series.fit.constant, 3e-3)
        fit = c.fit_order(H, 3e-3 * H**order)
        same([fit.order, fit.constant], [order, 3e-3])
        same(series.h, np.sort(H)[::-1])
        same(series.error, 3e-3 * np.sort(H)[::-1] ** order)


def scattered_errors_are_fitted_by_least_squares(c: ModuleType) -> None:
    error = 0.1 * H**2 * [1, 1.3, 0.8, 1.1, 0.9]
    fit = c.fit_order(H, error)
    same(fit.order, np.polyfit(np.log(H), np.log(error), 1)[0])
    same((fit.low + fit.high) / 2, fit.order)
    (slope, _), covariance = np.polyfit(np.log(H), np.log(error), 1, cov=True)
    # polyfit scales by n - 2 as well; 3.182 is the 97.5 % point of Student's t with three degrees of freedom.
    same(fit.high - slope, 3.182446305 * np.sqrt(covariance[0, 0]))


def intervals_cover_the_order_with_their_nominal_probability(c: ModuleType) -> None:
    generator = np.random.default_rng(0)
    h = H[:3]
    fits = [c.fit_order(h, h**2 * np.exp(0.1 * generator.standard_normal(3))) for _ in range(600)]
    assert 0.92 < np.mean([fit.low <= 2 <= fit.high for fit in fits]) < 0.98


def verdicts_of_series_are_right(c: ModuleType) -> None:
    for error, expected in (
        (H**2, "PASS"),
        (H**2.15, "PASS"),
        (H**1, "FAIL"),
        (H**3, "FAIL"),
        (H**-2, "FAIL"),
        (0 * H + 0.1, "FAIL"),
        (0.1 + H**3, "FAIL"),
        (np.where(FINEST, 1.0, H**2), "FAIL"),
        (np.where(FINEST, 1e-9, H**2), "INCONCLUSIVE"),
        (np.where(FINEST, 0, H**2), "INCONCLUSIVE"),
        (np.where(H < 0.2, 1e-14, H**2), "INCONCLUSIVE"),
        (np.where(FINEST, np.nan, H**2), "ERROR"),
        (np.where(COARSEST, np.inf, H**2), "ERROR"),
        (H**1.82 * [1, 1.05, 0.95, 1, 0.97], "INCONCLUSIVE"),
        (H**2.18 * [1, 1.05, 0.95, 1, 0.97], "INCONCLUSIVE"),
        (H**2.14 * [1, 1.05, 0.95, 1, 0.97], "INCONCLUSIVE"),
        (H**2 * [1, 2, 1, 2, 1], "INCONCLUSIVE"),
    ):
        assert c.verdict(H, error, band=BAND)[0] == expected, (error, expected)
    found, reason = c.verdict(H[:2], H[:2] ** 2, band=BAND)
    assert found == "INCONCLUSIVE"
    assert "an order needs three" in reason
    assert c.verdict(H, H**2)[0] == "INCONCLUSIVE"
    assert c.verdict(H, np.ma.masked_array(H**2, mask=H == 0.1), band=BAND)[0] == "ERROR"


def the_finest_levels_of_a_long_ladder_count(c: ModuleType) -> None:
    h = 0.5 ** np.arange(9.0)

    def after(*orders: float) -> str:
        verdict: str = c.verdict(h[: len(orders) + 1], 0.1 * 0.5 ** np.cumsum([0.0, *orders]), band=BAND)[0]
        return verdict

    assert after(2, 2, 2, 2, 2, 2, 1.6) == "INCONCLUSIVE"
    assert after(2, 2, 2, 2, 2, 2, -0.5) == "FAIL"
    assert after(2.1, 2.08, 2, 1.85, 1.7) == "FAIL"
    assert after(3.6, 3.4, 3.2, 3.0, 2.6) == "INCONCLUSIVE"
    assert after(3.9, 3.9, 3.9, 3.9, 3.9, 3.7, 3.0) == "INCONCLUSIVE"
    assert after(4.6, -0.6, 4.6, -0.6, 4.6, -0.6) == "INCONCLUSIVE"
    assert after(2.6, 1.4, 2.6, 1.4, 2.6, 1.4) == "PASS"
    assert after(2.6, 2.6, 2.6, 2.5, 2.3, 1.9) == "INCONCLUSIVE"
    assert after(2.9, 2.8, 2.65, 2.5, 2.37, 2.27) == "INCONCLUSIVE"
    assert after(2.6, 2.4, 2.23, 2.13, 2.07, 2.03) == "PASS"
    assert after(0.45, 1.82, 2, 2, 2, 2, 2) == "PASS"


def the_finest_levels_tell_where_an_order_goes(c: ModuleType) -> None:
    h = 0.5 ** np.arange(8.0)
    for error, expected in (
        (h**2 * [20, 8, 1, 1, 1, 1, 1, 1], "PASS"),
        (h**2 * (1 + 4 * h), "PASS"),
        (h[:5] ** 2 * (1 + 6 * h[:5]), "INCONCLUSIVE"),
        (h[:7] ** 2 + 0.5 * h[6] ** 0.5 * h[:7] ** 1.5, "INCONCLUSIVE"),
        (np.array([1, 0.25, 0.3]), "FAIL"),
    ):
        assert c.verdict(h[: len(error)], error, band=BAND)[0] == expected, (error, expected)
    three = np.array([1, 1 / 1.4, 1 / 3.92])
    assert c.verdict(three, [1, 1.4**-1.37, 1.4**-1.37 * 2.8**-0.87], band=(0.69, 1.31))[0] == "INCONCLUSIVE"
    fine = 1.1 ** -np.arange(12.0)
    scattered = fine**2 * [1, 1.01, 0.99, 1, 1.01, 0.99, 1, 1.005, 0.995, 1.01, 1, 1.06]
    assert c.verdict(fine, scattered, band=BAND)[0] == "INCONCLUSIVE"


def levels_on_both_sides_of_a_change_of_sign_tell_the_order(c: ModuleType) -> None:
    x = 2.0 ** np.arange(9, -1, -1)
    for more, at in ((1.1, 12.0), (2.6, 11.0), (2.6, 8 * 0.98 ** (-1 / 2.6))):  # the last one is next to the change at x = 8
        law = x**1.5 * np.abs(1 - (x / at) ** more)
        error = 1e-4 * law * np.exp(0.01 * np.random.default_rng(1).standard_normal(len(x)))
        assert c.verdict(x, error, band=(1.34, 1.66))[0] == "PASS"


def an_estimate_agrees_with_least_squares(c: ModuleType) -> None:
    h = 0.5 ** np.arange(8.0)
    error = 0.1 * h**2 * [1, 1.04, 0.97, 0.96, 1.05, 1.02, 0.95, 1.01]
    found, fit = c.analyse(h, error).fit, c.fit_order(h, error)
    same(found.order, fit.order, rtol=1e-6)
    assert 0.7 < (found.high - found.low) / (fit.high - fit.low) < 1.3


def the_floor_and_the_order_above_it_are_found(c: ModuleType) -> None:
    series = c.analyse(H, 1e-4 + H**3)
    assert series.classification == "other-error floor"
    same([series.floor.floor, series.floor.order], [1e-4, 3], rtol=0.02)


def errors_below_ten_times_the_uncertainty_of_a_reference_are_not_judged(c: ModuleType) -> None:
    h, error = np.sort(H)[::-1], np.sort(H)[::-1] ** 2
    assert c.verdict(h, error, band=BAND, uncertainty=error[2] / 11)[0] == "PASS"
    assert c.verdict(h, error, band=BAND, uncertainty=error[2] / 9)[0] == "INCONCLUSIVE"
    reference = c.qualify(h, 5 + error, formal=2)
    same(reference.uncertainty, 1.25 * error[-1] / (5 + error[-1]), rtol=1e-6)
    assert not c.qualify(h, 5 + h**0.1, formal=2).qualified
    assert not c.qualify(h[:2], error[:2], formal=2).qualified


def grid_convergence_is_exact_on_power_laws(c: ModuleType) -> None:
    for order in (0.8, 2.0, 3.1):
        for sign in (-1, 1):
            found = c.grid_convergence(H, 2 + sign * H**order, formal=2)
            same([found.order, found.limit], [order, 2], rtol=1e-7)
            assert found.factor == (1.25 if order == 2 else 3)
            assert found.uncertainty >= H.min() ** order * 0.999
            assert found.uncertainty <= 3.1 * H.min() ** min(order, 2) * (1 if order <= 2 else 10)
    assert c.grid_convergence(H, 2 - H**-1, formal=2).behaviour == "divergent"
    alternating = 2 + H**2 * [1, -1, -1, 1, -1]
    assert c.grid_convergence(H, alternating, formal=2).behaviour == "oscillatory"
