"""Cost per accuracy of a solver in each case, beside the nearest reference that ran the same case."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .cost_chart import Curve, chart
from .dossiers import Dossier, Entry
from .notation import NORM_NAMES, cell_size, count, ladder, number
from .orders import first_measure
from .parts import Link
from .record import Measure, Record, Series
from .solver_names import OWN, choices, family, page_of, plain_scheme
from .solver_parts import CostCase, CostRow

COSTS = {"seconds": "wall time [s]", "point_steps": "point-steps"}
"""Costs of a run: attributes of a level, with the titles of their axes."""
ROUND_OFF = 1e-10
"""Relative error below which a case tells nothing of the cost of accuracy."""
MEASURABLE = 1e-3
"""Wall time [s] below which a ratio of two times says more of the machine than of the solvers."""
MOST = 3
"""Largest number of ladders of a solver in one chart."""

Place = tuple[float, float]
"""(cost, error)."""


@dataclass(frozen=True)
class SameError:
    """Ratio of two costs at one error."""

    error: float
    ratio: float


def costs(dossier: Dossier) -> tuple[CostCase, ...]:
    """Return the cost per accuracy of every case in which the solver has an error that falls with a size."""
    table: dict[tuple[str, str], list[Entry]] = {}
    for entry in dossier.entries:
        table.setdefault((entry.record.name, entry.series.case), []).append(entry)
    return tuple(found for entries in table.values() if (found := _case(entries)))


def _case(entries: Sequence[Entry]) -> CostCase | None:
    record, case = entries[0].record, entries[0].series.case
    shown = next(one.shown for one in record.cases if one.name == case)
    measure = first_measure([entry.series for entry in entries if entry.series.axis], shown)
    mine = [entry.series for entry in entries if measure and _tells(entry.series, measure)][:MOST]
    if measure is None or not mine:
        return None
    beside = reference(record, mine[0], measure)
    drawn = [*mine, *([beside] if beside else [])]
    curves = {cost: [_curve(series, measure, cost, series is beside) for series in drawn] for cost in COSTS}
    error = f"relative error of {measure[0].replace('_', ' ')}, {NORM_NAMES.get(measure[1], measure[1])}"
    return CostCase(
        where=Link(f"{record.name}, {case}", entries[0].href),
        error=error,
        ladders=tuple(ladder(series.refinement) for series in mine),
        reference=Link(_named(beside), page_of(beside.solver, record.schemes[beside.solver])) if beside else None,
        charts=tuple(
            chart(curves[cost], title, f"{error}, against {title}") for cost, title in COSTS.items() if curves[cost][0].places
        ),
        comparison=" ".join(filter(None, [_compared(curves, beside) if beside else "", _missing(curves)])),
        rows=tuple(row for series in drawn for row in _rows(series, measure)),
    )


def reference(record: Record, mine: Series, measure: Measure) -> Series | None:
    """Return the series beside which a solver is shown.

    For a shipped solver, one of another family; for a stranger's, the shipped one with the nearest choices. Where none ran the case, any
    other solver. Among several, the one that declares most of the same orders, then the one with most of the same choices.
    """
    schemes = {name: plain_scheme(text) for name, text in record.schemes.items()}
    kinds = {name: family([scheme]) for name, scheme in schemes.items()}
    others = [
        series
        for series in record.series
        if series.case == mine.case and series.solver != mine.solver and _tells(series, measure)
    ]

    def near(series: Series) -> tuple[bool, bool, int, int]:
        shared = set(choices(schemes[series.solver])) & set(choices(schemes[mine.solver]))
        alike = set(series.formal.items()) & set(mine.formal.items())
        kind = kinds[series.solver]
        return kind not in (OWN, kinds[mine.solver]), series.axis == mine.axis, len(alike), len(shared)

    return max(others, key=near, default=None)  # the first of equals: the one that the study declares first


def modes_alone(series: Series) -> bool:
    """Whether a frequency or a stability limit alone is judged of a series.

    Its errors tell nothing: on a coarse grid a mode ends out of phase by many periods, and at the limit round-off decides how large the
    growing wave is.
    """
    return not series.bands and any(name.startswith(("phase_angle_", "stability_limit")) for name in series.metrics)


def _tells(series: Series, measure: Measure) -> bool:
    """Whether a series shows an error against a size: it has at least two errors, and not all at round-off."""
    estimate = series.estimates.get(measure)
    if estimate is None or not series.axis or modes_alone(series):
        return False
    known = estimate.error[np.isfinite(estimate.error) & (estimate.error > 0)]
    return len(known) > 1 and float(known.max()) > ROUND_OFF


def _curve(series: Series, measure: Measure, cost: str, beside: bool) -> Curve:
    return Curve(places([getattr(level, cost) for level in series.levels], series.estimates[measure].error.tolist()), beside)


def places(costs: Sequence[float], errors: Sequence[float]) -> tuple[Place, ...]:
    """Return the pairs of a cost and an error that are both positive and finite."""
    pairs = ((float(x), float(y)) for x, y in zip(costs, errors, strict=True))
    return tuple((x, y) for x, y in pairs if math.isfinite(x) and math.isfinite(y) and x > 0 and y > 0)


def _named(series: Series) -> str:
    return f"{series.solver}, {ladder(series.refinement)}"


def _compared(curves: dict[str, list[Curve]], beside: Series) -> str:
    """Say what an error costs that both the first ladder and the reference reach; "" if there is none or an error does not fall."""
    parts, errors = [], []
    for cost, name in (("seconds", "time"), ("point_steps", "point-steps")):
        found = at_same_error(curves[cost][0].places, curves[cost][-1].places, MEASURABLE if cost == "seconds" else 0.0)
        if found:
            errors.append(found.error)
            parts.append(f"{number(found.ratio, 2)} times the {name}")
    return f"An error of {number(errors[0], 2)} takes {' and '.join(parts)} of {beside.solver}." if parts else ""


def at_same_error(mine: Sequence[Place], theirs: Sequence[Place], least: float = 0.0) -> SameError | None:
    """Return the ratio of two costs at the smallest error that both reach, or None if there is no such error.

    Parameters
    ----------
    mine, theirs : sequence of (float, float)
        Costs with their errors, all positive, coarsest level first. Both errors must fall from level to level.
    least : float
        Cost below which a ratio tells nothing.

    Notes
    -----
    The cost of an error between two levels is interpolated in the logarithms of both.
    """
    if any(len(curve) < 2 or any(b >= a for (_, a), (_, b) in pairwise(curve)) for curve in (mine, theirs)):
        return None
    error = max(curve[-1][1] for curve in (mine, theirs))
    if error > min(curve[0][1] for curve in (mine, theirs)):
        return None
    spent = [_at(curve, error) for curve in (mine, theirs)]
    return SameError(error, spent[0] / spent[1]) if min(spent) >= least else None


def _missing(curves: dict[str, list[Curve]]) -> str:
    lacking = [title.partition(" [")[0] for cost, title in COSTS.items() if not curves[cost][0].places]
    return f"The solver returned no {' and no '.join(lacking)}." if lacking else ""


def _at(curve: Sequence[Place], error: float) -> float:
    """Return the cost of an error, from the logarithms of its neighbours."""
    table = np.log(sorted((y, x) for x, y in curve))
    return float(np.exp(np.interp(math.log(error), table[:, 0], table[:, 1])))


def _rows(series: Series, measure: Measure) -> Iterator[CostRow]:
    for level, size, error in zip(series.levels, series.sizes, series.estimates[measure].error, strict=True):
        yield CostRow(
            solver=series.solver,
            ladder=ladder(series.refinement),
            size=f"{series.axis} = {cell_size(size)}",
            error=number(float(error)),
            seconds=number(level.seconds, 2),
            point_steps=count(level.point_steps),
        )
