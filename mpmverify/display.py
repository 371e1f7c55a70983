"""What the command line shows: progress while runs go on, then the verdicts."""

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from types import TracebackType

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Column, Table

from mpmverify.change import Change, Direction, Kind
from mpmverify.comparison import Comparison
from mpmverify.dataset.kill_table import Fate, SelfTest
from mpmverify.gate import Finding, Judgement, Verdict
from mpmverify.summary import counts, matrix, ranked
from mpmverify.synthetic import total

STYLES = {Verdict.PASS: "green", Verdict.INCONCLUSIVE: "yellow", Verdict.FAIL: "bold red", Verdict.ERROR: "bold magenta"}
WIDTH = 200
"""Of lines for nobody's terminal: a matrix of nine studies and the longest names of solvers."""
LISTED = 20
"""Verdicts explained below the table unless all are asked for."""
COLOURS = {
    Direction.WORSE: "bold red",
    Direction.LOST: "red",
    Direction.SLOWER: "yellow",
    Direction.FASTER: "green",
    Direction.NEW: "cyan",
    Direction.BETTER: "bold green",
}
LISTED_CHANGES = 5
"""Changes of each direction and kind listed unless all are asked for."""


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


def show_selftest(test: SelfTest, *, explain: bool = False) -> None:
    """Print the kill table, then every survivor and every false alarm (with `explain`, every fault)."""
    console = _console()
    table = Table("rule", "planted", *Fate)
    rows = test.table()
    for rule, fates in rows.items():
        table.add_row(rule, *(str(count) for count in (sum(fates.values()), *fates.values())))
    totals = [sum(fates[fate] for fates in rows.values()) for fate in Fate]
    table.add_row("all", *(f"[bold]{count}[/]" for count in (sum(totals), *totals)))
    console.print(table)
    for fault in test.faults:
        if explain or fault.fate in (Fate.SURVIVED, Fate.UNDECIDED, Fate.NOT_EXERCISED):
            said = f"{fault.verdict} {fault.study}/{fault.case}/{fault.solver}: {fault.criterion}: " if fault.verdict else ""
            reason = fault.explanation or f"{said}{fault.reason}" or f"results differ by {fault.deviation:.1e} of their size"
            place = f"{fault.id} {fault.name} ({fault.file}:{fault.line})"
            console.print(f"[bold]{fault.fate.value}[/]", escape(f"{place}: {reason}"), highlight=False)
    for run in test.alarms:
        where = f"{run.jobs} processes, {run.threads} threads, jitter {run.jitter:g}, seed {run.seed}"
        console.print("[bold red]false alarm[/]", escape(f"{where}: {run.reason}"), highlight=False)
    console.print(
        f"{len(test.faults)} faults of {test.sites} by rule and by name, {len(test.unexplained)} unexplained survivors; "
        f"{len(test.runs)} unmodified runs, {len(test.alarms)} false alarms.",
        highlight=False,
    )
    for name, rates in (("series", test.rates.series), ("designs", test.rates.designs)):
        if rates:
            every = total(rates)
            shares = (
                f"{every.wrong_pass / every.series:.2%} passed wrongly, {every.wrong_fail / every.series:.2%} failed wrongly"
            )
            console.print(f"{every.series} random {name} of known truth: {shares}.", highlight=False)


def show(findings: Sequence[Finding], *, explain: bool = False) -> None:
    """Print the matrix of solver by study, then what is no PASS (with `explain`, everything), with the reason."""
    console = _console()
    studies = list(dict.fromkeys(finding.study for finding in findings))
    table = Table(Column("solver", overflow="fold"), *(escape(study) for study in studies))
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


def show_comparison(comparison: Comparison, *, explain: bool = False) -> None:
    """Print where two results folders come from, and the worst changes of each direction and kind (with `explain`, all), and how many."""
    console = _console()
    for name, source in (("A", comparison.before), ("B", comparison.after)):
        commit, state, tier, versions = ("; ".join(source[key]) for key in ("commit", "commit_state", "tier", "versions"))
        origin = f"{name}: commit {commit} ({state}), tier {tier}, of {source['date_created'][-1]}, with {versions}"
        console.print(origin, highlight=False, markup=False)
    for caution in comparison.cautions:
        console.print(f"[yellow]Caution:[/] {escape(caution)}.", highlight=False)
    grouped = [(change, 1) for change in comparison.changes] if explain else comparison.grouped()
    table = Table("", "what", "where", "of which", "A", "B", "change")
    for (direction, kind), group in groupby(grouped, lambda entry: (entry[0].direction, entry[0].kind)):
        mine = list(group)
        listed = mine if explain else mine[:LISTED_CHANGES]
        for change, count in listed:
            table.add_row(f"[{COLOURS[direction]}]{direction.upper()}[/]", *map(escape, _cells(change, count)))
        if left := sum(count for _, count in mine[len(listed) :]):
            table.add_row("", kind, f"and {left} more: --explain shows all")
        table.add_section()
    if comparison.changes:
        console.print(table)
    counted = Counter(change.direction for change in comparison.changes)
    changes = ", ".join(f"{counted[direction]} {direction}" for direction in Direction if counted[direction])
    both = ", ".join(f"{count} {name}" for name, count in comparison.compared.items())
    console.print(f"{changes or 'Nothing changed'}: {both} compared.", highlight=False)


def _cells(change: Change, count: int) -> tuple[str, ...]:
    """What changed, where, of which, from what, to what, and by how much."""
    where = " / ".join(part for part in (change.study, change.case, change.solver) if part)
    where += f" ({change.refinement})" if change.refinement else ""
    which = " at ".join(part for part in (change.name, change.level) if part)
    which += f" (and {count - 1} like it)" if count > 1 else ""
    then, now = (f"{value:.4g}" if isinstance(value, int | float) else value or "" for value in (change.before, change.after))
    return str(change.kind), where, which, then, now, _by(change)


def _by(change: Change) -> str:
    """Signed size of a change."""
    if change.kind is Kind.ORDER:
        return f"{-change.size if change.direction is Direction.WORSE else change.size:+.3f}"
    if isinstance(change.before, int | float) and isinstance(change.after, int | float) and change.before:
        ratio = change.after / change.before
        return f"x {ratio:.3g}" if ratio >= 10 else f"{100 * (ratio - 1):+.3g} %"
    return ""


def _console() -> Console:
    console = Console()
    return console if console.is_terminal else Console(width=WIDTH)
