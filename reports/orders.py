"""Tables of errors and orders of a case."""

from collections.abc import Sequence

from .charts import key
from .notation import DASH, NORM_NAMES, cell_size, interval, ladder, number, order, unit
from .parts import ErrorCell, Fact, OrderRow, OrderTable
from .record import Estimate, Level, Measure, Series


def measures(series: Sequence[Series]) -> list[Measure]:
    """Quantities and norms that were measured on any of some series."""
    return list(dict.fromkeys(measure for entry in series for measure in entry.estimates))


def leading(series: Sequence[Series], shown: str) -> Measure | None:
    """Return the measure that a reader sees first: one whose order is judged, of the shown quantity if there is one."""
    known = measures(series)
    judged = [measure for entry in series for measure in entry.bands if measure in known]
    ranked = sorted(judged, key=lambda measure: measure[0] != shown) if judged else known
    fallback = [measure for measure in known if measure == (shown, "L2")]
    if judged and (ranked[0][0] == shown or not fallback):
        return ranked[0]
    return next(iter(fallback or ranked), None)


def order_tables(series: Sequence[Series], shown: Measure | None) -> tuple[OrderTable, ...]:
    """One table for each measure; the page shows one at a time."""
    return tuple(_table(series, measure, measure == shown) for measure in measures(series))


def _table(series: Sequence[Series], measure: Measure, shown: bool) -> OrderTable:
    quantity, norm = measure
    sizes = sorted({level.h for entry in series for level in entry.levels}, reverse=True)
    rows = [_row(entry, measure, sizes) for entry in series if measure in entry.estimates or not entry.completed]
    dropped = [
        Fact(f"{entry.solver}, {ladder(entry.refinement)}", "; ".join(entry.estimates[measure].dropped))
        for entry in series
        if measure in entry.estimates and entry.estimates[measure].dropped
    ]
    caption = f"Relative error of {quantity}, {NORM_NAMES.get(norm, norm)}; below it the observed order"
    return OrderTable(
        key(measure), caption, shown, tuple(Fact(cell_size(h), f"{h:g} m") for h in sizes), tuple(rows), tuple(dropped)
    )


def _row(entry: Series, measure: Measure, sizes: Sequence[float]) -> OrderRow:
    estimate = entry.estimates.get(measure)
    cells = {level.h: _cell(k, level, estimate) for k, level in enumerate(entry.levels)}
    band, formal = entry.bands.get(measure), entry.formal.get(measure[0])
    expected = interval(*band) if band else f"formally {formal:g}" if formal is not None else DASH
    return OrderRow(
        solver=entry.solver,
        ladder=ladder(entry.refinement),
        cells=tuple(cells.get(h) for h in sizes),
        order=order(estimate.order) if estimate else DASH,
        interval=interval(estimate.low, estimate.high) if estimate else DASH,
        expected=expected,
        classification=(estimate and estimate.classification) or "not analysed",
        floor=number(estimate.floor, 2) if estimate else DASH,
    )


def _cell(k: int, level: Level, estimate: Estimate | None) -> ErrorCell:
    if estimate is None or level.outcome != "completed":
        return ErrorCell(DASH, level.outcome, DASH, False)
    absolute = f"absolute {number(float(estimate.absolute[k]))} {unit(estimate.units)}".rstrip()
    absolute += "" if estimate.kept[k] else ", not in the fit"
    return ErrorCell(number(float(estimate.error[k])), absolute, order(float(estimate.pairwise[k])), estimate.kept[k])
