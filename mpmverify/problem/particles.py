"""Initial positions and volumes of the particles of a body."""

from dataclasses import dataclass

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem.discretisation import Discretisation
from mpmverify.problem.problem import Problem
from mpmverify.problem.quantities import Array

SLIVER = 1e-4
"""A part of a sub-cell that is smaller than this share of it is merged with a neighbour: alone it could reach massless nodes."""


@dataclass(frozen=True)
class Layout:
    """Initial places of particles in their sub-cells, `ppc` of which lie along each axis of a cell.

    Parameters
    ----------
    name : str
    gauss : bool
        Whether they are the points of Gauss-Legendre quadrature, in sub-cells as large as its weights, or the middles of equal sub-cells.
    offset : float
        Shift along every axis, as a share of the sub-cell, in (-1/2, 1/2). Volumes do not change, which is an error of quadrature.

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

    def in_cell(self, ppc: int) -> tuple[Array, Array]:
        """Places (ppc,) and ends of the sub-cells (ppc + 1,) along an axis of a cell [1]."""
        if not self.gauss:
            return (np.arange(ppc) + 0.5) / ppc, np.arange(ppc + 1) / ppc
        points, weights = np.polynomial.legendre.leggauss(ppc)
        return (1 + points) / 2, np.concatenate([[0.0], np.cumsum(weights[:-1]) / 2, [1.0]])


REGULAR = Layout("regular")
GAUSS = Layout("gauss", gauss=True)


def offset(share: float) -> Layout:
    """Regular particles, shifted from the middles of their sub-cells.

    Parameters
    ----------
    share : float
        Shift along every axis, as a share of the sub-cell.

    Raises
    ------
    UsageError
        If it is not in (-1/2, 1/2).
    """
    return Layout(f"offset{share:.12g}", offset=float(share))


def place_particles(problem: Problem, at: Discretisation, layout: Layout = REGULAR) -> tuple[Array, Array]:
    """Reference positions (P, d) [m], body by body with x fastest, and volumes (P,) [m^d], which sum to the measure of the body.

    Notes
    -----
    A body with a shape has a particle in each sub-cell that it covers, with the volume of the covered part, at its centroid where
    that is not the whole sub-cell. Particles at the middle of their sub-cells would have errors of the same size that fall irregularly
    with h. Offset and jitter move a particle within its sub-cell. Each of several bodies has its own particles.
    """
    points, ends = layout.in_cell(at.ppc)
    counts = at.cells(problem)

    def in_cells(along: Array) -> Array:
        return _mesh([(np.arange(cells)[:, None] + along).ravel() for cells in counts])

    corner = np.array(problem.lower)
    place = corner + at.h * in_cells(points)
    size = at.h * _mesh([np.tile(np.diff(ends), cells) for cells in counts])
    volume = size.prod(axis=1)
    if problem.shape is None and not layout.offset and not at.jitter:
        return place, volume
    lower, upper = corner + at.h * in_cells(ends[:-1]), corner + at.h * in_cells(ends[1:])
    random = np.random.default_rng(at.seed)
    found = []
    for body in (None,) if problem.shape is None else problem.shape.bodies:
        X, V = place, volume
        if body is not None:
            part, centroid = body.parts(lower, upper)
            X = np.where((part < (1 - 1e-12) * volume)[:, None], centroid, place)
            V, X = _without_slivers(part, X, SLIVER * volume, [cells * at.ppc for cells in reversed(counts)])
        if layout.offset or at.jitter:
            X = np.clip(X + (layout.offset + at.jitter * random.uniform(-1, 1, X.shape)) * size, lower, upper)
        found.append((X[V > 0], V[V > 0]))
    return np.concatenate([X for X, _ in found]), np.concatenate([V for _, V in found])


def _mesh(along: list[Array]) -> Array:
    """Every combination of one value along each axis (P, d), x fastest."""
    return np.stack([axis.ravel() for axis in reversed(np.meshgrid(*reversed(along), indexing="ij"))], axis=1)


def _without_slivers(part: Array, place: Array, least: Array, counts: list[int]) -> tuple[Array, Array]:
    """Measures (B,) and places (B, d) after each part smaller than `least` (B,) is merged with its largest neighbour across a side.

    The sums of measures and of first moments do not change; a part without a larger neighbour is kept.
    """
    number = np.pad(np.arange(len(part)).reshape(counts), 1, mode="edge")
    inner, before, after = slice(1, -1), slice(None, -2), slice(2, None)
    itself = (inner,) * len(counts)
    sides = [(*itself[:k], side, *itself[k + 1 :]) for k in range(len(counts)) for side in (before, after)]
    around = np.stack([number[where].ravel() for where in (itself, *sides)])
    largest = np.take_along_axis(around, part[around].argmax(axis=0)[None], axis=0)[0]
    into = np.where(part < least, largest, around[0])
    while not np.array_equal(into[into], into):
        into = into[into]
    total = np.bincount(into, part, len(part)).astype(np.float64)
    joined = total > part
    place = place.copy()
    for k in range(len(counts)):
        place[joined, k] = np.bincount(into, part * place[:, k], len(part))[joined] / total[joined]
    return total, place
