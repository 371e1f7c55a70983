"""Two solvers in the series that both ran: which belong together, and the ratios of their errors and costs."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median

from .cost import MEASURABLE, ROUND_OFF, SameError, at_same_error, modes_alone, places, reference
from .dossiers import Dossier, Entry
from .orders import first_measure
from .record import Estimate, Measure, Record
from .scorecard import ORDER, STALL

SAME_SIZE = 1e-9
"""Relative difference up to which two sizes are the same."""


@dataclass(frozen=True)
class Trial:
    """A series of a solver in one quantity and norm."""

    entry: Entry
    measure: Measure

    @property
    def place(self) -> tuple[str, str, Measure]:
        """Study, case and measure."""
        return self.entry.record.name, self.entry.series.case, self.measure

    @property
    def estimate(self) -> Estimate:
        return self.entry.series.estimates[self.measure]

    @cached_property
    def tells(self) -> bool:
        """Whether the sizes of the errors tell something."""
        return bool(self.entry.series.axis) and not modes_alone(self.entry.series)


@dataclass(frozen=True)
class Match:
    """Two series that are compared.

    Parameters
    ----------
    first, second : Trial
    level : (float, float, float) or None
        Finest common size with the errors of both; None if there is none, or if errors tell nothing.
    time, work : SameError or None
        Ratio of the wall times and of the point-steps at the same error.
    """

    first: Trial
    second: Trial
    level: tuple[float, float, float] | None
    time: SameError | None
    work: SameError | None

    @property
    def ratio(self) -> float:
        """Error of the first divided by that of the second."""
        return self.level[1] / self.level[2] if self.level else math.nan


def compared_measures(record: Record, case: str) -> tuple[Measure, ...]:
    """Return the measures in which series of a case are compared: those whose order is judged, and the one that is shown first."""
    series = [entry for entry in record.series if entry.case == case]
    judged = (
        (str(criterion["quantity"]), str(criterion["norm"]))
        for entry in series
        for criterion in entry.criteria.values()
        if criterion["type"] in (ORDER, STALL)
    )
    shown = first_measure(series, next(one.shown for one in record.cases if one.name == case))
    return tuple(dict.fromkeys([*judged, *([shown] if shown else [])]))


def trials(dossier: Dossier) -> Iterator[Trial]:
    """Yield the series of a solver in every measure in which they are compared."""
    for entry in dossier.entries:
        for measure in compared_measures(entry.record, entry.series.case):
            if measure in entry.series.estimates:
                yield Trial(entry, measure)


def matches(first: Sequence[Trial], second: Sequence[Trial]) -> tuple[Match, ...]:
    """Match the series of two solvers.

    Series of one case and measure belong together if their ladders have the same label. Where no labels are the same, the first
    ladders with the same axis do: a finite element has no particles per cell.
    """
    table: dict[tuple[str, str, Measure], list[Trial]] = {}
    for trial in second:
        table.setdefault(trial.place, []).append(trial)
    mine: dict[tuple[str, str, Measure], list[Trial]] = {}
    for trial in first:
        mine.setdefault(trial.place, []).append(trial)
    return tuple(
        _match(one, other)
        for place, members in mine.items()
        if place in table
        for one, other in _together(members, table[place])
    )


def _together(mine: Sequence[Trial], theirs: Sequence[Trial]) -> list[tuple[Trial, Trial]]:
    pairs = [(one, other) for one in mine for other in theirs]
    alike = [pair for pair in pairs if pair[0].entry.series.refinement == pair[1].entry.series.refinement]
    return alike or [pair for pair in pairs if pair[0].entry.series.axis == pair[1].entry.series.axis][:1]


def _match(first: Trial, second: Trial) -> Match:
    if not (first.tells and second.tells and first.entry.series.axis == second.entry.series.axis):
        return Match(first, second, None, None, None)
    errors = [[float(error) for error in trial.estimate.error] for trial in (first, second)]
    common = [
        (size, one, other)
        for size, one in zip(first.entry.series.sizes, errors[0], strict=True)
        for near, other in zip(second.entry.series.sizes, errors[1], strict=True)
        if abs(size - near) <= SAME_SIZE * size and math.isfinite(one + other) and min(one, other) > 0
    ]
    level = min(common, default=None)
    if level and max(level[1:]) <= ROUND_OFF:
        level = None
    if max(map(_largest, errors)) <= ROUND_OFF:
        return Match(first, second, level, None, None)
    time = at_same_error(_places(first, "seconds"), _places(second, "seconds"), MEASURABLE)
    work = at_same_error(_places(first, "point_steps"), _places(second, "point_steps"))
    return Match(first, second, level, time, work)


def _places(trial: Trial, cost: str) -> tuple[tuple[float, float], ...]:
    return places([getattr(level, cost) for level in trial.entry.series.levels], trial.estimate.error.tolist())


def _largest(errors: Sequence[float]) -> float:
    return max((error for error in errors if math.isfinite(error)), default=0.0)


def middle(ratios: Sequence[float]) -> float:
    """Return the median of the ratios that are known, on a logarithmic scale; NaN if there is none."""
    known = [math.log(ratio) for ratio in ratios if math.isfinite(ratio)]
    return math.exp(median(known)) if known else math.nan


def nearest(dossier: Dossier) -> str:
    """Return the solver that most cases name as the nearest reference of this one; "" if no other ran any of its cases."""
    named: Counter[str] = Counter()
    for trial in trials(dossier):
        series, record = trial.entry.series, trial.entry.record
        if record.schemes.get(dossier.solver) and (beside := reference(record, series, trial.measure)):
            named[beside.solver] += 1
    return next((solver for solver, _ in named.most_common(1)), "")
