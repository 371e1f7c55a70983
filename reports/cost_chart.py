"""Charts of error against cost, as small still pictures in SVG."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

from .notation import number
from .still import log_range, marker, scaled

WIDTH, HEIGHT = 290.0, 190.0
LEFT, RIGHT, TOP, BOTTOM = 54.0, 12.0, 8.0, 36.0
ROOM = 34.0, 15.0
"""Least distance between two labels of the horizontal and of the vertical axis."""
PAINT = ("var(--series-0)", "var(--series-1)")
"""Colours of the solver and of the reference, which also differ in marker and dash."""


@dataclass(frozen=True)
class Curve:
    """Points (cost, error) of one series, all positive; `beside` marks the reference."""

    places: tuple[tuple[float, float], ...]
    beside: bool


def chart(curves: Sequence[Curve], title: str, label: str) -> str:
    """Draw errors against a cost on logarithmic axes.

    Parameters
    ----------
    curves : sequence of Curve
        The first is that of the solver.
    title : str
        Title of the horizontal axis.
    label : str
        Accessible name.

    Returns
    -------
    str
        SVG: disc and line for the solver, square and dashes for the reference.
    """
    places = [place for curve in curves for place in curve.places]
    wide, (low, high) = log_range([x for x, _ in places]), log_range([y for _, y in places])
    across = scaled(wide, LEFT, WIDTH - RIGHT)
    down = scaled((low, high), HEIGHT - BOTTOM, TOP)
    base, parts = HEIGHT - BOTTOM, []
    for y, text in _ticks((low, high), down, ROOM[1]):
        parts.append(f'<path class="grid" d="M{LEFT:g} {y:.1f}H{WIDTH - RIGHT:g}"/>')
        parts.append(f'<text x="{LEFT - 6:g}" y="{y + 4:.1f}" text-anchor="end">{text}</text>')
    for x, text in _ticks(wide, across, ROOM[0]):
        parts.append(f'<path class="grid" d="M{x:.1f} {TOP:g}V{base:g}"/>')
        parts.append(f'<text x="{x:.1f}" y="{base + 15:g}" text-anchor="middle">{text}</text>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2:.1f}" y="{HEIGHT - 4:g}" text-anchor="middle">{escape(title)}</text>')
    for curve in reversed(curves):
        parts += _drawn(curve, [(across(x), down(y)) for x, y in curve.places])
    view = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(label)}"'
    return f'<svg class="cost-chart" {view}>{"".join(parts)}</svg>'


def _ticks(ends: tuple[float, float], place: Callable[[float], float], room: float) -> list[tuple[float, str]]:
    """Return places and labels on an axis: every n-th power of ten, so that labels do not touch; 2 and 5 between few powers."""
    first, last = math.ceil(math.log10(ends[0])), math.floor(math.log10(ends[1]))
    powers = list(range(first, last + 1))
    if len(powers) > 1:
        every = math.ceil(room / abs(place(10.0) - place(1.0)))
        return [(place(10.0**n), _label(10.0**n)) for n in powers[::every]]
    values = [step * 10.0**n for n in range(first - 1, last + 2) for step in (1, 2, 5)]
    kept: list[tuple[float, str]] = []
    for value in values:
        if ends[0] <= value <= ends[1] and (not kept or abs(place(value) - kept[-1][0]) >= room):
            kept.append((place(value), _label(value)))
    return kept


def _label(value: float) -> str:
    return number(value, 1).removeprefix("1×")


def _drawn(curve: Curve, places: Sequence[tuple[float, float]]) -> list[str]:
    if not places:
        return []
    paint, dash = PAINT[curve.beside], ' stroke-dasharray="5 3"' if curve.beside else ""
    line = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    symbol = "square-open" if curve.beside else "circle"
    path = f'<path d="{line}" fill="none" stroke="{paint}" stroke-width="1.6"{dash}/>'
    return [path, *(marker(x, y, symbol, paint) for x, y in places)]
