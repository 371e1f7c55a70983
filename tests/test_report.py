"""The report: well-formed, complete, escaped, self-contained, deterministic, and rendered only when something changed."""

import base64
import dataclasses
import json
import math
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import netCDF4
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jinja2 import meta

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Balance, Order
from mpmverify.criteria.evidence import Evidence, Level, SeriesId, evidence_by_series
from mpmverify.dataset.files import Results
from mpmverify.dataset.selftest import write_selftest
from mpmverify.dataset.snapshots import Snapshots
from mpmverify.dataset.study import write_study
from mpmverify.dataset.tables import read_tables
from mpmverify.errors import DamagedError, ResultsError
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.judging import judge
from mpmverify.judgement.kill_table import Fate, PlantedFault, Rate, Rates, SelfTest, UnmodifiedRun
from mpmverify.problem import Discretisation, Periodic, Problem, Transport
from mpmverify.reports import cards, charts, render
from mpmverify.reports.catalogue_page import CataloguePage
from mpmverify.reports.changes_page import ChangesPage
from mpmverify.reports.compare_page import ComparePage
from mpmverify.reports.equations import mathml
from mpmverify.reports.handbook_page import HandbookPage
from mpmverify.reports.notation import DASH, cell_size, interval, number, slugs, typeset_numbers
from mpmverify.reports.overview import shares
from mpmverify.reports.pages import IndexPage, StudyPage, TrustPage
from mpmverify.reports.performance_page import PerformancePage
from mpmverify.reports.record import Estimate, Profile
from mpmverify.reports.record import Series as RecordSeries
from mpmverify.reports.site import TEMPLATES, environment
from mpmverify.reports.solver_pages import SolverPage, SolversPage
from mpmverify.reports.still import still
from mpmverify.reports.thumbnails import HEIGHT, MARGIN, Thumbnail, thumbnail
from mpmverify.reports.trust_page import trust_page
from mpmverify.study import Case, Refinement, Series, Study

HOSTILE = "<script>alert('x')</script> \"quoted\" & 'single'"
SIZES = (1 / 16, 1 / 32, 1 / 64, 1 / 128)


@dataclasses.dataclass(frozen=True)
class Scheme:
    """Stand-in for a solver: the report uses only its name, choices and orders."""

    name: str
    text: str = HOSTILE

    @property
    def orders(self) -> dict[str, float]:
        return {"u": 2.0}


def study(name: str = "sample", solvers: tuple[str, ...] = ("good", "bad", "crashed")) -> Study:
    faces = {"x-": Periodic(), "x+": Periodic()}
    problem = Problem("hill", (0.0,), (1.0,), Transport(1.0), faces, end_time=1.0)
    exact = ExactSolution({}, f"Someone (1999) {HOSTILE}, doi:10.1000/some.thing_1")
    hill = VerificationProblem(
        problem, exact, f"Phase errors. {HOSTILE}", (r"u_t + a u_x = 0", rf"\text{{{HOSTILE}}}", r"\frac{")
    )
    ladder = Refinement(f"nu_C=0.5 {HOSTILE}", tuple(Discretisation(h, 0.5) for h in SIZES), quick=4)
    criteria = (Order("u", "L2", 1.8, 2.2, f"theory, {HOSTILE}"), Balance("mass", "inflow", "conservation form"))
    series = tuple(Series(Scheme(solver), ladder, criteria) for solver in solvers)
    return Study(name, f"Sample {HOSTILE}", f"A summary. {HOSTILE}", (Case("hill & dale", hill, series, "u"),))


def level(case: str, solver: str, label: str, h: float) -> Level:
    identity = (case, solver, label, h, 0.5, 1, f"{solver}-{round(1 / h)}")
    if solver == "crashed":
        return Level(*identity, outcome=f"crashed; {HOSTILE}")
    error = (math.nan if h < 1 / 100 else h) if solver == "bad" else h**2
    norms = np.full(4, error), np.ones(4)
    mode = {"phase_angle_u": 2 * h, "relative_frequency_u": 1 - error, "theoretical_frequency_u": 1 - h**2}
    metrics = {"mass_defect": 1e-16} | (mode if solver == "good" else {})
    return Level(*identity, dt=h / 2, steps=9, point_steps=99, seconds=0.1, errors={"u": norms}, metrics=metrics)


def shot(case: str, solver: str, label: str) -> Snapshots:
    time, points = np.linspace(0, 1, 40), np.linspace(0, 1, 300)
    exact = np.sin(2 * np.pi * (points - time[:, None]))
    fields = exact + (1e-9 if solver == "good" else np.where(time[:, None] > 0.5, np.nan, 0.1))
    histories = {"time": time, "mass": 1 + 1e-16 * time, "momentum": time, "impulse": time}
    histories |= {"kinetic_energy": 1 - time, "strain_energy": time, "external_work": 0 * time}
    return Snapshots(case, label, 1 / 64, time, points[:, None], {"u": fields[..., None]}, {"u": exact[..., None]}, histories)


EVIDENCE = Evidence(
    *(np.array([value]) for value in (0.5, 0.25, 0.5, 1)), ("completed",), {"u": np.ones((1, 4))}, {"u": np.ones((1, 4))}
)
NONE = Baseline(Path("none"))


def store(results: Results, declared: Study, known: Baseline = NONE, run: str = "") -> list:
    """Write a study file as a run does, and return the findings."""
    table, shots = [], {}
    for case, series in declared.series():
        where = SeriesId(case.name, series.solver.name, series.refinement.label)
        table += [level(*where, h) for h in SIZES]
        if series.solver.name != "crashed":
            shots[where] = shot(*where)
    evidence = evidence_by_series(table)
    judged = judge(declared.name, declared.criteria(), evidence, known, declared.restricted_to)
    results.create()
    write_study(results.study(declared.name), declared, table, shots, judged, tier="quick", inputs="inputs", run=run)
    return list(judged.findings)


FAULTS = tuple(
    PlantedFault(
        f"mpm/{rule}/{k}",
        "mpm",
        rule,
        f"fault {k} {HOSTILE}",
        "mpm/constitution.py",
        k,
        f"before {k} {HOSTILE}",
        f"after {k}",
        fate,
        reason=f"reason {k} {HOSTILE}",
    )
    for k, (rule, fate) in enumerate((rule, fate) for rule in ("named", "term") for fate in Fate)
)
RATE = Rate(f"kind {HOSTILE}", "inside", 200, 150, 49, 0, 1)
ALARM = UnmodifiedRun(2, 4, 1e-4, 7, "FAIL", 63, f"alarm {HOSTILE}")
SELF_TEST = SelfTest("full", 999, FAULTS, (ALARM,), Rates((RATE,), (RATE, dataclasses.replace(RATE, series=0)), ()))


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, list]:
    results = Results(tmp_path_factory.mktemp("results"))
    table = store(results, study()) + store(results, study("second", ("good",)))
    results.run("good-64").write_bytes(b"")
    write_selftest(results.selftest, SELF_TEST)
    render(results)
    return results, table


@pytest.fixture
def fresh(tmp_path: Path) -> Results:
    results = Results(tmp_path)
    store(results, study(solvers=("good",)))
    return results


class Page(HTMLParser):
    """Checks that tags are balanced, and collects identifiers, links, resources, text and scripts."""

    VOID = frozenset(("meta", "link", "input", "br", "hr", "img"))

    def __init__(self, path: Path) -> None:
        super().__init__(convert_charrefs=True)
        self.path, self.open = path, []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.resources: list[str] = []
        self.labelled: list[str] = []
        self.text: list[str] = []
        self.cells: list[str] = []
        self.data: list[str] = []
        self.scripts = 0
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list) -> None:
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names)), f"<{tag}> repeats an attribute"
        assert not any(name.startswith("on") for name in names)
        table = dict(attrs)
        if "id" in table:
            self.ids.append(table["id"])
        if tag in ("a", "use"):
            self.links.append(table["href"])
        elif tag in ("link", "script", "img"):
            self.resources += [table[name] for name in ("href", "src") if name in table]
        self.labelled += [table[name] for name in ("aria-labelledby",) if name in table]
        if tag == "script":
            self.scripts += 1
        if tag in ("td", "th"):
            self.cells.append("")
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open[-1] == tag, f"</{tag}> closes <{self.open[-1]}> at {self.getpos()}"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "script":
            self.data.append(data)
            return
        self.text.append(data)
        if "td" in self.open or "th" in self.open:
            self.cells[-1] += data


def pages(results: Results) -> dict[str, Page]:
    return {path.relative_to(results.report).as_posix(): Page(path) for path in results.report.rglob("*.html")}


def broken_links(results: Results, known: dict[str, Page], name: str) -> list[str]:
    """Links of a page whose file or anchor does not exist."""
    broken = []
    for link in known[name].links:
        target, _, anchor = link.partition("#")
        path = ((results.report / name).parent / target if target else results.report / name).resolve()
        if link.startswith(
            ("https://doi.org/", "compare.html#a=", "data:application/x-bibtex")
        ):  # these say what the page shows
            continue
        if not path.exists() or (
            anchor and unquote(anchor) not in known[path.relative_to(results.report.resolve()).as_posix()].ids
        ):
            broken.append(link)
    return broken


def strict(text: str) -> dict:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def test_pages_are_well_formed_with_unique_identifiers(stored: tuple[Results, list]) -> None:
    for name, page in pages(stored[0]).items():
        repeated = [identifier for identifier, count in Counter(page.ids).items() if count > 1]
        assert not repeated, name
        assert set(page.labelled) <= set(page.ids), name


def test_every_link_has_a_target_and_every_resource_is_local(stored: tuple[Results, list]) -> None:
    results, _ = stored
    known = pages(results)
    solvers = {"problems.html", "solvers.html", "compare.html", "solver-good.html", "solver-bad.html", "solver-crashed.html"}
    assert {name for name in known if "/" not in name} == {"index.html", "sample.html", "second.html", "trust.html"} | solvers
    for name, page in known.items():
        assert not broken_links(results, known, name)
        assert page.resources
        for resource in page.resources:
            local = (results.report / name).parent / resource
            assert resource == "data:," or local.exists(), f"{name} loads {resource}"
    assert (results.report / "assets" / "plotly.min.js").stat().st_size > 1_000_000


def test_only_existing_run_files_are_linked(stored: tuple[Results, list]) -> None:
    links = pages(stored[0])["sample.html"].links
    assert [link for link in links if "/runs/" in link] == ["../runs/good-64.nc"]


def test_every_verdict_is_shown_with_its_reason_and_source(stored: tuple[Results, list]) -> None:
    results, table = stored
    known = pages(results)
    text = {name: " ".join(page.text) for name, page in known.items()}
    kinds = {finding.verdict.value for finding in table}
    assert kinds >= {"PASS", "ERROR", "INCONCLUSIVE"}
    for finding in table:
        shown = text[f"{finding.study}.html"]
        for part in (
            finding.verdict.value,
            finding.criterion,
            finding.reason,
            finding.source.partition("doi:")[0],
            finding.solver,
        ):
            assert part in shown
        if finding.verdict.value != "PASS":
            assert finding.reason in text["index.html"]
    assert any(HOSTILE in finding.reason for finding in table)


def test_a_failed_run_is_listed_once_for_all_criteria_of_its_series(stored: tuple[Results, list]) -> None:
    results, table = stored
    crashed = [finding for finding in table if finding.solver == "crashed"]
    (reason,) = {finding.reason for finding in crashed}
    by_gate = Counter(finding.gate for finding in crashed)
    assert by_gate["verification"] > 1
    for name in ("index.html", "sample.html"):
        page = pages(results)[name]
        assert page.cells.count(reason) == len(by_gate), name
        criteria = [cell for cell in page.cells if all(f.criterion in cell for f in crashed if f.gate == "verification")]
        assert criteria, name


def test_the_overview_has_a_card_for_each_study_and_says_what_failed_first(stored: tuple[Results, list]) -> None:
    results, table = stored
    text = (results.report / "index.html").read_text(encoding="utf-8")
    assert text.count('<li class="card"') == 2
    words = " ".join(pages(results)["index.html"].text)
    assert "First ERROR: sample, hill & dale" in words
    assert "2 different" not in words, "both studies are of one commit, tier and platform"
    assert f"{len(table)} criteria" in words


def test_the_catalogue_names_the_solvers_of_a_problem_and_the_faults_that_it_caught_first(fresh: Results) -> None:
    store(fresh, study("second", ("good", "bad")))
    render(fresh)
    page = pages(fresh)["problems.html"]
    assert {"sample.html#case-hill-dale", "second.html#case-hill-dale", "solver-good.html", "solver-bad.html"} <= set(
        page.links
    )
    assert "trust.html" not in page.links
    assert 'class="quiet caught' not in page.path.read_text(encoding="utf-8")
    assert " planted" not in " ".join(page.text)
    here = {"study": "sample", "case": "hill & dale", "solver": f"solver {HOSTILE}", "fate": Fate.KILLED}
    caught = [
        dataclasses.replace(FAULTS[0], id=str(k), name=f"fault {k}.", criterion=f"order {k} of {HOSTILE}", **here)
        for k in range(9)
    ]
    ruled = dataclasses.replace(FAULTS[0], id="r", rule="term", name="a term less", **here)
    survived = dataclasses.replace(caught[0], id="s", name="a survivor", fate=Fate.SURVIVED, study="second")
    elsewhere = dataclasses.replace(caught[0], id="e", name="of another study", study="third")
    write_selftest(fresh.selftest, dataclasses.replace(SELF_TEST, faults=(*caught, ruled, survived, elsewhere)))
    render(fresh)
    page = pages(fresh)["problems.html"]
    said = " ".join(" ".join(page.text).split())
    assert "trust.html" in page.links
    assert said.count("First to catch") == 1, "nothing is said of a problem that was not the first to catch any"
    assert "First to catch 10 planted faults: 9 named, 1 by rule" in said
    for fault in caught:
        assert f"{fault.name} {fault.criterion}, {fault.solver}" in said
    assert not any(name in said for name in ("a term less", "a survivor", "of another study"))
    text = page.path.read_text(encoding="utf-8")
    assert '<details class="quiet caught">' in text, "a long list is folded"
    write_selftest(fresh.selftest, dataclasses.replace(SELF_TEST, faults=(caught[0], ruled)))
    render(fresh)
    assert '<details class="quiet caught" open>' in page.path.read_text(encoding="utf-8")
    write_selftest(fresh.selftest, dataclasses.replace(SELF_TEST, faults=(ruled,)))
    render(fresh)
    page = pages(fresh)["problems.html"]
    assert "First to catch 1 planted fault, by rule." in " ".join(" ".join(page.text).split())
    assert 'class="quiet caught' not in page.path.read_text(encoding="utf-8")


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


@pytest.mark.parametrize(
    ("verdicts", "said"),
    [
        ((), "Nothing was judged."),
        ((Verdict.PASS,), "Every criterion holds."),
        ((Verdict.PASS, Verdict.INCONCLUSIVE), "Nothing failed; the evidence does not decide every criterion."),
        ((Verdict.ERROR, Verdict.FAIL), "First FAIL: study, case, solver: criterion: reason."),
    ],
)
def test_the_headline_names_the_first_failure(verdicts: tuple[Verdict, ...], said: str) -> None:
    findings = [Finding("study", "case", "solver", "l", "verification", "criterion", v, "reason", "") for v in verdicts]
    assert cards.headline(findings, shares(findings)) == said
    changed = [dataclasses.replace(finding, gate="regression") for finding in findings]
    compared = sum(verdict in (Verdict.PASS, Verdict.FAIL) for verdict in verdicts)
    shown = cards.changes(changed)
    assert ("errors of 1 series changed" in shown) == (Verdict.FAIL in verdicts)
    assert not verdicts or f"of {compared} that were compared" in shown
    assert ("could not be compared" in shown) == (compared < len(verdicts)), "a run that failed was not compared"


def test_a_known_limit_counts_apart_from_a_plain_pass() -> None:
    plain = Finding("study", "case", "solver", "l", "verification", "criterion", Verdict.PASS, "reason", "")
    counted = shares([plain, plain, dataclasses.replace(plain, limit="known limit")])
    assert [(share.mark.text, share.count) for share in counted] == [("known limit", 1), ("PASS", 2)]
    assert "1 of them are known limits" not in cards.headline([plain], counted)


def test_missing_baseline_series_and_the_restriction_of_the_run_are_shown(tmp_path: Path) -> None:
    whole, known = study(solvers=("good", "also good")), Baseline(tmp_path / "none")
    for solver in whole.solvers():
        known.accept_series("sample", solver, "hill & dale", "ladder", EVIDENCE)
    results = Results(tmp_path)
    *_, lacking = store(results, whole.restricted(("good",)), known)
    render(results)
    assert lacking.reason in (text := " ".join(pages(results)["sample.html"].text))
    assert "restricted to good" in text
    assert "lacking" in pages(results)["sample.html"].ids
    index = pages(results)["index.html"]
    assert index.links.count("sample.html#lacking") == 2, "at the top, and among what did not pass"
    assert index.cells.count("also good") == 1, "among what did not pass: a solver that was not run has no row in the matrix"


def test_a_copied_study_file_with_missing_series_links_to_its_own_page(tmp_path: Path) -> None:
    known = Baseline(tmp_path / "none")
    known.accept_series("sample", "good", "a case that is gone", "ladder", EVIDENCE)
    results = Results(tmp_path)
    store(results, study(solvers=("good",)), known)
    results.study("sample").rename(results.study("copy"))
    render(results)
    assert {name for name in pages(results) if "/" not in name} == {
        "index.html",
        "compare.html",
        "copy.html",
        "problems.html",
        "solvers.html",
        "solver-good.html",
    }
    assert "copy.html#lacking" in pages(results)["index.html"].links
    assert "sample.html#lacking" not in pages(results)["index.html"].links
    cells = [cell for page in pages(results).values() for cell in page.cells if "INCONCLUSIVE" in cell and "/" in cell]
    assert [cell.split()[-1] for cell in cells] == ["1/1"] * 3, "series that were not run are in no cell of a matrix"


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


def test_text_from_a_file_is_escaped(stored: tuple[Results, list]) -> None:
    for path in stored[0].report.glob("*.html"):
        assert "<script>" not in path.read_text(encoding="utf-8"), path.name
    known = pages(stored[0])
    assert known["index.html"].scripts == 1
    assert known["sample.html"].scripts == 2


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


def test_non_finite_numbers_are_shown_as_a_dash(stored: tuple[Results, list]) -> None:
    cells = [cell for page in pages(stored[0]).values() for cell in page.cells]
    assert not [cell for cell in cells if cell.strip().lower().strip("−-[]") in ("nan", "inf", "none")]
    assert DASH in cells


def test_each_template_uses_exactly_the_fields_of_its_page() -> None:
    engine = environment()
    for kind, template in TEMPLATES.items():
        names: set[str] = set()
        for part in (template, "base.html"):
            assert engine.loader is not None
            names |= meta.find_undeclared_variables(engine.parse(engine.loader.get_source(engine, part)[0]))
        assert names == {field.name for field in dataclasses.fields(kind)}, template
    assert set(TEMPLATES) == {
        IndexPage,
        StudyPage,
        TrustPage,
        HandbookPage,
        SolverPage,
        SolversPage,
        ComparePage,
        ChangesPage,
        CataloguePage,
        PerformancePage,
    }


def test_every_planted_fault_and_every_false_alarm_is_shown(stored: tuple[Results, list]) -> None:
    shown = " ".join(pages(stored[0])["trust.html"].text)
    for fault in FAULTS:
        assert all(part in shown for part in (fault.name, fault.before, fault.after, fault.fate.value, fault.reason))
    assert SELF_TEST.false_alarms[0].reason in shown
    assert "6 of 8" in shown
    assert "How far to trust this" in " ".join(pages(stored[0])["index.html"].text)


def test_the_trust_page_shows_what_each_study_saw_of_each_fault() -> None:
    killed = dataclasses.replace(FAULTS[0], fate=Fate.KILLED, killed_by="bar,ring", passed="deck")
    alone = dataclasses.replace(FAULTS[1], fate=Fate.KILLED, killed_by="ring", passed="bar")
    shown = trust_page(dataclasses.replace(SELF_TEST, faults=(killed, alone), every_study=True), "selftest", (), (), "")
    assert [(row.study, row.ran, row.killed, row.alone) for row in shown.studies] == [
        ("bar", "2", "1", "0"),
        ("deck", "1", "0", "0"),
        ("ring", "2", "2", "1"),
    ]
    assert [row.cells for row in shown.kills] == [("passed", "", "killed"), ("killed", "passed", "killed")]
    assert "--every-study" in shown.command
    assert trust_page(dataclasses.replace(SELF_TEST, faults=(killed, alone)), "selftest", (), (), "").kills == ()


def test_an_explained_survivor_is_not_a_failure() -> None:
    survivors = [fault for fault in FAULTS if fault.fate is Fate.SURVIVED]
    explained = tuple(dataclasses.replace(fault, explanation="it is too small") for fault in survivors)
    for faults, kind in ((tuple(survivors), "fail"), (explained, "inconclusive")):
        page = trust_page(dataclasses.replace(SELF_TEST, faults=faults), "selftest", (), (), "generator")
        assert {row.mark.kind for row in page.survivors} == {kind}
        assert all(row.mark.text.startswith("survived") for row in page.survivors)
    assert all(row.reason == "it is too small" for row in page.survivors)


def test_the_trust_page_exists_while_the_self_test_file_does(fresh: Results) -> None:
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    write_selftest(fresh.selftest, SELF_TEST)
    render(fresh)
    assert (fresh.report / "trust.html").exists()
    before = stamps(fresh)
    render(fresh)
    assert stamps(fresh) == before
    fresh.selftest.unlink()
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    assert "trust.html" not in (fresh.report / "index.html").read_text(encoding="utf-8")


def stamps(results: Results) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in results.report.rglob("*") if path.is_file()}


def test_an_unchanged_report_is_not_rewritten_and_a_missing_page_is_rendered_again(fresh: Results) -> None:
    index = render(fresh)
    assert index == fresh.report / "index.html"
    before = stamps(fresh)
    render(fresh)
    assert stamps(fresh) == before
    (fresh.report / "sample.html").unlink()
    render(fresh)
    assert (fresh.report / "sample.html").exists()
    render(fresh, fresh=True)
    after = stamps(fresh)
    for name in ("index.html", "sample.html"):
        assert after[str(fresh.report / name)] > before[str(fresh.report / name)]
    assert after[str(fresh.report / "assets" / "plotly.min.js")] == before[str(fresh.report / "assets" / "plotly.min.js")]


def test_only_a_changed_study_is_rendered_and_the_page_of_a_removed_study_is_deleted(fresh: Results) -> None:
    store(fresh, study("second", ("good",)))
    render(fresh)
    before = stamps(fresh)
    store(fresh, study("second", ("good", "bad")))
    render(fresh)
    after = stamps(fresh)
    changed = {Path(name).name for name in after if after[name] != before.get(name)}
    solvers = {"problems.html", "solvers.html", "compare.html", "solver-good.html", "solver-bad.html"}
    assert changed == {"second.html", "index.html", "manifest.json"} | solvers, "a page of a solver is made of all studies"
    fresh.study("second").unlink()
    render(fresh)
    assert not (fresh.report / "second.html").exists()
    assert not (fresh.report / "solver-bad.html").exists(), "no study that is left has this solver"
    assert (fresh.report / "solver-good.html").exists()
    assert "second.html" not in (fresh.report / "index.html").read_text(encoding="utf-8")


def test_rendering_is_reproducible_byte_for_byte(fresh: Results) -> None:
    def contents() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in fresh.report.rglob("*") if path.is_file()}

    render(fresh, fresh=True)
    first = contents()
    render(fresh, fresh=True)
    assert contents() == first


def test_an_unchanged_report_imports_no_heavy_libraries(fresh: Results) -> None:
    render(fresh)
    program = (
        "import sys; from pathlib import Path; from mpmverify.dataset.files import Results; from mpmverify.reports import render; "
        "render(Results(Path(sys.argv[1]))); "
        "assert not {'xarray', 'jinja2', 'scipy', 'plotly', 'latex2mathml', 'markdown_it', 'pygments'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program, fresh.path], check=True)


@pytest.mark.parametrize("kind", ["text", "netcdf"])
def test_a_foreign_file_is_named_in_the_error_and_nothing_is_written(fresh: Results, kind: str) -> None:
    path = fresh.study("alien")
    if kind == "text":
        path.write_text("not netCDF")
    else:
        netCDF4.Dataset(path, "w").close()
    with pytest.raises(ResultsError, match="alien"):
        render(fresh)
    assert not fresh.report.exists()


@pytest.mark.parametrize(
    "text", ["{", "[]", "3", '{"verdict": "PASS"}', '{"verdict": "MAYBE"}', '{"verdict": "PASS", "who": "me"}']
)
def test_a_damaged_finding_on_missing_series_is_named_in_the_error(fresh: Results, text: str) -> None:
    with netCDF4.Dataset(fresh.study("sample"), "a") as file:
        file.setncattr("lacking", text)
    with pytest.raises(ResultsError, match=r"sample\.nc' is damaged"):
        render(fresh)
    with pytest.raises(ResultsError, match=r"sample\.nc' is damaged"):
        read_tables([fresh.study("sample")])


def test_a_foreign_page_is_not_overwritten(fresh: Results) -> None:
    page = fresh.report / "sample.html"
    page.parent.mkdir()
    page.write_text("my notes")
    with pytest.raises(ResultsError, match=r"sample\.html"):
        render(fresh)
    assert page.read_text() == "my notes"


def test_a_damaged_manifest_is_replaced(fresh: Results) -> None:
    render(fresh)
    manifest = fresh.report / "manifest.json"
    manifest.write_text('{"code": []')
    render(fresh)
    assert json.loads(manifest.read_text())["studies"].keys() == {"sample"}


CUTS = {"cut off": -100, "cut off early": 40, "empty": 0}


@pytest.mark.parametrize("name", ["sample.html", "index.html"])
@pytest.mark.parametrize("cut", CUTS.values(), ids=CUTS)
@pytest.mark.parametrize("manifest", [True, False], ids=["known", "forgotten"])
def test_a_damaged_page_is_set_aside_named_and_rendered_again(
    fresh: Results, caplog: pytest.LogCaptureFixture, name: str, cut: int, manifest: bool
) -> None:
    page = render(fresh).with_name(name)
    sound = page.read_bytes()
    page.write_bytes(sound[:cut])
    if not manifest:
        (fresh.report / "manifest.json").unlink()
    render(fresh)
    assert page.read_bytes() == sound
    assert page.with_name(f"{name}.damaged").read_bytes() == sound[:cut]
    assert caplog.messages == [f"'{page}' is damaged: it is set aside as '{name}.damaged'."]


def test_a_damaged_asset_is_written_again(fresh: Results) -> None:
    asset = render(fresh).parent / "assets" / "plotly.min.js"
    sound = asset.read_bytes()
    asset.write_bytes(sound[:1000])
    render(fresh)
    assert asset.read_bytes() == sound


def test_a_self_test_that_lacks_what_the_pages_show_is_set_aside(fresh: Results) -> None:
    write_selftest(fresh.selftest, SELF_TEST)
    with netCDF4.Dataset(fresh.selftest, "a") as file:
        file.delncattr("every_study")
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    assert fresh.selftest.with_name("selftest.nc.damaged").exists()


def test_a_damaged_self_test_is_set_aside_and_its_page_removed(fresh: Results) -> None:
    write_selftest(fresh.selftest, SELF_TEST)
    render(fresh)
    fresh.selftest.write_bytes(fresh.selftest.read_bytes()[:5000])
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    assert fresh.selftest.with_name("selftest.nc.damaged").stat().st_size == 5000


def test_a_damaged_study_is_named_and_not_changed(fresh: Results) -> None:
    path = fresh.study("sample")
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(DamagedError, match=re.escape(f"'{path}' is damaged: run `mpmverify run` again")):
        render(fresh)
    assert path.stat().st_size == 5000


@given(st.floats(min_value=1e-30, max_value=1e30), st.booleans())
def test_numbers_read_back_to_three_digits(size: float, negative: bool) -> None:
    value = -size if negative else size
    text = number(value)
    assert "-" not in text
    back = text.replace("−", "-").translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")).replace("×10", "e")
    assert float(back) == pytest.approx(value, rel=0.006)


def test_numbers_in_a_text_are_typeset() -> None:
    assert typeset_numbers("E = 1e+07 Pa, a = -2.5e-06 m/s on [-1, 2] m") == "E = 1×10⁷ Pa, a = −2.5×10⁻⁶ m/s on [−1, 2] m"
    assert typeset_numbers("neo-Hookean, mass-1e5, 3e, x1e5") == "neo-Hookean, mass-1e5, 3e, x1e5"


def test_notation() -> None:
    assert number(0.0) == "0"
    assert number(math.nan) == number(math.inf) == interval(1.0, math.inf) == DASH
    assert number(-1.234e-5) == "−1.23×10⁻⁵"
    assert number(0.012345) == "0.0123"
    assert [cell_size(h) for h in (1 / 64, 0.09765625, 1.0, 2.5)] == ["1/64", "0.09766", "1", "2.5"]
    assert interval(-0.5, 1.0) == "[−0.50, 1.00]"
    assert slugs(["a b", "a-b", "?"]) == {"a b": "a-b", "a-b": "a-b-2", "?": "x"}


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


@pytest.mark.parametrize("latex", [r"\frac{", r"\text{<script>1</script>}", r"\text{<a href='x'>y</a>}", ""])
def test_invalid_formulas_are_shown_as_code(latex: str) -> None:
    assert mathml(latex).startswith("<code>")
    assert "<script>" not in mathml(latex)


def test_formulas_become_mathml() -> None:
    assert mathml(r"\frac{a}{b}").startswith("<math")
