"""From evidence to findings: the only place where a study is judged."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from mpmverify.convergence import ROUND_OFF, Convergence
from mpmverify.convergence.sources import Separation
from mpmverify.criteria import Order, Separated
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import Evidence, SeriesId
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import ResultsError
from mpmverify.judgement import baseline as regression
from mpmverify.judgement.findings import Finding, judge_criterion

Fits = Mapping[tuple[str, str], Convergence]
"""Analysis of each relative error of a series by (quantity, norm)."""


@dataclass(frozen=True)
class Judged:
    """A judged study.

    Parameters
    ----------
    evidence : mapping of SeriesId to Evidence
        Evidence of each series.
    declared : mapping of SeriesId to sequence of Criterion
        Criteria of each series.
    by_series : mapping of SeriesId to tuple of Finding
        Findings of each series, ordered by solver.
    missing_series : Finding or None
        Finding on series that are in the baseline but not in the results; None if there are none.
    """

    evidence: Mapping[SeriesId, Evidence]
    declared: Mapping[SeriesId, Sequence[Criterion]]
    by_series: Mapping[SeriesId, tuple[Finding, ...]]
    missing_series: Finding | None

    @cached_property
    def fits(self) -> Mapping[SeriesId, Fits]:
        """Analysis of each error; empty for a design, which has no single order."""
        return {series: _fits(self.declared.get(series, ()), self.evidence[series]) for series in self.by_series}

    @cached_property
    def separations(self) -> Mapping[SeriesId, tuple[tuple[Separated, Separation], ...]]:
        """Sources of error, for each criterion that separates them."""
        return {series: _separations(self.declared.get(series, ()), self.evidence[series]) for series in self.by_series}

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All findings, with the one on missing series last."""
        listed = [finding for findings in self.by_series.values() for finding in findings]
        return (*listed, *([self.missing_series] if self.missing_series else []))


def judge(
    study: str,
    declared: Mapping[SeriesId, Sequence[Criterion]],
    evidence: Mapping[SeriesId, Evidence],
    baseline: regression.Baseline | None = None,
    restricted_to: str = "",
) -> Judged:
    """Judge a study: verification by its criteria, regression by the baseline.

    Parameters
    ----------
    study : str
    declared : mapping of SeriesId to sequence of Criterion
        Criteria of each series.
    evidence : mapping of SeriesId to Evidence
    baseline : Baseline, optional
        Without a baseline there is no regression gate.
    restricted_to : str
        Part of the study to which the run was restricted; "" for the whole study.

    Raises
    ------
    ResultsError
        If a criterion is declared for a series without evidence; it must not be skipped silently.
    """
    for series in (series for series in declared if series not in evidence):
        for criterion in declared[series]:
            where = f"{study}/{series.case}/{series.solver} ({series.refinement})"
            raise ResultsError(f"{criterion.title!r} is declared for {where}, which has no results: run it again")
    solvers = list(dict.fromkeys(series.solver for series in evidence))
    ordered = sorted(evidence, key=lambda series: solvers.index(series.solver))
    return Judged(
        evidence=evidence,
        declared=declared,
        by_series={
            series: _findings(study, series, declared.get(series, ()), evidence[series], baseline) for series in ordered
        },
        missing_series=baseline.missing_series(study, ordered, restricted_to) if baseline else None,
    )


def _findings(
    study: str, series: SeriesId, criteria: Sequence[Criterion], seen: Evidence, baseline: regression.Baseline | None
) -> tuple[Finding, ...]:
    case, solver, refinement = series
    findings = [
        Finding(
            *(study, case, solver, refinement, "verification", criterion.title),
            *judge_criterion(criterion, seen),
            criterion.source,
            getattr(criterion, "marker", ""),
        )
        for criterion in criteria
    ]
    if baseline and baseline.gates(study):
        judgement = baseline.judge(study, solver, case, refinement, seen, criteria)
        findings.append(Finding(study, case, solver, refinement, "regression", regression.TITLE, *judgement, baseline.source))
    return tuple(findings)


def _fits(criteria: Sequence[Criterion], seen: Evidence) -> Fits:
    orders = [one for one in criteria if isinstance(one, Order)]
    of_quantity = {one.quantity: one.round_off for one in orders}
    told = {(one.quantity, one.norm): one.round_off for one in orders}
    found = {
        (quantity, norm): seen.convergence(
            quantity, norm, round_off=told.get((quantity, norm), of_quantity.get(quantity, ROUND_OFF))
        )
        for quantity in seen.error
        for norm in NORMS
    }
    return {measure: series for measure, series in found.items() if series}


def _separations(criteria: Sequence[Criterion], seen: Evidence) -> tuple[tuple[Separated, Separation], ...]:
    return tuple(
        (criterion, criterion.separation(seen))
        for criterion in criteria
        if isinstance(criterion, Separated) and criterion.quantity in seen.error
    )
