"""What a series was measured to do on the curve of its scheme's own theory: frequencies of a mode, limits of stability."""

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
    """A chart of measurements, as markers, on theoretical lines; `label` is for those who do not see it."""

    heading: str
    label: str
    caption: str
    figure: Figure


def theory(series: Sequence[Series], looks: Sequence[Style]) -> Theory | None:
    """Chart of a case in which frequencies or limits of stability were measured; None in any other."""
    frequencies = [_frequencies(k, entry, look) for k, (entry, look) in enumerate(zip(series, looks, strict=True))]
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
            "Markers: measured frequency of the mode, ω/(ck), at each cell size. Lines: the scheme's own dispersion relation at the same "
            "steps. The wave equation has 1.",
            {"data": list(chain(*frequencies)), "layout": shape},
        )
    limits = [_limits(k, entry, look) for k, (entry, look) in enumerate(zip(series, looks, strict=True))]
    if any(limits):
        counts = sorted({x for traces in limits for trace in traces for x in trace["x"]})
        ticks = {"tickvals": counts, "ticktext": [f"{count:g}" for count in counts]}
        shape = layout(
            xaxis=axis("particles per cell", type="log", **ticks),
            yaxis=axis("largest stable Courant number, c Δt/h", rangemode="tozero"),
        )
        return Theory(
            "Limit of stability",
            "Largest stable Courant number against particles per cell",
            "Markers: the largest Courant number at which no wave grew, by bisection. Lines: the limit of von Neumann's analysis.",
            {"data": list(chain(*limits)), "layout": shape},
        )
    return None


def _frequencies(k: int, entry: Series, look: Style) -> list[Figure]:
    """Omega/(c k) over k h of every quantity in which a series has them."""
    traces = []
    for name in entry.metrics:
        if name.startswith("phase_angle_"):
            quantity = name.removeprefix("phase_angle_")
            names = (name, f"relative_frequency_{quantity}", f"theoretical_frequency_{quantity}")
            angle, found, known = _along(*(entry.metrics[name] for name in names))
            notes = [
                f"kh = {number(x)}<br>ω/(ck) = {value:.6f}, theory {right:.6f}"
                for x, value, right in zip(angle, found, known, strict=True)
            ]
            traces += _traces(k, entry, look, angle, found, known, notes, "spline")
    return traces


def _limits(k: int, entry: Series, look: Style) -> list[Figure]:
    """Largest stable Courant number over particles per cell, where a series has it."""
    if "stability_limit" not in entry.metrics:
        return []
    counts = np.array([level.ppc for level in entry.levels], dtype=float)
    ppc, found, known = _along(counts, entry.metrics["stability_limit"], entry.metrics["theoretical_stability_limit"])
    notes = [
        f"{x:g} particles per cell<br>limit {value:.4f}, theory {right:.4f} ({value / right - 1:+.2%})"
        for x, value, right in zip(ppc, found, known, strict=True)
    ]
    return _traces(k, entry, look, ppc, found, known, notes, "linear")


def _along(x: Array, *others: Array) -> tuple[Array, ...]:
    """All of them in the order of x."""
    order = np.argsort(x)
    return x[order], *(values[order] for values in others)


def _traces(
    k: int, entry: Series, look: Style, x: Array, found: Array, known: Array, notes: Sequence[str], shape: str
) -> list[Figure]:
    plain = {"type": "scatter", "x": [sig(value) for value in x], "name": entry.solver, "meta": {"series": k}}
    line = {"color": look.paint, "dash": look.dash, "width": 1.4, "shape": shape}
    marker = {"color": look.paint, "size": 8, "symbol": look.symbol}
    titled = [f"{entry.solver}, {ladder(entry.refinement)}<br>{note}" for note in notes]
    told = {"text": titled, "hovertemplate": "%{text}<extra></extra>"}
    return [
        plain | {"mode": "lines", "y": [sig(v) for v in known], "line": line, "hoverinfo": "skip"},
        plain | {"mode": "markers", "y": [sig(v) for v in found], "marker": marker} | told,
    ]
