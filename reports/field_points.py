"""Points of fields in two and three dimensions: where they are, and which of them a page shows."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .record import Array, Field

OUTPUTS = 16
"""Largest number of output times that a page shows of a field."""
LATTICE = 0.8
"""Share of the points that must be alone in cells of one spacing for them to count as a lattice."""
BISECTIONS = 14
"""Steps in which the size of the cells is found from which points are drawn."""


def positions(field: Field, *, exact: bool = False) -> Array:
    """Return the positions (T, P, dim) [m]: reference plus displacement, or the reference where no displacement was stored.

    Where a displacement is not finite, the point is drawn where the exact one is, or else at its reference position.
    """
    names = [f"displacement_{axis}" for axis in "xyz"[: field.dimension]]
    still = np.broadcast_to(field.reference, (len(field.time), *field.reference.shape))
    if not set(names) <= field.numerical.keys():
        return still
    place = still
    if set(names) <= field.exact.keys():
        known = still + np.stack([field.exact[name] for name in names], axis=-1)
        place = np.where(np.isfinite(known), known, still)
    if exact:
        return place
    moved = still + np.stack([field.numerical[name] for name in names], axis=-1)
    return np.where(np.isfinite(moved), moved, place)


def outputs(field: Field, most: int = OUTPUTS) -> NDArray[np.intp]:
    """Return the rows of at most `most` output times, evenly spaced, the last and, of several, the first among them."""
    count = len(field.time)
    return np.unique(np.round(np.linspace(count - 1, 0, min(count, most))).astype(int))


def subsample(reference: Array, most: int) -> NDArray[np.intp]:
    """Return the indices of at most `most` points (P, dim), spread evenly.

    Of a lattice, which may have some other points at its edge, these are the points of a coarser one; else the first point in each
    cell of a grid as fine as possible.
    """
    if len(reference) <= most:
        return np.arange(len(reference))
    apart = spacing(reference, 1.0)
    if len(_first_in_cells(reference, apart, apart / 2)) >= LATTICE * len(reference):
        for every in range(2, len(reference) + 1):
            first = _first_in_cells(reference, every * apart, apart / 2)
            if len(first) <= most:
                return np.sort(first)
    coarse, fine = float(np.ptp(reference, axis=0).max()) or 1.0, 0.0
    best = np.zeros(1, dtype=np.intp)
    for _ in range(BISECTIONS):
        edge = (coarse + fine) / 2
        first = _first_in_cells(reference, edge, 0.0)
        if len(first) > most:
            fine = edge
        else:
            coarse = edge
            best = first if len(first) > len(best) else best
    return np.sort(best)


def _first_in_cells(reference: Array, edge: float, offset: float) -> NDArray[np.intp]:
    """Return the first point in each cell of a grid that begins `offset` [m] before the points (P, dim)."""
    cells = np.floor((reference - reference.min(axis=0) + offset) / edge).astype(np.int64)
    return np.unique(np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1)), return_index=True)[1]


def spacing(reference: Array, h: float) -> float:
    """Return the median distance [m] of points (P, dim) from their nearest neighbours; `h` if there is none."""
    near = _nearest(np.ascontiguousarray(reference).tobytes(), reference.shape[1]) if len(reference) > 1 else 0.0
    return near if near > 0 else h


@lru_cache(maxsize=512)
def _nearest(points: bytes, dimension: int) -> float:
    """Return the median distance of points from their nearest neighbours; the fields of many series are at the same points."""
    places = np.frombuffer(points).reshape(-1, dimension)
    return float(np.median(cKDTree(places).query(places, k=2)[0][:, 1]))


def thinnest(reference: Array) -> int:
    """Return the axis along which points (P, dim) extend least, the last of equal ones."""
    extent = np.ptp(reference, axis=0)
    return max(k for k in range(len(extent)) if extent[k] <= extent.min() * (1 + 1e-6))


def view(field: Field, layer: float) -> tuple[Array, Array]:
    """Return the corners (dim,), (dim,) [m] of the box in which a field is drawn.

    It holds the exact positions, or the numerical ones where no displacement is known, at all shown times with a margin of one
    spacing `layer` [m], and the numerical positions up to half its size beyond.
    """
    rows = outputs(field)
    known = positions(field, exact=True)[rows].reshape(-1, field.dimension)
    moved = positions(field)[rows].reshape(-1, field.dimension)
    low, high = known.min(axis=0), known.max(axis=0)
    if not {f"displacement_{axis}" for axis in "xyz"[: field.dimension]} <= field.exact.keys():
        low, high = np.quantile(moved, 0.01, axis=0), np.quantile(moved, 0.99, axis=0)
    room = 0.5 * np.maximum(high - low, layer)
    inside = moved.clip(low - room, high + room)
    return np.minimum(low, inside.min(axis=0)) - layer, np.maximum(high, inside.max(axis=0)) + layer
