"""Every kind of page in a browser: no error, no missing file, charts are drawn, filters and the address work."""

import dataclasses

import pytest
from browser import BROWSER, acted
from sample_study import rendered, store, study

from mpmverify.dataset.files import Results
from mpmverify.reports import render

pytestmark = pytest.mark.skipif(BROWSER is None, reason="needs Chromium")

OPEN = """
  for (const folded of document.querySelectorAll("details")) folded.open = true;
  for (let pass = 0; pass < 2; pass += 1) {  // the first makes the charts of the histories
    for (const chart of document.querySelectorAll(".chart")) {
      chart.scrollIntoView({ behavior: "instant" });
      for (let k = 0; k < 300 && chart.isConnected && !chart.querySelector(".main-svg"); k += 1) await frame();
    }
  }
  const blank = [...document.querySelectorAll(".chart")].filter((chart) => !chart.querySelector(".main-svg"));
  const wide = document.documentElement.scrollWidth - innerWidth;
  return { blank: blank.map((chart) => chart.dataset.chart), charts: document.querySelectorAll(".chart").length, wide };
"""
FILTER = """
  const form = document.querySelector("form.filters");
  const shown = () => [...document.querySelectorAll(".card")].filter((card) => !card.hidden).map((card) => card.dataset.name);
  const outcome = { all: shown() };
  const choose = async (name, value) => {
    form.elements[name].value = value;
    form.dispatchEvent(new Event("input"));
    await pause();
    return shown();
  };
  outcome.none = await choose("find", "nothing is called so");
  outcome.said = form.querySelector("output").textContent;
  outcome.some = await choose("find", "crashed");
  outcome.address = location.hash;
  await choose("find", "");
  location.hash = "#find=crashed&sort=name";
  await pause();
  outcome.restored = shown();
  outcome.field = form.elements.find.value;
  return outcome;
"""
VIEWS = """
  const section = document.querySelector("section.case");
  section.querySelector("details").open = true;
  const chart = section.querySelector('[data-chart="convergence"]');
  chart.scrollIntoView({ behavior: "instant" });
  while (!chart.querySelector(".main-svg")) await frame();
  const titles = {};
  const view = section.querySelector('[data-role="view"]');
  for (const { value } of view.options) {
    view.value = value;
    view.dispatchEvent(new Event("change"));
    for (let k = 0; k < 60; k += 1) await frame();
    titles[value] = chart.layout.yaxis.title.text + " / " + chart.layout.xaxis.title.text;
  }
  let made = null;
  URL.createObjectURL = (blob) => { made = blob; return "#"; };
  section.querySelector('[data-download="csv"]').click();
  await pause();
  return { titles, csv: await made.text() };
"""


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A report with failures of every kind, a self-test, and two studies."""
    return rendered(tmp_path_factory.mktemp("browsed"))[0].report


@pytest.mark.parametrize("window", ["1280,900", "390,800"])
@pytest.mark.parametrize(
    "name", ["index", "sample", "solvers", "solver-good", "solver-crashed", "compare", "problems", "trust", "handbook/verdicts"]
)
def test_a_page_opens_without_errors_and_draws_its_charts(report, tmp_path, name, window):
    found = acted(report / f"{name}.html", report, OPEN, tmp_path, window=window)
    assert (found["faults"], found["missing"], found["blank"]) == ([], [], [])
    assert found["charts"] > 0 or name != "sample"
    # A headless window is not narrower than 500 pixels on some systems: what counts is that nothing leaves it.
    assert found["wide"] <= 0, "the page can be scrolled sideways"


def test_long_and_foreign_texts_are_shown_and_widen_no_page(tmp_path):
    texts = {"title": "\U0001f30a \u202egpj.exe " + "t" * 10_000, "summary": "w" * 10_000 + " \u05d0\u05d1\u05d2 \U0001f9ca"}
    results = Results(tmp_path / "results")
    store(results, dataclasses.replace(study("wild", ("good", "\U0001f30a")), **texts))
    render(results)
    for name in ("index", "wild", "solvers", "problems", "compare"):
        found = acted(results.report / f"{name}.html", results.report, OPEN, tmp_path / name, window="390,800")
        assert (found["faults"], found["missing"], found["wide"] <= 0) == ([], [], True), name
    page = (results.report / "wild.html").read_text(encoding="utf-8")
    assert all(text in page for text in texts.values())


def test_the_filters_choose_cards_and_the_address_restores_them(report, tmp_path):
    found = acted(report / "index.html", report, FILTER, tmp_path)
    assert found["faults"] == []
    assert (len(found["all"]), found["none"], found["said"]) == (2, [], "0 of 2 studies")
    assert len(found["some"]) == 1
    assert found["address"] == "#find=crashed"
    assert (found["restored"], found["field"]) == (found["some"], "crashed")


def test_the_convergence_chart_shows_errors_orders_and_costs_and_gives_its_numbers(report, tmp_path):
    found = acted(report / "sample.html", report, VIEWS, tmp_path)
    assert found["faults"] == []
    titles = found["titles"]
    assert titles["size"].endswith("h [m]")
    assert titles["local"] == "order from the coarser level / h [m]"
    assert titles["seconds"].endswith("/ wall time [s]")
    assert titles["steps"].endswith("/ point-steps")
    head, *rows = found["csv"].strip().splitlines()
    assert head == "series,size,error,order_from_coarser,wall_seconds,point_steps"
    assert len(rows) % 4 == 0
    assert any(row.endswith(",0.1,99") and ",2," in row for row in rows), "errors that fall at second order"
