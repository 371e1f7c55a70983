"""Small drawings of final profiles: the exact one behind the numerical one, as paths of SVG."""

from dataclasses import dataclass

import numpy as np

from .record import Array, Profile

WIDTH, HEIGHT, MARGIN, POINTS = 150.0, 48.0, 3.0, 100


@dataclass(frozen=True)
class Thumbnail:
    """Path data in a box of `WIDTH` by `HEIGHT`."""

    exact: str
    numerical: str


def thumbnail(profile: Profile, quantity: str) -> Thumbnail | None:
    """Draw the last profile of a quantity; None when it was not recorded or no value of the exact one is finite."""
    if quantity not in profile.fields:
        return None
    every = -(-len(profile.reference) // POINTS)
    x = profile.reference[::every]
    exact, numerical = profile.exact[quantity][-1, ::every], profile.fields[quantity][-1, ::every]
    both = np.concatenate([exact, numerical])
    # The scale is that of the whole run: a field that happens to vanish at its end would show nothing but round-off.
    seen, spread = profile.exact[quantity][np.isfinite(profile.exact[quantity])], np.ptp(x)
    if not np.isfinite(exact).any() or spread == 0:
        return None
    # A wild numerical profile may take half of the room again on either side, so that the exact one stays visible.
    room = np.ptp(seen) or float(np.abs(seen).max()) or 1.0
    inside = both[np.isfinite(both)].clip(seen.min() - 0.5 * room, seen.max() + 0.5 * room)
    low, high = min(inside.min(), seen.min()), max(inside.max(), seen.max())
    across = MARGIN + (x - x[0]) / spread * (WIDTH - 2 * MARGIN)

    def path(values: Array) -> str:
        down = MARGIN + (high - values.clip(low, high)) / ((high - low) or 1.0) * (HEIGHT - 2 * MARGIN)
        places = [f"{px:.1f} {py:.1f}" for px, py in zip(across, down, strict=True) if np.isfinite(py)]
        return "M" + "L".join(places) if len(places) > 1 else ""

    return Thumbnail(path(exact), path(numerical))
