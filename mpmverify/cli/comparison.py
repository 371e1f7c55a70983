"""What the command line shows of two results folders side by side."""

from collections import Counter
from itertools import groupby

from rich.markup import escape
from rich.table import Table

from mpmverify.cli.console import console
from mpmverify.judgement.change import Change, Direction, Kind
from mpmverify.judgement.comparison import Comparison

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


def show_comparison(comparison: Comparison, *, explain: bool = False) -> None:
    """Print where two results folders come from, and the worst changes of each direction and kind (with `explain`, all), and how many."""
    output = console()
    for name, source in (("A", comparison.before), ("B", comparison.after)):
        commit, state, tier, versions = ("; ".join(source[key]) for key in ("commit", "commit_state", "tier", "versions"))
        origin = f"{name}: commit {commit} ({state}), tier {tier}, of {source['date_created'][-1]}, with {versions}"
        output.print(origin, highlight=False, markup=False)
    for caution in comparison.cautions:
        output.print(f"[yellow]Caution:[/] {escape(caution)}.", highlight=False)
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
        output.print(table)
    counted = Counter(change.direction for change in comparison.changes)
    changes = ", ".join(f"{counted[direction]} {direction}" for direction in Direction if counted[direction])
    both = ", ".join(f"{count} {name}" for name, count in comparison.compared.items())
    output.print(f"{changes or 'Nothing changed'}: {both} compared.", highlight=False)


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
