"""The chart of convergence as a still picture in SVG: what a page shows without scripts, in print, and until the chart is drawn."""

import math
from collections.abc import Callable, Collection, Iterator
from html import escape
from typing import Any

WIDTH, HEIGHT = 760.0, 470.0
LEFT, RIGHT, TOP, BOTTOM = 64.0, 16.0, 16.0, 48.0
DASHES = {"dash": "6 4", "dot": "2 3", "dashdot": "6 3 2 3"}
CORNERS = {"square": 4, "diamond": 4, "triangle-up": 3, "triangle-down": 3, "pentagon": 5}
"""Corners of the markers that are polygons; every other one is drawn as a circle."""
STARTS = {"square": 45.0, "triangle-down": 90.0}
"""Angle of the first corner, clockwise from the right [degrees]; -90 for the others."""


def still(figure: dict[str, Any], measure: str, shown: Collection[int]) -> str:
    """Draw the convergence chart in one measure.

    Parameters
    ----------
    figure : dict
        What `charts.convergence` returns.
    measure : str
        Key of the measure.
    shown : collection of int
        Numbers of the series that are drawn.

    Returns
    -------
    str
        SVG whose colours are those of the page; "" if nothing can be drawn.
    """
    traces = [trace for trace in figure["data"] if trace["meta"]["measure"] == measure and _chosen(trace["meta"], shown)]
    heights = [y for trace in traces for y in trace["y"] if y]
    if not heights or measure not in figure["titles"]:
        return ""
    axes = {name: entry for name, entry in figure["layout"].items() if name.startswith("xaxis")}
    parts = [f'<svg class="still" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" aria-hidden="true">']
    low, high = log_range(heights)

    down = scaled((low, high), HEIGHT - BOTTOM, TOP)
    for value, label in log_levels(low, high):
        y = down(value)
        parts.append(f'<path class="grid" d="M{LEFT:g} {y:.1f}H{WIDTH - RIGHT:g}"/>')
        parts.append(f'<text x="{LEFT - 8:g}" y="{y + 4:.1f}" text-anchor="end">{label}</text>')
    middle = (TOP + HEIGHT - BOTTOM) / 2
    title = escape(figure["titles"][measure])
    parts.append(f'<text transform="translate(14 {middle:g}) rotate(-90)" text-anchor="middle">{title}</text>')
    for name, axis in axes.items():
        mine = [trace for trace in traces if trace.get("xaxis", "x") == name.replace("xaxis", "x")]
        widths = [x for trace in mine for x in trace["x"] if x]
        if widths:
            parts += _panel(axis, mine, widths, down)
    return "".join([*parts, "</svg>"])


def _chosen(meta: dict[str, Any], shown: Collection[int]) -> bool:
    return any(k in shown for k in meta.get("members", [meta.get("series")]))


def log_range(values: list[float]) -> tuple[float, float]:
    """Ends of a logarithmic axis around values, with a margin."""
    low, high = min(values), max(values)
    margin = (high / low) ** 0.07 if high > low else 1.15
    return low / margin, high * margin


def scaled(ends: tuple[float, float], first: float, last: float) -> Callable[[float], float]:
    """Return the map of a logarithmic axis, from its ends to the places `first` and `last`."""
    low, high = map(math.log10, ends)
    return lambda value: first + (math.log10(value) - low) / (high - low) * (last - first)


def log_levels(low: float, high: float) -> Iterator[tuple[float, str]]:
    """Levels of a logarithmic axis with their labels: powers of ten, and where there are few, twice and five times these."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    few = math.log10(high / low) < 2
    for decade in decades:
        for step in (1, 2, 5) if few else (1,):
            if low <= step * 10.0**decade <= high:
                factor = "" if step == 1 else f"{step} × "
                yield step * 10.0**decade, f'{factor}10<tspan dy="-5" font-size="9">{_minus(decade)}</tspan>'


def _panel(axis: dict[str, Any], traces: list[dict[str, Any]], widths: list[float], down: Any) -> Iterator[str]:
    """Draw the traces over one horizontal axis."""
    low, high = log_range(widths)
    first, last = (LEFT + share * (WIDTH - LEFT - RIGHT) for share in axis["domain"])

    across = scaled((low, high), first, last)
    base = HEIGHT - BOTTOM
    ticks = dict(zip(axis.get("tickvals", []), axis.get("ticktext", []), strict=True))
    if not ticks:
        ticks = {10.0**n: f"1e{n}" for n in range(math.ceil(math.log10(low)), math.floor(math.log10(high)) + 1)}
    reached = -math.inf
    for value, label in sorted(ticks.items()):
        x = across(value)
        yield f'<path class="grid" d="M{x:.1f} {TOP:g}V{base:g}"/>'
        if x - reached > 7.0 * len(label):
            yield f'<text x="{x:.1f}" y="{base + 18:g}" text-anchor="middle">{escape(label)}</text>'
            reached = x
    yield f'<text x="{(first + last) / 2:.1f}" y="{base + 38:g}" text-anchor="middle">{escape(axis["title"]["text"])}</text>'
    for trace in sorted(traces, key=lambda trace: "series" in trace["meta"]):
        places = [(across(x), down(y), k) for k, (x, y) in enumerate(zip(trace["x"], trace["y"], strict=True)) if x and y]
        if places:
            yield from _trace(trace, places)


def _trace(trace: dict[str, Any], places: list[tuple[float, float, int]]) -> Iterator[str]:
    line = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y, _ in places)
    if trace.get("fill"):
        yield f'<path d="{line}Z" fill="{trace["fillcolor"]}"/>'
    elif "lines" in trace["mode"]:
        style, dash = trace["line"], DASHES.get(trace["line"].get("dash", ""), "")
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        yield f'<path d="{line}" fill="none" stroke="{style["color"]}" stroke-width="{style["width"]}"{dashed}/>'
    if "text" in trace["mode"]:
        for x, y, k in places:
            if trace["text"][k]:
                after = "left" not in trace["textposition"]
                end = "start" if after else "end"
                yield f'<text x="{x:.1f}" y="{y + (14 if after else 4):.1f}" text-anchor="{end}">{escape(trace["text"][k])}</text>'
    if "markers" in trace["mode"]:
        for x, y, k in places:
            yield marker(x, y, trace["marker"]["symbol"][k], trace["marker"]["color"])


def marker(x: float, y: float, symbol: str, colour: str) -> str:
    """Draw the marker of a point; "-open" at the end of the name of its symbol stands for a hollow one."""
    name = symbol.removesuffix("-open")
    paint = f'fill="{colour if name == symbol else "var(--panel)"}" stroke="{colour}" stroke-width="1.5"'
    if name not in CORNERS:
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" {paint}/>'
    start, count = math.radians(STARTS.get(name, -90.0)), CORNERS[name]
    corners = [
        (x + 5 * math.cos(start + 2 * math.pi * k / count), y + 5 * math.sin(start + 2 * math.pi * k / count))
        for k in range(count)
    ]
    return f'<path d="M{"L".join(f"{cx:.1f} {cy:.1f}" for cx, cy in corners)}Z" {paint}/>'


def _minus(number: int) -> str:
    return f"{number}".replace("-", "−")
