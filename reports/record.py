"""Records: frozen dataclasses with the content of a study file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpmverify.convergence.sources import Separation
from mpmverify.convergence.verdict import Verdict
from mpmverify.dataset.history import History
from mpmverify.judgement.findings import Finding

Array = NDArray[np.float64]
Measure = tuple[str, str]
"""(quantity, norm)."""


@dataclass(frozen=True)
class Level:
    """One run of a series: `h` [m], `dt` [s], wall time `seconds` [s]; `run` is the key of the run file."""

    h: float
    dt: float
    courant: float
    ppc: int
    steps: int
    point_steps: int
    seconds: float
    outcome: str
    run: str

    def size(self, name: str) -> float:
        """Return the size "h" [m], "dt" [s] or "1/ppc"."""
        return 1 / self.ppc if name == "1/ppc" else float(getattr(self, name))


@dataclass(frozen=True)
class Estimate:
    """Errors of one series in one quantity and norm, with the order fitted to them.

    Parameters
    ----------
    error, absolute : Array
        Relative and absolute errors (L,), coarsest level first.
    units : str
        Unit of the absolute errors.
    pairwise : Array
        Observed order from the next coarser level (L,).
    kept : tuple of bool
        Whether each level is in the fit.
    dropped : tuple of str
        The dropped levels, with reasons.
    order, low, high : float
        Fitted order and its interval.
    floor : float
        Error that remains as the size goes to zero.
    classification : str
    """

    error: Array
    absolute: Array
    units: str
    pairwise: Array
    kept: tuple[bool, ...]
    dropped: tuple[str, ...]
    order: float
    low: float
    high: float
    floor: float
    classification: str


@dataclass(frozen=True)
class Profile:
    """Fields (T, P) of one level at T output times [s] and P points, sorted by reference position [m]."""

    h: float
    time: Array
    reference: Array
    fields: Mapping[str, Array]
    exact: Mapping[str, Array]
    units: Mapping[str, str]

    def error(self, quantity: str) -> Array:
        """Return the numerical minus the exact field (T, P)."""
        difference: Array = self.fields[quantity] - self.exact[quantity]
        return difference


@dataclass(frozen=True)
class Field:
    """Fields of one level in two or three dimensions, at T output times and P points.

    Parameters
    ----------
    h : float
        Cell size [m].
    time : Array
        Output times (T,) [s].
    reference : Array
        Reference positions of the points (P, dim) [m].
    numerical : mapping of str to Array
        Numerical fields (T, P) by component: "displacement_x", "stress_xy".
    exact, error : mapping of str to Array
        Exact fields (T, P), and numerical minus exact ones, of the components whose exact field is known. The error is as stored:
        it has digits that the difference of the two fields has lost.
    units : mapping of str to str
        Unit of each component (UDUNITS spelling).
    """

    h: float
    time: Array
    reference: Array
    numerical: Mapping[str, Array]
    exact: Mapping[str, Array]
    error: Mapping[str, Array]
    units: Mapping[str, str]

    @property
    def dimension(self) -> int:
        return self.reference.shape[1]


@dataclass(frozen=True)
class Series:
    """One solver on one ladder of one case.

    Parameters
    ----------
    case, solver, family, refinement : str
        `family` is the name of the class of the solver, and `refinement` the label of the ladder.
    axis : str
        The refined size, or "" for a design, which has no orders.
    formal : mapping of str to float
        Declared order by quantity.
    levels : tuple of Level
    estimates : mapping of Measure to Estimate
    criteria : mapping of str to mapping
        Fields of each declared criterion by its title; "type" is the name of its class.
    findings : tuple of Finding
    metrics : mapping of str to Array
        What the criteria measured, by name, on every level.
    separations : mapping of Measure to Separation
    profile : Profile or None
    histories, history_units : mapping of str
        Histories (N,) of the level that is shown, and their units.
    """

    case: str
    solver: str
    family: str
    refinement: str
    axis: str
    formal: Mapping[str, float]
    levels: tuple[Level, ...]
    estimates: Mapping[Measure, Estimate]
    criteria: Mapping[str, Mapping[str, Any]]
    findings: tuple[Finding, ...]
    metrics: Mapping[str, Array] = field(default_factory=dict)
    separations: Mapping[Measure, Separation] = field(default_factory=dict)
    profile: Profile | None = None
    spatial: Field | None = None
    histories: Mapping[str, Array] = field(default_factory=dict)
    history_units: Mapping[str, str] = field(default_factory=dict)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Refined size of each level; empty for a design."""
        return tuple(level.size(self.axis) for level in self.levels) if self.axis else ()

    @cached_property
    def bands(self) -> Mapping[Measure, tuple[float, float]]:
        """Accepted orders by measure."""
        judged = (entry for entry in self.criteria.values() if entry["type"] == "Order")
        return {(entry["quantity"], entry["norm"]): (entry["low"], entry["high"]) for entry in judged}

    @property
    def verified(self) -> tuple[Finding, ...]:
        """Findings of the verification gate, or all findings if it has none."""
        return tuple(finding for finding in self.findings if finding.gate == "verification") or self.findings

    @property
    def passed(self) -> bool:
        return all(finding.verdict is Verdict.PASS for finding in self.verified)

    @property
    def completed(self) -> bool:
        return all(level.outcome == "completed" for level in self.levels)

    @property
    def failed(self) -> bool:
        """Whether a run did not complete that should have: the criterion `Unstable` expects that its runs do not."""
        kinds = {self.criteria.get(f.criterion, {}).get("type") for f in self.findings if f.verdict is Verdict.PASS}
        return not self.completed and "Unstable" not in kinds


@dataclass(frozen=True)
class Case:
    """A case of a study: its verification problem, described for readers, and the quantity that is shown first."""

    name: str
    exposes: str
    citation: str
    equations: tuple[str, ...]
    setup: tuple[tuple[str, str], ...]
    shown: str

    @property
    def dimension(self) -> int:
        """Number of axes of the domain, which the set-up states as "[0, 1] m x [0, 2] m"."""
        return dict(self.setup)["domain"].count("[")


@dataclass(frozen=True)
class Record:
    """A study file: attributes, cases, scheme of each solver, series, a finding on baseline series that are missing, and which verdicts changed."""

    name: str
    attributes: Mapping[str, Any]
    cases: tuple[Case, ...]
    schemes: Mapping[str, str]
    series: tuple[Series, ...]
    lacking: tuple[Finding, ...] = ()
    history: History = field(default_factory=History)

    @property
    def judged(self) -> tuple[Finding, ...]:
        """Findings on all series."""
        return tuple(finding for series in self.series for finding in series.findings)

    @property
    def findings(self) -> tuple[Finding, ...]:
        return self.judged + self.lacking

    @property
    def restricted_to(self) -> str:
        """The part of the study that was run; "" for the whole study."""
        return str(self.attributes.get("restricted_to", ""))
