"""The report as one file of a study, and as PDF."""

import re
import subprocess

import pytest
from click.testing import CliRunner

from mpmverify.cli import cli
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError, UsageError
from mpmverify.reports import pdf, render, render_alone, single


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of the smallest study with its report."""
    folder = tmp_path_factory.mktemp("results")
    invoked = CliRunner().invoke(cli, ["run", "gehojerez-deck", "--out", str(folder), "--solver", "tg-lumped"])
    assert invoked.exit_code == 0, invoked.output
    return Results(folder)


def test_a_page_in_one_file_needs_no_other(results):
    path = render_alone(results, "gehojerez-deck")
    text = path.read_text(encoding="utf-8")
    page = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    assert not re.findall(r'(?:src|href)="(?!#|https?:|data:)[^"]*"', page)
    assert "Handbook" in page, "a link to another file is left as text"
    scripts = re.findall(r"<script>(.*?)</script>", text, flags=re.DOTALL)
    assert "plotly" in scripts[0][:3000]
    assert (results.report / "assets" / "report.js").read_text(encoding="utf-8") in scripts
    assert (results.report / "assets" / "report.css").read_text(encoding="utf-8") in page
    with pytest.raises(ResultsError, match="has no study 'none': choose from gehojerez-deck"):
        render_alone(results, "none")


def test_pictures_become_part_of_a_page(tmp_path):
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "plotly.min.js").write_text("plotly", encoding="utf-8")
    (tmp_path / "drawing.svg").write_text("<svg/>", encoding="utf-8")
    page = single.self_contained(
        '<img alt="a" src="drawing.svg"><a class="x" href="other.html">other <b>page</b></a>', tmp_path
    )
    assert 'alt="a" src="data:image/svg+xml;base64,PHN2Zy8+"' in page
    assert "<span>other <b>page</b></span>" in page


def test_a_page_in_one_file_is_html_alone(results):
    invoked = CliRunner().invoke(
        cli, ["report", "--out", str(results.path), "--self-contained", "gehojerez-deck", "--format", "md"]
    )
    assert (invoked.exit_code, "leave --format out" in invoked.output) == (2, True)
    invoked = CliRunner().invoke(cli, ["report", "--out", str(results.path), "--self-contained", "../none"])
    assert invoked.exit_code == 2
    assert "has no study '../none'" in invoked.output


def test_a_report_in_pdf_without_a_browser_says_so(results, monkeypatch):
    monkeypatch.setattr(pdf.shutil, "which", lambda _: None)
    with pytest.raises(UsageError, match="needs Chromium"):
        pdf.write(results)


@pytest.mark.parametrize("failure", ["killed", "nothing"])
def test_a_page_that_cannot_be_printed_is_named(results, monkeypatch, failure):
    def refuse(command, **_):
        if failure == "killed":
            raise subprocess.TimeoutExpired(command, 1.0)
        return subprocess.CompletedProcess(command, 1, "", "first\nno display")

    monkeypatch.setattr(pdf.shutil, "which", lambda _: "browser")
    monkeypatch.setattr(pdf.subprocess, "run", refuse)
    with pytest.raises(ResultsError, match=r"index\.html' cannot be printed \((TimeoutExpired|no display)\)"):
        pdf.write(results)


@pytest.mark.skipif(not any(map(pdf.shutil.which, pdf.BROWSERS)), reason="no Chromium is installed")
def test_each_page_is_printed_where_a_browser_is_found(results):
    render(results)
    path = pdf.write(results)
    for printed in (path, path.with_name("gehojerez-deck.pdf")):
        assert printed.read_bytes().startswith(b"%PDF")
