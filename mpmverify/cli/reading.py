"""Commands that read stored results: judge, render, compare and accept them; nothing is run."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mpmverify.cli.group import Group
from mpmverify.cli.options import (
    EPILOG,
    Folder,
    baseline_option,
    explain_option,
    open_option,
    out_option,
    studies_argument,
)
from mpmverify.cli.results import accepted, shipped_baseline, show_report, stored
from mpmverify.errors import UsageError

if TYPE_CHECKING:
    from mpmverify.judgement.findings import Finding


@click.command(epilog=EPILOG)
@studies_argument
@out_option
@baseline_option
@click.option("--junit", type=click.Path(path_type=Path, dir_okay=False), help="Write JUnit XML here.")
@click.option(
    "--summary",
    type=click.Path(path_type=Path, dir_okay=False),
    envvar="GITHUB_STEP_SUMMARY",
    help="Append a Markdown summary here  [default: $GITHUB_STEP_SUMMARY]",
)
@click.option("--strict", is_flag=True, help="Exit with 4 when a verdict is inconclusive.")
@explain_option
def gate(
    studies: tuple[str, ...],
    out: Path,
    baseline: Path | None,
    junit: Path | None,
    summary: Path | None,
    strict: bool,
    explain: bool,
) -> None:
    """Judge stored results; nothing is run and nothing is changed.

    On GitHub ($GITHUB_ACTIONS is "true") the worst ten findings become annotations.
    """
    from mpmverify.cli.console import console
    from mpmverify.cli.findings import StudyTable, show
    from mpmverify.convergence.verdict import exit_status
    from mpmverify.execution import gate as stored_studies
    from mpmverify.judgement import summary as summaries

    known = accepted(baseline)
    paths, output = stored(out, studies), console()
    table = StudyTable(output, [path.stem for path in paths])
    findings: list[Finding] = []
    for path in paths:
        judged = stored_studies.gate(path, known)
        table.add(path.stem, judged)
        findings += judged
    if junit:
        summaries.write_junit(junit, findings)
    if summary and not summaries.append_markdown(summary, findings):
        click.echo(f"'{summary}' is full: no verdicts were added to it.", err=True)
    show(output, findings, explain=explain)
    if os.environ.get("GITHUB_ACTIONS") == "true":
        click.echo("".join(f"{command}\n" for command in summaries.annotations(findings, out)), nl=False)
    sys.exit(exit_status([finding.verdict for finding in findings], strict=strict))


@click.command()
@out_option
@click.option(
    "--format",
    "form",
    type=click.Choice(("html", "md", "pdf")),
    default="html",
    show_default=True,
    help="Pages in HTML, one page in Markdown for a pull request, or each page in PDF, which needs Chromium.",
)
@click.option("--self-contained", "alone", metavar="STUDY", default="", help="Write the page of STUDY as one HTML file.")
@click.option(
    "--benchmarks",
    type=click.Path(path_type=Path),
    metavar="FILE",
    multiple=True,
    help="Add a page of a JSON file of pytest-benchmark; several give a history.",
)
@open_option
def report(out: Path, form: str, alone: str, benchmarks: tuple[Path, ...], open_: bool) -> None:
    """Render the report anew from the stored results alone."""
    from mpmverify.dataset.files import Results

    if alone and form != "html":
        raise UsageError("--self-contained writes HTML: leave --format out")
    if benchmarks and form == "md":
        raise UsageError("--benchmarks adds a page in HTML: leave --format md out")
    stored(out, ())
    show_report(Results(out), form, alone, benchmarks, fresh=True, opened=open_)


@click.command(epilog="Exit status: 0 nothing is worse or lost, 1 something is, 2 usage.")
@click.argument("before", metavar="A", type=Folder())
@click.argument("after", metavar="B", type=Folder())
@click.option("--explain", is_flag=True, help="Print every change.")
@click.option(
    "--html", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE", help="Write the comparison as a page here."
)
def compare(before: Path, after: Path, explain: bool, html: Path | None) -> None:
    """Say what became worse, slower, lost, new, faster or better from the results in A to those in B.

    Nothing is run: verdicts, errors, orders, steps and seconds are those in the files.
    """
    from mpmverify.cli.comparison import show_comparison
    from mpmverify.dataset.tables import read_tables
    from mpmverify.judgement import comparison

    if before.resolve() == after.resolve():
        raise UsageError(f"A and B are both '{before}': name two results folders")
    a, b = (read_tables(stored(path, ())) for path in (before, after))
    compared = comparison.compare(a, b)
    show_comparison(compared, explain=explain)
    if html:
        from mpmverify import reports

        click.echo(f"Comparison: {reports.render_comparison(compared, (a, b), (str(before), str(after)), html)}")
    sys.exit(compared.exit_status)


@click.group(cls=Group)
def baseline() -> None:
    """Manage the baseline of the regression gate."""


@baseline.command()
@studies_argument
@out_option
@baseline_option
@click.option("--reason", required=True, help="Why the errors may change; kept in the baseline.")
def accept(studies: tuple[str, ...], out: Path, baseline: Path | None, reason: str) -> None:
    """Take the stored errors over into the baseline."""
    from mpmverify.execution import gate as stored_studies
    from mpmverify.judgement.baseline import read_baseline

    if not reason.strip():
        raise UsageError("--reason must say why the errors may change")
    known = read_baseline(baseline or shipped_baseline())
    count = stored_studies.accept(known, stored(out, studies), reason.strip())
    known.write()
    click.echo(f"Accepted {count} series into {known.path}")
