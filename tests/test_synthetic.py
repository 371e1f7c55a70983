"""Random series of known truth: they have the stated properties, and wrong verdicts on them are rare."""

import dataclasses
import itertools

import numpy as np
import pytest
from click.testing import CliRunner

from mpmverify.convergence import ROUND_OFF, pairwise_orders
from mpmverify.convergence.synthetic import KINDS, Rate, Truth, draw_series, measure, measure_limits, rates, total
from mpmverify.convergence.synthetic.__main__ import main
from mpmverify.convergence.synthetic.laws import MARGIN, LawInputs
from mpmverify.convergence.verdict import Verdict

EACH = 200


def of(truth):
    return {name: kind for name, kind in KINDS.items() if kind.truth is truth}


# The series have the stated properties.


def orders_at_the_finest(kind, count=200):
    """Inputs of a law, and its order between levels that almost coincide with the finest one."""
    generator = np.random.default_rng(0)
    x = 1.0001 ** np.arange(4.0)[::-1]
    for low in generator.uniform(0.3, 4, count):
        setting = LawInputs(generator, x, low, low + 0.5)
        yield setting, pairwise_orders(x, kind.law(setting))[-1]


@pytest.mark.parametrize("name", [name for name in of(Truth.OUTSIDE) if "alternating" not in name and name != "blows up"])
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
        assert all(np.allclose(r, np.log(2)) is equal for r in ratios)


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


def test_a_wrong_pass_is_rarer_than_one_in_a_thousand(rates_of_all):
    assert total(rates_of_all).wrong_pass < 0.001 * total(rates_of_all).series


def test_a_wrong_fail_is_rarer_than_one_in_a_hundred_and_rare_in_every_kind(rates_of_all):
    innocent = total(rates_of_all, Truth.INSIDE, Truth.UNDECIDABLE)
    assert innocent.wrong_fail < 0.01 * innocent.series
    assert max(r.wrong_fail for r in rates_of_all) <= 0.02 * EACH


def test_most_decidable_series_get_a_decision(rates_of_all):
    right = {r.kind: r.right / r.series for r in rates_of_all}
    for name, kind in KINDS.items():
        if kind.truth in (Truth.UNDECIDABLE, Truth.NOT_FINITE):
            assert right[name] == 1
    assert min(right["power law, equal ratios"], right["power law, unequal ratios"]) > 0.9
    assert min(right[name] for name in ("order too low", "order too high", "stagnant", "divergent", "blows up")) > 0.9
    assert total(rates_of_all, Truth.OUTSIDE).right > 0.75 * EACH * len(of(Truth.OUTSIDE))


def test_an_order_outside_the_band_does_not_pass_and_fails_more_often_with_distance():
    beside = [r for r in measure_limits(200 * 11, seed=1) if "outside" in r.kind]
    assert max(r.wrong_pass for r in beside) <= 2
    share = [r.right for r in beside]
    assert all(b >= a - 8 for a, b in itertools.pairwise(share))
    assert share[-1] > 0.95 * 200


def test_rates_depend_on_the_seed_alone():
    assert measure(270, seed=5) == measure(270, seed=5)
    assert measure(270, seed=5) != measure(270, seed=6)


@pytest.mark.parametrize("blind", list(Verdict))
def test_a_judge_with_a_constant_verdict_is_counted_wrong(monkeypatch, blind):
    monkeypatch.setattr(rates, "verdict", lambda *_, **__: (blind, ""))
    for r in measure(len(KINDS)):
        right = {"inside": "PASS", "outside": "FAIL", "undecidable": "INCONCLUSIVE", "not finite": "ERROR"}[r.truth]
        column = "right" if blind == right else {"PASS": "wrong_pass", "INCONCLUSIVE": "inconclusive"}.get(blind, "wrong_fail")
        assert getattr(r, column) == r.series == 1


# The command.


def test_the_command_prints_every_kind_and_the_totals():
    result = CliRunner().invoke(main, ["--count", "27", "--seed", "3"])
    assert result.exit_code == 0
    for name in (*KINDS, "all", "0.3 outside the edge"):
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
