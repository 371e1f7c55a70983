"""What the command line shows: progress while runs go on, then the verdicts."""

import sys
from collections.abc import Mapping, Sequence
from types import TracebackType

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Table

from mpmverify.gate import Finding, Judgement, Verdict
from mpmverify.summary import counts, matrix, ranked

STYLES = {Verdict.PASS: "green", Verdict.INCONCLUSIVE: "yellow", Verdict.FAIL: "bold red", Verdict.ERROR: "bold magenta"}
LISTED = 20
"""Verdicts explained below the table unless all are asked for."""


class Progress:
    """Bars when a terminal looks, plain lines otherwise, nothing when there is nothing to wait for."""

    def __init__(self) -> None:
        console = Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        self._bars = Bars(*columns, console=console) if console.is_terminal else None
        self._tasks: dict[str, TaskID] = {}

    def __enter__(self) -> "Progress":
        if self._bars:
            self._bars.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bars:
            self._bars.stop()

    def update(self, study: str, done: int, total: int) -> None:
        if self._bars:
            if study not in self._tasks:
                self._tasks[study] = self._bars.add_task(study, total=total)
            self._bars.update(self._tasks[study], completed=done)
        elif done == total:
            print(f"{study}: {total} runs", file=sys.stderr)


def show(findings: Sequence[Finding], *, explain: bool = False) -> None:
    """Print the matrix of solver by study, then what is no PASS (with `explain`, everything), with the reason."""
    console = Console()
    if not console.is_terminal:
        console = Console(width=140)
    studies = list(dict.fromkeys(finding.study for finding in findings))
    table = Table("solver", *(escape(study) for study in studies))
    for solver, row in matrix(findings).items():
        table.add_row(escape(solver), *(f"[{STYLES[row[s]]}]{row[s]}[/]" if s in row else "[dim]-[/]" for s in studies))
    console.print(table)
    listed = list(findings) if explain else ranked(findings)[:LISTED]
    for finding in listed:
        console.print(
            f"[{STYLES[finding.verdict]}]{finding.verdict}[/]",
            escape(str(finding).removeprefix(finding.verdict).strip()),
            highlight=False,
        )
        if explain:
            console.print(f"    expected by: {finding.source}", style="dim", highlight=False, markup=False)
    if not explain and len(ranked(findings)) > LISTED:
        console.print(f"and {len(ranked(findings)) - LISTED} more: --explain shows all")
    console.print(f"{counts(findings)}.", highlight=False)


def show_judgements(judgements: Mapping[str, Judgement]) -> None:
    """Print verdicts by name, one a line, with the reason."""
    console = Console()
    for name, (verdict, reason) in judgements.items():
        console.print(f"[{STYLES[verdict]}]{verdict}[/]", escape(f"{name}: {reason}"), highlight=False, soft_wrap=True)
