"""What the command line shows of findings: the matrix of solvers and studies, then the findings that did not pass."""

from collections.abc import Sequence

from rich.markup import escape
from rich.table import Column, Table

from mpmverify.cli.console import STYLES, console
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import counts, matrix, ranked

LISTED = 20
"""Findings listed below the matrix unless all are asked for."""


def show(findings: Sequence[Finding], *, explain: bool = False) -> None:
    """Print the matrix of solver by study, then what is no PASS (with `explain`, everything), with the reason."""
    output = console()
    studies = list(dict.fromkeys(finding.study for finding in findings))
    table = Table(Column("solver", overflow="fold"), *(escape(study) for study in studies))
    for solver, row in matrix(findings).items():
        table.add_row(escape(solver), *(f"[{STYLES[row[s]]}]{row[s]}[/]" if s in row else "[dim]-[/]" for s in studies))
    output.print(table)
    listed = list(findings) if explain else ranked(findings)[:LISTED]
    for finding in listed:
        output.print(
            f"[{STYLES[finding.verdict]}]{finding.word}[/]",
            escape(str(finding).removeprefix(finding.word).strip()),
            highlight=False,
        )
        if explain:
            output.print(f"    expected by: {finding.source}", style="dim", highlight=False, markup=False)
    if not explain and len(ranked(findings)) > LISTED:
        output.print(f"and {len(ranked(findings)) - LISTED} more: --explain shows all")
    output.print(f"{counts(findings)}.", highlight=False)
