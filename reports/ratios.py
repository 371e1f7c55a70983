"""Ratios of two numbers on a logarithmic axis, as small still pictures in SVG."""

import math
from html import escape

from .notation import number

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
