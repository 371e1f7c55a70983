"""Thumbnails of final profiles as SVG paths: the numerical profile in front of the exact one."""

from dataclasses import dataclass

import numpy as np

from .record import Array, Profile

WIDTH, HEIGHT, MARGIN, POINTS = 150.0, 48.0, 3.0, 100


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
