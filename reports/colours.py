"""Colour maps of fields, for light and dark pages; readers with any of the common colour deficiencies can tell their ends apart."""

from dataclasses import dataclass

Map = tuple[str, ...]


@dataclass(frozen=True)
class Palette:
    """Colours of fields on one kind of page.

    Parameters
    ----------
    rising, signed : tuple of str
        Evenly spaced colours of fields with one sign, and of fields with both signs, whose middle stands for zero.
    missing : str
        Colour of values that are not finite.
    """

    rising: Map
    signed: Map
    missing: str


PALETTES = {
    "light": Palette(
        ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#f1df2b"),
        ("#0b3c7d", "#2f6bb0", "#6a9fce", "#a9c6dc", "#d3d3d0", "#e8b594", "#dd7f4f", "#b94a25", "#7c1f0d"),
        "#d6006c",
    ),
    "dark": Palette(
        ("#6a3d9a", "#5f56b0", "#4b73b8", "#3c8fb4", "#36a8a2", "#4cc089", "#7fd46a", "#bde24f", "#fdf06a"),
        ("#8ec5ff", "#64a5ea", "#4a82bd", "#476789", "#53585e", "#8a6450", "#c37c4f", "#ec9b5e", "#ffc48c"),
        "#ff5fa8",
    ),
}
"""Palettes by page.

On a light page the colours of one sign are those of viridis (van der Walt and Smith, 2015) with a darker bright end; on a dark page
the dark end is lighter. So no point has the colour of the page.
"""


def mixed(stops: Map, share: float) -> str:
    """Return the colour at `share`, from 0 to 1, of a map."""
    place = min(max(share, 0.0), 1.0) * (len(stops) - 1)
    k = min(int(place), len(stops) - 2)
    ends = [[int(stop[n : n + 2], 16) for n in (1, 3, 5)] for stop in stops[k : k + 2]]
    return "#" + "".join(f"{round(a + (b - a) * (place - k)):02x}" for a, b in zip(*ends, strict=True))
