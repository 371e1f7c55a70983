"""Strips: a measured order with its interval, the accepted band and the formal order on one axis, as a small picture in SVG."""

import math
from collections.abc import Iterator, Sequence
from html import escape

from .notation import interval as bracketed
from .notation import order as formatted

WIDTH, HEIGHT = 240.0, 22.0
MARGIN = 10.0
"""Space beside the axis for the arrows that stand for values beyond its ends."""
AXIS = (0.0, 4.0)
"""Ends of the axis: with it, strips of different series, cases and studies can be compared by eye."""

Ends = tuple[float, float]


def strip(measured: float, interval: Ends, band: Ends | None = None, formal: float | None = None, axis: Ends = AXIS) -> str:
    """Draw one strip.

    Parameters
    ----------
    measured : float
        Order of convergence; no marker is drawn if it is not finite.
    interval : (float, float)
        Ends of its 95 % interval; not drawn unless both are finite.
    band : (float, float), optional
        Accepted orders.
    formal : float, optional
        Order that the solver declares.
    axis : (float, float)
        Ends of the axis.

    Returns
    -------
    str
        SVG with an accessible name that states all numbers. Its classes are styled in the style sheet of the report.

    Notes
    -----
    The marker is a disc if the interval lies inside the band, a ring if it crosses an end of it or there is no band, and a cross if it
    lies outside: the strip reads without colour. A value beyond the axis is an arrow at its end.
    """
    middle, parts = HEIGHT / 2, [_rule(axis)]
    if band:
        left, right = (across(_within(end, axis), axis) for end in band)
        parts.append(
            f'<rect class="band" x="{left:.1f}" y="2" width="{max(right - left, 1.5):.1f}" height="{HEIGHT - 4:g}"/>'
            f'<path class="edge" d="M{left:.1f} 2V{HEIGHT - 2:g}M{max(right, left + 1.5):.1f} 2V{HEIGHT - 2:g}"/>'
        )
    if formal is not None and axis[0] <= formal <= axis[1]:
        parts.append(_formal(across(formal, axis)))
    low, high = interval
    if math.isfinite(low) and math.isfinite(high) and low <= axis[1] and high >= axis[0]:
        left, right = (across(_within(end, axis), axis) for end in interval)
        # Caps closer than the marker is wide would only blur it.
        caps = [across(end, axis) for end in interval if axis[0] <= end <= axis[1]] if right - left > 9 else []
        ends = "".join(f"M{x:.1f} {middle - 5:g}v10" for x in caps)
        parts.append(f'<path class="interval" d="M{left:.1f} {middle:g}H{right:.1f}{ends}"/>')
    parts += _marker(measured, interval, band, axis)
    return _framed("".join(parts), described(measured, interval, band, formal))


def ruler(axis: Ends = AXIS) -> str:
    """Draw the numbers of the axis, for the head of a column of strips."""
    numbers = "".join(
        f'<text x="{across(tick, axis):.1f}" y="11" text-anchor="middle">{tick:g}</text>' for tick in _ticks(axis)
    )
    return f'<svg class="strip ruler" viewBox="0 0 {WIDTH:g} 14" aria-hidden="true">{numbers}</svg>'


def rug(measured: Sequence[float], formal: Sequence[float] = (), axis: Ends = AXIS) -> str:
    """Draw many measured orders as strokes on one axis: where a solver stands, at a glance.

    Parameters
    ----------
    measured : sequence of float
        Orders of convergence; those that are not finite are left out, and those beyond the axis stand at its end.
    formal : sequence of float
        Declared orders, ticked above the axis.
    axis : (float, float)
        Ends of the axis.

    Returns
    -------
    str
        SVG with an accessible name that states the number of orders, the least and the greatest.
    """
    known = [value for value in measured if math.isfinite(value)]
    middle, parts = HEIGHT / 2, [_rule(axis)]
    parts += [_formal(across(value, axis)) for value in sorted(set(formal)) if axis[0] <= value <= axis[1]]
    places = sorted({f"{across(_within(value, axis), axis):.1f}" for value in known})
    strokes = "".join(f"M{x} {middle - 5:g}v10" for x in places)
    parts += [f'<path class="stroke" d="{strokes}"/>'] if strokes else []
    span = f", {formatted(min(known))} to {formatted(max(known))}" if known else ""
    return _framed("".join(parts), f"{len(known)} measured order{'s' * (len(known) != 1)}{span}")


def described(measured: float, interval: Ends, band: Ends | None, formal: float | None) -> str:
    """Say in words what a strip shows."""
    parts = [f"order {formatted(measured)}, 95 % interval {bracketed(*interval)}" if math.isfinite(measured) else "no order"]
    parts += [f"accepted {band[0]:g} to {band[1]:g}"] if band else []
    parts += [f"formal {formal:g}"] if formal is not None else []
    return ", ".join(parts)


def across(value: float, axis: Ends = AXIS) -> float:
    """Return the horizontal place of a value in a strip."""
    return MARGIN + (value - axis[0]) / (axis[1] - axis[0]) * (WIDTH - 2 * MARGIN)


def _framed(content: str, name: str) -> str:
    view = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(name)}"'
    return f'<svg class="strip" {view}>{content}</svg>'


def _rule(axis: Ends) -> str:
    ticks = "".join(f"M{across(tick, axis):.1f} {HEIGHT / 2 - 3:g}v6" for tick in _ticks(axis))
    return f'<path class="rule" d="M{MARGIN:g} {HEIGHT / 2:g}H{WIDTH - MARGIN:g}{ticks}"/>'


def _formal(x: float) -> str:
    return f'<path class="formal" d="M{x - 3.5:.1f} 0h7L{x:.1f} 5.5Z"/>'


def _within(value: float, axis: Ends) -> float:
    return min(max(value, axis[0]), axis[1])


def _ticks(axis: Ends) -> range:
    return range(math.ceil(axis[0]), math.floor(axis[1]) + 1)


def _marker(measured: float, interval: Ends, band: Ends | None, axis: Ends) -> Iterator[str]:
    y = HEIGHT / 2
    if not math.isfinite(measured):
        return
    if measured < axis[0] or measured > axis[1]:
        x, tip = (WIDTH - MARGIN + 1, 7) if measured > axis[1] else (MARGIN - 1, -7)
        yield f'<path class="beyond" d="M{x:g} {y - 4.5:g}l{tip} 4.5l{-tip} 4.5Z"/>'
        return
    x = across(measured, axis)
    low, high = interval if all(map(math.isfinite, interval)) else (measured, measured)
    if band and (high < band[0] or low > band[1]):
        yield f'<path class="outside" d="M{x - 4:.1f} {y - 4:g}l8 8m0 -8l-8 8"/>'
    else:
        inside = band is not None and band[0] <= low and high <= band[1]
        yield f'<circle class="{"inside" if inside else "open"}" cx="{x:.1f}" cy="{y:g}" r="3.4"/>'
