"""Studies: a verification problem, solvers, refinements and criteria, declared as values."""

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from mpmverify.convergence.axis import Axis, axis
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import SeriesId
from mpmverify.errors import UsageError
from mpmverify.exact import VerificationProblem
from mpmverify.problem import Discretisation
from mpmverify.solution import Solver

TIERS = ("quick", "full")


@dataclass(frozen=True)
class Refinement:
    """A ladder of discretisations, or a design that varies several of h, dt and particles per cell independently.

    Parameters
    ----------
    label : str
        Names the ladder within its case, such as "nu_C=0.5".
    levels : tuple of Discretisation
        Coarsest first.
    quick : int
        How many of them, from the coarsest, the quick tier runs.

    Raises
    ------
    UsageError
        If the quick tier runs no level, or more than there are.
    """

    label: str
    levels: tuple[Discretisation, ...]
    quick: int

    def __post_init__(self) -> None:
        if not 1 <= self.quick <= len(self.levels):
            raise UsageError(f"ladder {self.label!r} has {len(self.levels)} levels: the quick tier cannot run {self.quick}")

    def tier(self, tier: str) -> tuple[Discretisation, ...]:
        """Levels that a tier runs.

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
        return self.levels[: self.quick] if tier == "quick" else self.levels

    @property
    def axis(self) -> Axis:
        """What the levels refine; a time step is as long as the Courant number allows."""
        columns = np.array([(level.h, level.courant * level.h, level.ppc) for level in self.levels])
        return axis(*columns.T)

    def with_courant(self, courant: float) -> "Refinement":
        """Return the same ladder at another Courant number [1] throughout; levels that become equal are one."""
        levels = tuple(dict.fromkeys(dataclasses.replace(level, courant=courant) for level in self.levels))
        return Refinement(ladder_label(courant, levels[0].ppc), levels, min(self.quick, len(levels)))

    def with_jitter(self, jitter: float, seed: int) -> "Refinement":
        """Return the same ladder with the particles moved from their places, as a `Discretisation` says."""
        levels = tuple(dataclasses.replace(level, jitter=jitter, seed=seed) for level in self.levels)
        return Refinement(f"{self.label}, jitter {jitter:g}, seed {seed}", levels, self.quick)


def ladder_label(courant: float, ppc: int) -> str:
    """Name of a ladder in h: its Courant number [1], and its particles per cell where there are several."""
    return f"nu_C={courant:g}" + (f", {ppc} ppc" if ppc > 1 else "")


def halving(
    length: float, cells: int, *, quick: int, full: int, courant: float, ppc: int = 1, courant_power: float = 0.0
) -> Refinement:
    """Ladder of `full` levels that starts with `cells` cells on `length` and halves h.

    Parameters
    ----------
    length : float
        Side of the box [m].
    cells : int
        Cells on it, on the coarsest level.
    quick, full : int
        Levels that the quick and the full tier run.
    courant : float
        Courant number of the coarsest level [1].
    ppc : int
        Particles per cell.
    courant_power : float
        The Courant number falls as h to this power: 0.5 makes dt proportional to h^(3/2), so that a scheme of second order
        in time shows an order of three in h.

    Raises
    ------
    UsageError
        If a level cannot be discretised, or the quick tier runs no level or more than there are.
    """
    levels = tuple(
        Discretisation(h=length / (cells * 2**k), courant=courant * 0.5 ** (k * courant_power), ppc=ppc) for k in range(full)
    )
    label = ladder_label(courant, ppc) + (f", nu_C ~ h^{courant_power:g}" if courant_power else "")
    return Refinement(label, levels, quick)


def in_time(length: float, cells: int, *, quick: int, full: int, courant: float, ppc: int = 1) -> Refinement:
    """Ladder of `full` levels on `cells` cells of `length` that starts at a Courant number and halves dt.

    Parameters
    ----------
    length, cells, quick, full, courant, ppc
        As of `halving`; h is the same on every level.
    """
    levels = tuple(Discretisation(length / cells, courant * 0.5**k, ppc) for k in range(full))
    return Refinement(f"dt from {ladder_label(courant, ppc)}, {cells} cells", levels, quick)


def in_particles(length: float, cells: int, *, courant: float, ppc: Sequence[int]) -> Refinement:
    """Ladder in particles per cell on `cells` cells of `length`, all of it in both tiers.

    Parameters
    ----------
    length, cells, courant
        As of `halving`; h and dt are the same on every level.
    ppc : sequence of int
        Particles per cell, by level.
    """
    levels = tuple(Discretisation(length / cells, courant, count) for count in ppc)
    return Refinement(f"ppc, {ladder_label(courant, 1)}, {cells} cells", levels, len(levels))


def design(length: float, *, cells: Sequence[int], courant: Sequence[float], ppc: Sequence[int] = (1,)) -> Refinement:
    """Every combination of cell size, time step and particles per cell, all of them in both tiers.

    Parameters
    ----------
    length : float
        Side of the box [m].
    cells : sequence of int
        Cells on `length`.
    courant : sequence of float
        Courant numbers on the first number of cells, each of which stands for a time step that all cell sizes share.
    ppc : sequence of int
        Particles per cell.
    """
    levels = tuple(
        Discretisation(length / count, number * count / cells[0], particles)
        for count, number, particles in product(cells, courant, ppc)
    )
    counts = (("h", len(cells)), ("dt", len(courant)), ("ppc", len(ppc)))
    return Refinement(" x ".join(f"{count} {size}" for size, count in counts if count > 1), levels, len(levels))


@dataclass(frozen=True)
class Series:
    """One solver on one ladder, and what must hold of it.

    Parameters
    ----------
    solver : Solver
    refinement : Refinement
    criteria : tuple of Criterion
    """

    solver: Solver
    refinement: Refinement
    criteria: tuple[Criterion, ...]


@dataclass(frozen=True)
class Case:
    """One verification problem and the series that are run on it.

    Parameters
    ----------
    name : str
        Names the case within its study.
    problem : VerificationProblem
    series : tuple of Series
    shown : str
        The quantity that the pages plot first.
    """

    name: str
    problem: VerificationProblem
    series: tuple[Series, ...]
    shown: str


@dataclass(frozen=True)
class Study:
    """Cases that belong on one page.

    Parameters
    ----------
    name : str
        On the command line and in file names.
    title, summary : str
        For people.
    cases : tuple of Case
    restricted_to : str
        Of what was declared the part that these cases are, in words; "" for the whole.

    Raises
    ------
    UsageError
        If two series share their case, solver and refinement, two solvers share a name, or a name cannot be that of a file.
    """

    name: str
    title: str
    summary: str
    cases: tuple[Case, ...]
    restricted_to: str = ""

    def __post_init__(self) -> None:
        seen = set()
        named: dict[str, Solver] = {}
        for case, series in self.series():
            identity = (case.name, series.solver.name, series.refinement.label)
            if identity in seen:
                raise UsageError(f"study {self.name!r} declares {' / '.join(identity)} twice")
            seen.add(identity)
            if named.setdefault(series.solver.name, series.solver) != series.solver:
                raise UsageError(f"study {self.name!r} has two solvers of the name {series.solver.name!r}: rename one")
        for name in (self.name, *named):
            if not name or "/" in name or name.startswith("."):
                raise UsageError(f"{name!r} cannot name a file or a group: give it letters and no '/'")

    def series(self) -> Iterator[tuple[Case, Series]]:
        """Every series beside its case, as declared."""
        for case in self.cases:
            for series in case.series:
                yield case, series

    def criteria(self) -> dict[SeriesId, tuple[Criterion, ...]]:
        """Declared criteria of every series."""
        return {
            SeriesId(case.name, series.solver.name, series.refinement.label): series.criteria for case, series in self.series()
        }

    def solvers(self) -> dict[str, Solver]:
        """Solvers by name, as declared."""
        return {series.solver.name: series.solver for _, series in self.series()}

    def solver_names(self) -> tuple[str, ...]:
        """Names of the solvers, each once, as declared."""
        return tuple(self.solvers())

    def restricted(self, solvers: tuple[str, ...] = (), courant: float | None = None) -> "Study":
        """Return the study with the named solvers alone, and at one Courant number throughout; it says what it was restricted to."""
        cases = []
        for case in self.cases:
            chosen: dict[tuple[str, str], Series] = {}
            for series in case.series:
                if solvers and series.solver.name not in solvers:
                    continue
                if courant is not None:
                    series = dataclasses.replace(series, refinement=series.refinement.with_courant(courant))
                chosen.setdefault((series.solver.name, series.refinement.label), series)
            if chosen:
                cases.append(dataclasses.replace(case, series=tuple(chosen.values())))
        kept = dataclasses.replace(self, cases=tuple(cases))
        names = kept.solver_names()
        parts = [", ".join(names)] if len(names) < len(self.solver_names()) else []
        parts += [] if courant is None else [f"Courant number {courant:g}"]
        return dataclasses.replace(kept, restricted_to="; ".join(parts) or self.restricted_to)
