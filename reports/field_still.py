"""Fields as static pictures in SVG: what a page shows without scripts and in print, and what an overview shows of a study."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from . import field_points, fields
from .colours import PALETTES, Map, mixed
from .fields import Quantity, Scale
from .notation import cell_size, count, in_unit, number, size, unit
from .record import Array, Field

POINTS, TONES = 900, 33
"""Largest number of points in each view of a picture, and number of its colours."""
WIDTH, GAP, LEFT, BOTTOM, TOP, BAR = 960.0, 28.0, 44.0, 40.0, 24.0, 44.0
"""Sizes of the picture in SVG units: its width, the gap between views, and the room for labels and for a bar of colours."""
PAPER = PALETTES["light"]
AXES = "xyz"


@dataclass(frozen=True)
class Frame:
    """A plot of two axes: the corners of its box (2,) [m], its upper left corner and the SVG units per metre."""

    low: Array
    high: Array
    left: float
    top: float
    factor: float

    @property
    def width(self) -> float:
        return float(self.high[0] - self.low[0]) * self.factor

    @property
    def height(self) -> float:
        return float(self.high[1] - self.low[1]) * self.factor

    def place(self, positions: Array) -> Array:
        """Return the SVG coordinates (P, 2) of positions (P, 2) [m]."""
        across = self.left + (positions[:, 0] - self.low[0]) * self.factor
        down = self.top + (self.high[1] - positions[:, 1]) * self.factor
        return np.stack([across, down], axis=1)


@dataclass(frozen=True)
class Cut:
    """The part of a field that is drawn: its points, the two axes of the picture, and the place of a slice in words."""

    points: NDArray[np.intp]
    axes: tuple[int, int]
    words: str


def main_quantity(field: Field, shown: str) -> str:
    """Return the key of the quantity that is drawn first: of the group `shown`, unless its exact field is lost in the error."""
    every = fields.quantities(field)
    first = {entry.group: entry for entry in reversed(every)}
    ranked = sorted(first.values(), key=lambda entry: (entry.group != shown, every.index(entry)))
    return next((entry.key for entry in ranked if _told(entry)), ranked[0].key)


def _told(quantity: Quantity) -> bool:
    if quantity.exact is None or quantity.error is None:
        return True
    error = np.abs(quantity.error[np.isfinite(quantity.error)])
    typical = float(np.quantile(error, 0.5)) if error.size else 0.0
    known = quantity.exact[np.isfinite(quantity.exact)]
    return bool(known.size) and float(np.abs(known).max()) > typical


def cut(field: Field, most: int) -> Cut:
    """Return at most `most` points of a plane field, or of the middle layer of a spatial one across its thinnest axis."""
    if field.dimension == 2:
        return Cut(field_points.subsample(field.reference, most), (0, 1), "")
    across = field_points.thinnest(field.reference)
    layer = field_points.spacing(field.reference, field.h)
    depth = field.reference[:, across]
    middle = float(depth[np.argmin(np.abs(depth - (depth.min() + depth.max()) / 2))])
    inside = np.flatnonzero(np.abs(depth - middle) <= layer / 2)
    first, second = (k for k in range(3) if k != across)
    points = inside[field_points.subsample(field.reference[inside], most)]
    return Cut(points, (first, second), f"; slice across {AXES[across]} at {AXES[across].upper()} = {number(middle)} m")


def field_still(field: Field, key: str) -> tuple[str, str]:
    """Draw the numerical field, the exact one and their difference at one output time.

    Parameters
    ----------
    field : Field
    key : str
        Key of the quantity.

    Returns
    -------
    str
        SVG.
    str
        Caption, without the name of the series.
    """
    every = fields.quantities(field)
    quantity = next(entry for entry in every if entry.key == key)
    row, part = fields.telling(quantity, np.arange(len(field.time))), cut(field, POINTS)
    scale = fields.scale(quantity, fields.size_of_group(quantity.group, every))
    views: list[tuple[str, Array, Array, Scale]] = [
        ("numerical", field_points.positions(field)[row], quantity.numerical[row], scale),
    ]
    if quantity.exact is not None and quantity.error is not None:
        error = fields.held_error(quantity, fields.size_of_group(quantity.group, every))
        reach = float(np.abs(error[np.isfinite(error)]).max(initial=0.0))
        views.append(("exact", field_points.positions(field, exact=True)[row], quantity.exact[row], scale))
        views.append(("numerical − exact", views[0][1], error[row], Scale(-reach, reach, True)))
    layer = field_points.spacing(field.reference[part.points][:, part.axes], field.h)
    low, high = (corner[list(part.axes)] for corner in field_points.view(field, layer))
    frames, height = _frames(low, high, len(views))
    body: list[str] = []
    for frame, (title, places, values, colours) in zip(frames, views, strict=True):
        body += _axes(frame, title, [AXES[axis] for axis in part.axes])
        chosen = places[part.points][:, part.axes]
        body += dots(frame.place(chosen), values[part.points], colours, layer * frame.factor)
        body += _bar(frame, colours, quantity.units)
    missing = int((~np.isfinite(quantity.numerical[row][part.points])).sum())
    points = "1 point" if missing == 1 else f"{count(missing)} points"
    notes = f"; crosses: {points} whose value is not finite" if missing else ""
    caption = (
        f"{quantity.name}{_bracket(quantity.units)} at t = {size(float(field.time[row]))} s, level h = {cell_size(field.h)} m, "
        f"{count(len(part.points))} of {count(len(field.reference))} points drawn{part.words}{notes}"
    )
    return f'<svg class="field-picture" viewBox="0 0 {WIDTH:g} {height:.0f}" aria-hidden="true">{"".join(body)}</svg>', caption


def _bracket(units: str) -> str:
    return f" [{unit(units)}]" if unit(units) else ""


def _frames(low: Array, high: Array, views: int) -> tuple[list[Frame], float]:
    """Return the frames of the views, beside one another unless the body is long, and the height of the picture."""
    extent = high - low
    beside = extent[0] < 2.4 * extent[1]
    columns = views if beside else 1
    room = WIDTH / columns - LEFT - GAP
    factor = min(room / extent[0], (360.0 if beside else 240.0) / extent[1])
    step = extent[1] * factor + TOP + BOTTOM + BAR
    frames = [
        Frame(low, high, LEFT + (k * WIDTH / columns if beside else 0.0), TOP + (0.0 if beside else k * step), factor)
        for k in range(views)
    ]
    return frames, step * (1 if beside else views)


def dots(places: Array, values: Array, scale: Scale, diameter: float) -> Iterator[str]:
    """Yield one path for each colour: every point is a line of no length with round ends, in tenths of a unit."""
    stops: Map = PAPER.signed if scale.signed else PAPER.rising
    width = scale.high - scale.low
    finite = np.isfinite(values)
    share = np.where(finite, values - scale.low, 0.0) / width if width > 0 else np.full(len(values), 0.5)
    tone = np.round(share.clip(0, 1) * (TONES - 1)).astype(int)
    tenths = np.round(places * 10).astype(int)
    yield f'<g transform="scale(.1)" fill="none" stroke-linecap="round" stroke-width="{10 * max(diameter, 1.5):.0f}">'
    for k in np.unique(tone[finite]).tolist():
        mine = tenths[finite & (tone == k)]
        steps = np.diff(mine, axis=0).tolist()
        path = f"M{mine[0][0]} {mine[0][1]}h0" + "".join(f"m{x} {y}h0" for x, y in steps)
        yield f'<path stroke="{mixed(stops, k / (TONES - 1))}" d="{path}"/>'
    if not finite.all():
        crosses = "".join(f"M{x - 30} {y - 30}l60 60m0-60l-60 60" for x, y in tenths[~finite].tolist())
        yield f'<path stroke="{PAPER.missing}" stroke-width="15" d="{crosses}"/>'
    yield "</g>"


def _axes(frame: Frame, title: str, names: Sequence[str]) -> Iterator[str]:
    base, end = frame.top + frame.height, frame.left + frame.width
    yield f'<path class="grid" fill="none" d="M{frame.left:.1f} {frame.top:.1f}V{base:.1f}H{end:.1f}"/>'
    yield f'<text class="title" x="{frame.left:.1f}" y="{frame.top - 8:.1f}">{escape(title)}</text>'
    for value in ticks(float(frame.low[0]), float(frame.high[0]), max(2, int(frame.width / 55))):
        x = frame.left + (value - float(frame.low[0])) * frame.factor
        yield f'<text x="{x:.1f}" y="{base + 14:.1f}" text-anchor="middle">{size(value)}</text>'
    for value in ticks(float(frame.low[1]), float(frame.high[1]), max(2, int(frame.height / 40))):
        y = frame.top + (float(frame.high[1]) - value) * frame.factor
        yield f'<text x="{frame.left - 5:.1f}" y="{y + 4:.1f}" text-anchor="end">{size(value)}</text>'
    yield f'<text x="{end:.1f}" y="{base + 28:.1f}" text-anchor="end">{names[0]} [m]</text>'
    yield f'<text x="{frame.left - 5:.1f}" y="{frame.top - 8:.1f}" text-anchor="end">{names[1]} [m]</text>'


def ticks(low: float, high: float, most: int) -> list[float]:
    """Return at most about `most` round numbers between two ends, evenly spaced."""
    raw = (high - low) / most
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= raw)
    return [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]


def _bar(frame: Frame, scale: Scale, units: str) -> Iterator[str]:
    stops: Map = PAPER.signed if scale.signed else PAPER.rising
    top, width = frame.top + frame.height + BOTTOM, max(frame.width, 120.0)
    for k in range(TONES):
        paint = mixed(stops, k / (TONES - 1))
        yield f'<path fill="{paint}" d="M{frame.left + k * width / TONES:.1f} {top:.1f}h{width / TONES + 0.5:.1f}v8h{-width / TONES - 0.5:.1f}Z"/>'
    ends = ((0.0, scale.low, "start"), (0.5, (scale.low + scale.high) / 2, "middle"), (1.0, scale.high, "end"))
    for share, value, anchor in ends:
        shown = in_unit(number(value), units) if share == 1 else number(value)
        yield f'<text x="{frame.left + share * width:.1f}" y="{top + 22:.1f}" text-anchor="{anchor}">{shown}</text>'
