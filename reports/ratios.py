"""Ratios of two numbers on a logarithmic axis, as small still pictures in SVG."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from statistics import median

from .notation import count, number

WIDTH, HEIGHT, MARGIN = 120.0, 14.0, 9.0
DECADES = 2.0
"""Powers of ten on each side of 1."""


def ratio_bar(ratio: float, label: str = "ratio") -> str:
    """Draw a bar from 1 to a ratio: to the left, in the first colour, if the first number is smaller, else to the right in the second.

    Parameters
    ----------
    ratio : float
        The first number divided by the second.
    label : str
        What the ratio is, for the accessible name.

    Returns
    -------
    str
        SVG; "" if the ratio is not positive and finite. A ratio beyond the axis ends in an arrow.
    """
    if not (math.isfinite(ratio) and ratio > 0):
        return ""
    middle, y = WIDTH / 2, HEIGHT / 2
    half = middle - MARGIN
    share = math.log10(ratio) / DECADES
    x = middle + half * min(max(share, -1.0), 1.0)
    side = "first" if ratio < 1 else "second"
    ticks = "".join(f"M{middle + half * k / 2:g} {y - 3:g}v6" for k in (-2, -1, 1, 2))
    parts = [f'<path class="rule" d="M{MARGIN:g} {y:g}H{WIDTH - MARGIN:g}{ticks}"/>']
    parts.append(f'<rect class="{side}" x="{min(x, middle):.1f}" y="{y - 4:g}" width="{abs(x - middle):.1f}" height="8"/>')
    if abs(share) > 1:
        tip = math.copysign(7, share)
        parts.append(f'<path class="{side}" d="M{x:.1f} {y - 5:g}l{tip:g} 5l{-tip:g} 5Z"/>')
    parts.append(f'<path class="one" d="M{middle:g} 1V{HEIGHT - 1:g}"/>')
    name = escape(f"{label} {number(ratio, 2)}")
    return f'<svg class="ratio" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{name}">{"".join(parts)}</svg>'


@dataclass(frozen=True)
class Spread:
    """Many ratios on one axis.

    Parameters
    ----------
    name, said : str
        What they are of; their number, least, median and greatest in words.
    picture : str
        SVG with a stroke for each; "" if there is none.
    """

    name: str
    said: str
    picture: str


EXTENTS = (1.01, 1.1, 2.0, 10.0, 100.0, 1e4, 1e8)
"""Ends of the axis of a spread: the smallest that holds all ratios is taken."""
LONG, LOW = 360.0, 44.0


def spread(name: str, ratios: Sequence[float]) -> Spread:
    """Draw ratios as strokes on a logarithmic axis whose middle is 1.

    Parameters
    ----------
    name : str
    ratios : sequence of float
        All positive and finite.
    """
    if not ratios:
        return Spread(name, "none compared", "")
    logs = sorted(math.log(ratio) for ratio in ratios)
    reach = max(map(abs, logs))
    extent = next((end for end in EXTENTS if reach <= math.log(end) * (1 + 1e-12)), EXTENTS[-1])
    half, middle, base = LONG / 2 - 24, LONG / 2, LOW - 18

    def across(logarithm: float) -> float:
        return middle + half * min(max(logarithm / math.log(extent), -1.0), 1.0)

    ends = [extent**power for power in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    parts = [f'<path class="rule" d="M{middle - half:g} {base / 2:g}H{middle + half:g}"/>']
    parts += [f'<path class="{"one" if end == 1 else "grid"}" d="M{across(math.log(end)):.1f} 0V{base:g}"/>' for end in ends]
    parts += [
        f'<text x="{across(math.log(end)):.1f}" y="{LOW - 4:g}" text-anchor="middle">{end:.3g}</text>' for end in ends[::2]
    ]
    for kind, chosen in (("first", [x for x in logs if x < 0]), ("second", [x for x in logs if x > 0])):
        strokes = "".join(f"M{x} 3V{base - 3:g}" for x in sorted({f"{across(value):.1f}" for value in chosen}))
        parts += [f'<path class="{kind}" d="{strokes}"/>'] if strokes else []
    parts += [f'<circle cx="{middle:g}" cy="{base / 2:g}" r="4"/>'] if 0.0 in logs else []
    low, high = (number(math.exp(value), 3) for value in (logs[0], logs[-1]))
    same = sum(value == 0 for value in logs)
    said = f"{count(len(logs))} compared, {count(same)} the same; {low} to {high}, median {number(math.exp(median(logs)), 3)}"
    view = f'viewBox="0 0 {LONG:g} {LOW:g}" role="img" aria-label="{escape(f"{name}: {said}")}"'
    return Spread(name, said, f'<svg class="spread" {view}>{"".join(parts)}</svg>')
