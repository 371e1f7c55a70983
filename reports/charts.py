"""Figures as dictionaries for plotly.js; colours refer to custom properties of the style sheet."""

import base64
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mpmverify.convergence.axis import UNITS as AXIS_UNITS

from .balances import Balance
from .notation import NORM_NAMES, cell_size, in_unit, ladder, number, order, unit
from .record import Array, Estimate, Measure, Profile, Series
from .styles import COLOURS, DASHES, Style

Figure = dict[str, Any]

POINTS, OUTPUTS = 160, 17
"""Largest numbers of points and output times that a page stores of a profile."""
BUDGET = 1_000_000
"""Number of profile values of a page beyond which fewer output times are stored.

Field and error take two bytes for each value, in base64: the profiles of a page are at most 2.7 MB of text.
"""
INK, MUTED, GRID = "var(--ink)", "var(--muted)", "var(--grid)"
SEQUENTIAL = [[0, "#0b1f4b"], [0.25, "#23558c"], [0.5, "#3f8f9e"], [0.75, "#8cc59a"], [1, "#f4efb6"]]
DIVERGING = [[0, "#1b4f8f"], [0.25, "#6fa3cf"], [0.5, "var(--neutral)"], [0.75, "#e08a5f"], [1, "#a3341c"]]


def sig(value: float, digits: int = 5) -> float | None:
    """Round to significant digits; return None for a non-finite value, which JSON cannot hold."""
    return float(f"{value:.{digits}g}") if math.isfinite(value) else None


def packed(values: Array) -> dict[str, Any]:
    """Encode values as 16-bit integers k in base64: `low + (k + 32767) scale`; k = -32768 stands for a non-finite value."""
    finite = np.isfinite(values)
    low, high = (float(values[finite].min()), float(values[finite].max())) if finite.any() else (0.0, 0.0)
    scale = (high - low) / 65534 or 1.0
    steps = np.where(finite, np.round((np.where(finite, values, low) - low) / scale) - 32767, -32768)
    return {"low": low, "scale": scale, "data": base64.b64encode(steps.astype("<i2").tobytes()).decode()}


def floats(values: Array) -> dict[str, str]:
    """Encode values in single precision, as plotly.js reads them."""
    return {"dtype": "f4", "bdata": base64.b64encode(np.asarray(values).astype("<f4").tobytes()).decode()}


def axis(title: str = "", **choices: Any) -> Figure:
    plain = {"gridcolor": GRID, "zerolinecolor": GRID, "linecolor": GRID, "exponentformat": "power", "automargin": True}
    return plain | {"title": {"text": title, "standoff": 8}} | choices


def layout(**choices: Any) -> Figure:
    plain = {
        "font": {"family": "var(--sans)", "size": 12, "color": MUTED},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "margin": {"l": 64, "r": 16, "t": 16, "b": 48},
        "showlegend": False,
        "hoverlabel": {"font": {"family": "var(--sans)", "size": 12}},
    }
    return plain | choices


def key(measure: Measure) -> str:
    return "|".join(measure)


def convergence(series: Sequence[Series], curve_styles: Sequence[Style], measures: Sequence[Measure]) -> Figure:
    """Chart the error of each series against the size that it refines, in every measure; the page shows one measure at a time.

    Notes
    -----
    The `meta` of a trace holds its measure and the number of its series; that of a reference slope or an accepted band holds
    `members`, the numbers of several series. Each refined size has its own horizontal axis; all share the vertical axis.
    """
    axes = list(dict.fromkeys(entry.axis for entry in series if entry.axis))
    data = [
        trace for measure in measures for name in axes for trace in _references(series, measure, name, _abscissa(axes, name))
    ]
    for k, (entry, style) in enumerate(zip(series, curve_styles, strict=True)):
        for measure, estimate in entry.estimates.items():
            if entry.axis:
                data.append(_errors(k, entry, style, measure, estimate) | {"xaxis": _abscissa(axes, entry.axis)})
    titles = {key(measure): f"relative error of {measure[0]}, {NORM_NAMES.get(measure[1], measure[1])}" for measure in measures}
    shape = layout(
        yaxis=axis(type="log", dtick=1),
        hovermode="closest",
    )
    for name in axes:
        shape[_abscissa(axes, name).replace("x", "xaxis")] = _sizes(series, axes, name)
    return {"data": data, "layout": shape, "titles": titles}


def _abscissa(axes: Sequence[str], name: str) -> str:
    """Return plotly's name of the horizontal axis of a size: "x", "x2" and so on."""
    return "x" if axes.index(name) == 0 else f"x{axes.index(name) + 1}"


def _sizes(series: Sequence[Series], axes: Sequence[str], name: str) -> Figure:
    """Return the horizontal axis of one size, beside those of the other sizes."""
    sizes = sorted({size for entry in series if entry.axis == name for size in entry.sizes if math.isfinite(size)})
    few = len(sizes) <= 10
    ticks = {"tickvals": [sig(size) for size in sizes], "ticktext": [cell_size(size) for size in sizes]} if few else {}
    place, gap = axes.index(name), 0.04 if len(axes) > 1 else 0.0
    domain = [(place + gap) / len(axes) if place else 0.0, (place + 1 - gap) / len(axes) if place + 1 < len(axes) else 1.0]
    return axis(in_unit(name, AXIS_UNITS[name]), type="log", domain=domain, **ticks)


def _errors(k: int, entry: Series, style: Style, measure: Measure, estimate: Estimate) -> Figure:
    name = f"{entry.solver}, {ladder(entry.refinement)}"
    notes = [
        f"{name}<br>{_value(entry.axis, size)}, error {number(error)}<br>order from the coarser level {order(pair)}"
        + ("" if kept else "<br>not in the fit")
        for size, error, pair, kept in zip(entry.sizes, estimate.error, estimate.pairwise, estimate.kept, strict=True)
    ]
    return {
        "type": "scatter",
        "mode": "lines+markers",
        "name": name,
        "x": [sig(size) for size in entry.sizes],
        "y": [sig(error) if error > 0 else None for error in estimate.error],
        "text": notes,
        "hovertemplate": "%{text}<extra></extra>",
        "line": {"color": style.paint, "dash": style.dash, "width": 1.8},
        "marker": {
            "color": style.paint,
            "size": 8,
            "line": {"width": 1.5, "color": style.paint},
            "symbol": [style.symbol if kept else f"{style.symbol}-open" for kept in estimate.kept],
        },
        "meta": {
            "measure": key(measure),
            "series": k,
            "order": order(estimate.order),
            "local": [sig(pair, 4) for pair in estimate.pairwise],
        },
    }


def _value(name: str, size: float) -> str:
    """Format a size with its name and unit: "h = 1/64 m"."""
    return f"{name} = {cell_size(size)} {unit(AXIS_UNITS[name])}".rstrip()


def _references(series: Sequence[Series], measure: Measure, size: str, abscissa: str) -> Iterator[Figure]:
    """Yield accepted bands as wedges, and formal orders as dashed lines where no band is declared, each below the errors of its series."""
    bands: dict[tuple[float, float], list[int]] = {}
    slopes: dict[float, list[int]] = {}
    for k, entry in enumerate(series):
        if measure in entry.estimates and entry.axis == size:
            if measure in entry.bands:
                bands.setdefault(entry.bands[measure], []).append(k)
            elif size == "h" and measure[0] in entry.formal:
                slopes.setdefault(float(entry.formal[measure[0]]), []).append(k)
    for (low, high), members in sorted(bands.items()):
        start = _start([series[k] for k in members], measure)
        if start:
            coarse, fine, error = start
            yield {
                "type": "scatter",
                "mode": "text",
                "hoverinfo": "skip",
                "text": ["", "", f"order {low:g} to {high:g}"],
                "textposition": "bottom right",
                "textfont": {"color": MUTED, "size": 11},
                "x": [sig(coarse), sig(fine), sig(fine)],
                "y": [sig(error), sig(error * (fine / coarse) ** low), sig(error * (fine / coarse) ** high)],
                "fill": "toself",
                "fillcolor": "var(--band)",
                "xaxis": abscissa,
                "meta": {"measure": key(measure), "members": members, "accepted": [low, high if math.isfinite(high) else None]},
            }
    for slope, members in sorted(slopes.items()):
        start = _start([series[k] for k in members], measure)
        if start:
            coarse, fine, error = start
            yield {
                "type": "scatter",
                "mode": "lines+text",
                "hoverinfo": "skip",
                "x": [sig(coarse), sig(fine)],
                "y": [sig(error), sig(error * (fine / coarse) ** slope)],
                "text": ["", f"order {slope:g}"],
                "textposition": "middle left",
                "textfont": {"color": MUTED, "size": 11},
                "cliponaxis": False,
                "line": {"color": MUTED, "dash": "dash", "width": 1},
                "xaxis": abscissa,
                "meta": {"measure": key(measure), "members": members, "accepted": [slope, slope]},
            }


def _start(series: Sequence[Series], measure: Measure) -> tuple[float, float, float] | None:
    """Return the largest and smallest size and the error at which a reference line starts; None if no error is usable."""
    sizes = [size for entry in series for size in entry.sizes]
    coarsest = [float(entry.estimates[measure].error[0]) for entry in series]
    usable = [error for error in coarsest if math.isfinite(error) and error > 1e-10]
    if not usable or min(sizes) == max(sizes):
        return None
    return max(sizes), min(sizes), 0.5 * float(np.quantile(usable, 0.25))


def waves(profile: Profile, outputs: int) -> Figure:
    """Return the data of the wave charts: profiles of the shown level of one series, at no more than `outputs` times."""
    rows = np.unique(np.round(np.linspace(0, len(profile.time) - 1, min(len(profile.time), outputs))).astype(int))
    every = math.ceil(len(profile.reference) / POINTS)
    fields = {}
    for quantity, values in profile.fields.items():
        value, error = values[rows, ::every], profile.error(quantity)[rows, ::every]
        finite = value[np.isfinite(value)]
        signed = bool(len(finite)) and float(finite.min()) < -0.05 * float(finite.max())
        fields[quantity] = {"value": packed(value), "error": packed(error), "signed": signed}
    return {"t": [sig(t) for t in profile.time[rows]], "x": [sig(x, 7) for x in profile.reference[::every]], "fields": fields}


def outputs_within_budget(profiles: Sequence[Profile]) -> int:
    """Return the number of output times that each profile of a page may have within the budget."""
    values = sum(field.size for profile in profiles for field in profile.fields.values())
    return OUTPUTS if values <= BUDGET else max(9, int(OUTPUTS * BUDGET / values))


def wave_figures(units: dict[str, str]) -> dict[str, Figure]:
    """Return the charts of each quantity, without data: profile and error at one time, and both over space and time."""
    return {quantity: _wave_figures(quantity, unit) for quantity, unit in units.items()}


def _wave_figures(quantity: str, unit: str) -> Figure:
    line = {"type": "scatter", "mode": "lines"}
    position = "reference position X [m]"
    bar = {"thickness": 10, "outlinewidth": 0, "exponentformat": "power", "tickfont": {"color": MUTED}}
    square = layout(xaxis=axis(position), yaxis=axis("t [s]"), margin={"l": 56, "r": 8, "t": 12, "b": 48})

    def heat(title: str, **colours: Any) -> Figure:
        colorbar = bar | {"title": {"text": in_unit(title, unit), "side": "right"}}
        hover = "X = %{x} m<br>t = %{y} s<br>%{z:.3~g}<extra></extra>"
        return {"type": "heatmap", "colorbar": colorbar, "hovertemplate": hover} | colours

    return {
        "profile": {
            "data": [
                line | {"name": "exact", "line": {"color": INK, "width": 1.2, "dash": "dash"}},
                line | {"name": "numerical", "mode": "lines+markers", "marker": {"size": 4}, "line": {"width": 1.8}},
                line | {"name": "numerical − exact", "yaxis": "y2", "line": {"width": 1.4}},
            ],
            "layout": layout(
                xaxis=axis(position, anchor="y2"),
                yaxis=axis(in_unit(quantity, unit), domain=[0.36, 1]),
                yaxis2=axis(in_unit("error", unit), domain=[0, 0.26]),
                showlegend=True,
                legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
                margin={"l": 72, "r": 16, "t": 32, "b": 48},
                hovermode="x unified",
            ),
        },
        "value": {"data": [heat(quantity, colorscale=SEQUENTIAL)], "signed": DIVERGING, "layout": square},
        "error": {"data": [heat("error", colorscale=DIVERGING, zmid=0)], "layout": square},
    }


def history_layout() -> Figure:
    """Return the layout shared by the charts of the balances; each balance sets the title of its vertical axis."""
    return layout(
        xaxis=axis("t [s]"),
        yaxis=axis(),
        legend={"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        margin={"l": 64, "r": 12, "t": 28, "b": 44},
    )


def history(part: Balance) -> Figure:
    """Return the chart of a balance without its times, which are stored once for all balances of a series."""
    data = [
        {
            "type": "scatter",
            "mode": "lines",
            "name": name,
            "y": floats(values),
            **({} if part.time is None else {"x": floats(part.time)}),
            "line": {"color": f"var(--series-{k % COLOURS})", "dash": DASHES[k % len(DASHES)], "width": 1.6},
        }
        for k, (name, values) in enumerate(part.curves.items())
    ]
    return {"title": part.title, "axis": in_unit(part.quantity, part.units), "data": data}
