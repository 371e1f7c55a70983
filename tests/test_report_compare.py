"""The page that compares two solvers: its ratios, its static table, and that its script says what the report says."""

import dataclasses
import json
import math
from pathlib import Path
from urllib.parse import parse_qs, urlencode

import pytest
import sample_study
from browser import BROWSER, acted
from hypothesis import given
from hypothesis import strategies as st
from report_pages import Page
from sample_study import HOSTILE, store, study

from mpmverify.criteria import Order, Stall
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError
from mpmverify.reports import render
from mpmverify.reports.compare_page import compare_page, comparison_of
from mpmverify.reports.cost import at_same_error
from mpmverify.reports.dossiers import dossiers
from mpmverify.reports.notation import number, order
from mpmverify.reports.pairs import compared_measures, matches, middle, nearest, trials
from mpmverify.reports.ratios import ratio_bar
from mpmverify.reports.reader import read
from mpmverify.reports.record import Record
from mpmverify.study import Case

HARMFUL = f"x{HOSTILE.replace('/', '')}"
FACTORS = {"good": (1.0, 2.0, 1.0), "rough": (3.0, 2.0, 0.5), "low": (0.2, 1.0, 2.0), HARMFUL: (1.0, 1.5, 7.0)}
"""Of each solver: factor of its error, order, and factor of its seconds and point-steps."""


def level(case: str, solver: str, label: str, h: float) -> sample_study.Level:
    made = TRUE_LEVEL(case, "good", label, h)
    factor, power, cost = FACTORS[solver]
    error = factor * h**power * (1 + 0.03 * math.sin(40 * h))
    norms = (sample_study.np.full(4, error), sample_study.np.ones(4))
    spent = {"seconds": cost * 0.001 / h, "point_steps": round(50 * cost / h)}
    return dataclasses.replace(made, solver=solver, errors={"u": norms}, metrics={"mass_defect": 1e-16}, **spent)


TRUE_LEVEL = sample_study.level


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Record]:
    """Four solvers in two cases, one of which two solvers alone ran; `low` has another ladder, `rough` a known limit."""
    results = Results(tmp_path_factory.mktemp("compared"))
    declared = study(solvers=tuple(FACTORS))
    (case,) = declared.cases
    known = (*case.series[1].criteria, Stall("u", "L1", 3.0, 0.0, 1.0, "as is known"))
    wide = (Order("u", "L2", 1.4, 1.6, "theory"),)
    table = list(case.series)
    table[1] = dataclasses.replace(table[1], criteria=known)
    ladder = table[2].refinement
    table[2] = dataclasses.replace(table[2], refinement=dataclasses.replace(ladder, label="nu_C=0.25, 2 ppc"))
    table[3] = dataclasses.replace(table[3], criteria=wide)
    other = Case("second", case.problem, tuple(case.series[:2]), case.shown)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sample_study, "level", level)
        store(results, dataclasses.replace(declared, cases=(dataclasses.replace(case, series=tuple(table)), other)))
    render(results)
    return results, read(results.study("sample"))


def test_series_with_the_same_ladder_belong_together_else_the_first_with_the_same_axis(
    compared: tuple[Results, Record],
) -> None:
    known = {one.solver: trials(one, compared_measures([compared[1]])) for one in dossiers([compared[1]])}
    pairs = matches(known["good"], known["rough"])
    assert [(match.first.entry.series.case, match.first.measure) for match in pairs] == [
        ("hill & dale", ("u", "L2")),
        ("hill & dale", ("u", "L1")),
        ("second", ("u", "L2")),
    ]
    (other, _) = matches(known["good"], known["low"])
    assert other.second.entry.series.refinement == "nu_C=0.25, 2 ppc"
    assert matches(known["good"], ()) == ()


def test_the_ratio_of_errors_is_that_at_the_finest_common_size(compared: tuple[Results, Record]) -> None:
    known = {one.solver: trials(one, compared_measures([compared[1]])) for one in dossiers([compared[1]])}
    match = matches(known["good"], known["rough"])[0]
    assert match.level is not None
    assert match.level[0] == 1 / 128
    assert match.ratio == pytest.approx(1 / 3)
    # The error of `rough` on its finest level is reached by `good` on a level that is the square root of 3 coarser, at twice the cost.
    assert match.time is not None
    assert match.time.ratio == pytest.approx(2 / math.sqrt(3), rel=0.02)


def test_errors_at_round_off_have_no_ratio(compared: tuple[Results, Record]) -> None:
    record = compared[1]
    tiny = tuple(
        dataclasses.replace(
            series,
            estimates={
                measure: dataclasses.replace(estimate, error=1e-12 * estimate.error)
                for measure, estimate in series.estimates.items()
            },
        )
        for series in record.series
    )
    tiny_record = dataclasses.replace(record, series=tiny)
    known = {one.solver: trials(one, compared_measures([tiny_record])) for one in dossiers([tiny_record])}
    for match in matches(known["good"], known["rough"]):
        assert (match.level, match.time, match.work) == (None, None, None)


@given(st.floats(0.5, 3), st.floats(0.1, 10), st.floats(0.1, 10))
def test_costs_at_one_error_are_those_of_power_laws(power: float, error: float, cost: float) -> None:
    curve = [(2.0**k, 2.0 ** (-power * k)) for k in range(5)]
    other = [(cost * x, y) for x, y in curve]
    found = at_same_error(other, curve)
    assert found is not None
    assert found.ratio == pytest.approx(cost)
    assert at_same_error(curve, curve, least=1e9) is None
    assert at_same_error(curve, curve[:1]) is None
    assert at_same_error(curve, curve[::-1]) is None
    shifted = at_same_error([(x, error * y) for x, y in curve], curve)
    if shifted is not None:
        # To reach an error takes error^(1/power) times the cost where errors are `error` times as large.
        assert shifted.ratio == pytest.approx(error ** (1 / power), rel=1e-6)


@given(st.floats(1e-6, 1e6))
def test_a_bar_points_to_the_smaller_number(ratio: float) -> None:
    picture = ratio_bar(ratio)
    assert ('class="first"' in picture) == (ratio < 1)
    assert ("Z" in picture) == (abs(math.log10(ratio)) > 2)
    assert ratio_bar(math.nan) == ratio_bar(0.0) == ratio_bar(math.inf) == ""


@given(st.lists(st.one_of(st.floats(1e-3, 1e3), st.just(math.nan))))
def test_the_median_of_inverse_ratios_is_the_inverse(ratios: list[float]) -> None:
    here, there = middle(ratios), middle([1 / ratio for ratio in ratios])
    assert (math.isnan(here) and math.isnan(there)) or here * there == pytest.approx(1)


def test_without_scripts_each_solver_stands_beside_its_nearest_reference(compared: tuple[Results, Record]) -> None:
    results, record = compared
    page = compare_page([record], "generator")
    assert [row.solver.text for row in page.rows] == sorted(FACTORS)
    known = {one.solver: one for one in dossiers([record])}
    for row in page.rows:
        assert row.reference.text == nearest(trials(known[row.solver.text], compared_measures([record]))) != row.solver.text
    shown = Page(results.report / "compare.html")
    for row in page.rows:
        assert row.href in shown.links
        assert parse_qs(row.href.partition("#")[2]) == {"a": [row.solver.text], "b": [row.reference.text]}


def test_names_never_become_markup_and_solvers_link_to_their_comparison(compared: tuple[Results, Record]) -> None:
    results, _ = compared
    text = (results.report / "compare.html").read_text(encoding="utf-8")
    assert "<script>" not in text
    page = Page(results.report / "compare.html")
    assert (page.scripts, len(page.data)) == (3, 1)
    stored = json.loads(page.data[0])
    assert {solver["name"] for solver in stored["solvers"]} == set(FACTORS)
    assert "compare.html" in Page(results.report / "solvers.html").links
    assert comparison_of("good") in Page(results.report / "solver-good.html").links


def test_a_solver_that_nobody_shares_a_case_with_has_no_reference(tmp_path: Path) -> None:
    results = Results(tmp_path)
    store(results, study(solvers=("good",)))
    render(results)
    words = "".join(Page(results.report / "compare.html").text)
    assert "1 solver has no reference: no other ran a series whose errors fall with a size." in words
    store(results, study("compare", ("good",)))
    with pytest.raises(ResultsError, match="rename the study"):
        render(results)


# The script.

READ = """
  const text = (selector, root = document) => [...root.querySelectorAll(selector)].map((one) => one.textContent.trim());
  const seen = () => ({
    sentence: document.querySelector('[data-role="sentence"]').textContent,
    names: text(".duel h2 a"),
    rows: [...document.querySelectorAll("table.sides tbody tr:not(.heading)")].map((row) => text("td", row)),
    strips: [...document.querySelectorAll("table.sides .lane .strip")].map((one) => one.getAttribute("aria-label")),
    alone: text('[data-role="alone"] summary .name'),
    limits: text('[data-role="limits"] tbody td'),
    shown: !document.querySelector('[data-role="comparison"]').hidden,
    notice: document.querySelector('[data-role="unknown"]').textContent,
    address: location.hash,
  });
  const settle = async () => { await pause(); await pause(); };
"""


def looked(results: Results, profile: Path, act: str, window: str = "1280,900") -> dict:
    found = acted(results.report / "compare.html", results.report, READ + act, profile, window=window)
    assert (found["faults"], found["missing"]) == ([], [])
    return found


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
def test_the_script_computes_the_ratios_that_the_report_computes(compared: tuple[Results, Record], tmp_path: Path) -> None:
    results, record = compared
    known = {one.solver: trials(one, compared_measures([record])) for one in dossiers([record])}
    pairs = [(one, other) for one in FACTORS for other in FACTORS]
    steps = "".join(
        f"location.hash = {json.dumps(urlencode({'a': a, 'b': b}))}; await settle(); all.push(seen());" for a, b in pairs
    )
    found = looked(results, tmp_path, f"const all = []; {steps} return {{ all }};")
    for (one, other), seen in zip(pairs, found["all"], strict=True):
        expected = matches(known[one], known[other])
        assert seen["names"] == [one, other]
        assert len(seen["rows"]) == len(expected) > 0
        for match, row in zip(sorted(expected, key=lambda m: m.first.entry.series.case), seen["rows"], strict=True):
            assert row[5].startswith(number(match.ratio, 2))
            assert row[6] == (number(match.time.ratio, 2) if match.time else "–")
            assert row[7] == (number(match.work.ratio, 2) if match.work else "–")
            for trial in (match.first, match.second):
                assert number(float(trial.estimate.error[-1])) in row[4]
                assert order(trial.estimate.order) in row[3] or match.first.measure == ("u", "L1")
        said = seen["sentence"]
        assert f"Both ran {len(expected)} series in 1 study." in said
        assert f"the median ratio is {number(middle([match.ratio for match in expected]), 2)}." in said
        assert seen["strips"][0].startswith("order ")
    by_pair = dict(zip(pairs, found["all"], strict=True))
    assert by_pair["good", "low"]["alone"] == ["A alone"]
    assert "A Courant 0.5" in by_pair["good", "low"]["rows"][0][0]
    assert any("stall" in cell for cell in by_pair["good", "rough"]["limits"])


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
def test_the_address_keeps_the_choice_and_an_unknown_name_is_said(compared: tuple[Results, Record], tmp_path: Path) -> None:
    act = """
      const first = seen();
      document.querySelector("form.pickers").elements.a.value = "rough";
      document.querySelector("form.pickers").dispatchEvent(new Event("change"));
      const chosen = seen();
      document.querySelector('[data-role="swap"]').click();
      const swapped = seen();
      location.hash = "#a=nobody&b=good";
      await settle();
      return { first, chosen, swapped, unknown: seen() };
    """
    found = looked(compared[0], tmp_path, act)
    assert found["first"]["shown"]
    assert found["chosen"]["names"][0] == "rough"
    assert found["swapped"]["names"] == found["chosen"]["names"][::-1]
    assert parse_qs(found["swapped"]["address"][1:])["b"] == ["rough"]
    assert found["unknown"]["notice"] == "This report has no solver “nobody”."
    assert found["unknown"]["names"][1] == "good"
