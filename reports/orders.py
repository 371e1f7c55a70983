"""Tables of errors and orders of a case."""

from collections.abc import Sequence

from mpmverify.convergence.axis import UNITS

from .charts import key
from .notation import DASH, NORM_NAMES, cell_size, in_unit, interval, ladder, number, order, unit
from .overview import mark
from .parts import ErrorCell, Fact, OrderRow, OrderTable
from .record import Estimate, Level, Measure, Series


def measures(series: Sequence[Series]) -> list[Measure]:
    """Return the measures (quantity, norm) that any of the series has."""
    return list(dict.fromkeys(measure for entry in series for measure in entry.estimates))


def first_measure(series: Sequence[Series], shown: str) -> Measure | None:
    """Return the measure that a page shows first, or None if there is none.

    The first of these that exists: a judged measure of the quantity `shown`, its L2 error, any judged measure, any measure.
    """
    known = measures(series)
    judged = [measure for entry in series for measure in entry.bands if measure in known]
    ranked = sorted(judged, key=lambda measure: measure[0] != shown) if judged else known
    fallback = [measure for measure in known if measure == (shown, "L2")]
    if judged and (ranked[0][0] == shown or not fallback):
        return ranked[0]
    return next(iter(fallback or ranked), None)


def order_tables(series: Sequence[Series], shown: Measure | None) -> tuple[OrderTable, ...]:
    """Return one table for each measure and refined size; the page shows the tables of one measure at a time."""
    axes = dict.fromkeys(entry.axis for entry in series if entry.axis)
    by_axis = {name: [entry for entry in series if entry.axis == name] for name in axes}
    return tuple(
        _table(members, name, measure, measure == shown)
        for measure in measures(series)
        for name, members in by_axis.items()
        if measure in measures(members)
    )


def _table(series: Sequence[Series], axis: str, measure: Measure, shown: bool) -> OrderTable:
    quantity, norm = measure
    sizes = sorted({size for entry in series for size in entry.sizes}, reverse=True)
    rows = [_row(entry, measure, sizes) for entry in series if measure in entry.estimates or not entry.completed]
    dropped = [
        Fact(f"{entry.solver}, {ladder(entry.refinement)}", "; ".join(entry.estimates[measure].dropped))
        for entry in series
        if measure in entry.estimates and entry.estimates[measure].dropped
    ]
    caption = f"Relative error of {quantity}, {NORM_NAMES.get(norm, norm)}, with the observed order below"
    columns = tuple(Fact(cell_size(size), in_unit(f"{size:g}", UNITS[axis])) for size in sizes)
    return OrderTable(key(measure), caption, shown, axis, columns, tuple(rows), tuple(dropped))


def _row(entry: Series, measure: Measure, sizes: Sequence[float]) -> OrderRow:
    estimate = entry.estimates.get(measure)
    cells = {size: _cell(k, level, estimate) for k, (size, level) in enumerate(zip(entry.sizes, entry.levels, strict=True))}
    band, formal = entry.bands.get(measure), entry.formal.get(measure[0]) if entry.axis == "h" else None
    expected = interval(*band) if band else f"formal order {formal:g}" if formal is not None else DASH
    return OrderRow(
        solver=entry.solver,
        ladder=ladder(entry.refinement),
        mark=None if entry.passed else mark(entry.verified),
        cells=tuple(cells.get(size) for size in sizes),
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
