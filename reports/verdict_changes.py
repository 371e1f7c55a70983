"""Verdicts that changed since the run before, for the overview: one sentence for each run, and the criteria."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mpmverify.judgement.change import Change, Direction

from .notation import count, ladder, typeset_numbers
from .parts import Mark
from .record import Record

UNFOLDED = 6
"""Largest number of rows of the last run that are open at first."""
NAMED = 3
"""Largest number of new studies that are named."""


@dataclass(frozen=True)
class ChangedVerdicts:
    """Criteria of one series whose verdicts changed alike.

    Parameters
    ----------
    before, after : Mark or None
        None where there was, or is, no verdict.
    study, case, solver, ladder : str
    criteria : tuple of str
    href : str
        Place of the series; "" if it is gone.
    """

    before: Mark | None
    after: Mark | None
    study: str
    case: str
    solver: str
    ladder: str
    criteria: tuple[str, ...]
    href: str


@dataclass(frozen=True)
class RunChanges:
    """What one run changed: `sentence` says it, `unfolded` if the rows are open at first."""

    sentence: str
    unfolded: bool
    rows: tuple[ChangedVerdicts, ...]


def verdict_changes(records: Sequence[Record], places: Mapping[str, Mapping[tuple[str, str], str]]) -> tuple[RunChanges, ...]:
    """Say what the last run changed, and what the runs before it changed in the studies that were not judged since.

    Parameters
    ----------
    records : sequence of Record
    places : mapping of str to mapping of (str, str) to str
        Anchor of the verdicts on each (case, solver), by study.

    Returns
    -------
    tuple of RunChanges
        The newest run first; of older ones those that changed a verdict. Empty if no study has been judged before.
    """
    runs: dict[str, list[Record]] = {}
    for record in records:
        if record.history.run:
            runs.setdefault(record.history.run, []).append(record)
    if not any(record.history.before for record in records) and len(runs) < 2:
        return ()
    newest = max(runs, default="")
    table = []
    for run in sorted(runs, reverse=True):
        changes = [change for record in runs[run] for change in record.history.changes]
        if run == newest or changes:
            rows = _rows(changes, places)
            said = _newest(runs[run], changes, len(records)) if run == newest else _earlier(runs[run], changes)
            table.append(RunChanges(said, run == newest and len(rows) <= UNFOLDED, rows))
    return tuple(table)


def _newest(judged: Sequence[Record], changes: Sequence[Change], studies: int) -> str:
    before = [record for record in judged if record.history.before]
    new = [str(record.attributes["title"]) for record in judged if not record.history.before]
    news = f"Judged for the first time: {', '.join(new) if len(new) <= NAMED else f'{count(len(new))} studies'}."
    if not before:
        return news
    since = f"since the run before ({_span(before)})"
    said = f"S{since[1:]}: {_counted(changes)}" if changes else f"No verdict changed {since}."
    verb = "was" if len(judged) == 1 else "were"
    part = f"{len(judged)} of {studies} studies {verb} judged anew." if len(judged) < studies else ""
    return " ".join(filter(None, (said, news if new else "", part)))


def _earlier(judged: Sequence[Record], changes: Sequence[Change]) -> str:
    return f"The run of {_minute(judged[0].history.run)}, against that of {_span(judged)}: {_counted(changes)}"


def _span(records: Sequence[Record]) -> str:
    """Return when the runs before started, from the first to the last."""
    starts = sorted(record.history.before for record in records if record.history.before)
    return " to ".join(dict.fromkeys((_minute(starts[0]), _minute(starts[-1]))))


def _minute(time: str) -> str:
    """Convert "2026-01-31T09:05:59Z" to "2026-01-31 09:05 UTC"."""
    return f"{time[:16].replace('T', ' ')} UTC"


def _counted(changes: Sequence[Change]) -> str:
    turned = Counter((change.before, change.after) for change in changes if change.before and change.after)
    worse = {(change.before, change.after) for change in changes if change.direction is Direction.WORSE}
    ranked = sorted(turned.items(), key=lambda entry: (entry[0] not in worse, -entry[1]))
    kinds = Counter(change.direction for change in changes)
    counted = [(number, f"turned from {before} to {after}") for (before, after), number in ranked]
    counted += [(number, f"{'is' if number == 1 else 'are'} new") for number in (kinds[Direction.NEW],) if number]
    counted += [(number, f"{'is' if number == 1 else 'are'} gone") for number in (kinds[Direction.LOST],) if number]
    (first, said), *others = counted
    noun = "criterion" if first == 1 else "criteria"
    return ", ".join([f"{count(first)} {noun} {said}", *(f"{count(number)} {words}" for number, words in others)]) + "."


def _rows(changes: Sequence[Change], places: Mapping[str, Mapping[tuple[str, str], str]]) -> tuple[ChangedVerdicts, ...]:
    order = (Direction.WORSE, Direction.LOST, Direction.NEW, Direction.BETTER)
    table: dict[tuple[str, ...], list[Change]] = {}
    for change in sorted(changes, key=lambda change: order.index(change.direction)):
        key = (change.study, change.case, change.solver, change.refinement, str(change.before), str(change.after))
        table.setdefault(key, []).append(change)
    rows = []
    for first, *others in table.values():
        place = places[first.study].get((first.case, first.solver))
        rows.append(
            ChangedVerdicts(
                before=_mark(first.before),
                after=_mark(first.after),
                study=first.study,
                case=first.case,
                solver=first.solver,
                ladder=ladder(first.refinement),
                criteria=tuple(typeset_numbers(change.name.removeprefix("verification: ")) for change in (first, *others)),
                href=f"{first.study}.html#{place}" if place and first.after else "",
            )
        )
    return tuple(rows)


def _mark(verdict: str | float | None) -> Mark | None:
    return Mark(str(verdict).lower(), str(verdict)) if verdict else None
