"""Scorecard of a solver: every measured order as a strip on one axis, by study."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any
from urllib.parse import quote

from .dossiers import Dossier, Entry, mark_of
from .notation import DASH, NORM_NAMES, interval, ladder, order
from .parts import Link
from .solver_parts import OrderStrip, StudyOrders
from .strips import AXIS, Ends, strip

ORDER, STALL = "Order", "Stall"
"""Criteria on orders: one accepts a band, the other expects that the error does not fall."""
UNKNOWN = (math.nan, math.nan)


def scorecard(dossier: Dossier) -> tuple[StudyOrders, ...]:
    """Return a strip for every order that was judged, by study; a run that failed leaves the strip without a marker."""
    table: dict[str, list[OrderStrip]] = {}
    titles = {record.name: str(record.attributes["title"]) for record in dossier.records}
    for entry in dossier.entries:
        found = [replace(one, again=k > 0) for k, one in enumerate(_strips(entry))]
        table.setdefault(entry.record.name, []).extend(found)
    return tuple(
        StudyOrders(Link(titles[name], f"{quote(name)}.html"), tuple(strips)) for name, strips in table.items() if strips
    )


def measured_orders(dossier: Dossier) -> list[float]:
    """Return all orders for which a band is accepted."""
    return [
        entry.series.estimates[measure].order
        for entry in dossier.entries
        for measure in entry.series.bands
        if measure in entry.series.estimates and math.isfinite(entry.series.estimates[measure].order)
    ]


def _strips(entry: Entry) -> Iterator[OrderStrip]:
    for title, criterion in entry.series.criteria.items():
        finding = entry.judged(title)
        if finding is None or criterion["type"] not in (ORDER, STALL):
            continue
        quantity, norm = str(criterion["quantity"]), str(criterion["norm"])
        measured, ends = measured_order(entry, criterion)
        band, accepted = accepted_orders(criterion)
        formal = entry.series.formal.get(quantity) if entry.series.axis == "h" else None
        yield OrderStrip(
            mark=mark_of(finding),
            again=False,
            case=entry.series.case,
            ladder=ladder(entry.series.refinement),
            quantity=quantity.replace("_", " "),
            norm=NORM_NAMES.get(norm, norm),
            href=entry.href,
            strip=strip(measured, ends, band, formal),
            order=order(measured),
            interval=interval(*ends),
            band=accepted,
            formal=DASH if formal is None else f"{formal:g}",
        )


def measured_order(entry: Entry, criterion: Mapping[str, Any]) -> tuple[float, Ends]:
    """Return an order with its interval: of the fit, or the last one between two levels where the error is expected to stall."""
    estimate = entry.series.estimates.get((criterion["quantity"], criterion["norm"]))
    if estimate is None:
        return math.nan, UNKNOWN
    if criterion["type"] == STALL:
        return float(estimate.pairwise[-1]), UNKNOWN
    return estimate.order, (estimate.low, estimate.high)


def accepted_orders(criterion: Mapping[str, Any]) -> tuple[Ends, str]:
    """Return the band that a criterion on an order accepts, also in words."""
    if criterion["type"] == STALL:
        return (AXIS[0], float(criterion["below"])), f"below {criterion['below']:g}"
    return (float(criterion["low"]), float(criterion["high"])), f"{criterion['low']:g} to {criterion['high']:g}"
