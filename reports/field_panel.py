"""The panel of a case in two or three dimensions: points where they are, coloured by a quantity."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
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
from .record import Array, Case, Field, Record, Series

BYTES_PER_VALUE = 8 / 3
"""Characters that one value of 16 bits takes in base64."""
STILL = 45_000
"""Characters that the static picture of a case takes at most, about."""
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


def points_within_budget(record: Record, room: int) -> int:
    """Return how many points of each field a page may show so that the fields take at most `room` characters of it."""
    every = [entry.spatial for entry in record.series if entry.spatial]
    room -= STILL * len({entry.case for entry in record.series if entry.spatial})
    loads = [(len(f.reference), len(field_points.outputs(f)) * _values_per_point(f) * BYTES_PER_VALUE) for f in every]
    most = max((points for points, _ in loads), default=1)
    while most > 64 and sum(min(points, most) * load for points, load in loads) > room:
        most = int(most * 0.9)
    return most


def _values_per_point(field: Field) -> int:
    return field.dimension + sum(1 if entry.error is None else 2 for entry in fields.quantities(field))


def field_panel(case: Case, series: Sequence[Series], first: Sequence[int], most: int) -> FieldPanel | None:
    """Make the panel of a case.

    Parameters
    ----------
    case : Case
    series : sequence of Series
        All series of the case.
    first : sequence of int
        Numbers of the series that the page draws at first.
    most : int
        Largest number of points of each field.

    Returns
    -------
    FieldPanel or None
        None if no series has a field in two or three dimensions.
    """
    kept = [(k, entry, entry.spatial) for k, entry in enumerate(series) if entry.spatial and entry.spatial.numerical]
    if not kept:
        return None
    chosen = next((row for row, (k, _, _) in enumerate(kept) if k in first), 0)
    known: dict[str, Quantity] = {q.key: q for _, _, field in kept for q in fields.quantities(field)}
    shown = main_quantity(kept[chosen][2], case.shown)
    three = kept[chosen][2].dimension == 3
    names = [f"{entry.solver}, {ladder(entry.refinement)}" for _, entry, _ in kept]
    body = {
        "palettes": {page: asdict(palette) for page, palette in PALETTES.items()},
        "quantities": {key: {"name": q.name, "unit": unit(q.units)} for key, q in known.items()},
        "series": [_figure(field, most) for _, _, field in kept],
    }
    still, caption = field_still(kept[chosen][2], shown)
    return FieldPanel(
        series=tuple(Option(str(row), name, row == chosen) for row, name in enumerate(names)),
        quantities=tuple(Option(key, q.name, key == shown) for key, q in known.items()),
        views=tuple(_views(kept[chosen][2])) if three else (),
        still=still,
        still_caption=f"{names[chosen]}: {caption}",
        description=f"Points of {case.name} at their current positions, coloured by the chosen quantity",
        data=escaped(body),
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


def _figure(field: Field, most: int) -> dict[str, Any]:
    """Return the data of one series: shown points, output times, reference positions, view and quantities."""
    points, rows = field_points.subsample(field.reference, most), field_points.outputs(field)
    reference = field.reference[points]
    layer = field_points.spacing(reference, field.h)
    every = fields.quantities(field)
    lows, highs = field_points.view(field, layer)
    return {
        "h": cell_size(field.h),
        "t": [sig(t) for t in field.time[rows]],
        "shown": len(points),
        "count": f"{count(len(points))} of {count(len(field.reference))} points shown",
        "spacing": sig(layer),
        "view": [[sig(low, 7), sig(high, 7)] for low, high in zip(lows, highs, strict=True)],
        "reference": [_packed(column) for column in reference.T],
        "fields": {quantity.key: _values(quantity, every, rows, points) for quantity in every},
    }


def _values(quantity: Quantity, every: Sequence[Quantity], rows: NDArray[np.intp], points: NDArray[np.intp]) -> dict[str, Any]:
    """Return a quantity: exact field and error, or the numerical field alone, with the scale of its colours."""
    size = fields.size_of_group(quantity, every)
    scale = fields.scale(quantity, size)
    part = np.ix_(rows, points)
    shown: dict[str, Any] = {"low": sig(scale.low, 7), "high": sig(scale.high, 7), "signed": scale.signed}
    if quantity.exact is None or quantity.error is None:
        return shown | {"numerical": _packed(quantity.numerical[part])}
    error = fields.held_error(quantity, size)[part]
    seen = np.abs(error[np.isfinite(error)])
    return shown | {
        "exact": _packed(quantity.exact[part]),
        "error": _packed(error),
        "reach": sig(float(seen.max(initial=0.0)), 7),
        "cut": int((error != quantity.error[part]).any(axis=0, where=np.isfinite(quantity.error[part])).sum()),
    }


def _packed(values: Array) -> dict[str, Any]:
    """Encode values as `charts.packed` does; a uniform field is its value alone."""
    if np.isfinite(values).all() and np.ptp(values) == 0:
        return {"low": float(values.flat[0]), "scale": 0, "data": ""}
    return packed(values)
