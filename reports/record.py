"""A study as it is read from its file: plain frozen values, one series at a time."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpmverify.convergence.sources import Separation
from mpmverify.convergence.verdict import Verdict
from mpmverify.judgement.findings import Finding

Array = NDArray[np.float64]
Measure = tuple[str, str]
"""(quantity, norm)."""


@dataclass(frozen=True)
class Level:
    """One run of a series."""

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
        """Size that a series may refine, by its name: h [m], dt [s] or 1/ppc."""
        return 1 / self.ppc if name == "1/ppc" else float(getattr(self, name))


@dataclass(frozen=True)
class Estimate:
    """Errors of one series in one quantity and norm, coarsest level first, and the order that was fitted to them.

    `units` are those of the absolute errors.
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
    """Fields of one level at its output times: T times, P points, sorted by reference position."""

    h: float
    time: Array
    reference: Array
    fields: Mapping[str, Array]
    exact: Mapping[str, Array]
    units: Mapping[str, str]

    def error(self, quantity: str) -> Array:
        """Numerical less exact field (T, P)."""
        difference: Array = self.fields[quantity] - self.exact[quantity]
        return difference


@dataclass(frozen=True)
class Series:
    """One solver on one ladder of one case; `axis` is the size that it refines, "" for a design, which has no orders."""

    case: str
    solver: str
    family: str
    refinement: str
    axis: str
    formal: Mapping[str, float]
    levels: tuple[Level, ...]
    estimates: Mapping[Measure, Estimate]
    bands: Mapping[Measure, tuple[float, float]]
    findings: tuple[Finding, ...]
    metrics: Mapping[str, Array] = field(default_factory=dict)
    separations: Mapping[Measure, Separation] = field(default_factory=dict)
    profile: Profile | None = None
    histories: Mapping[str, Array] = field(default_factory=dict)
    history_units: Mapping[str, str] = field(default_factory=dict)

    @property
    def sizes(self) -> tuple[float, ...]:
        """Size of each level along the axis; none of a design."""
        return tuple(level.size(self.axis) for level in self.levels) if self.axis else ()

    @property
    def verified(self) -> tuple[Finding, ...]:
        """Findings that tell whether the series is right: those of the verification gate, or all where it judged nothing."""
        return tuple(finding for finding in self.findings if finding.gate == "verification") or self.findings

    @property
    def passed(self) -> bool:
        return all(finding.verdict is Verdict.PASS for finding in self.verified)

    @property
    def completed(self) -> bool:
        return all(level.outcome == "completed" for level in self.levels)


@dataclass(frozen=True)
class Case:
    """What a study says of one of its verification problems."""

    name: str
    exposes: str
    citation: str
    equations: tuple[str, ...]
    setup: tuple[tuple[str, str], ...]
    shown: str


@dataclass(frozen=True)
class Record:
    """A study's file: its attributes, cases, schemes by solver and series; `lacking` says what the baseline has beside these."""

    name: str
    attributes: Mapping[str, Any]
    cases: tuple[Case, ...]
    schemes: Mapping[str, str]
    series: tuple[Series, ...]
    lacking: tuple[Finding, ...] = ()

    @property
    def judged(self) -> tuple[Finding, ...]:
        """Findings on the series."""
        return tuple(finding for series in self.series for finding in series.findings)

    @property
    def findings(self) -> tuple[Finding, ...]:
        return self.judged + self.lacking

    @property
    def restricted_to(self) -> str:
        """What its run was restricted to; "" where it was not."""
        return str(self.attributes.get("restricted_to", ""))
