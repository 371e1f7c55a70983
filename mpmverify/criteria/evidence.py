"""Evidence: the results of the runs of one series, on which criteria are judged."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mpmverify.convergence import ROUND_OFF, Convergence, analyse
from mpmverify.convergence import axis as axes
from mpmverify.convergence.sources import Separation, separate
from mpmverify.criteria.metrics import Metrics
from mpmverify.criteria.norms import NORMS
from mpmverify.problem import Array


class SeriesId(NamedTuple):
    """Identifies one series of a study: a solver on one refinement of a case."""

    case: str
    solver: str
    refinement: str


@dataclass(frozen=True)
class Level:
    """Summary of one run: its discretisation, outcome, errors and metrics.

    Parameters
    ----------
    case, solver, refinement : str
        Series of the run.
    h : float
        Cell size [m].
    courant : float
        Courant number [1].
    ppc : int
        Particles per cell and dimension.
    key : str
        Content key of the run.
    jitter : float
        Largest random displacement of a particle, relative to the particle spacing [1].
    seed : int
        Seed of the displacements.
    dt : float
        Time step [s]; NaN when the run never began.
    steps, point_steps : int
        Number of time steps, and that number times the number of particles or elements.
    seconds : float
        Wall time without compilation [s].
    outcome : str
        "completed", or how the run failed.
    errors : mapping of str to (Array, Array)
        Error norms, and sizes of the exact field over the run (norms,), by quantity in the order of `norms.NORMS` and in its unit.
    metrics : mapping of str to float
        Measurements of the criteria on the solution, by name.
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
        """Series of the run."""
        return SeriesId(self.case, self.solver, self.refinement)


@dataclass(frozen=True)
class Evidence:
    """Results of one series: the runs of one solver on n levels.

    Parameters
    ----------
    h, dt, courant, ppc : Array
        Cell size [m], time step [s], Courant number [1] and particles per cell and dimension of each level (n,).
    outcomes : tuple of str
        "completed", or how the run failed, by level.
    error, reference : mapping of str to Array
        Norms of the error, and sizes of the exact field over the run, by quantity: (n, norms) in the order of `norms.NORMS` and the
        unit of the quantity.
    metrics : mapping of str to Array
        Measurements of the criteria on the solutions, (n,) by name.
    jitter, seed : Array, optional
        Largest random displacement of a particle relative to the spacing [1], and its seed (n,); None without displacements.
    steps : Array, optional
        Number of time steps that a run made (n,).
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
    steps: Array | None = None
    _series: dict[tuple[str, str, float], Convergence] = field(default_factory=dict, init=False, repr=False, compare=False)
    _separations: dict[tuple[tuple[str, ...], str, str], Separation] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @cached_property
    def axis(self) -> axes.Axis:
        """Refinement axis of the levels."""
        return axes.axis(self.h, self.dt, self.ppc)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each level: its cell size, followed by its Courant number and particles per cell if a cell size occurs twice."""
        if len(np.unique(self.h)) == len(self.h):
            return tuple(f"h={h:g}" for h in self.h)
        return tuple(f"h={h:g} nu_C={c:g} ppc={ppc}" for h, c, ppc in zip(self.h, self.courant, self.ppc, strict=True))

    @property
    def incomplete(self) -> str:
        """How the incomplete runs failed, with each outcome and each piece of advice once; "" if every run completed."""
        levels: dict[tuple[str, str], list[int]] = {}
        for k, outcome in enumerate(self.outcomes):
            ended, _, advice = outcome.rpartition("; ")
            levels.setdefault((advice, ended) if ended else ("", outcome), []).append(k)
        sentences: dict[str, list[str]] = {}
        for (advice, outcome), members in levels.items():
            if outcome != "completed":
                sentences.setdefault(advice, []).append(f"{self._name_levels(members)}: {outcome}")
        return "; ".join(part for advice, told in sentences.items() for part in (*told, advice) if part)

    def _name_levels(self, levels: Sequence[int]) -> str:
        """Name the given levels (ascending indices); a span of neighbours is named by its first and last level."""
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
        """Every size with which an error may vanish, by name (n,)."""
        return axes.sizes(self.h, self.dt, self.ppc)

    def relative(self, quantity: str, norm: str) -> Array:
        """Error relative to the size of the exact field (n,); absolute where that is zero, NaN where it is not finite."""
        k = NORMS.index(norm)
        size = np.where(np.isfinite(self.reference[quantity][:, k]), self.reference[quantity][:, k], np.nan)
        return self.error[quantity][:, k] / np.where(size == 0, 1.0, size)

    def convergence(
        self, quantity: str, norm: str, expected: tuple[float, float] | None = None, round_off: float = ROUND_OFF
    ) -> Convergence | None:
        """Analyse one relative error over the refined size; None for a design, which has no single order.

        The result is cached, because both the verdict and the results file need it.
        """
        size, asked = self.axis.size, (quantity, norm, round_off)
        if not size:
            return None
        if asked not in self._series:
            self._series[asked] = analyse(self.sizes[size], self.relative(quantity, norm), round_off=round_off, size=size)
        return self._series[asked] if expected is None else self._series[asked].expecting(expected)

    def separation(self, sizes: tuple[str, ...], quantity: str, norm: str) -> Separation:
        """Separate the sources of one relative error.

        Parameters
        ----------
        sizes : tuple of str
            Sizes with which the sources vanish: keys of the property `sizes`.
        quantity, norm : str

        Notes
        -----
        The result is cached, because both the verdict and the results file need it.
        """
        asked = sizes, quantity, norm
        if asked not in self._separations:
            self._separations[asked] = separate({size: self.sizes[size] for size in sizes}, self.relative(quantity, norm))
        return self._separations[asked]


def absent(metric: str) -> str:
    """Name of the metric that records, in place of `metric`, that a solution does not have what is measured, such as a front."""
    return f"{metric}_absent"


def first_absent(metric: str, evidence: Evidence) -> str:
    """Return the name of the first level whose solution does not have what is measured; "" if all have it, or none was looked at."""
    found = evidence.metrics.get(absent(metric))
    return "" if found is None else evidence.names[int(np.argmax(found == 1))]


def evidence_of(levels: Sequence[Level]) -> Evidence:
    """Collect the evidence of one series.

    Parameters
    ----------
    levels : sequence of Level
        Runs of one series.

    Returns
    -------
    Evidence
        With the quantities that every level has with finite exact norms, and the metrics that at least one level has; a metric is NaN
        on levels that lack it.
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
        steps=np.array([level.steps for level in levels]),
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
