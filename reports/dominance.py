"""Sources of error: their table, and maps of the dominating source over the planes of a design."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.axis import UNITS
from mpmverify.convergence.sources import REST, Separation, Source

from .charts import DIVERGING, INK, MUTED, Figure, axis, layout, sig
from .notation import DASH, NORM_NAMES, cell_size, in_unit, interval, ladder, number, order, size
from .parts import SourceRow
from .record import Array, Level, Measure, Series

CELLS = 48
"""Number of cells along each side of a map."""
DECADES = 2.0
"""Power of ten of the ratio of two sources at which the colour scale ends."""
PLANES = (("h", "dt"), ("h", "ppc"))
MARKERS = {"h": "circle", "dt": "square", "1/ppc": "diamond", "h/ppc": "diamond"}
"""Marker of a run, by its dominating source."""


@dataclass(frozen=True)
class Plane:
    """Ratio of two sources over the plane that a design spans.

    Parameters
    ----------
    x, y : str
        Sizes on the axes: h, and dt or ppc.
    x_values, y_values : Array
        Values on the axes (N,) and (M,).
    first, second : str
        Sizes of the two sources.
    ratio : Array
        Log10 of the second source divided by the first (M, N).
    """

    x: str
    y: str
    x_values: Array
    y_values: Array
    first: str
    second: str
    ratio: Array


def magnitude(source: Source, h: Array, dt: Array, ppc: Array) -> Array:
    """Return the relative error from a source that is seen; h [m], dt [s] and ppc are arrays of one shape."""
    sizes = {"h": h, "dt": dt, "1/ppc": 1 / ppc, "h/ppc": h / ppc}
    return np.asarray(source.amplitude * sizes[source.size] ** source.exponent, dtype=float)


def planes(levels: Sequence[Level], separation: Separation) -> Iterator[Plane]:
    """Yield the planes of a design in which the sources on both axes are seen."""
    seen = {source.size: source for source in separation.sources if source.seen and source.size != REST}
    by_axis = {"h": seen.get("h"), "dt": seen.get("dt"), "ppc": seen.get("h/ppc") or seen.get("1/ppc")}
    for x, y in PLANES:
        first, second = by_axis[x], by_axis[y]
        if separation.obstacle or first is None or second is None:
            continue
        x_values, y_values = (_span([getattr(level, name) for level in levels]) for name in (x, y))
        h, other = np.meshgrid(x_values, y_values)
        # The two sources depend only on the sizes on the axes: the third size may have any value.
        dt, ppc = (other, np.ones_like(h)) if y == "dt" else (np.ones_like(h), other)
        ratio = np.log10(magnitude(second, h, dt, ppc) / magnitude(first, h, dt, ppc))
        yield Plane(x, y, x_values, y_values, first.size, second.size, ratio)


def _span(values: Sequence[float]) -> Array:
    """Return logarithmically spaced values over the range of a design, extended by 12 % of its logarithm at either end."""
    low, high = math.log(min(values)), math.log(max(values))
    room = 0.12 * (high - low)
    return np.exp(np.linspace(low - room, high + room, CELLS))


def maps(series: Sequence[Series]) -> list[Figure]:
    """Return the dominance maps of the designs of a case, with their titles."""
    return [
        _map(entry, measure, separation, plane)
        for entry in series
        for measure, separation in entry.separations.items()
        for plane in planes(entry.levels, separation)
    ]


def _map(entry: Series, measure: Measure, separation: Separation, plane: Plane) -> Figure:
    grid = {"x": [sig(value) for value in plane.x_values], "y": [sig(value) for value in plane.y_values]}
    ratio = [[sig(value, 3) for value in row] for row in plane.ratio]
    powers = range(-int(DECADES), int(DECADES) + 1)
    heat = {
        "type": "heatmap",
        "z": ratio,
        "zmin": -DECADES,
        "zmax": DECADES,
        "colorscale": DIVERGING,
        "hovertemplate": f"{plane.x} = %{{x}}<br>{plane.y} = %{{y}}<br>log₁₀ of {plane.second} over {plane.first}: %{{z}}<extra></extra>",
        "colorbar": {
            "thickness": 10,
            "outlinewidth": 0,
            "tickvals": list(powers),
            "ticktext": [_tick_label(power, plane) for power in powers],
            "tickfont": {"color": MUTED},
        },
    }
    equal = {
        "type": "contour",
        "z": ratio,
        "showscale": False,
        "hoverinfo": "skip",
        "contours": {"type": "constraint", "operation": "=", "value": 0, "coloring": "none"},
        "line": {"color": INK, "width": 1.6, "dash": "dash"},
    }
    ticks = {name: sorted({float(getattr(level, name)) for level in entry.levels}) for name in (plane.x, plane.y)}
    units = {"ppc": "1"} | dict(UNITS)

    def side(name: str) -> Figure:
        text = [cell_size(value) if name == "h" else size(value) for value in ticks[name]]
        shown = {"tickvals": [sig(value) for value in ticks[name]], "ticktext": text}
        return axis(in_unit(name, units[name]), type="log", **shown)

    return {
        "data": [heat | grid, equal | grid, _runs(entry, measure, separation, plane)],
        "layout": layout(xaxis=side(plane.x), yaxis=side(plane.y), margin={"l": 64, "r": 8, "t": 12, "b": 48}),
        "title": f"{entry.solver}, {ladder(entry.refinement)}: {_error(measure)} over {plane.x} and {plane.y}",
    }


def _tick_label(power: int, plane: Plane) -> str:
    """Return the label of a tick of the colour bar, such as "dt ×10"."""
    if power == 0:
        return "equal"
    return f"{plane.second if power > 0 else plane.first} ×{10 ** abs(power)}"


def _runs(entry: Series, measure: Measure, separation: Separation, plane: Plane) -> Figure:
    """Return the runs of the design, marked by their dominating source."""
    seen = [source for source in separation.sources if source.seen]
    h, dt, ppc = (np.array([getattr(level, name) for level in entry.levels], dtype=float) for name in ("h", "dt", "ppc"))
    parts = np.array([magnitude(source, h, dt, ppc) for source in seen])
    leading = [seen[k].size for k in np.argmax(parts, axis=0)]
    notes = [
        f"h = {cell_size(level.h)} m, dt = {size(level.dt)} s, {level.ppc} ppc<br>relative error {number(error)}, {name} dominates<br>"
        + ", ".join(f"{source.size}: {number(part)}" for source, part in zip(seen, column, strict=True))
        for level, error, name, column in zip(entry.levels, entry.estimates[measure].error, leading, parts.T, strict=True)
    ]
    return {
        "type": "scatter",
        "mode": "markers",
        "x": [sig(getattr(level, plane.x)) for level in entry.levels],
        "y": [sig(getattr(level, plane.y)) for level in entry.levels],
        "text": notes,
        "hovertemplate": "%{text}<extra></extra>",
        "marker": {
            "size": 11,
            "symbol": [MARKERS[name] for name in leading],
            "color": [
                DIVERGING[-1 if name == plane.second else 0][1] if name in (plane.first, plane.second) else INK
                for name in leading
            ],
            "line": {"color": "#ffffff", "width": 1.5},
        },
    }


def _error(measure: Measure) -> str:
    return f"{measure[0]}, {NORM_NAMES.get(measure[1], measure[1])}"


def source_rows(series: Sequence[Series]) -> tuple[SourceRow, ...]:
    """Return the rows of the table of error sources of a case."""
    return tuple(
        row
        for entry in series
        for measure, separation in entry.separations.items()
        for row in _rows(entry, measure, separation)
    )


def _rows(entry: Series, measure: Measure, separation: Separation) -> Iterator[SourceRow]:
    where = (entry.solver, ladder(entry.refinement), _error(measure))
    if not separation.sources:
        yield SourceRow(*where, DASH, DASH, DASH, DASH, separation.obstacle)
    cosines = "".join(f", cos({one}, {other}) = {order(value)}" for (one, other), value in separation.cosine.items())
    fit = separation.obstacle or f"residual {separation.residual:.1%}{cosines}"
    for source in separation.sources:
        if not source.seen:
            yield SourceRow(*where, source.size, "not seen", DASH, DASH, fit)
        else:
            constant = source.size == REST
            low_to_high = DASH if constant else interval(source.low, source.high)
            yield SourceRow(
                *where, source.size, DASH if constant else order(source.exponent), low_to_high, f"{source.share:.0%}", fit
            )
