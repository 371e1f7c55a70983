"""The exact solution of a problem in motion: its stored output times as the frames of a film in SVG that the style sheet moves."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from . import field_points, fields
from .field_still import Frame, cut, dots, main_quantity
from .fields import Quantity
from .notation import size
from .record import Array, Case, Field, Profile, Record

WIDTH, HEIGHT, MARGIN = 300, 96.0, 10.0
FIELD_HEIGHT = 170.0
"""Greatest height of the frames of a field in two or three dimensions."""
POINTS, FIELD_POINTS = 60, 240
LONGEST = 24
"""Largest number of frames."""
SLOT, FIELD_SLOT = 0.2, 0.5
"""Time for which a frame is shown [s]."""
STILL = 1e-9
"""Change of a field, relative to its size, up to which it does not move."""


@dataclass(frozen=True)
class Motion:
    """The exact solution in motion.

    Parameters
    ----------
    svg : str
        The frames side by side, of which one is seen at a time: the telling one where nothing may move.
    caption : str
        The quantity, and the times.
    """

    svg: str
    caption: str


def motion(record: Record, case: Case) -> Motion | None:
    """Return the exact solution of a case in motion, from the finest level that was kept of it.

    Parameters
    ----------
    record : Record
    case : Case

    Returns
    -------
    Motion or None
        None if no exact field was kept at several times, or it does not move.
    """
    series = [entry for entry in record.series if entry.case == case.name]
    profiles = [entry.profile for entry in series if entry.profile and _shown(entry.profile, case.shown)]
    if profiles:
        return _of_profile(min(profiles, key=lambda profile: (_shown(profile, case.shown) != case.shown, profile.h)), case)
    spatial = [entry.spatial for entry in series if entry.spatial and len(entry.spatial.time) > 1]
    made = (_of_field(field, case) for field in sorted(spatial, key=lambda field: field.h))
    return next((found for found in made if found), None)


def _shown(profile: Profile, first: str) -> str:
    """Return the quantity whose exact profile is drawn: the first one of the case if it moves; "" if none does."""
    names = sorted(profile.exact, key=lambda name: name != first)
    return next((name for name in names if len(profile.time) > 1 and _moves(profile.exact[name])), "")


def _moves(values: Array) -> bool:
    known = np.where(np.isfinite(values), values, 0.0)
    return bool(np.isfinite(values).any()) and float(np.ptp(known, axis=0).max()) > STILL * float(np.abs(known).max())


def _rows(count: int) -> list[int]:
    return np.unique(np.round(np.linspace(0, count - 1, min(count, LONGEST))).astype(int)).tolist()


def _of_profile(profile: Profile, case: Case) -> Motion | None:
    name = _shown(profile, case.shown)
    every = -(-len(profile.reference) // POINTS)
    x, exact = profile.reference[::every], profile.exact[name]
    if np.ptp(x) == 0:
        return None
    rows, seen = _rows(len(profile.time)), exact[np.isfinite(exact)]
    low, high = min(float(seen.min()), 0.0), max(float(seen.max()), 0.0)
    across = MARGIN + (x - x[0]) / np.ptp(x) * (WIDTH - 2 * MARGIN)
    top, base = 18.0, HEIGHT - 6

    def down(values: Array) -> Array:
        return top + (high - values) / (high - low) * (base - top)

    zero = float(down(np.zeros(1))[0])
    frames = [
        f'<path class="zero" d="M{MARGIN:g} {zero:.1f}H{WIDTH - MARGIN:g}"/>'
        f'<path class="exact" d="{_path(across, down(exact[row, ::every]))}"/>'
        for row in rows
    ]
    telling = int(np.argmax([float(np.ptp(np.nan_to_num(exact[row]))) for row in rows]))
    label = f"{name.replace('_', ' ')}, {case.name}"
    return _film(frames, [float(profile.time[row]) for row in rows], telling, label, HEIGHT, SLOT)


def _path(across: Array, down: Array) -> str:
    """Return a path through the finite points, broken where one is missing."""
    parts, pen = [], "M"
    for x, y in zip(across.tolist(), down.tolist(), strict=True):
        if np.isfinite(y):
            parts.append(f"{pen}{x:.1f} {y:.1f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(parts)


def _of_field(field: Field, case: Case) -> Motion | None:
    every = fields.quantities(field)
    key = main_quantity(field, case.shown)
    ranked = sorted((one for one in every if one.exact is not None), key=lambda one: one.key != key)
    places = field_points.positions(field, exact=True)
    carried = _moves(places - field.reference)
    quantity = next((one for one in ranked if one.exact is not None and (carried or _moves(one.exact))), None)
    if quantity is None or quantity.exact is None:
        return None
    part, rows = cut(field, FIELD_POINTS), _rows(len(field.time))
    layer = field_points.spacing(field.reference[part.points][:, part.axes], field.h)
    drawn = places[rows][:, part.points][..., part.axes]
    low, high = drawn.reshape(-1, 2).min(axis=0) - layer, drawn.reshape(-1, 2).max(axis=0) + layer
    factor = float(min(WIDTH / (high[0] - low[0]), FIELD_HEIGHT / (high[1] - low[1])))
    height = float((high[1] - low[1]) * factor) + 18
    frame = Frame(low, high, float(WIDTH - (high[0] - low[0]) * factor) / 2, 18.0, factor)
    scale = fields.scale(quantity, fields.size_of_group(quantity.group, every))
    frames = [
        "".join(dots(frame.place(drawn[k]), quantity.exact[row][part.points], scale, layer * factor))
        for k, row in enumerate(rows)
    ]
    telling = int(np.argmin(np.abs(np.array(rows) - fields.telling(_exact(quantity), np.array(rows)))))
    return _film(
        frames,
        [float(field.time[row]) for row in rows],
        telling,
        f"{quantity.name}, {case.name}{part.words}",
        height,
        FIELD_SLOT,
        kind=" field",
    )


def _exact(quantity: Quantity) -> Quantity:
    """Return a quantity whose numerical field is the exact one."""
    assert quantity.exact is not None, "only such quantities are drawn"
    return Quantity(quantity.key, quantity.name, quantity.group, quantity.units, quantity.exact, quantity.exact, None)


def _film(
    frames: Sequence[str], times: Sequence[float], telling: int, label: str, height: float, slot: float, kind: str = ""
) -> Motion:
    """Put frames side by side; the style sheet moves them by one frame at a time, and holds them where motion is not wanted."""
    strip = "".join(
        f'<g transform="translate({k * WIDTH} 0)">{frame}<text x="{MARGIN:g}" y="11">t = {size(time)} s</text></g>'
        for k, (frame, time) in enumerate(zip(frames, times, strict=True))
    )
    count = len(frames)
    style = (
        f"--at:-{telling * WIDTH}px;--end:-{count * WIDTH}px;--time:{count * slot:g}s;animation-timing-function:steps({count})"
    )
    name = escape(f"Exact {label}, t = {size(times[0])} to {size(times[-1])} s")
    svg = (
        f'<svg class="motion{kind}" viewBox="0 0 {WIDTH} {height:.0f}" role="img" aria-label="{name}">'
        f'<g class="film" style="{style}">{strip}</g></svg>'
    )
    return Motion(svg, f"Exact {label.partition(',')[0]}, {size(times[0])} to {size(times[-1])} s")
