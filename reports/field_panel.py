"""The panel of a case in two or three dimensions: points where they are, coloured by a quantity."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import field_points, fields
from .charts import packed, sig
from .colours import PALETTES
from .field_still import field_still, main_quantity
from .fields import Quantity
from .notation import cell_size, count, ladder, unit
from .parts import Option
from .record import Array, Field, Record, Series

STAGES, LAST = ((9, 4000), (5, 2000), (3, 1000)), (1, 250)
"""Output times of a field, and points that remain of a larger one, in the order in which a page gives them up for room."""
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class FieldPanel:
    """The panel "Field".

    Parameters
    ----------
    series : tuple of Option
        Series that have a field; the value is the row in `data`.
    quantities : tuple of Option
    views : tuple of Option
        Slices and the view of all points in three dimensions; empty in two.
    still : str
        SVG shown without scripts and in print.
    still_caption : str
    description : str
        What the picture shows, for readers who do not see it.
    data : str
        JSON of the points and their values, escaped for use in HTML.
    """

    series: tuple[Option, ...]
    quantities: tuple[Option, ...]
    views: tuple[Option, ...]
    still: str
    still_caption: str
    description: str
    data: str


@dataclass(frozen=True)
class _Body:
    """A series with a field, and the quantities of the field, each with the size of its group and its scale.

    Most solvers of a case have the same points, whose bytes tell so.
    """

    name: str
    field: Field
    points: bytes
    quantities: tuple[Quantity, ...]
    sizes: Mapping[str, float]
    scales: Mapping[str, fields.Scale]

    def values(self, outputs: int, most: int) -> int:
        """Return the number of values at no more than so many outputs and points."""
        return len(self.quantities) * min(len(self.field.time), outputs) * len(self.shown(most))

    def shown(self, most: int) -> NDArray[np.intp]:
        """Return the points that are shown of a field if no more than so many may be."""
        return _subsample(self.points, self.field.dimension, most)


def field_panels(record: Record, drawn: Mapping[str, Sequence[int]], room: int) -> dict[str, FieldPanel]:
    """Make the panels of a study, of as many points as fit into a page.

    Parameters
    ----------
    record : Record
    drawn : mapping of str to sequence of int
        Numbers of the series that the page draws at first, among those of their case.
    room : int
        Characters that the panels may take, about.

    Returns
    -------
    dict of str to FieldPanel
        Panels by case; a case without a field in two or three dimensions has none.
    """
    bodies: dict[str, list[_Body]] = {}
    first: dict[str, int] = {}
    for case in record.cases:
        series = [entry for entry in record.series if entry.case == case.name]
        kept = [(k, _body(entry, field)) for k, entry in enumerate(series) if (field := entry.spatial) and field.numerical]
        if kept:
            bodies[case.name] = [body for _, body in kept]
            first[case.name] = next((row for row, (k, _) in enumerate(kept) if k in drawn[case.name]), 0)
    shown = {
        case.name: main_quantity(bodies[case.name][first[case.name]].field, case.shown)
        for case in record.cases
        if case.name in bodies
    }
    stills = {name: field_still(bodies[name][row].field, shown[name]) for name, row in first.items()}
    room -= sum(len(picture) for picture, _ in stills.values())
    data = _data(bodies, shown, room)
    return {name: _panel(name, some, first[name], shown[name], stills[name], data[name]) for name, some in bodies.items()}


def _body(entry: Series, field: Field) -> _Body:
    quantities = fields.quantities(field)
    groups = {group: fields.size_of_group(group, quantities) for group in {quantity.group for quantity in quantities}}
    sizes = {quantity.key: groups[quantity.group] for quantity in quantities}
    scales = {quantity.key: fields.scale(quantity, sizes[quantity.key]) for quantity in quantities}
    name = f"{entry.solver}, {ladder(entry.refinement)}"
    return _Body(name, field, field.reference.tobytes(), quantities, sizes, scales)


@lru_cache(maxsize=512)
def _subsample(points: bytes, dimension: int, most: int) -> NDArray[np.intp]:
    return field_points.subsample(np.frombuffer(points).reshape(-1, dimension), most)


def _data(bodies: Mapping[str, Sequence[_Body]], shown: Mapping[str, str], room: int) -> dict[str, str]:
    """Return the data of every panel, with the same bounds on the output times and points of each field, such that all fit into the room."""
    every = [body for some in bodies.values() for body in some]
    longest = min(max((len(body.field.time) for body in every), default=1), field_points.OUTPUTS)
    largest = max((len(body.field.reference) for body in every), default=1)

    def encoded(outputs: int, most: int) -> tuple[dict[str, str], int]:
        data = {name: _text(some, shown[name], outputs, most) for name, some in bodies.items()}
        return data, sum(len(text) for text in data.values())

    data, whole = encoded(longest, largest)
    if whole <= room:
        return data
    each = whole / sum(body.values(longest, largest) for body in every)

    def predicted(outputs: int, most: int) -> float:
        return each * sum(body.values(outputs, most) for body in every)

    for outputs, fewest in (*(stage for stage in STAGES if stage[0] < longest), LAST):
        most = largest
        while most > fewest and predicted(outputs, most) > room:
            most = max(fewest, int(0.7 * most))
        if predicted(outputs, most) > room and (outputs, fewest) != LAST:
            continue
        # What several fields share is stored once, so that a part may take more than its share of the values.
        data, taken = encoded(outputs, most)
        while taken > room and most > fewest:
            most = max(fewest, int(0.9 * most))
            data, taken = encoded(outputs, most)
        if taken <= room:
            break
    return data


def _panel(name: str, bodies: Sequence[_Body], first: int, shown: str, still: tuple[str, str], data: str) -> FieldPanel:
    known = {quantity.key: quantity.name for body in bodies for quantity in body.quantities}
    field = bodies[first].field
    return FieldPanel(
        series=tuple(Option(str(row), body.name, row == first) for row, body in enumerate(bodies)),
        quantities=tuple(Option(key, text, key == shown) for key, text in known.items()),
        views=tuple(_views(field)) if field.dimension == 3 else (),
        still=still[0],
        still_caption=f"{bodies[first].name}: {still[1]}",
        description=f"Points of {name} at their current positions, coloured by the chosen quantity",
        data=data,
    )


def _text(bodies: Sequence[_Body], shown: str, outputs: int, most: int) -> str:
    """Return the JSON of a panel. Columns that are equal, such as the exact fields of several series, are stored once."""
    columns: dict[str, int] = {}
    series = [_figure(body, shown, outputs, most, columns) for body in bodies]
    known = {quantity.key: quantity for body in bodies for quantity in body.quantities}
    return escaped(
        {
            "palettes": {page: asdict(palette) for page, palette in PALETTES.items()},
            "quantities": {key: {"name": quantity.name, "unit": unit(quantity.units)} for key, quantity in known.items()},
            "series": series,
            "columns": [json.loads(column) for column in columns],
        }
    )


def _views(field: Field) -> Iterator[Option]:
    thin = field_points.thinnest(field.reference)
    for k, axis in enumerate(AXES):
        yield Option(str(k), f"Slice across {axis}", k == thin)
    yield Option("all", "All points", False)


def escaped(body: Mapping[str, Any]) -> str:
    """Return JSON without the characters that could end the script element or open a comment in it."""
    text = json.dumps(body, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _figure(body: _Body, shown: str, outputs: int, most: int, columns: dict[str, int]) -> dict[str, Any]:
    """Return the data of one series: shown points, output times, reference positions, view and quantities."""
    field = body.field
    points, rows = body.shown(most), field_points.outputs(field, outputs)
    reference = field.reference[points]
    layer = field_points.spacing(reference, field.h)
    lows, highs = field_points.view(field, layer)
    return {
        "h": cell_size(field.h),
        "t": [sig(t) for t in field.time[rows]],
        "start": next((fields.telling(q, rows) for q in body.quantities if q.key == shown), len(rows) - 1),
        "shown": len(points),
        "count": f"{count(len(points))} of {count(len(field.reference))} points shown",
        "spacing": sig(layer),
        "view": [[sig(low, 7), sig(high, 7)] for low, high in zip(lows, highs, strict=True)],
        "reference": [_number(column, columns) for column in reference.T],
        "fields": {q.key: _values(q, body, rows, points, columns) for q in body.quantities},
    }


def _values(
    quantity: Quantity,
    body: _Body,
    rows: NDArray[np.intp],
    points: NDArray[np.intp],
    columns: dict[str, int],
) -> dict[str, Any]:
    """Return a quantity: exact field and error, or the numerical field alone, with the scale of its colours."""
    size, scale = body.sizes[quantity.key], body.scales[quantity.key]
    part = np.ix_(rows, points)
    shown: dict[str, Any] = {"low": sig(scale.low, 7), "high": sig(scale.high, 7), "signed": scale.signed}
    if quantity.exact is None or quantity.error is None:
        return shown | {"numerical": _number(quantity.numerical[part], columns)}
    error, stored = fields.held_error(quantity, size)[part], quantity.error[part]
    seen = np.abs(error[np.isfinite(error)])
    return shown | {
        "exact": _number(quantity.exact[part], columns),
        "error": _number(error, columns),
        "reach": sig(float(seen.max(initial=0.0)), 7),
        "cut": int((error != stored).any(axis=0, where=np.isfinite(stored)).sum()),
    }


def _number(values: Array, columns: dict[str, int]) -> int:
    """Return the number of a column, encoded as `charts.packed` does; a uniform one is its value alone."""
    uniform = bool(np.isfinite(values).all()) and float(np.ptp(values)) == 0
    column = {"low": float(values.flat[0]), "scale": 0, "data": ""} if uniform else packed(values)
    return columns.setdefault(json.dumps(column, sort_keys=True), len(columns))
