"""The report on designs and on ladders in dt: sources of error, dominance maps, tables and charts."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from report_pages import Page
from sample_study import Scheme, study
from stored_results import tree_of

from mpmverify.convergence.sources import Separation, Source
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Order, Separated
from mpmverify.criteria.evidence import Level, evidence_by_series
from mpmverify.dataset.files import Results
from mpmverify.dataset.sources import NAMES, source_table
from mpmverify.dataset.study import read_study, read_study_groups, stored_findings, write_study
from mpmverify.execution.gate import judged
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.judging import judge
from mpmverify.reports import render
from mpmverify.reports.dominance import planes
from mpmverify.reports.reader import read
from mpmverify.reports.record import Record
from mpmverify.study import Case, Refinement, Series, Study, design, in_time

BOTH = Separated("u", "L2", (("h", 1.8, 2.2), ("dt", 0.8, 1.2)), "theory")
LADDERS: dict[str, Refinement] = {
    "design": design(1.0, cells=(8, 16, 32), courant=(0.5, 0.25, 0.125)),
    "in time": in_time(1.0, 8, quick=6, full=6, courant=0.5),
    "joint": design(1.0, cells=(8, 16, 32), courant=(0.5,)),
}


def error(h: float, dt: float) -> float:
    """Return the error h^2 + dt/20 of every run."""
    return h**2 + dt / 20


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Record]:
    results = Results(tmp_path_factory.mktemp("results"))
    hill = study().cases[0]
    series = (
        Series(Scheme("good"), LADDERS["design"], (BOTH,)),
        Series(
            Scheme("good"),
            LADDERS["in time"],
            (Order("u", "L2", 0.9, 1.1, "theory"), Separated("u", "L2", (("dt", 0.9, 1.1),), "t")),
        ),
        Series(Scheme("good"), LADDERS["joint"], ()),
    )
    declared = Study("sources", "Sources", "", (Case("hill", hill.problem, series, "u"),))
    table = []
    for _, entry in declared.series():
        for at in entry.refinement.levels:
            dt, norms = at.courant * at.h, np.full(4, error(at.h, at.courant * at.h))
            where = ("hill", "good", entry.refinement.label, at.h, at.courant, at.ppc, f"{at.h}-{at.courant}")
            table.append(Level(*where, dt=dt, errors={"u": (norms, np.ones(4))}))
    results.create()
    evidence = evidence_by_series(table)
    found = judge("sources", declared.criteria(), evidence, Baseline(Path("none")))
    write_study(results.study("sources"), declared, table, {}, found, tier="quick", inputs="", run="")
    render(results)
    return results, read(results.study("sources"))


def test_sources_are_stored_and_judging_the_file_again_gives_the_same_findings(stored: tuple[Results, Record]) -> None:
    path = stored[0].study("sources")
    dataset = tree_of(path)["good"].to_dataset(inherit=False)
    assert dataset["source"].values.tolist() == list(NAMES)
    assert dataset["source_exponent"].dims == ("separation", "source")
    found = dataset["source_exponent"].isel(separation=0).sel(source=["h", "dt"]).values
    np.testing.assert_allclose(found, [2, 1], atol=1e-4)
    np.testing.assert_allclose(dataset["source_cosine"].isel(separation=0).sel(source="h", beside="dt"), 1, atol=1e-3)
    again, groups = judged(read_study(path), Baseline(Path("none"))), read_study_groups(path)
    assert again.findings == stored_findings(groups)
    kept = groups["/good"].columns
    for name, values in source_table("good", again).columns.items():
        np.testing.assert_array_equal(values, kept[name])
    verdicts = {(f.refinement, f.criterion): f.verdict for f in stored_findings(groups) if f.gate == "verification"}
    assert verdicts[LADDERS["design"].label, BOTH.title] is Verdict.PASS


def test_series_are_read_with_their_refined_size(stored: tuple[Results, Record]) -> None:
    by_label = {entry.refinement: entry for entry in stored[1].series}
    (designed, timed, joint) = (by_label[refinement.label] for refinement in LADDERS.values())
    assert (designed.axis, timed.axis, joint.axis) == ("", "dt", "h")
    assert designed.sizes == ()
    assert timed.sizes == tuple(level.dt for level in timed.levels)
    assert list(timed.sizes) == sorted(timed.sizes, reverse=True)
    np.testing.assert_allclose(timed.estimates["u", "L2"].error, [error(1 / 8, dt) for dt in timed.sizes])
    assert not math.isfinite(designed.estimates["u", "L2"].order)
    (separation,) = designed.separations.values()
    assert [round(source.exponent, 3) for source in separation.sources] == [2, 1]


def test_the_map_holds_the_ratio_of_the_two_sources(stored: tuple[Results, Record]) -> None:
    designed = next(entry for entry in stored[1].series if not entry.axis)
    (plane,) = planes(designed.levels, designed.separations["u", "L2"])
    assert (plane.x, plane.y, plane.first, plane.second) == ("h", "dt", "h", "dt")
    h, dt = np.meshgrid(plane.x_values, plane.y_values)
    np.testing.assert_allclose(plane.ratio, np.log10(dt / 20 / h**2), atol=1e-3)
    levels = designed.levels
    for axis, values in ((plane.x_values, [level.h for level in levels]), (plane.y_values, [level.dt for level in levels])):
        assert axis[0] < min(values) < max(values) < axis[-1], "every run lies on the map"


def test_a_plane_needs_two_seen_sources_and_an_accepted_fit() -> None:
    from mpmverify.reports.record import Level as Run

    levels = [Run(h, 0.1, 0.1, ppc, 1, 1, 0.0, "completed", "") for h in (0.1, 0.2, 0.4) for ppc in (1, 2, 3)]
    h, spacing = Source("h", 2.0, 2.0, 1.9, 2.1, 0.9), Source("h/ppc", 0.5, 2.0, 1.9, 2.1, 0.4)
    (plane,) = planes(levels, Separation((h, spacing)))
    assert (plane.x, plane.y, plane.second) == ("h", "ppc", "h/ppc")
    np.testing.assert_allclose(plane.ratio, np.tile(np.log10(0.25 / plane.y_values**2)[:, None], (1, len(plane.x_values))))
    assert list(planes(levels, Separation((h, Source("h/ppc"))))) == []
    assert list(planes(levels, Separation((h, spacing), obstacle="off"))) == []
    assert list(planes(levels, Separation(obstacle="too few"))) == []


def test_the_page_names_sizes_and_sources(stored: tuple[Results, Record]) -> None:
    page = Page(stored[0].report / "sources.html")
    text = " ".join(page.text)
    for expected in ("Sources of error", "dt = 1/16", "h = 1/8", "residual", "where they are equal"):
        assert expected in text
    figures = next(json.loads(data) for data in page.data if "dominance" in data)
    (chart,) = figures["dominance"]
    assert [trace["type"] for trace in chart["data"]] == ["heatmap", "contour", "scatter"]
    assert chart["layout"]["xaxis"]["title"]["text"] == "h [m]"
    assert chart["layout"]["yaxis"]["title"]["text"] == "dt [s]"
    shape = figures["convergence"]["layout"]
    assert {shape[name]["title"]["text"] for name in ("xaxis", "xaxis2")} == {"h [m]", "dt [s]"}
    assert shape["xaxis"]["domain"][1] < shape["xaxis2"]["domain"][0]
    drawn = {trace["meta"]["series"]: trace["xaxis"] for trace in figures["convergence"]["data"] if "series" in trace["meta"]}
    by_axis = {shape[name.replace("x", "xaxis")]["title"]["text"]: k for k, name in drawn.items()}
    axes = [entry.axis for entry in stored[1].series]
    assert {title: axes[k] for title, k in by_axis.items()} == {"h [m]": "h", "dt [s]": "dt"}
