"""Charts, their still pictures and thumbnails: what they draw, and the data that they are drawn from."""

import base64
import dataclasses
import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_pages import pages, strict
from sample_study import SIZES, rendered, store, study

from mpmverify.criteria import Balance
from mpmverify.dataset.files import Results
from mpmverify.reports import cards, charts, render
from mpmverify.reports.record import Estimate, Profile
from mpmverify.reports.record import Series as RecordSeries
from mpmverify.reports.still import still
from mpmverify.reports.thumbnails import HEIGHT, MARGIN, Thumbnail, thumbnail


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, list]:
    return rendered(tmp_path_factory.mktemp("results"))


def test_a_strip_places_a_dot_at_its_order_and_a_cross_at_one_outside_its_band() -> None:
    def judged_by(low: float, high: float) -> dict:
        return {q: {"type": "Order", "quantity": q, "norm": "L2", "low": low, "high": high} for q in ("u", "v")}

    estimate = Estimate(*(np.ones(1),) * 2, "1", np.ones(1), (True,), (), 2.0, 1.9, 2.1, 0.0, "converging")
    outside = dataclasses.replace(estimate, order=9.0)
    series = RecordSeries(
        "case",
        "solver",
        "Scheme",
        "ladder",
        "h",
        {},
        (),
        {("u", "L2"): estimate, ("v", "L2"): outside},
        judged_by(1.5, math.inf),
        (),
    )
    assert cards.judged_orders([series]) == [(2.0, 1.5, math.inf, True), (9.0, 1.5, math.inf, True)]
    series = dataclasses.replace(series, criteria=judged_by(1.8, 2.2))
    drawn = cards.strip([series])
    middle, end = cards.STRIP_WIDTH / 2, cards.STRIP_WIDTH - cards.LEFT
    assert re.search(rf'<circle class="dot-in" cx="{middle:.1f}"', drawn)
    assert f'<path class="dot-out" d="M{end - 3:.1f}' in drawn
    assert drawn.count('class="accepted"') == 1
    assert cards.orders([series]) == "2 orders, 2.00 to 9.00; 1 in the accepted band"
    assert cards.strip([dataclasses.replace(series, criteria={})]) == cards.orders([]) == ""


def test_a_case_with_frequencies_only_has_a_series_chooser_and_no_convergence_chart(tmp_path: Path) -> None:
    criteria = (Balance("mass", "inflow", "conservation form"),)
    results = Results(tmp_path)
    declared = study(solvers=("good",))
    case = declared.cases[0]
    series = tuple(dataclasses.replace(entry, criteria=criteria) for entry in case.series)
    store(results, dataclasses.replace(declared, cases=(dataclasses.replace(case, series=series),)))
    store(results, study("judged", ("good",)))
    render(results)
    for name, charts_shown in (("sample", ["theory"]), ("judged", ["convergence", "theory"])):
        text = (results.report / f"{name}.html").read_text(encoding="utf-8")
        assert [kind for kind in ("convergence", "theory") if f'data-chart="{kind}"' in text] == charts_shown
        assert text.count('<fieldset class="curves">') == 1, "there is one chooser of curves"
        assert text.index('<fieldset class="curves">') > text.index(f'data-chart="{charts_shown[0]}"')
        assert ("with the observed order below" in text) == ("convergence" in charts_shown)
        assert ('class="order"' in text) == ("convergence" in charts_shown)


def test_a_series_that_did_not_pass_is_drawn_at_first_and_marked_in_the_chooser(tmp_path: Path) -> None:
    results = Results(tmp_path)
    store(results, study(solvers=("first", "bad", *(f"good {k}" for k in range(10)))))
    render(results)
    text = (results.report / "sample.html").read_text(encoding="utf-8")
    boxes = dict(re.findall(r'<input type="checkbox" data-series="(\d+)" data-default="(\d)"', text))
    assert len(boxes) == 12
    assert boxes["1"] == "1"
    assert list(boxes.values()).count("1") == 7, "in addition to the default six"
    chooser = text[text.index('<fieldset class="curves">') : text.index("</fieldset>")]
    assert chooser.count('class="dot error"') == chooser.count('class="dot') == 1
    assert len(re.findall(r'<td class="key"><span class="dot error">', text)) == 4, "in the table of every norm"


def test_measured_frequencies_are_charted_for_the_series_that_has_them(stored: tuple[Results, list]) -> None:
    page = pages(stored[0])["sample.html"]
    lines, markers = strict(page.data[0])["theory"]["data"]
    assert (lines["mode"], markers["mode"]) == ("lines", "markers")
    assert lines["meta"] == markers["meta"] == {"series": 0}
    assert markers["x"] == lines["x"] == sorted(2 * h for h in SIZES)
    assert markers["y"] == pytest.approx([1 - h**2 for h in sorted(SIZES)], rel=1e-4)
    assert "ω/(ck) = 0.999939" in markers["text"][0]
    assert 'data-chart="theory"' in (stored[0].report / "sample.html").read_text(encoding="utf-8")


def test_figures_are_strict_json_of_bounded_size(stored: tuple[Results, list]) -> None:
    (text,) = pages(stored[0])["sample.html"].data
    figures = strict(text)
    assert figures["convergence"]["titles"]
    measured = {trace["meta"]["series"] for trace in figures["convergence"]["data"] if "series" in trace["meta"]}
    assert measured == {0, 1}, "the crashed series has no errors"
    assert figures["series"][2]["waves"] is None
    waves = figures["series"][1]["waves"]
    assert len(waves["x"]) <= charts.POINTS
    assert len(waves["t"]) <= charts.OUTPUTS
    values = len(base64.b64decode(waves["fields"]["u"]["value"]["data"])) // 2
    assert values == len(waves["x"]) * len(waves["t"])


def test_levels_outside_the_fit_have_hollow_markers(stored: tuple[Results, list]) -> None:
    figures = strict(pages(stored[0])["sample.html"].data[0])
    symbols = {
        trace["meta"]["series"]: set(trace["marker"]["symbol"])
        for trace in figures["convergence"]["data"]
        if trace["meta"]["measure"] == "u|L2" and "series" in trace["meta"]
    }
    assert not any(symbol.endswith("-open") for symbol in symbols[0])
    assert all(symbol.endswith("-open") for symbol in symbols[1])


def test_the_convergence_chart_has_a_still_picture_of_the_series_that_are_drawn_at_first(stored: tuple[Results, list]) -> None:
    page = (stored[0].report / "sample.html").read_text(encoding="utf-8")
    figure = json.loads(re.search(r'<script type="application/json" class="figures">(.*?)</script>', page, re.DOTALL)[1])
    drawn = [trace for trace in figure["convergence"]["data"] if "series" in trace["meta"]]
    (picture,) = re.findall(r'<svg class="still".*?</svg>', page, re.DOTALL)
    points = sum(
        sum(y is not None for y in trace["y"]) for trace in drawn if trace["meta"]["measure"] == drawn[0]["meta"]["measure"]
    )
    assert picture.count("<circle") + picture.count('Z" fill=') >= points
    assert "nan" not in picture.lower()
    assert "order 1.8 to 2.2" in picture


def test_a_still_picture_places_points_by_their_logarithms() -> None:
    line = {"color": "red", "width": 1, "dash": "dash"}
    trace = {
        "mode": "lines+markers",
        "x": [1.0, 0.1, 0.01],
        "y": [1.0, 0.01, 1e-4],
        "line": line,
        "meta": {"measure": "a", "series": 0},
    }
    trace["marker"] = {"symbol": ["circle", "circle-open", "square"], "color": "red"}
    layout = {"xaxis": {"domain": [0, 1], "title": {"text": "h <m>"}}}
    figure = {"data": [trace], "layout": layout, "titles": {"a": "error & more"}}
    picture = still(figure, "a", [0])
    (x0, y0), (x1, y1) = (tuple(map(float, found)) for found in re.findall(r'<circle cx="(\S+)" cy="(\S+)"', picture))
    assert x1 < x0
    assert y1 > y0
    assert "error &amp; more" in picture
    assert "h &lt;m&gt;" in picture
    assert picture.count('fill="var(--panel)"') == 1
    assert still(figure, "a", [1]) == still(figure, "b", [0]) == ""
    trace["y"] = [None, None, None]
    assert still(figure, "a", [0]) == ""


@given(st.lists(st.one_of(st.floats(-1e6, 1e6), st.just(math.nan), st.just(math.inf)), min_size=1))
def test_packed_values_unpack_to_within_half_a_step(values: list[float]) -> None:
    field = charts.packed(np.array(values))
    steps = np.frombuffer(base64.b64decode(field["data"]), dtype="<i2").astype(float)
    back = np.where(steps == -32768, np.nan, field["low"] + (steps + 32767) * field["scale"])
    expected = np.where(np.isfinite(values), values, np.nan)
    np.testing.assert_allclose(back, expected, rtol=1e-12, atol=0.51 * field["scale"])


def heights(path: str) -> np.ndarray:
    return np.array([float(place.split()[1]) for place in path.removeprefix("M").split("L")])


def drawn(numerical: Callable[[np.ndarray], np.ndarray], final: float = 1.0) -> Thumbnail:
    """Return the thumbnail of an oscillating sin(pi x) with final amplitude `final`."""
    x, time = np.linspace(0, 1, 50), np.linspace(0, 1, 9)
    exact = np.append(np.linspace(-1, 1, 8), final)[:, None] * np.sin(np.pi * x)
    fields = np.vstack([exact[:-1], numerical(exact[-1])])
    found = thumbnail(Profile(0.1, time, x, {"u": fields}, {"u": exact}, {"u": "m"}), "u")
    assert found is not None
    return found


@pytest.mark.parametrize("final", [1.0, 0.3, 1e-17, 0.0])
def test_a_thumbnail_scales_an_error_by_the_whole_run_for_any_final_amplitude(final: float) -> None:
    for error in (0.0, 1e-3, 0.3):
        small = drawn(lambda exact, error=error: exact + error, final)
        apart = np.abs(heights(small.exact) - heights(small.numerical)).max() / (HEIGHT - 2 * MARGIN)
        assert apart == pytest.approx(error / 2.3 if error > 0.1 and final == 1 else error / 2, abs=4e-3)


def test_a_diverging_profile_leaves_the_exact_one_visible() -> None:
    for error in (1e9, -1e9, math.nan):
        figure = drawn(lambda exact, error=error: exact + error)
        assert np.ptp(heights(figure.exact)) > 0.25 * HEIGHT
        assert bool(figure.numerical) == math.isfinite(error)
