"""The page that shows what changed from one results folder to another: verdicts, orders, errors, cost, and what is new or gone."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from mpmverify.judgement.change import Change, Direction, Kind
from mpmverify.judgement.comparison import Comparison
from mpmverify.judgement.tables import SeriesKey, Tables

from .notation import NORM_NAMES, cell_size, count, ladder, number, order, typeset_numbers
from .parts import Fact, Link, Mark, Origin
from .ratios import Spread, spread
from .strips import ruler, strip

MARKS = {
    Direction.WORSE: "fail",
    Direction.LOST: "fail",
    Direction.SLOWER: "inconclusive",
    Direction.FASTER: "pass",
    Direction.NEW: "limit",
    Direction.BETTER: "pass",
}
"""Style of each direction: that of a verdict which a reader takes the same way."""
SECTIONS: Mapping[str, tuple[Kind, ...]] = {
    "Verdicts": (Kind.VERDICT, Kind.OUTCOME),
    "Orders": (Kind.ORDER,),
    "Errors": (Kind.ERROR,),
    "Cost": (Kind.STEPS, Kind.SECONDS),
    "New and gone": (Kind.STUDY, Kind.CASE, Kind.SOLVER, Kind.LADDER, Kind.LEVEL, Kind.CRITERION, Kind.NORM),
}
"""Kinds of changes by section."""
UNFOLDED = 40
"""Largest number of rows of a section that is open at first."""
LABELS = {"commit": "Commit", "commit_state": "State", "tier": "Tier", "versions": "Versions", "platform": "Platform"}


@dataclass(frozen=True)
class ChangeRow:
    """One change, or several of one kind in one series.

    Parameters
    ----------
    mark : Mark
        The direction; its note says how many more are like it.
    study, case, solver, ladder, which : str
        Where it is, and what of it: a criterion, a quantity with its norm, a level.
    before, after, by : str
        Values in both folders, and the size of the change.
    strips : tuple of str
        SVG of both orders; empty for other kinds.
    """

    mark: Mark
    study: str
    case: str
    solver: str
    ladder: str
    which: str
    before: str
    after: str
    by: str
    strips: tuple[str, ...] = ()


@dataclass(frozen=True)
class ChangeSection:
    """Changes of one section, with their number in words; `drawn` if its rows have strips."""

    anchor: str
    title: str
    note: str
    unfolded: bool
    drawn: bool
    rows: tuple[ChangeRow, ...]


@dataclass(frozen=True)
class Side:
    """One of the two folders, with its provenance."""

    letter: str
    name: str
    facts: tuple[Fact, ...]


@dataclass(frozen=True)
class ChangesPage:
    """The comparison of two results folders.

    Parameters
    ----------
    title, generator, root : str
    navigation : tuple of Link
    mark : Mark
        Whether anything is worse or lost.
    sentence : str
        Number of changes by direction, and of what was compared.
    sides : tuple of Side
    cautions : tuple of str
        What limits the comparison.
    spreads : tuple of Spread
        Ratios of all errors, seconds and steps.
    sections : tuple of ChangeSection
    ruler : str
        SVG of the axis of the orders.
    origins : tuple of Origin
        None: the provenance of both folders is in `sides`.
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    mark: Mark
    sentence: str
    sides: tuple[Side, ...]
    cautions: tuple[str, ...]
    spreads: tuple[Spread, ...]
    sections: tuple[ChangeSection, ...]
    ruler: str
    origins: tuple[Origin, ...] = ()


def changes_page(comparison: Comparison, before: Tables, after: Tables, names: tuple[str, str], generator: str) -> ChangesPage:
    """Make the page of a comparison.

    Parameters
    ----------
    comparison : Comparison
    before, after : Tables
        What was compared.
    names : (str, str)
        Names of the two folders.
    generator : str
        Name and version of the program.
    """
    grouped = comparison.grouped()
    sections = tuple(_section(title, grouped, (before, after)) for title in SECTIONS)
    worse = comparison.exit_status != 0
    return ChangesPage(
        title="Comparison of two results folders",
        generator=generator,
        root="",
        navigation=tuple(Link(section.title, f"#{section.anchor}") for section in sections),
        mark=Mark("fail", "WORSE OR LOST") if worse else Mark("pass", "NOTHING WORSE"),
        sentence=_sentence(comparison),
        sides=tuple(
            Side(letter, name, _provenance(source))
            for letter, name, source in zip("AB", names, (comparison.before, comparison.after), strict=True)
        ),
        cautions=tuple(f"{caution[:1].upper()}{caution[1:]}." for caution in comparison.cautions),
        spreads=tuple(
            spread(name, list(values))
            for name, values in (
                ("Errors", _errors(before, after)),
                ("Seconds", _seconds(before, after)),
                ("Steps", _steps(before, after)),
            )
        ),
        sections=sections,
        ruler=ruler(),
    )


def _sentence(comparison: Comparison) -> str:
    counted = Counter(change.direction for change in comparison.changes)
    changes = ", ".join(f"{count(counted[direction])} {direction}" for direction in Direction if counted[direction])
    both = ", ".join(f"{count(number)} {name}" for name, number in comparison.compared.items())
    return f"{changes or 'Nothing changed'}; {both} compared."


def _provenance(source: Mapping[str, tuple[str, ...]]) -> tuple[Fact, ...]:
    facts = [Fact(label, "; ".join(source[name])) for name, label in LABELS.items()]
    return (*facts, Fact("Written", source["date_created"][-1] if source["date_created"] else ""))


def _section(title: str, grouped: Sequence[tuple[Change, int]], tables: tuple[Tables, Tables]) -> ChangeSection:
    mine = [(change, size) for change, size in grouped if change.kind in SECTIONS[title]]
    rows = tuple(_row(change, size, tables) for change, size in mine)
    total = sum(size for _, size in mine)
    note = f"{count(total)} change{'s' * (total != 1)}" if total else "none changed"
    anchor = title.lower().replace(" ", "-")
    return ChangeSection(anchor, title, note, len(rows) <= UNFOLDED, any(row.strips for row in rows), rows)


def _row(change: Change, size: int, tables: tuple[Tables, Tables]) -> ChangeRow:
    strips: tuple[str, ...] = ()
    if change.kind is Kind.ORDER:
        key = (SeriesKey(change.study, change.case, change.solver, change.refinement), change.name)
        fits = [table.orders[key] for table in tables if key in table.orders]
        strips = tuple(strip(fit.order, (fit.low, fit.high)) for fit in fits)
    more = f"and {count(size - 1)} like it" if size > 1 else ""
    return ChangeRow(
        mark=Mark(MARKS[change.direction], str(change.direction).upper(), more),
        study=change.study,
        case=change.case,
        solver=change.solver,
        ladder=ladder(change.refinement),
        which=_which(change),
        before=_value(change.before),
        after=_value(change.after),
        by=_by(change),
        strips=strips,
    )


def _which(change: Change) -> str:
    if change.kind in (Kind.ORDER, Kind.ERROR, Kind.NORM):
        quantity, _, norm = change.name.rpartition(" ")
        name = f"{quantity.replace('_', ' ')} {NORM_NAMES.get(norm, norm)}".strip()
    else:
        name = typeset_numbers(change.name)
    kind = "" if change.kind in (Kind.VERDICT, Kind.ORDER, Kind.ERROR, Kind.STEPS) else str(change.kind)
    return ", ".join(part for part in (kind, name, *_level(change)) if part)


def _level(change: Change) -> Iterator[str]:
    """Yield the sizes of a level, without those that the label of its ladder states."""
    for part in change.level.split():
        name, _, value = part.partition("=")
        shown = {"nu_C": f"Courant {value}", "ppc": f"{value} ppc"}.get(name, part)
        if name == "h":
            cells = round(1 / float(value))
            stored = f"{1 / cells:.9g}" if cells else ""  # a level is named by nine digits
            shown = f"h = {cell_size(1 / cells if stored == value else float(value))}"
        if shown not in ladder(change.refinement):
            yield shown


def _value(value: str | float | None) -> str:
    if value is None:
        return ""
    return number(float(value), 4) if isinstance(value, int | float) else typeset_numbers(value)


def _by(change: Change) -> str:
    if change.kind is Kind.ORDER:
        return order(-change.size if change.direction is Direction.WORSE else change.size)
    then, now = change.before, change.after
    ratio = _ratio(then, now) if isinstance(then, int | float) and isinstance(now, int | float) else math.nan
    if not math.isfinite(ratio):
        return ""
    if ratio >= 2 or ratio <= 0.5:
        return f"× {number(ratio, 3)}"
    return f"{'+' if ratio > 1 else ''}{number(100 * (ratio - 1), 3)} %"


def _errors(before: Tables, after: Tables) -> Iterator[float]:
    """Yield of each series and norm the ratio of the errors of the second to the first folder that is farthest from 1."""
    table: dict[tuple[SeriesKey, str], float] = {}
    for (series, level, name), (then, _) in before.errors.items():
        now, _ = after.errors.get((series, level, name), (math.nan, 0.0))
        ratio = _ratio(then, now)
        if math.isfinite(ratio) and abs(math.log(ratio)) >= abs(math.log(table.get((series, name), 1.0))):
            table[series, name] = ratio
    yield from table.values()


def _seconds(before: Tables, after: Tables) -> Iterator[float]:
    """Yield the ratio of the wall times of each solver on each study."""
    yield from _sums(before, after, "seconds")


def _steps(before: Tables, after: Tables) -> Iterator[float]:
    """Yield the ratio of the point-steps of each solver on each study."""
    yield from _sums(before, after, "point_steps")


def _sums(before: Tables, after: Tables, cost: str) -> Iterator[float]:
    table: dict[tuple[str, str], list[float]] = {}
    for key, then in before.runs.items():
        now = after.runs.get(key)
        if now and then.outcome == now.outcome == "completed":
            sums = table.setdefault((key[0].study, key[0].solver), [0.0, 0.0])
            sums[0] += getattr(then, cost)
            sums[1] += getattr(now, cost)
    yield from filter(math.isfinite, (_ratio(then, now) for then, now in table.values()))


def _ratio(then: float, now: float) -> float:
    """Return the ratio of two numbers, NaN unless it and both of them are positive and finite."""
    known = then > 0 and now > 0 and math.isfinite(then) and math.isfinite(now)
    return now / then if known and 0 < now / then < math.inf else math.nan
