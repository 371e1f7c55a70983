"""Charts of measured frequencies and stability limits against the theory of each scheme."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from .charts import MUTED, Figure, axis, layout, sig
from .notation import ladder, number
from .record import Array, Series
from .styles import Style

EXACT = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 1, "y1": 1}


@dataclass(frozen=True)
class Theory:
    """Chart of measurements (markers) and theory (lines); `label` describes it to screen readers."""

    heading: str
    label: str
    caption: str
    figure: Figure


def theory(series: Sequence[Series], curve_styles: Sequence[Style]) -> Theory | None:
    """Return the chart of a case in which frequencies or stability limits were measured, else None."""
    frequencies = [_frequencies(k, entry, style) for k, (entry, style) in enumerate(zip(series, curve_styles, strict=True))]
    if any(frequencies):
        exact = EXACT | {"line": {"color": MUTED, "dash": "dash", "width": 1}}
        shape = layout(
            xaxis=axis("phase angle per cell, kh [rad]", rangemode="tozero"),
            yaxis=axis("frequency over its exact value, ω/(ck)"),
            shapes=[exact],
        )
        return Theory(
            "Dispersion",
            "Frequency over that of the wave equation against phase angle per cell",
            "Markers: measured frequency of the mode, ω/(ck), at each cell size. Lines: the scheme's own dispersion relation with the "
            "same time steps. Dashed line: exact value, 1.",
            {"data": list(chain(*frequencies)), "layout": shape},
        )
    limits = [_limits(k, entry, style) for k, (entry, style) in enumerate(zip(series, curve_styles, strict=True))]
    if any(limits):
        counts = sorted({x for traces in limits for trace in traces for x in trace["x"]})
        ticks = {"tickvals": counts, "ticktext": [f"{count:g}" for count in counts]}
        shape = layout(
            xaxis=axis("particles per cell", type="log", **ticks),
            yaxis=axis("largest stable Courant number, c Δt/h", rangemode="tozero"),
        )
        return Theory(
            "Stability limit",
            "Largest stable Courant number against particles per cell",
            "Markers: largest Courant number at which no wave grew, found by bisection. Lines: limit from von Neumann's analysis.",
            {"data": list(chain(*limits)), "layout": shape},
        )
    return None


def _frequencies(k: int, entry: Series, style: Style) -> list[Figure]:
    """Return the traces of ω/(ck) over kh for every quantity whose frequencies were measured."""
    traces = []
    for name in entry.metrics:
        if name.startswith("phase_angle_"):
            quantity = name.removeprefix("phase_angle_")
            names = (name, f"relative_frequency_{quantity}", f"theoretical_frequency_{quantity}")
            angle, measured, predicted = _sorted_by(*(entry.metrics[name] for name in names))
            notes = [
                f"kh = {number(x)}<br>ω/(ck) = {value:.6f}, theory {right:.6f}"
                for x, value, right in zip(angle, measured, predicted, strict=True)
            ]
            traces += _traces(k, entry, style, angle, measured, predicted, notes, "spline")
    return traces


def _limits(k: int, entry: Series, style: Style) -> list[Figure]:
    """Return the traces of the stability limit over particles per cell; empty if it was not measured."""
    if "stability_limit" not in entry.metrics:
        return []
    counts = np.array([level.ppc for level in entry.levels], dtype=float)
    ppc, measured, predicted = _sorted_by(
        counts, entry.metrics["stability_limit"], entry.metrics["theoretical_stability_limit"]
    )
    notes = [
        f"{x:g} particles per cell<br>limit {value:.4f}, theory {right:.4f} ({value / right - 1:+.2%})"
        for x, value, right in zip(ppc, measured, predicted, strict=True)
    ]
    return _traces(k, entry, style, ppc, measured, predicted, notes, "linear")


def _sorted_by(x: Array, *others: Array) -> tuple[Array, ...]:
    """Sort all arrays by x."""
    order = np.argsort(x)
    return x[order], *(values[order] for values in others)


def _traces(
    k: int, entry: Series, style: Style, x: Array, measured: Array, predicted: Array, notes: Sequence[str], shape: str
) -> list[Figure]:
    plain = {"type": "scatter", "x": [sig(value) for value in x], "name": entry.solver, "meta": {"series": k}}
    line = {"color": style.paint, "dash": style.dash, "width": 1.4, "shape": shape}
    marker = {"color": style.paint, "size": 8, "symbol": style.symbol}
    titled = [f"{entry.solver}, {ladder(entry.refinement)}<br>{note}" for note in notes]
    hover = {"text": titled, "hovertemplate": "%{text}<extra></extra>"}
    return [
        plain | {"mode": "lines", "y": [sig(v) for v in predicted], "line": line, "hoverinfo": "skip"},
        plain | {"mode": "markers", "y": [sig(v) for v in measured], "marker": marker} | hover,
    ]
