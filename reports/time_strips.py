"""Times as small still pictures in SVG: a dot at the median with a bar between the quartiles, on one logarithmic axis for a group."""

import math
from collections.abc import Iterator, Sequence
from html import escape

from .notation import number

WIDTH, HEIGHT, MARGIN = 320.0, 22.0, 26.0
HISTORY = 120.0
"""Width of the picture of a history."""
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))

Ends = tuple[float, float]
"""Ends of an axis [s]."""


def seconds(value: float, digits: int = 3) -> str:
    """Format a time with the unit that leaves it between 1 and 1000."""
    if value == 0:
        return "0 s"
    size, unit = next(((size, unit) for size, unit in UNITS if value >= size * (1 - 0.5 * 10.0**-digits)), UNITS[-1])
    return f"{number(value / size, digits)} {unit}"


def axis(times: Sequence[float]) -> Ends:
    """Return the ends of an axis that holds some times: at least a factor of 4 apart, with a margin."""
    known = [time for time in times if time > 0] or [1.0]
    low, high = min(known) / 1.15, max(known) * 1.15
    widen = max(4.0 / (high / low), 1.0) ** 0.5
    return low / widen, high * widen


def time_strip(median: float, low: float, high: float, ends: Ends, *, fastest: bool = False) -> str:
    """Draw one time.

    Parameters
    ----------
    median, low, high : float
        Median and quartiles [s].
    ends : (float, float)
        Ends of the axis [s].
    fastest : bool
        The fastest of a group is a filled disc, and every other one a ring.

    Returns
    -------
    str
        SVG with an accessible name that states all numbers. A median of zero has no dot.
    """
    y, parts = HEIGHT / 2, [_grid(ends)]
    if low > 0 and high > low:
        left, right = _across(low, ends), _across(high, ends)
        parts.append(f'<path class="quartiles" d="M{left:.1f} {y:g}H{max(right, left + 1):.1f}"/>')
    if median > 0:
        kind = "inside" if fastest else "open"
        parts.append(f'<circle class="{kind}" cx="{_across(median, ends):.1f}" cy="{y:g}" r="4"/>')
    name = escape(f"median {seconds(median)}, quartiles {seconds(low)} to {seconds(high)}")
    view = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{name}"'
    return f'<svg class="strip times" {view}>{"".join(parts)}</svg>'


def time_ruler(ends: Ends) -> str:
    """Draw the numbers of an axis, for the head of a column."""
    numbers = "".join(
        f'<text x="{_across(tick, ends):.1f}" y="11" text-anchor="middle">{seconds(tick, 1)}</text>' for tick in _ticks(ends)
    )
    return f'<svg class="strip ruler times" viewBox="0 0 {WIDTH:g} 14" aria-hidden="true">{numbers}</svg>'


def history_line(ratios: Sequence[float]) -> str:
    """Draw the ratios of one benchmark in several files, the oldest at the left, on a logarithmic axis of its own.

    Parameters
    ----------
    ratios : sequence of float
        NaN where a file has none.

    Returns
    -------
    str
        SVG; "" if fewer than two are known.
    """
    known = [(k, math.log(ratio)) for k, ratio in enumerate(ratios) if math.isfinite(ratio) and ratio > 0]
    if len(known) < 2:
        return ""
    low, high = min(y for _, y in known), max(y for _, y in known)
    room = max(high - low, math.log(1.1))  # a change of some percent is no cliff
    middle = (low + high) / 2
    places = [(6 + k / (len(ratios) - 1) * (HISTORY - 12), HEIGHT / 2 - (y - middle) / room * (HEIGHT - 10)) for k, y in known]
    line = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    end = f'<circle class="inside" cx="{places[-1][0]:.1f}" cy="{places[-1][1]:.1f}" r="3"/>'
    name = escape(f"ratios {', '.join(number(ratio, 3) for ratio in ratios)}")
    view = f'viewBox="0 0 {HISTORY:g} {HEIGHT:g}" role="img" aria-label="{name}"'
    return f'<svg class="history-line times" {view}><path d="{line}"/>{end}</svg>'


def _grid(ends: Ends) -> str:
    lines = "".join(f"M{_across(tick, ends):.1f} 0V{HEIGHT:g}" for tick in _ticks(ends))
    return f'<path class="gridline" d="{lines}"/><path class="rule" d="M{MARGIN:g} {HEIGHT / 2:g}H{WIDTH - MARGIN:g}"/>'


def _across(value: float, ends: Ends) -> float:
    low, high = map(math.log10, ends)
    return MARGIN + (math.log10(value) - low) / (high - low) * (WIDTH - 2 * MARGIN)


def _ticks(ends: Ends) -> list[float]:
    """Return round times: every n-th power of ten, and 2 and 5 between them where there are few."""
    first, last = math.floor(math.log10(ends[0])), math.ceil(math.log10(ends[1]))

    def inside(steps: Sequence[int], every: int = 1) -> Iterator[float]:
        yield from (v for n in range(first, last + 1, every) for step in steps if ends[0] <= (v := step * 10.0**n) <= ends[1])

    decades = math.log10(ends[1] / ends[0])
    if decades > 2.5:
        return list(inside((1,), math.ceil(decades / 6)))
    return list(inside((1, 2, 5) if decades < 1.7 else (1, 3)))
