"""Thumbnails as SVG: final profiles, the numerical one in front of the exact one, and fields in two and three dimensions."""

from dataclasses import dataclass
from html import escape

import numpy as np

from . import field_points, fields
from .field_still import Frame, cut, dots, main_quantity
from .record import Array, Field, Profile, Record

WIDTH, HEIGHT, MARGIN, POINTS = 150.0, 48.0, 3.0, 100
FIELD_HEIGHT, FIELD_POINTS = 100.0, 600


@dataclass(frozen=True)
class Thumbnail:
    """SVG path data in a box of `WIDTH` by `HEIGHT`."""

    exact: str
    numerical: str


def thumbnail(profile: Profile, quantity: str) -> Thumbnail | None:
    """Draw the last profile of a quantity; return None if it was not recorded or the exact profile has no finite value."""
    if quantity not in profile.fields:
        return None
    every = -(-len(profile.reference) // POINTS)
    x = profile.reference[::every]
    exact, numerical = profile.exact[quantity][-1, ::every], profile.fields[quantity][-1, ::every]
    both = np.concatenate([exact, numerical])
    # Scaled by the whole run: otherwise a field that vanishes at the final time would show only round-off.
    seen, spread = profile.exact[quantity][np.isfinite(profile.exact[quantity])], np.ptp(x)
    if not np.isfinite(exact).any() or spread == 0:
        return None
    # A numerical profile is clipped at half the exact range beyond either end of it, so that the exact profile stays visible.
    room = np.ptp(seen) or float(np.abs(seen).max()) or 1.0
    inside = both[np.isfinite(both)].clip(seen.min() - 0.5 * room, seen.max() + 0.5 * room)
    low, high = min(inside.min(), seen.min()), max(inside.max(), seen.max())
    across = MARGIN + (x - x[0]) / spread * (WIDTH - 2 * MARGIN)

    def path(values: Array) -> str:
        down = MARGIN + (high - values.clip(low, high)) / ((high - low) or 1.0) * (HEIGHT - 2 * MARGIN)
        places = [f"{px:.1f} {py:.1f}" for px, py in zip(across, down, strict=True) if np.isfinite(py)]
        return "M" + "L".join(places) if len(places) > 1 else ""

    return Thumbnail(path(exact), path(numerical))


def field_thumbnail(record: Record) -> str:
    """Draw the finest field of the first case of a study that has a field in two or three dimensions.

    Parameters
    ----------
    record : Record

    Returns
    -------
    str
        SVG, complete in itself, of the numerical field at a telling time; "" if the study has no such field.
    """
    for case in record.cases:
        found = [
            entry.spatial for entry in record.series if entry.case == case.name and entry.spatial and entry.spatial.numerical
        ]
        if found:
            return _thumbnail(min(found, key=lambda field: field.h), case.shown, case.name)
    return ""


def _thumbnail(field: Field, shown: str, name: str) -> str:
    every, key = fields.quantities(field), main_quantity(field, shown)
    quantity = next(entry for entry in every if entry.key == key)
    part, row = cut(field, FIELD_POINTS), fields.telling(quantity, np.arange(len(field.time)))
    layer = field_points.spacing(field.reference[part.points][:, part.axes], field.h)
    low, high = (corner[list(part.axes)] for corner in field_points.view(field, layer))
    factor = float(min(WIDTH / (high[0] - low[0]), FIELD_HEIGHT / (high[1] - low[1])))
    left, top = ((room - extent * factor) / 2 for room, extent in zip((WIDTH, FIELD_HEIGHT), high - low, strict=True))
    frame = Frame(low, high, float(left), float(top), factor)
    scale = fields.scale(quantity, fields.size_of_group(quantity.group, every))
    places = field_points.positions(field)[row][part.points][:, part.axes]
    drawn = "".join(dots(frame.place(places), quantity.numerical[row][part.points], scale, layer * factor))
    label = escape(f"{quantity.name}, {name}", quote=True)
    box = f"0 0 {WIDTH:g} {FIELD_HEIGHT:g}"
    return f'<svg class="field-thumbnail" viewBox="{box}" role="img" aria-label="{label}">{drawn}</svg>'
