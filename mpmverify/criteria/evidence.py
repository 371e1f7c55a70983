"""Evidence: what the runs of one series left behind, as the judge takes it."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mpmverify.convergence import Convergence, analyse
from mpmverify.convergence import axis as refined
from mpmverify.convergence.sources import Separation, separate
from mpmverify.criteria.metrics import Metrics
from mpmverify.criteria.norms import NORMS
from mpmverify.problem import Array
from mpmverify.solution import ADVICE


class SeriesId(NamedTuple):
    """One series of a study: a solver on one ladder of a case."""

    case: str
    solver: str
    refinement: str


@dataclass(frozen=True)
class Level:
    """What is kept of one run beside its file.

    Parameters
    ----------
    case, solver, refinement : str
        Series that the run belongs to.
    h : float
        Cell size [m].
    courant : float
        Courant number [1].
    ppc : int
        Particles per cell and dimension.
    key : str
        Content key of the run.
    jitter : float
        Largest displacement of a particle as a share of the spacing [1].
    seed : int
        Seed of the displacements.
    dt : float
        Time step [s]; NaN when the run never began.
    steps, point_steps : int
        Time steps, and particles or elements times steps.
    seconds : float
        Wall time without compilation [s].
    outcome : str
        "completed", or what happened.
    errors : mapping of str to (Array, Array)
        Error norms and exact norms (norms,) by quantity, in the order of `norms.NORMS` and the unit of the quantity.
    metrics : mapping of str to float
        What the criteria measured on the solution.
    """

    case: str
    solver: str
    refinement: str
    h: float
    courant: float
    ppc: int
    key: str
    jitter: float = 0.0
    seed: int = 0
    dt: float = np.nan
    steps: int = 0
    point_steps: int = 0
    seconds: float = 0.0
    outcome: str = "completed"
    errors: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)

    @property
    def series(self) -> SeriesId:
        """Series that the run belongs to."""
        return SeriesId(self.case, self.solver, self.refinement)


@dataclass(frozen=True)
class Evidence:
    """What one series of runs, n levels of one solver, left behind.

    Parameters
    ----------
    h, dt, courant, ppc : Array
        Levels (n,).
    outcomes : tuple of str
        "completed", or what happened, by level.
    error, reference : mapping of str to Array
        Norms of the error and of the exact field by quantity, (n, norms) in the order of `norms.NORMS`.
    metrics : mapping of str to Array
        Whatever the criteria measured on the solutions, (n,) by name.
    jitter, seed : Array, optional
        Of the particles, (n,); None where all stand at their places.
    """

    h: Array
    dt: Array
    courant: Array
    ppc: Array
    outcomes: tuple[str, ...]
    error: Mapping[str, Array] = field(default_factory=dict)
    reference: Mapping[str, Array] = field(default_factory=dict)
    metrics: Mapping[str, Array] = field(default_factory=dict)
    jitter: Array | None = None
    seed: Array | None = None
    _separations: dict[tuple[tuple[str, ...], str, str], Separation] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @property
    def axis(self) -> refined.Axis:
        """What the levels refine."""
        return refined.axis(self.h, self.dt, self.ppc)

    @property
    def names(self) -> tuple[str, ...]:
        """Each level by its cell size, and by its Courant number and particles per cell where several share that."""
        if len(np.unique(self.h)) == len(self.h):
            return tuple(f"h={h:g}" for h in self.h)
        return tuple(f"h={h:g} nu_C={c:g} ppc={ppc}" for h, c, ppc in zip(self.h, self.courant, self.ppc, strict=True))

    @property
    def incomplete(self) -> str:
        """What became of the runs that did not complete, each outcome and each advice once; "" where every run did."""
        levels: dict[tuple[str, str], list[int]] = {}
        for k, outcome in enumerate(self.outcomes):
            advice = next((known for known in ADVICE.values() if known and outcome.endswith(f"; {known}")), "")
            levels.setdefault((advice, outcome.removesuffix(f"; {advice}")), []).append(k)
        sentences: dict[str, list[str]] = {}
        for (advice, outcome), members in levels.items():
            if outcome != "completed":
                sentences.setdefault(advice, []).append(f"{self._which(members)}: {outcome}")
        return "; ".join(part for advice, told in sentences.items() for part in (*told, advice) if part)

    def _which(self, levels: Sequence[int]) -> str:
        """Name some levels, in ascending order: neighbours by the first and the last of them."""
        if len(levels) == len(self.outcomes) > 1:
            return "every level"
        spans: list[list[int]] = []
        for k in levels:
            if spans and k == spans[-1][-1] + 1:
                spans[-1].append(k)
            else:
                spans.append([k])
        first_to_last = (dict.fromkeys((self.names[span[0]], self.names[span[-1]])) for span in spans)
        return ", ".join(" to ".join(ends) for ends in first_to_last)

    @property
    def sizes(self) -> Mapping[str, Array]:
        """Every size that an error may vanish with, by its name (n,)."""
        return refined.sizes(self.h, self.dt, self.ppc)

    def relative(self, quantity: str, norm: str) -> Array:
        """Error over the exact norm (n,); absolute where the exact field vanishes, NaN where its norm is not finite."""
        k = NORMS.index(norm)
        size = np.where(np.isfinite(self.reference[quantity][:, k]), self.reference[quantity][:, k], np.nan)
        return self.error[quantity][:, k] / np.where(size == 0, 1.0, size)

    def convergence(self, quantity: str, norm: str, expected: tuple[float, float] | None = None) -> Convergence | None:
        """Analyse one relative error over the size that the levels refine; None for a design, which has no single order."""
        size = self.axis.size
        if not size:
            return None
        series = analyse(self.sizes[size], self.relative(quantity, norm), expected=expected)
        return replace(series, dropped=tuple(re.sub(r"^h=", f"{size}=", sentence) for sentence in series.dropped))

    def separation(self, sizes: tuple[str, ...], quantity: str, norm: str) -> Separation:
        """Tell the sources of one relative error apart; kept, since the verdict and the file need the same one.

        Parameters
        ----------
        sizes : tuple of str
            Sizes that the sources vanish with, of those of `sizes`.
        quantity, norm : str
        """
        asked = sizes, quantity, norm
        if asked not in self._separations:
            self._separations[asked] = separate({size: self.sizes[size] for size in sizes}, self.relative(quantity, norm))
        return self._separations[asked]


def evidence_of(levels: Sequence[Level]) -> Evidence:
    """Evidence of one series.

    Parameters
    ----------
    levels : sequence of Level
        Runs of one series. A quantity is absent that a level lacks or whose exact norm is not finite; a metric is absent that no
        level has, and NaN where one lacks it.
    """
    first = levels[0].errors if levels else {}
    quantities = [q for q in first if all(q in level.errors and np.isfinite(level.errors[q][1]).all() for level in levels)]
    metrics = dict.fromkeys(name for level in levels for name, value in level.metrics.items() if not np.isnan(value))
    return Evidence(
        h=np.array([level.h for level in levels]),
        dt=np.array([level.dt for level in levels]),
        courant=np.array([level.courant for level in levels]),
        ppc=np.array([level.ppc for level in levels]),
        jitter=np.array([level.jitter for level in levels]),
        seed=np.array([level.seed for level in levels]),
        outcomes=tuple(level.outcome for level in levels),
        error={quantity: np.array([level.errors[quantity][0] for level in levels]) for quantity in quantities},
        reference={quantity: np.array([level.errors[quantity][1] for level in levels]) for quantity in quantities},
        metrics=Metrics({name: np.array([level.metrics.get(name, np.nan) for level in levels]) for name in metrics}),
    )


def evidence_by_series(levels: Iterable[Level]) -> dict[SeriesId, Evidence]:
    """Evidence of every series that some levels belong to, in their order."""
    table: dict[SeriesId, list[Level]] = {}
    for level in levels:
        table.setdefault(level.series, []).append(level)
    return {series: evidence_of(members) for series, members in table.items()}
