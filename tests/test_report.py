"""The report: well-formed, complete, escaped and self-contained."""

import dataclasses
from collections import Counter
from pathlib import Path

import pytest
from jinja2 import meta
from report_pages import broken_links, pages
from sample_study import EVIDENCE, FAULTS, HOSTILE, SELF_TEST, one_solver, rendered, store, study

from mpmverify.convergence.verdict import Verdict
from mpmverify.dataset.files import Results
from mpmverify.dataset.selftest import write_selftest
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.kill_table import Fate
from mpmverify.reports import cards, render
from mpmverify.reports.catalogue_page import CataloguePage
from mpmverify.reports.changes_page import ChangesPage
from mpmverify.reports.compare_page import ComparePage
from mpmverify.reports.handbook_page import HandbookPage
from mpmverify.reports.notation import DASH
from mpmverify.reports.overview import shares
from mpmverify.reports.pages import IndexPage, StudyPage, TrustPage
from mpmverify.reports.performance_page import PerformancePage
from mpmverify.reports.site import TEMPLATES, environment
from mpmverify.reports.solver_pages import SolverPage, SolversPage


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, list]:
    return rendered(tmp_path_factory.mktemp("results"))


@pytest.fixture
def fresh(tmp_path: Path) -> Results:
    return one_solver(tmp_path)


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


def test_text_from_a_file_is_escaped(stored: tuple[Results, list]) -> None:
    for path in stored[0].report.glob("*.html"):
        assert "<script>" not in path.read_text(encoding="utf-8"), path.name
    known = pages(stored[0])
    assert known["index.html"].scripts == 1
    assert known["sample.html"].scripts == 2


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
