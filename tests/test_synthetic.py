"""Random series of known truth: they have the stated properties, and wrong verdicts on them are rare."""

import dataclasses
import itertools

import numpy as np
import pytest
from click.testing import CliRunner

from mpmverify.convergence import ROUND_OFF, pairwise_orders
from mpmverify.convergence.synthetic import (
    KINDS,
    RandomSeries,
    Rate,
    Truth,
    draw_series,
    ideal_rates,
    measure,
    measure_limits,
    rates,
    total,
)
from mpmverify.convergence.synthetic.__main__ import main
from mpmverify.convergence.synthetic.ideal import FAMILIES, GRID_ERROR, log_ratio, power
from mpmverify.convergence.synthetic.laws import MARGIN, LawInputs
from mpmverify.convergence.verdict import Verdict

EACH = 40


def of(truth):
    return {name: kind for name, kind in KINDS.items() if kind.truth is truth}


# The series have the stated properties.


def orders_at_the_finest(kind, count=200):
    """Inputs of a law, and its order between levels that almost coincide with the finest one."""
    generator = np.random.default_rng(0)
    x = 1.0001 ** np.arange(8.0)[::-1]
    for low in generator.uniform(0.3, 4, count):
        setting = LawInputs(generator, x, low, low + 0.5)
        yield setting, pairwise_orders(x, kind.law(setting))[-1]


ALTERED = ("blows up", "single precision, untold")


@pytest.mark.parametrize("name", [name for name in of(Truth.OUTSIDE) if "alternating" not in name and name not in ALTERED])
def test_the_finest_order_of_an_outside_series_lies_outside_the_band(name):
    for s, order in orders_at_the_finest(KINDS[name]):
        assert order <= max(s.low - MARGIN, 0.05) + 1e-3 or order >= s.high + MARGIN - 1e-3


@pytest.mark.parametrize("name", [name for name in of(Truth.INSIDE) if name.startswith(("power law", "round", "numerical"))])
def test_the_order_of_an_inside_power_law_lies_in_the_inner_half_of_the_band(name):
    for s, order in orders_at_the_finest(KINDS[name]):
        assert abs(order - (s.low + s.high) / 2) <= (s.high - s.low) / 4 + 1e-9


def draw_many(name, count=200):
    generator = np.random.default_rng(1)
    return [draw_series(KINDS[name], generator) for _ in range(count)]


@pytest.mark.parametrize("name", of(Truth.UNDECIDABLE))
def test_an_undecidable_series_has_at_most_two_usable_levels_or_an_implausibly_small_finest_error(name):
    for series in draw_many(name):
        above = series.error > ROUND_OFF
        finest, second = np.argsort(series.h)[: 2 if len(series.h) > 1 else 1][[0, -1]]
        fastest = (series.h[second] / series.h[finest]) ** series.high
        assert above.sum() <= 2 or series.error[finest] < series.error[second] / fastest / 10


def test_decidable_series_at_round_off_or_with_a_reference_have_three_usable_levels():
    for series in draw_many("round-off after three levels"):
        assert np.sum(series.error > ROUND_OFF) >= 3
    for series in draw_many("numerical reference"):
        assert np.sum(series.error > 10 * KINDS["numerical reference"].uncertainty) >= 3


@pytest.mark.parametrize("name", KINDS)
def test_errors_are_finite_except_in_kinds_that_are_not_finite(name):
    series = draw_many(name)
    assert all(np.isfinite(s.error).all() is np.bool_(KINDS[name].truth is not Truth.NOT_FINITE) for s in series)
    assert any(np.any(np.diff(s.h) > 0) for s in series), "the levels are in any order"
    assert all(s.high - s.low >= 0.2 for s in series)


def test_ratios_are_equal_where_the_kind_says_so():
    for name, equal in (("power law, equal ratios", True), ("power law, unequal ratios", False)):
        ratios = [np.diff(np.log(np.sort(series.h))) for series in draw_many(name, 50)]
        assert all(bool(np.ptp(r) < 1e-9) is equal for r in ratios)
        assert all(1.0999 <= np.exp(r.min()) <= np.exp(r.max()) <= 4.0001 for r in ratios)
        assert min(map(len, ratios)) == 2
        assert max(map(len, ratios)) >= 10
        assert sum(np.allclose(r, np.log(2)) for r in ratios) >= (15 if equal else 0)


def test_replicates_have_the_same_size_and_rough_starts_leave_four_levels():
    assert all(len(set(s.h)) >= 3 for s in draw_many("replicates"))
    assert any(len(set(s.h)) < len(s.h) for s in draw_many("replicates"))
    assert all(len(s.h) >= 5 for s in draw_many("rough start"))


def test_of_single_precision_that_is_not_told_three_levels_are_noise():
    for s in draw_many("single precision, untold"):
        assert np.all(np.sort(s.error)[:3] < 1e-6)
        assert len(s.error) > 3


# The judge.


@pytest.fixture(scope="module")
def rates_of_all():
    return measure(EACH * len(KINDS), seed=1)


def test_every_verdict_is_counted_once(rates_of_all):
    assert [r.kind for r in rates_of_all] == list(KINDS)
    for r in (*rates_of_all, total(rates_of_all)):
        assert r.series == r.right + r.inconclusive + r.wrong_pass + r.wrong_fail
    assert total(rates_of_all).series == EACH * len(KINDS)
    assert total(rates_of_all, Truth.INSIDE).series == EACH * len(of(Truth.INSIDE))


def test_nothing_passes_wrongly(rates_of_all):
    assert total(rates_of_all).wrong_pass == 0


def test_a_wrong_fail_is_rarer_than_one_in_a_hundred_and_rare_in_every_kind(rates_of_all):
    innocent = total(rates_of_all, Truth.INSIDE, Truth.UNDECIDABLE)
    assert innocent.wrong_fail < 0.01 * innocent.series
    assert max(r.wrong_fail for r in rates_of_all) <= 1


def test_most_decidable_series_get_a_decision(rates_of_all):
    right = {r.kind: r.right / r.series for r in rates_of_all}
    for name, kind in KINDS.items():
        if kind.truth in (Truth.UNDECIDABLE, Truth.NOT_FINITE):
            assert right[name] == 1
    assert (
        min(right[f"power law, {ratios} ratios{side}"] for ratios in ("equal", "unequal") for side in ("", ", too low")) > 0.9
    )
    assert min(right[name] for name in ("rough start", "stagnant", "equal errors", "divergent", "blows up")) > 0.9


def test_most_of_what_the_ideal_judge_decides_is_decided(rates_of_all):
    ideal = ideal_rates(40, seed=1)
    decidable = [r for r in rates_of_all if r.kind in ideal]
    assert {r.truth for r in decidable} == {Truth.INSIDE, Truth.OUTSIDE}
    assert sum(r.right / r.series for r in decidable) >= 0.85 * sum(ideal.values())
    inside = [r for r in decidable if r.truth is Truth.INSIDE]
    assert sum(r.right / r.series for r in inside) >= 0.75 * sum(ideal[r.kind] for r in inside)


def test_an_order_outside_the_band_does_not_pass_and_fails_more_often_with_distance():
    beside = [r for r in measure_limits(40 * 11, seed=1) if "outside" in r.kind]
    assert max(r.wrong_pass for r in beside) <= 1
    share = [r.right for r in beside]
    assert all(b >= a - 4 for a, b in itertools.pairwise(share))
    assert share[-1] > 0.9 * 40


def test_the_ideal_judge_decides_by_the_law_of_each_kind():
    """A straight line with known scatter: the ratio of the likelihoods follows from the distances to the two regions."""
    h, scatter, low, high = 2.0 ** -np.arange(5), 0.1, 1.8, 2.2
    series = RandomSeries(h, h**2.4, low, high, scatter)
    spread = np.log(2) ** 2 * 10
    inwards, outwards = high + MARGIN - 2.4, 2.4 - (high - (high - low) / 4)
    expected = (inwards**2 - outwards**2) * spread / (2 * (scatter**2 + GRID_ERROR**2))
    assert log_ratio(power, series, 0.0) == pytest.approx(expected)
    for name in ("power law, equal ratios", "alternating", "mixed orders"):
        generator = np.random.default_rng(0)
        ratios = [log_ratio(FAMILIES.get(name, power), draw_series(KINDS[name], generator), 1e-12) for _ in range(50)]
        assert np.median(ratios) > 10


def test_rates_depend_on_the_seed_alone():
    assert measure(len(KINDS), seed=5) == measure(len(KINDS), seed=5)
    assert measure(len(KINDS), seed=5) != measure(len(KINDS), seed=6)


@pytest.mark.parametrize("blind", list(Verdict))
def test_a_judge_with_a_constant_verdict_is_counted_wrong(monkeypatch, blind):
    monkeypatch.setattr(rates, "decide", lambda *_: (blind, ""))
    for r in measure(len(KINDS)):
        right = {"inside": "PASS", "outside": "FAIL", "undecidable": "INCONCLUSIVE", "not finite": "ERROR"}[r.truth]
        column = "right" if blind == right else {"PASS": "wrong_pass", "INCONCLUSIVE": "inconclusive"}.get(blind, "wrong_fail")
        assert getattr(r, column) == r.series == 1


# The command.


def test_the_command_prints_every_kind_and_the_totals():
    result = CliRunner().invoke(main, ["--count", "49", "--seed", "3"])
    assert result.exit_code == 0
    for name in (*KINDS, "all", "0.3 outside the edge", "ideal judge"):
        assert name in result.output
    assert CliRunner().invoke(main, ["--count", "0"]).exit_code == 2


def test_a_rate_is_a_dataclass_with_the_documented_fields():
    assert dataclasses.is_dataclass(Rate)
    assert {field.name for field in dataclasses.fields(Rate)} >= {
        "kind",
        "truth",
        "series",
        "right",
        "wrong_pass",
        "wrong_fail",
    }
