"""Ladders and designs of discretisations, and the tiers that run them."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from mpmverify.convergence.axis import Axis, axis
from mpmverify.errors import UsageError
from mpmverify.problem import Discretisation

TIERS = ("quick", "full")


@dataclass(frozen=True)
class Refinement:
    """A ladder of discretisations, or a design that varies several of h, dt and particles per cell independently.

    Parameters
    ----------
    label : str
        Name of the ladder within its case, such as "nu_C=0.5".
    levels : tuple of Discretisation
        Coarsest first.
    quick : int
        Number of levels, from the coarsest, in the quick tier; 0 for a ladder of the full tier alone.

    Raises
    ------
    UsageError
        If there is no level, or `quick` is negative or exceeds the number of levels.
    """

    label: str
    levels: tuple[Discretisation, ...]
    quick: int

    def __post_init__(self) -> None:
        if not self.levels or not 0 <= self.quick <= len(self.levels):
            raise UsageError(
                f"ladder {self.label!r} has {len(self.levels)} levels: let the quick tier run 0 to {len(self.levels)}, not {self.quick}"
            )

    def tier(self, tier: str) -> tuple[Discretisation, ...]:
        """Return the levels of a tier.

        Parameters
        ----------
        tier : str
            "quick" or "full".

        Raises
        ------
        UsageError
            If there is no such tier.
        """
        if tier not in TIERS:
            raise UsageError(f"there is no tier {tier!r}: choose from {', '.join(TIERS)}")
        return self.levels[: self.quick if tier == "quick" else None]

    @property
    def axis(self) -> Axis:
        """The sizes that the levels refine; the time steps are taken as the largest that the Courant numbers allow."""
        return axis(*np.array([(level.h, level.courant * level.h, level.ppc) for level in self.levels]).T)

    def with_courant(self, courant: float) -> "Refinement":
        """Return the same ladder with one Courant number [1] on all levels; levels that become equal are merged."""
        levels = tuple(dict.fromkeys(dataclasses.replace(level, courant=courant) for level in self.levels))
        return Refinement(ladder_label(courant, levels[0].ppc), levels, min(self.quick, len(levels)))

    def with_jitter(self, jitter: float, seed: int) -> "Refinement":
        """Return the same ladder with randomly displaced particles, see `Discretisation`."""
        levels = tuple(dataclasses.replace(level, jitter=jitter, seed=seed) for level in self.levels)
        return Refinement(f"{self.label}, jitter {jitter:g}, seed {seed}", levels, self.quick)


def ladder_label(courant: float, ppc: int) -> str:
    """Return the name of a ladder in h: its Courant number [1], and the particles per cell if there are several."""
    return f"nu_C={courant:g}" + (f", {ppc} ppc" if ppc > 1 else "")


def halving(
    length: float, cells: int, *, quick: int, full: int, courant: float, ppc: int = 1, courant_power: float = 0.0
) -> Refinement:
    """Return a ladder of `full` levels that halves h, with `cells` cells on `length` on the coarsest level.

    Parameters
    ----------
    length : float
        Side of the box [m].
    cells : int
        Number of cells on that side, on the coarsest level.
    quick, full : int
        Number of levels in the quick and in the full tier.
    courant : float
        Courant number of the coarsest level [1].
    ppc : int
        Particles per cell.
    courant_power : float
        Power of h with which the Courant number falls. 0.5 makes dt proportional to h^(3/2), so that a scheme of second order in
        time shows an order of three in h.

    Raises
    ------
    UsageError
        If a value is not valid for a `Discretisation`, or `quick` is less than 1 or exceeds `full`.
    """
    levels = tuple(
        Discretisation(h=length / (cells * 2**k), courant=courant * 0.5 ** (k * courant_power), ppc=ppc) for k in range(full)
    )
    label = ladder_label(courant, ppc) + (f", nu_C ~ h^{courant_power:g}" if courant_power else "")
    return Refinement(label, levels, quick)


def in_time(length: float, cells: int, *, quick: int, full: int, courant: float, ppc: int = 1) -> Refinement:
    """Return a ladder of `full` levels that halves dt at a fixed cell size.

    Parameters
    ----------
    length, cells, quick, full, courant, ppc
        See `halving`; h is the same on every level.
    """
    levels = tuple(Discretisation(length / cells, courant * 0.5**k, ppc) for k in range(full))
    return Refinement(f"dt from {ladder_label(courant, ppc)}, {cells} cells", levels, quick)


def in_particles(length: float, cells: int, *, courant: float, ppc: Sequence[int]) -> Refinement:
    """Return a ladder in particles per cell at a fixed cell size and time step; both tiers run all levels.

    Parameters
    ----------
    length, cells, courant
        See `halving`; h and dt are the same on every level.
    ppc : sequence of int
        Particles per cell of each level.
    """
    levels = tuple(Discretisation(length / cells, courant, count) for count in ppc)
    return Refinement(f"ppc, {ladder_label(courant, 1)}, {cells} cells", levels, len(levels))


def design(length: float, *, cells: Sequence[int], courant: Sequence[float], ppc: Sequence[int] = (1,)) -> Refinement:
    """Return a design with every combination of cell size, time step and particles per cell; both tiers run all of it.

    Parameters
    ----------
    length : float
        Side of the box [m].
    cells : sequence of int
        Numbers of cells on that side.
    courant : sequence of float
        Courant numbers at the first number of cells; each defines a time step that is used with all cell sizes.
    ppc : sequence of int
        Particles per cell.
    """
    levels = tuple(
        Discretisation(length / count, number * count / cells[0], particles)
        for count, number, particles in product(cells, courant, ppc)
    )
    counts = (("h", len(cells)), ("dt", len(courant)), ("ppc", len(ppc)))
    return Refinement(" x ".join(f"{count} {size}" for size, count in counts if count > 1), levels, len(levels))
