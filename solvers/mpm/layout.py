"""Where the particles of a body begin."""

from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem import Array, Discretisation, Problem

SLIVER = 1e-4
"""Parts of a sub-cell below this share of it belong to the particle of a neighbour."""


@dataclass(frozen=True)
class Layout:
    """Where the particles of a cell begin along each axis: in sub-cells of their volumes.

    Parameters
    ----------
    name : str
    gauss : bool
        At the points of Gauss-Legendre quadrature, with its weights for volumes, instead of the middles of equal sub-cells.
    offset : float
        From there, as a share of the sub-cell, in (-1/2, 1/2). Volumes stay: the quadrature is off by it.

    Raises
    ------
    UsageError
        If the offset is not in (-1/2, 1/2).
    """

    name: str
    gauss: bool = False
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.offset) < 0.5:
            raise UsageError(f"the offset of the particles is a share of their sub-cell in (-0.5, 0.5), not {self.offset!r}")

    def along(self, cells: int, ppc: int) -> tuple[Array, Array]:
        """Places (cells ppc,) and ends of the sub-cells (cells ppc + 1,) along an axis, in cells from its lower end."""
        if self.gauss:
            points, weights = np.polynomial.legendre.leggauss(ppc)
            first = np.arange(cells)[:, None]
            inner = np.concatenate([[0.0], np.cumsum(weights[:-1]) / 2])
            return (first + (1 + points) / 2).ravel(), np.append((first + inner).ravel(), cells)
        ends = np.arange(cells * ppc + 1) / ppc
        return (np.arange(cells * ppc) + 0.5) / ppc, ends


REGULAR = Layout("regular")
GAUSS = Layout("gauss", gauss=True)


def offset(share: float) -> Layout:
    """Particles off the middles of their sub-cells by this share of them along every axis.

    Raises
    ------
    UsageError
        If it is not in (-1/2, 1/2).
    """
    return Layout(f"offset{share:g}", offset=share)


def place_particles(problem: Problem, at: Discretisation, layout: Layout = REGULAR) -> tuple[Array, Array]:
    """Reference positions (P, d) [m], x fastest, and volumes (P,) [m^d].

    `ppc` sub-cells along each axis of a cell, a particle in each that the body covers at least in part, and its volume that of the
    part. It begins at its place in the layout, or at the centroid of the part where that is not the whole; offset and jitter move it
    from there, but not out of its sub-cell.
    """
    axes = [layout.along(cells, at.ppc) for cells in at.cells(problem)]
    place = np.array(problem.lower) + at.h * _mesh([places for places, _ in axes])
    lower, upper = (np.array(problem.lower) + at.h * _mesh([ends[side] for _, ends in axes]) for side in (np.s_[:-1], np.s_[1:]))
    size = upper - lower
    volume = size.prod(axis=1)
    if problem.shape is not None:
        area, centroid = problem.shape.parts(lower, upper)
        cut = area < volume * (1 - 1e-12)
        place[cut] = centroid[cut]
        volume, place = _without_slivers(area, place, SLIVER * volume, [len(p) for p, _ in reversed(axes)])
    if layout.offset or at.jitter:
        random = np.random.default_rng(at.seed)
        moved = layout.offset + at.jitter * random.uniform(-1, 1, place.shape)
        place = np.clip(place + moved * size, lower, upper)
    return place[volume > 0], volume[volume > 0]


def _mesh(along: list[Array]) -> Array:
    """Points (P, d) of coordinates along each axis, x fastest."""
    return np.stack([axis.ravel() for axis in reversed(np.meshgrid(*reversed(along), indexing="ij"))], axis=1)


def _without_slivers(area: Array, place: Array, least: Array, counts: list[int]) -> tuple[Array, Array]:
    """Areas (B,) and places (B, 2) when every part below `least` (B,) has joined the largest of its neighbours across a side.

    The body keeps its measure, and where the places are centroids its centroid, too.
    """
    number = np.pad(np.arange(len(area)).reshape(counts), 1, mode="edge")
    around = np.stack([number[1:-1, 1:-1], number[:-2, 1:-1], number[2:, 1:-1], number[1:-1, :-2], number[1:-1, 2:]]).reshape(5, -1)
    largest = np.take_along_axis(around, area[around].argmax(axis=0)[None], axis=0)[0]
    into = np.where(area < least, largest, around[0])
    while not np.array_equal(into[into], into):
        into = into[into]
    total = np.bincount(into, area, len(area))
    moment = np.stack([np.bincount(into, area * x, len(area)) for x in place.T], axis=1)
    joined = total > area
    place[joined] = moment[joined] / total[joined, None]
    return total, place
