"""The page of a comparison of two results folders: it shows every change once, its numbers, and nothing of a name as markup."""

import dataclasses
import math
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from faulty_solvers import Scripted, plan, study
from hypothesis import given
from hypothesis import strategies as st
from report_pages import Page
from sample_study import HOSTILE
from test_comparison import CostlySolver, tables

from mpmverify import cli
from mpmverify.convergence.verdict import Verdict
from mpmverify.execution.runner import run
from mpmverify.judgement.change import Direction
from mpmverify.judgement.comparison import compare
from mpmverify.judgement.tables import Run, SeriesKey, Tables
from mpmverify.reports import render_comparison
from mpmverify.reports.changes_page import SECTIONS, changes_page
from mpmverify.reports.ratios import spread
from mpmverify.reports.site import render


def call(*arguments: object) -> Result:
    return CliRunner().invoke(cli.cli, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two results folders; in the second a solver is of first order, slower, and another one is new."""
    a, b = tmp_path_factory.mktemp("a"), tmp_path_factory.mktemp("b")
    list(run([study(CostlySolver())], plan(a)))
    list(run([study(CostlySolver(order=1.0, seconds=1.0, steps=2), Scripted("unstable", below=0.0))], plan(b)))
    return a, b


def test_the_command_writes_one_file_that_needs_no_other(folders: tuple[Path, Path], tmp_path: Path) -> None:
    target = tmp_path / "deep" / "changes.html"
    shown = call("compare", *folders, "--html", target)
    assert shown.exit_code == call("compare", *folders).exit_code == 1
    assert f"Comparison: {target}" in shown.output
    page = Page(target)
    assert page.resources == ["data:,"]
    assert all(link.startswith("#") for link in page.links)
    assert {link[1:] for link in page.links if "icon" not in link} <= set(page.ids)
    assert target.stat().st_size < 200_000, "no library of charts"
    cells = [" ".join(cell.split()) for cell in page.cells]
    for word in ("WORSE", "SLOWER", "NEW"):
        assert word in cells
    assert "PASS" in cells
    assert "FAIL" in cells
    assert any(re.match(r"\+?−?1\.0", cell) for cell in cells), "the order fell by one"
    assert "× 4.00" in cells, "seconds"
    assert "+100 %" in cells or "× 2.00" in cells, "steps"
    assert "h = 1/32" in " ".join(cells)
    assert 'class="strip"' in target.read_text(encoding="utf-8")


def test_a_comparison_replaces_its_own_page_and_no_other_file(folders: tuple[Path, Path], tmp_path: Path) -> None:
    target = tmp_path / "changes.html"
    target.write_text("my notes")
    refused = call("compare", *folders, "--html", target)
    assert refused.exit_code == 2
    assert "is not a page of an mpmverify report: move it away or choose another place" in " ".join(refused.output.split())
    assert target.read_text() == "my notes"
    target.unlink()
    for _ in range(2):
        assert call("compare", *folders, "--html", target).exit_code == 1
    missing = call("compare", *folders, "--html", tmp_path / "changes.html" / "below.html")
    assert missing.exit_code == 2
    assert "Traceback" not in missing.output


def test_folders_that_agree_have_a_page_that_says_so(folders: tuple[Path, Path], tmp_path: Path) -> None:
    list(run([study(CostlySolver())], plan(tmp_path / "again")))
    target = tmp_path / "changes.html"
    assert call("compare", folders[0], tmp_path / "again", "--html", target).exit_code == 0
    text = " ".join(" ".join(Page(target).text).split())
    assert "NOTHING WORSE" in text
    assert text.count("none changed") == len(SECTIONS)


def test_names_never_become_markup(tmp_path: Path) -> None:
    series = SeriesKey(HOSTILE, HOSTILE, HOSTILE, HOSTILE)
    key = (series, "h=0.5 nu_C=0.5 ppc=1")
    then = Tables(
        {HOSTILE: dict.fromkeys(("commit", "commit_state", "tier", "versions", "platform", "date_created"), HOSTILE)},
        {key: Run("completed", 1, 1, 1.0)},
        {(*key, f"{HOSTILE} L2"): (1.0, 1.0)},
        {},
        {(series, HOSTILE): Verdict.PASS},
    )
    now = dataclasses.replace(then, errors={(*key, f"{HOSTILE} L2"): (5.0, 1.0)}, verdicts={(series, HOSTILE): Verdict.FAIL})
    path = render_comparison(compare(then, now), (then, now), (HOSTILE, HOSTILE), tmp_path / "changes.html")
    page = Page(path)
    assert page.scripts == 1, "the script of the report"
    assert HOSTILE in "".join(page.text)


@given(tables(), tables())
def test_every_change_is_in_one_section(a: Tables, b: Tables) -> None:
    comparison = compare(a, b)
    page = changes_page(comparison, a, b, ("a", "b"), "generator")
    rows = [row for section in page.sections for row in section.rows]
    assert len(rows) == len(comparison.grouped())
    assert {row.mark.text for row in rows} <= {str(direction).upper() for direction in Direction}
    assert (page.mark.kind == "fail") == bool(comparison.exit_status)
    text = render(page)
    assert "nan" not in re.sub(r"[^<]*</(dd|td)>", "", text).lower().replace("finance", "")


@given(st.lists(st.floats(1e-9, 1e9), min_size=1))
def test_a_spread_holds_every_ratio_inside_its_frame(ratios: list[float]) -> None:
    drawn = spread("errors", ratios)
    places = [float(x) for x in re.findall(r"[MH](-?[\d.]+)", drawn.picture)]
    assert all(0 <= x <= 360 for x in places)
    assert f"{len(ratios)}".replace(",", "") in drawn.said.replace("\u2009", "")
    assert (math.prod(ratio == 1 for ratio in ratios) == 1) == (
        'class="first"' not in drawn.picture and 'class="second"' not in drawn.picture
    )
    assert spread("errors", []).picture == ""
