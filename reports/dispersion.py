"""Frequency against wave number: what a mode of a bar was measured to do, on the curve of the scheme's dispersion relation."""

from collections.abc import Iterator, Sequence

import numpy as np

from .charts import MUTED, Figure, axis, layout, sig
from .notation import ladder, number
from .record import Array, Series
from .styles import Style


def measured(entry: Series) -> Iterator[tuple[Array, Array, Array]]:
    """Phase angle k h, measured and theoretical frequency over c k, of every quantity in which a series has them."""
    for name, angle in entry.metrics.items():
        if name.startswith("phase_angle_"):
            quantity = name.removeprefix("phase_angle_")
            found, theory = (entry.metrics[f"{what}_frequency_{quantity}"] for what in ("relative", "theoretical"))
            along = np.argsort(angle)
            yield angle[along], found[along], theory[along]


def figure(series: Sequence[Series], looks: Sequence[Style]) -> Figure:
    """Chart of omega/(c k) over k h; without data where no series has them. Markers are measured, lines theoretical."""
    data = []
    for k, (entry, look) in enumerate(zip(series, looks, strict=True)):
        for angle, found, theory in measured(entry):
            plain = {"type": "scatter", "x": [sig(value) for value in angle], "name": entry.solver, "meta": {"series": k}}
            notes = [
                f"{entry.solver}, {ladder(entry.refinement)}<br>kh = {number(x)}<br>ω/(ck) = {value:.6f}, theory {known:.6f}"
                for x, value, known in zip(angle, found, theory, strict=True)
            ]
            line = {"color": look.paint, "dash": look.dash, "width": 1.4, "shape": "spline"}
            data.append(plain | {"mode": "lines", "y": [sig(v) for v in theory], "line": line, "hoverinfo": "skip"})
            data.append(
                plain
                | {
                    "mode": "markers",
                    "y": [sig(v) for v in found],
                    "marker": {"color": look.paint, "size": 8, "symbol": look.symbol},
                    "text": notes,
                    "hovertemplate": "%{text}<extra></extra>",
                }
            )
    exact = {
        "type": "line",
        "xref": "paper",
        "x0": 0,
        "x1": 1,
        "y0": 1,
        "y1": 1,
        "line": {"color": MUTED, "dash": "dash", "width": 1},
    }
    return {
        "data": data,
        "layout": layout(
            xaxis=axis("phase angle per cell, kh [rad]", rangemode="tozero"),
            yaxis=axis("frequency over its exact value, ω/(ck)"),
            shapes=[exact],
        ),
    }
