"""Comparison of two results folders by their stored numbers: what is worse or better, slower or faster, lost or new."""

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from mpmverify.convergence.verdict import Verdict
from mpmverify.judgement.baseline import noise, rose
from mpmverify.judgement.change import Change, Direction, Kind
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.tables import PROVENANCE, Run, SeriesKey, Tables, verdicts_by_criterion

K = TypeVar("K")
V = TypeVar("V")
Verdicts = Mapping[tuple[SeriesKey, str], Verdict]
"""By (series, "gate: criterion")."""

SLOWER = 1.25
"""Ratio of seconds above which a run is slower."""
SLOWER_SHARE = 0.75
"""Share of the runs of a solver on a study that must be slower, in addition to their sum, because every run is timed only once. When
the same code was run repeatedly on a busy machine, the sum alone changed by more than `SLOWER` for 111 of 177 pairs; with this share,
4 remained."""
SECONDS = 0.01
"""Total time of a solver on a study below which a change is noise [s]."""


@dataclass(frozen=True)
class Comparison:
    """Differences between two results folders.

    Parameters
    ----------
    before, after : mapping of str to tuple of str
        Distinct values of each provenance attribute in the first and in the second folder.
    cautions : tuple of str
        What limits the comparison, one sentence each.
    changes : tuple of Change
        The worst first.
    compared : mapping of str to int
        Number of verdicts, errors, orders and runs that both folders have.
    """

    before: Mapping[str, tuple[str, ...]]
    after: Mapping[str, tuple[str, ...]]
    cautions: tuple[str, ...]
    changes: tuple[Change, ...]
    compared: Mapping[str, int]

    @property
    def exit_status(self) -> int:
        """1 if something is worse or lost, else 0; changes of seconds and steps do not count."""
        return int(any(change.direction in (Direction.WORSE, Direction.LOST) for change in self.changes))

    def grouped(self) -> list[tuple[Change, int]]:
        """Changes grouped for display: the first change of each group and the size of the group; the worst first."""
        table: dict[Hashable, list[Change]] = {}
        for change in self.changes:
            table.setdefault((change.direction, change.kind, _group(change)), []).append(change)
        return [(some[0], len(some)) for some in table.values()]


def _group(change: Change) -> Hashable:
    """Key by which changes of one direction and kind are grouped for display."""
    if change.kind is Kind.VERDICT and change.name.startswith("regression"):  # the errors of each series are listed anyway
        return change.study, change.name, change.before, change.after
    if change.kind in (Kind.ORDER, Kind.ERROR, Kind.STEPS, Kind.NORM, Kind.LEVEL):
        return change.study, change.case, change.solver, change.refinement
    return change


def compare(before: Tables, after: Tables) -> Comparison:
    """Compare two results folders; entries of the first alone are lost, entries of the second alone are new."""
    changes = [
        *_lost_and_new(before, after),
        *_verdicts(before.verdicts, after.verdicts),
        *_outcomes(before, after),
        *(errors := list(_errors(before, after))),
        *_orders(before, after, errors),
        *_steps(before, after),
        *_seconds(before, after),
    ]

    def worst_first(c: Change) -> tuple[int, int, float, tuple[str, ...]]:
        where = (c.study, c.case, c.solver, c.refinement, c.level, c.name)
        return directions.index(c.direction), kinds.index(c.kind), -c.size, where

    directions, kinds = list(Direction), list(Kind)
    return Comparison(
        _distinct(before),
        _distinct(after),
        tuple(_cautions(before, after)),
        tuple(sorted(changes, key=worst_first)),
        {
            name: len(getattr(before, name).keys() & getattr(after, name).keys())
            for name in ("verdicts", "errors", "orders", "runs")
        },
    )


def _lost_and_new(before: Tables, after: Tables) -> Iterator[Change]:
    """Entries that only one folder has; a missing study, case or solver is reported once, not with everything in it."""
    for direction, mine, theirs in ((Direction.LOST, before, after), (Direction.NEW, after, before)):
        present = {part for series, level in theirs.runs for _, part in _enclosing_parts(series, level)}
        absent = {}
        for series, level in mine.runs:
            missing = [(kind, part) for kind, part in _enclosing_parts(series, level) if part not in present]
            absent.update(dict.fromkeys(missing[:1]))
        for kind, part in absent:
            yield Change(direction, kind, *part)
        series_of_theirs = {series for series, _ in theirs.runs}
        for series, criterion in mine.verdicts.keys() - theirs.verdicts.keys():
            if series in series_of_theirs:
                yield Change(direction, Kind.CRITERION, *series, name=criterion)
        for series, level, name in mine.errors.keys() - theirs.errors.keys():
            run = theirs.runs.get((series, level))
            if run and run.outcome == "completed":
                yield Change(direction, Kind.NORM, *series, level, name)


def _enclosing_parts(series: SeriesKey, level: str) -> list[tuple[Kind, tuple[str, str, str, str, str]]]:
    """Parts of a folder that contain a run, the largest first."""
    study, case, solver, refinement = series
    return [
        (Kind.STUDY, (study, "", "", "", "")),
        (Kind.CASE, (study, case, "", "", "")),
        (Kind.SOLVER, (study, "", solver, "", "")),
        (Kind.LADDER, (study, case, solver, refinement, "")),
        (Kind.LEVEL, (study, case, solver, refinement, level)),
    ]


def verdict_changes(before: Iterable[Finding], after: Iterable[Finding]) -> tuple[Change, ...]:
    """Compare the verdicts of one study with those of an earlier run of it.

    Parameters
    ----------
    before, after : iterable of Finding

    Returns
    -------
    tuple of Change
        Criteria with another verdict, the worst first, then those of which one has none: lost ones, with the verdict before, and new
        ones, with the verdict after.
    """
    then, now = verdicts_by_criterion(before), verdicts_by_criterion(after)
    turned = sorted(_verdicts(then, now), key=lambda change: (change.direction is Direction.BETTER, -change.size))
    lost = [
        Change(Direction.LOST, Kind.CRITERION, *key[0], name=key[1], before=str(then[key])) for key in then if key not in now
    ]
    new = [Change(Direction.NEW, Kind.CRITERION, *key[0], name=key[1], after=str(now[key])) for key in now if key not in then]
    return (*turned, *lost, *new)


def _verdicts(before: Verdicts, after: Verdicts) -> Iterator[Change]:
    rank = list(Verdict).index
    for (series, criterion), then in before.items():
        now = after.get((series, criterion), then)
        if now is not then:
            direction = Direction.WORSE if rank(now) > rank(then) else Direction.BETTER
            size = max(rank(now), rank(then)) + abs(rank(now) - rank(then)) / 10
            yield Change(direction, Kind.VERDICT, *series, name=criterion, before=str(then), after=str(now), size=size)


def _outcomes(before: Tables, after: Tables) -> Iterator[Change]:
    for (series, level), then, now in _in_both(before.runs, after.runs):
        if (then.outcome == "completed") is not (now.outcome == "completed"):
            direction = Direction.WORSE if then.outcome == "completed" else Direction.BETTER
            yield Change(direction, Kind.OUTCOME, *series, level, before=then.outcome, after=now.outcome)


def _errors(before: Tables, after: Tables) -> Iterator[Change]:
    """Errors that changed by more than the regression gate allows; a non-finite error is worse than every finite one."""
    for (series, level, name), (then, size_then), (now, size_now) in _in_both(before.errors, after.errors):
        size = max(size_then, size_now)
        if not (math.isfinite(then) and math.isfinite(now)):
            worse, better, by = math.isfinite(then), math.isfinite(now), math.inf
        else:
            worse, better = rose(then, now, size), rose(now, then, size)
            by = _log_ratio(then, now, noise(size))
        if worse or better:
            direction = Direction.WORSE if worse else Direction.BETTER
            yield Change(direction, Kind.ERROR, *series, level, name, then, now, by)


def _orders(before: Tables, after: Tables, errors: Sequence[Change]) -> Iterator[Change]:
    """Orders over the same levels whose intervals do not overlap; only where an error changed, since else the cause is round-off."""
    changed = {(SeriesKey(c.study, c.case, c.solver, c.refinement), c.name) for c in errors}
    for key, then, now in _in_both(before.orders, after.orders):
        if key in changed and then.levels == now.levels and (now.high < then.low or then.high < now.low):
            direction = Direction.WORSE if now.high < then.low else Direction.BETTER
            was, is_ = (f"{fit.order:.3f} [{fit.low:.3f}, {fit.high:.3f}]" for fit in (then, now))
            yield Change(direction, Kind.ORDER, *key[0], "", key[1], was, is_, abs(now.order - then.order))


def _steps(before: Tables, after: Tables) -> Iterator[Change]:
    """Changed numbers of steps: unlike seconds they are exact, and more steps are slower on every machine."""
    for (series, level), then, now in _completed(before, after):
        for name, was, is_ in (("steps", then.steps, now.steps), ("point-steps", then.point_steps, now.point_steps)):
            if was != is_:
                direction = Direction.SLOWER if is_ > was else Direction.FASTER
                yield Change(direction, Kind.STEPS, *series, level, name, was, is_, _log_ratio(was, is_, 1))
                break


def _seconds(before: Tables, after: Tables) -> Iterator[Change]:
    """Solvers that are slower or faster on a study: in the sum of their runs and in at least `SLOWER_SHARE` of the runs."""
    timed: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for (series, _), then, now in _completed(before, after):
        timed.setdefault((series.study, series.solver), []).append((then.seconds, now.seconds))
    for (study, solver), pairs in timed.items():
        was, is_ = (math.fsum(column) for column in zip(*pairs, strict=True))
        compared = [*pairs, (max(was, SECONDS), max(is_, SECONDS))]
        slower, faster = ([b > SLOWER * a for a, b in compared], [a > SLOWER * b for a, b in compared])
        for direction, (*runs, together) in ((Direction.SLOWER, slower), (Direction.FASTER, faster)):
            if together and sum(runs) >= SLOWER_SHARE * len(runs):
                size = _log_ratio(was, is_, SECONDS)
                yield Change(direction, Kind.SECONDS, study, solver=solver, before=was, after=is_, size=size)


def _log_ratio(then: float, now: float, least: float) -> float:
    """Log of the ratio of two numbers, the larger over the smaller; numbers below `least` are replaced by it."""
    return abs(math.log(max(now, least)) - math.log(max(then, least)))


def _completed(before: Tables, after: Tables) -> Iterator[tuple[tuple[SeriesKey, str], Run, Run]]:
    for key, then, now in _in_both(before.runs, after.runs):
        if then.outcome == now.outcome == "completed":
            yield key, then, now


def _in_both(before: Mapping[K, V], after: Mapping[K, V]) -> Iterator[tuple[K, V, V]]:
    for key, then in before.items():
        if key in after:
            yield key, then, after[key]


def _distinct(tables: Tables) -> dict[str, tuple[str, ...]]:
    return {name: tuple(sorted({study[name] for study in tables.provenance.values()})) for name in PROVENANCE}


def _cautions(before: Tables, after: Tables) -> Iterator[str]:
    for name, tables in (("A", before), ("B", after)):
        seen = _distinct(tables)
        if len(seen["commit"]) > 1:
            yield f"{name} holds studies of {len(seen['commit'])} commits: run them all again to compare commits"
        if "dirty" in seen["commit_state"]:
            yield f"{name} was made with uncommitted changes: its commit does not say all that was run"
    common = [(then, now) for _, then, now in _in_both(before.provenance, after.provenance)]
    tiers = {f"{then['tier']} and {now['tier']}" for then, now in common if then["tier"] != now["tier"]}
    if tiers:
        yield f"the tiers differ ({', '.join(sorted(tiers))}): levels that one of them lacks are not compared"
    for name, what in (("versions", "libraries or machines"), ("platform", "platforms")):
        differing = {pair for then, now in common for pair in _unequal(then[name], now[name])}
        if differing:
            yield f"the {what} differ ({'; '.join(sorted(differing))}): seconds are not comparable"


def _unequal(then: str, now: str) -> list[str]:
    """Difference of two comma-separated lists as "old -> new"; empty if they have the same entries."""
    was, is_ = then.split(", "), now.split(", ")
    pair = ([entry for entry in was if entry not in is_], [entry for entry in is_ if entry not in was])
    return [" -> ".join(", ".join(entries) or "nothing" for entries in pair)] if any(pair) else []
