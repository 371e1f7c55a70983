"""Pages of solvers and runs that failed: every link resolves, names stay text, and no known limit counts as a plain success."""

import dataclasses
import math
import re
import shlex
from pathlib import Path
from xml.etree import ElementTree

import pytest
from faulty_solvers import Scripted, ladder, plan
from faulty_solvers import study as scripted
from hypothesis import given
from hypothesis import strategies as st
from markupsafe import escape
from report_pages import Page, broken_links, pages, stamps
from sample_study import HOSTILE, store, study

from mpmverify.cli.solving import run as run_command
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Balance, Order, Stall, Unstable
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError
from mpmverify.execution.runner import run
from mpmverify.reports import render
from mpmverify.reports.cost import costs, reference
from mpmverify.reports.dossiers import dossiers
from mpmverify.reports.failures import command, failures
from mpmverify.reports.overview import verdict_anchors
from mpmverify.reports.reader import read
from mpmverify.reports.record import Record
from mpmverify.reports.site import render as html
from mpmverify.reports.solver_names import choices, family, file_of, plain_scheme, subject
from mpmverify.reports.solver_page import sentence, solver_pages
from mpmverify.reports.strips import MARGIN, WIDTH, across, rug, ruler, strip
from mpmverify.study import Study

ORDERS = st.one_of(st.floats(-1e3, 1e3), st.sampled_from([math.nan, math.inf, -math.inf]))


# Strips.


def test_a_strip_puts_order_two_in_the_middle_of_an_axis_from_zero_to_four() -> None:
    picture = strip(2.0, (1.9, 2.1), (1.8, 2.2), 2.0)
    assert re.search(rf'<circle class="inside" cx="{WIDTH / 2:.1f}"', picture)
    (left, width) = map(float, re.search(r'<rect class="band" x="(\S+)" y="2" width="(\S+)"', picture).groups())
    assert (left, left + width) == pytest.approx((across(1.8), across(2.2)), abs=0.11)
    (low, high) = map(float, re.search(r'<path class="interval" d="M(\S+) 11H([\d.]+)', picture).groups())
    assert (low, high) == pytest.approx((across(1.9), across(2.1)), abs=0.06)
    assert (across(0.0), across(4.0)) == (MARGIN, WIDTH - MARGIN)
    assert 'aria-label="order 2.00, 95 % interval [1.90, 2.10], accepted 1.8 to 2.2, formal 2"' in picture


@pytest.mark.parametrize(
    ("measured", "interval", "band", "marker"),
    [
        (2.0, (1.9, 2.1), (1.8, 2.2), "inside"),
        (2.0, (1.7, 2.1), (1.8, 2.2), "open"),
        (2.0, (1.9, 2.1), None, "open"),
        (1.0, (0.9, 1.1), (1.8, 2.2), "outside"),
        (5.0, (4.9, 5.1), (1.8, 2.2), "beyond"),
        (-1.0, (-1.1, -0.9), None, "beyond"),
    ],
)
def test_the_marker_of_a_strip_tells_by_its_shape_how_an_order_meets_its_band(
    measured: float, interval: tuple[float, float], band: tuple[float, float] | None, marker: str
) -> None:
    found = re.findall(r'class="(inside|open|outside|beyond)"', strip(measured, interval, band))
    assert found == [marker]


@given(ORDERS, ORDERS, ORDERS, ORDERS, ORDERS)
def test_every_strip_is_well_formed_and_stays_in_its_frame(a: float, b: float, c: float, d: float, e: float) -> None:
    for picture in (strip(a, (b, c), (min(d, 1), max(d, 1)) if math.isfinite(d) else None, e), rug([a, b, c], [d, e]), ruler()):
        ElementTree.fromstring(picture)
        drawn = re.sub(r'aria-label="[^"]*"', "", picture)
        assert "nan" not in drawn
        assert "inf" not in drawn
        places = [float(x) for x in re.findall(r'(?:[MH]|c?x=")(-?[\d.]+)', drawn)]
        assert all(0 <= x <= WIDTH for x in places)


def test_an_order_that_is_not_known_has_no_marker() -> None:
    picture = strip(math.nan, (math.nan, math.nan), (1.8, 2.2))
    assert not re.search(r'class="(inside|open|outside|beyond|interval)"', picture)
    assert "no order" in picture
    assert rug([]) == rug([math.nan])


# Names.

HARMFUL = HOSTILE.replace("/", "")
NAMES = (f"x{HARMFUL}", "long-" * 50, "Good", "good", "a b", "a-b", "schön", "a...b", "index", "solver-good", "trust")
"""Names that a netCDF group can have."""
OTHERS = (HARMFUL, "long-" * 60, "?", "../../up", "\u202e", "con")
"""Names that it cannot have."""


def resolves(results: Results) -> None:
    """Check that every link of every page leads to an existing page and anchor."""
    known = pages(results)
    for name, page in known.items():
        assert not broken_links(results, known, name), name
        repeated = [one for one in page.ids if page.ids.count(one) > 1]
        assert not repeated, name


def test_a_hostile_name_is_shown_as_text_and_its_page_stays_in_the_folder(tmp_path: Path) -> None:
    results = Results(tmp_path)
    store(results, study(solvers=NAMES))
    render(results)
    files = {file_of(name) for name in NAMES}
    assert len(files) == len({file.lower() for file in files}) == len(NAMES)
    for name in NAMES:
        path = results.report / file_of(name)
        assert path.parent == results.report
        assert len(path.name.encode()) < 120
        page = Page(path)
        assert name in "".join(page.text)
        assert page.scripts == 1
        assert "<script>" not in path.read_text(encoding="utf-8")
        assert "sample.html" in {link.partition("#")[0] for link in page.links}
        for other in ("index.html", "sample.html", "solvers.html"):
            assert path.name in Page(results.report / other).links, f"{other} does not link to {name!r}"
    assert Page(results.report / "index.html").path.exists()
    resolves(results)


def test_a_name_that_no_file_can_have_has_a_page_all_the_same(limited: tuple[Results, Record]) -> None:
    record = limited[1]
    (series, *_) = record.series
    for name in OTHERS:
        finding = tuple(dataclasses.replace(one, solver=name) for one in series.findings)
        renamed = dataclasses.replace(series, solver=name, findings=finding)
        made = solver_pages([dataclasses.replace(record, schemes={name: HOSTILE}, series=(renamed,))], frozenset(), "generator")
        (file, page), _ = made.items()
        assert re.fullmatch(r"solver-[a-z0-9-]{1,95}", file)
        assert "<script>" not in html(page)
        assert escape(name) in html(page)


@given(st.text(min_size=1), st.text(min_size=1))
def test_two_names_never_share_a_file(one: str, other: str) -> None:
    assert re.fullmatch(r"solver-[a-z0-9-]{1,90}\.html", file_of(one))
    assert (file_of(one) == file_of(other)) == (one == other)


@pytest.mark.parametrize("name", ["solvers", "solver-good"])
def test_a_study_with_the_name_of_a_page_of_solvers_is_refused(tmp_path: Path, name: str) -> None:
    results = Results(tmp_path)
    store(results, study(name, ("good",)))
    with pytest.raises(ResultsError, match="rename the study"):
        render(results)


def test_a_foreign_page_of_a_solver_is_not_overwritten(tmp_path: Path) -> None:
    results = Results(tmp_path)
    store(results, study(solvers=("good",)))
    page = results.report / "solver-good.html"
    page.parent.mkdir()
    page.write_text("my notes")
    with pytest.raises(ResultsError, match=r"solver-good\.html"):
        render(results)
    assert page.read_text() == "my notes"
    page.unlink()
    render(results)
    mine = page.with_name("solver-mine.html")
    mine.write_text("my notes")
    store(results, study(solvers=("bad",)))
    render(results)
    assert (page.exists(), mine.exists()) == (False, True)


def test_a_missing_page_of_a_solver_is_written_again_and_an_unchanged_one_is_not(tmp_path: Path) -> None:
    results = Results(tmp_path)
    store(results, study(solvers=("good",)))
    render(results)
    before = stamps(results)
    render(results)
    assert stamps(results) == before
    (results.report / "solver-good.html").unlink()
    render(results)
    assert (results.report / "solver-good.html").exists()


def test_the_choices_of_a_scheme_are_read_from_its_text_and_other_texts_are_shown_as_they_are() -> None:
    scheme = "MaterialPoint(schedule='USL', transfer=Transfer(name='flip', flip=1.0, affine=None), record_every=1)"
    assert [(fact.name, fact.value) for fact in choices(scheme)] == [
        ("schedule", "USL"),
        ("transfer", "flip (flip 1.0, affine none)"),
        ("record every", "1"),
    ]
    for text in (HOSTILE, "", "<object at 0x7f>", "Mine(3)", "Mine()", "(" * 10000):
        assert [fact.value for fact in choices(text)] == [text]
    measured = f"Bisection(solver={scheme}, resolution=0.001)"
    assert plain_scheme(measured) == plain_scheme(scheme)
    assert family([plain_scheme(measured)]) == family([scheme]) == "Material point methods"
    assert family(["Mine(x=1)"]) == family([]) == "Your own solvers"
    assert subject("limit-mpm", measured) == "mpm"
    assert subject("limit-mpm", "Mine(x=1)") == "limit-mpm"


# Known limits.


@pytest.fixture(scope="module")
def limited(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Record]:
    """A solver that keeps an order, stalls as is known of it and conserves the mass; one that fails it; and one that is unstable."""
    results = Results(tmp_path_factory.mktemp("limited"))
    declared = study(solvers=("good", "good too", "bad", "crashed"))
    case = declared.cases[0]
    known = (
        Stall("u", "L1", 3.0, 0.0, 1.0, "as is known"),
        Order("u", "L2", 1.9, 2.1, "theory"),
        Order("u", "Linf", 2.9, 3.1, "theory"),
        Balance("mass", "inflow", "conservation form"),
    )
    by_solver = {"good": known, "good too": (known[1],), "bad": known[1:], "crashed": (Unstable(0.1, "theory"),)}
    series = tuple(dataclasses.replace(one, criteria=by_solver[one.solver.name]) for one in case.series)
    store(results, dataclasses.replace(declared, cases=(dataclasses.replace(case, series=series),)))
    render(results)
    return results, read(results.study("sample"))


def test_known_limits_are_listed_as_such_and_not_counted_as_plain_passes(limited: tuple[Results, Record]) -> None:
    results, record = limited
    (good,) = (one for one in dossiers([record]) if one.solver == "good")
    text = (results.report / "solver-good.html").read_text(encoding="utf-8")
    plain = sum(finding.verdict is Verdict.PASS and not finding.limit for finding in good.findings)
    limits = sum(finding.word == "PASS (known limit)" for finding in good.findings)
    assert (plain, limits) == (2, 1)
    assert f'<li class="pass" style="flex-grow: {plain}"><span class="count">{plain}</span> PASS</li>' in text
    assert f'<li class="limit" style="flex-grow: {limits}"><span class="count">{limits}</span> known limit</li>' in text
    section = text[text.index('<h2 id="limits">') : text.index('<h2 id="studies">')]
    assert section.count("<tr>") == 1 + limits
    assert "stalls or diverges" in section
    overview = Page(results.report / "solvers.html")
    cells = [cell.strip() for cell in overview.cells]
    row = cells[cells.index("good") :]
    assert row[2:4] == [str(plain), str(limits)]


def test_the_sentence_of_a_solver_counts_known_limits_by_themselves(limited: tuple[Results, Record]) -> None:
    known = {one.solver: one for one in dossiers([limited[1]])}
    good = known["good"]
    assert sentence(good).startswith(
        "2 of 5 criteria in the study sample did not pass; the worst is FAIL in sample, hill & dale"
    )
    entries = tuple(
        dataclasses.replace(
            entry,
            series=dataclasses.replace(
                entry.series, findings=tuple(f for f in entry.series.findings if f.verdict is Verdict.PASS)
            ),
        )
        for entry in good.entries
    )
    held = sentence(dataclasses.replace(good, entries=entries))
    assert held == ("All 3 criteria in the study sample hold: 2 passed, and 1 passed on a known limit of the scheme.")
    assert sentence(dataclasses.replace(good, entries=())) == "Nothing was judged."


def test_the_scorecard_has_a_row_for_every_judged_order_with_its_numbers_as_text(limited: tuple[Results, Record]) -> None:
    text = (results := limited[0]).report.joinpath("solver-good.html").read_text(encoding="utf-8")
    table = text[text.index('<table class="scorecard">') : text.index("</table>", text.index('<table class="scorecard">'))]
    rows = table.split("<tr>")[2:]
    assert len(rows) == 3
    for row, (accepted, marker, verdict) in zip(
        rows,
        (("below 3", "inside", "PASS (known limit)"), ("1.9 to 2.1", "inside", "PASS"), ("2.9 to 3.1", "outside", "FAIL")),
        strict=True,
    ):
        assert f">{accepted}<" in row
        assert f'class="{marker}"' in row
        assert f"</svg>{verdict}</span>" in row
        assert ">2.00<" in row
        assert 'aria-label="order 2.00' in row
    resolves(results)


def test_conservation_shows_what_was_measured_and_its_bound(limited: tuple[Results, Record]) -> None:
    cells = Page(limited[0].report / "solver-good.html").cells
    row = cells[cells.index("mass") :]
    assert row[1] == "mass less inflow conserved to 1×10⁻¹²"
    assert "PASS" in row[2]
    assert "1 of 1 series" in row[2]
    assert row[3:6] == ["1.00×10⁻¹⁶", "1.00×10⁻¹²", "sample, hill & dale"]


def test_cost_per_accuracy_is_drawn_with_the_numbers_beside_it(limited: tuple[Results, Record]) -> None:
    results, record = limited
    text = (results.report / "solver-good.html").read_text(encoding="utf-8")
    assert text.count('<svg class="cost-chart"') == 2
    assert "An error of 6.1×10⁻⁵ takes 1.0 times the time and 1.0 times the point-steps of good too." in text
    assert '<svg class="cost-chart"' not in (results.report / "solver-crashed.html").read_text(encoding="utf-8")
    by_solver = {series.solver: series for series in record.series}
    beside = reference(record, by_solver["good"], ("u", "L2"))
    assert beside is by_solver["good too"]
    shipped = dataclasses.replace(record, schemes=record.schemes | {"bad": "TaylorGalerkin(passes=1)"})
    assert reference(shipped, by_solver["good"], ("u", "L2")) is by_solver["bad"], "a shipped one stands beside a stranger's"


def test_a_cost_that_was_not_recorded_is_named_instead_of_drawn(limited: tuple[Results, Record]) -> None:
    record = limited[1]
    untimed = tuple(
        dataclasses.replace(one, levels=tuple(dataclasses.replace(level, seconds=0.0) for level in one.levels))
        for one in record.series
    )
    (good,) = (one for one in dossiers([dataclasses.replace(record, series=untimed)]) if one.solver == "good")
    (case,) = costs(good)
    assert len(case.charts) == 1
    assert case.comparison == (
        "An error of 6.1×10⁻⁵ takes 1.0 times the point-steps of good too. The solver returned no wall time."
    )


# Runs that failed.

FAILING = ("raises", "nan", "unstable", "good", "returns-nothing", "hangs")


def test_the_verdicts_on_a_solver_come_with_the_command_that_measures_them_again(limited: tuple[Results, Record]) -> None:
    text = (limited[0].report / "sample.html").read_text(encoding="utf-8")
    for solver in ("good", "'good too'", "bad", "crashed"):
        shown = f"mpmverify run sample --solver {solver} --out rerun".replace("'", "&#39;")
        assert f'<p class="again">Run it again: <code>{shown}</code></p>' in text


@pytest.fixture(scope="module")
def failing(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, Study]:
    """Solvers that raise, return NaN, diverge and hang on the finest level, beside one that is right."""
    path = tmp_path_factory.mktemp("failing")
    declared = scripted(*(Scripted(behaviour, below=0.04) for behaviour in FAILING if behaviour != "hangs"))
    list(run([declared], plan(path)))
    render(Results(path))
    return Results(path), declared


def test_every_failed_run_says_what_happened_when_and_what_to_do(failing: tuple[Results, Study]) -> None:
    results, _ = failing
    page, text = Page(results.report / "scripted.html"), (results.report / "scripted.html").read_text(encoding="utf-8")
    shown = " ".join(" ".join(page.text).split())
    section = text[text.index('<h2 id="failed">') : text.index('<h2 id="solvers">')]
    assert "<details" not in section
    assert [one for one in page.ids if one.startswith("failed-")] == ["failed-1", "failed-2", "failed-3", "failed-4"]
    for said in (
        "ZeroDivisionError: a mass of [/zero] at node 3",
        "run `mpmverify check` on the solver to see its lines",
        "u is not finite from t = 0.25 s on",
        "the solution grew without bound: lower the Courant number",
        "it returned NoneType instead of a Solution",
        "1 of 3 runs failed",
        "mpmverify run scripted --solver scripted-raises --out rerun",
    ):
        assert said in shown
    cells = [cell.strip() for cell in page.cells]
    place = cells.index("unstable")
    assert cells[place + 1 : place + 6] == ["1/32", "0.5", "1", "3", "0.0469"]
    place = cells.index("non-finite")
    assert cells[place + 4 : place + 6] == ["–", "0.25"]
    assert section.count(">netCDF</a>") == 2, "what crashed left no file"
    assert "scripted-good" not in section


def test_an_error_links_to_the_run_that_caused_it(failing: tuple[Results, Study]) -> None:
    results, _ = failing
    text = (results.report / "scripted.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<a class="bare" href="#failed-\d">\s*<span class="verdict error small">', text)) >= 4
    for name in FAILING[:3]:
        page = (results.report / f"solver-scripted-{name}.html").read_text(encoding="utf-8")
        assert '<h2 id="failed">Runs that failed</h2>' in page
        assert re.search(r'<a class="bare" href="#failed-1">\s*<span class="verdict error small">', page)
    good = (results.report / "solver-scripted-good.html").read_text(encoding="utf-8")
    assert "Runs that failed" not in good
    resolves(results)


def test_a_run_that_hangs_is_named_with_its_time_limit(tmp_path: Path) -> None:
    list(run([scripted(Scripted("hangs", below=0.04))], dataclasses.replace(plan(tmp_path), jobs=1, timeout=2.0)))
    render(Results(tmp_path))
    shown = " ".join(Page(tmp_path / "report" / "scripted.html").text)
    assert "timed out" in shown
    assert "no result within 2 s" in shown
    assert "raise the limit or coarsen the level" in shown


def test_an_instability_that_is_expected_is_no_failed_run(limited: tuple[Results, Record], tmp_path: Path) -> None:
    declared = scripted(Scripted("unstable"), criteria=(Unstable(0.1, "theory"),))
    list(run([declared], plan(tmp_path)))
    render(Results(tmp_path))
    assert "Runs that failed" not in (tmp_path / "report" / "scripted.html").read_text(encoding="utf-8")
    page = (tmp_path / "report" / "solver-scripted-unstable.html").read_text(encoding="utf-8")
    assert "Runs that failed" not in page
    assert "unstable above 0.1" in page
    crashed = (limited[0].report / "solver-crashed.html").read_text(encoding="utf-8")
    assert "Runs that failed" in crashed, "a crash is not the instability that is expected"


def test_what_a_program_printed_is_shown_by_itself(tmp_path: Path) -> None:
    results, printed = Results(tmp_path), f"out of ideas; its files are in doubt {HOSTILE}"
    store(results, study(solvers=("good",)))
    record = read(results.study("sample"))
    (series,) = record.series
    outcome = (
        f"crashed; the program ended with exit status 3 and printed: {printed}; its files are in kept; run it in that folder"
    )
    ended = dataclasses.replace(series.levels[0], outcome=outcome, steps=0)
    broken = dataclasses.replace(record, series=(dataclasses.replace(series, levels=(ended, *series.levels[1:])),))
    ((failure),) = failures(broken, verdict_anchors(broken), frozenset()).values()
    (ran,) = failure.runs
    assert (ran.status, ran.printed) == ("crashed", printed)
    assert ran.happened == "the program ended with exit status 3; its files are in kept"
    assert (ran.step, ran.time) == ("–", "–")
    assert failure.advice == ("run it in that folder",)


@pytest.mark.parametrize(
    ("attributes", "schemes", "expected"),
    [
        ({"id": "advection", "tier": "quick"}, ("tg",), "mpmverify run advection --solver tg --out rerun"),
        ({"id": "advection", "tier": "full"}, ("tg",), "mpmverify run advection --solver tg --tier full --out rerun"),
        (
            {"id": "advection", "tier": "quick", "restricted_to": "tg; Courant number 0.25"},
            ("tg",),
            "mpmverify run advection --solver tg --courant 0.25 --out rerun",
        ),
        ({"id": "bar-with-tg", "tier": "quick"}, ("tg", "fem"), "mpmverify run bar --with FILE.py:NAME --out rerun"),
        ({"id": "bar-with-me", "kind": "Executable"}, ("me",), "mpmverify run bar --with bench.toml --out rerun"),
        ({"id": "bar-with-me", "kind": "Files"}, ("me",), "mpmverify run --with bench.toml --out rerun"),
        ({"id": "a b", "tier": "quick"}, ("it's; rm",), """mpmverify run 'a b' --solver 'it'"'"'s; rm' --out rerun"""),
    ],
)
def test_the_command_that_runs_again_is_one_that_the_command_line_takes(
    attributes: dict[str, str], schemes: tuple[str, ...], expected: str
) -> None:
    kind = attributes.get("kind", "Mine")
    record = Record("copy", attributes, (), dict.fromkeys(schemes, f"{kind}()"), ())
    written = command(record, schemes[0])
    assert written == expected
    program, word, *arguments = shlex.split(written)
    assert (program, word) == ("mpmverify", "run")
    context = run_command.make_context("run", arguments)
    assert context.params["out"] == Path("rerun")
    assert context.params["own"] or context.params["solvers"] == (schemes[0],)


def test_the_ladder_of_the_scripted_solvers_has_three_levels() -> None:
    """Otherwise the numbers of runs above would say nothing."""
    assert len(ladder().levels) >= 3
