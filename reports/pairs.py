"""Two solvers in the series that both ran: which belong together, and the ratios of their errors and costs."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median

from .cost import MEASURABLE, ROUND_OFF, SameError, at_same_error, modes_alone, places, reference
from .dossiers import Dossier, Entry
from .orders import first_measure
from .record import Estimate, Measure, Record, Series
from .scorecard import ORDER, STALL
from .solver_names import subject

SAME_SIZE = 1e-6
"""Relative difference up to which two sizes are the same: more than that of the rounded sizes on a page."""


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


Compared = Mapping[tuple[str, str], tuple[Measure, ...]]
"""Measures in which series are compared, by (study, case)."""


def compared_measures(records: Sequence[Record]) -> Compared:
    """Return the measures in which series are compared: those whose order is judged, and the one that is shown first of a case."""
    table: dict[tuple[str, str], tuple[Measure, ...]] = {}
    for record in records:
        members: dict[str, list[Series]] = {}
        for series in record.series:
            members.setdefault(series.case, []).append(series)
        for case in record.cases:
            mine = members.get(case.name, [])
            judged = (
                (str(criterion["quantity"]), str(criterion["norm"]))
                for series in mine
                for criterion in series.criteria.values()
                if criterion["type"] in (ORDER, STALL)
            )
            shown = first_measure(mine, case.shown)
            table[record.name, case.name] = tuple(dict.fromkeys([*judged, *([shown] if shown else [])]))
    return table


def measured(entry: Entry, compared: Compared) -> tuple[Measure, ...]:
    """Return the measures in which a series is compared: it has errors in them that are above round-off, or an order is judged."""
    series = entry.series
    return tuple(
        measure
        for measure in compared.get((entry.record.name, series.case), ())
        if measure in series.estimates
        and (measure in series.bands or _largest(series.estimates[measure].error.tolist()) > ROUND_OFF)
    )


def trials(dossier: Dossier, compared: Compared) -> tuple[Trial, ...]:
    """Return the series of a solver in every measure in which they are compared."""
    return tuple(Trial(entry, measure) for entry in dossier.entries for measure in measured(entry, compared))


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


def nearest(mine: Sequence[Trial]) -> str:
    """Return the solver that most cases name as the nearest reference of one with these series; "" if no other ran any of its cases."""
    first = {trial.place[:2]: trial for trial in reversed(mine)}
    named: Counter[str] = Counter()
    for trial in first.values():
        if beside := reference(trial.entry.record, trial.entry.series, trial.measure):
            named[subject(beside.solver, trial.entry.record.schemes[beside.solver])] += 1
    return next((solver for solver, _ in named.most_common(1)), "")
