"""Flat tables of a results folder, for the comparison of two folders."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from mpmverify.convergence.verdict import Verdict, worst
from mpmverify.judgement.findings import Finding

PROVENANCE = ("commit", "commit_state", "tier", "versions", "platform", "date_created")


class SeriesKey(NamedTuple):
    """Identifies one series of one study: a solver on one refinement of a case."""

    study: str
    case: str
    solver: str
    refinement: str


class Run(NamedTuple):
    """How one level was solved: outcome, time steps, steps times particles or elements, and wall time without compilation [s]."""

    outcome: str
    steps: int
    point_steps: int
    seconds: float


class Order(NamedTuple):
    """Fitted order with its confidence interval, and the levels of the series."""

    order: float
    low: float
    high: float
    levels: frozenset[str]


@dataclass(frozen=True)
class Tables:
    """Contents of the studies of one results folder.

    Parameters
    ----------
    provenance : mapping
        `PROVENANCE` attributes by study.
    runs : mapping
        By (series, level); a level is "h=... nu_C=... ppc=...".
    errors : mapping
        (absolute error, exact norm), in the unit of the field, by (series, level, "quantity norm"); for completed runs only.
    orders : mapping
        By (series, "quantity norm"); only series with a fit.
    verdicts : mapping
        By (series, "gate: criterion"); the worst verdict if several criteria have the same title.
    """

    provenance: Mapping[str, Mapping[str, str]]
    runs: Mapping[tuple[SeriesKey, str], Run]
    errors: Mapping[tuple[SeriesKey, str, str], tuple[float, float]]
    orders: Mapping[tuple[SeriesKey, str], Order]
    verdicts: Mapping[tuple[SeriesKey, str], Verdict]


def verdicts_by_criterion(findings: Iterable[Finding]) -> dict[tuple[SeriesKey, str], Verdict]:
    """Return verdicts by (series, "gate: criterion"); the worst verdict if several criteria have the same title."""
    verdicts: dict[tuple[SeriesKey, str], Verdict] = {}
    for f in findings:
        judged = SeriesKey(f.study, f.case, f.solver, f.refinement), f"{f.gate}: {f.criterion}"
        verdicts[judged] = worst((f.verdict, verdicts.get(judged, f.verdict)))
    return verdicts
