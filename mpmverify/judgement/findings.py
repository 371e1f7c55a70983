"""Findings: a criterion judged, with everything that a reader needs to act on it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.criterion import Criterion, OnOutcomes
from mpmverify.criteria.evidence import Evidence


@dataclass(frozen=True)
class Finding:
    """One verdict with everything that a reader needs to act on it.

    Parameters
    ----------
    study, case, solver, refinement : str
        What was judged.
    gate : str
        "verification" or "regression".
    criterion : str
        Title of the criterion.
    verdict : Verdict
    reason : str
        What was measured.
    source : str
        Where the expectation comes from.
    """

    study: str
    case: str
    solver: str
    refinement: str
    gate: str
    criterion: str
    verdict: Verdict
    reason: str
    source: str

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> "Finding":
        """Make a finding of its fields as a file holds them; an unknown verdict is a `ValueError`."""
        return cls(**(dict(fields) | {"verdict": Verdict(fields["verdict"])}))

    def __str__(self) -> str:
        return f"{self.verdict} {self.study}/{self.case}/{self.solver} ({self.refinement}): {self.criterion}: {self.reason}"


def judge_criterion(criterion: Criterion, evidence: Evidence) -> Judgement:
    """Judge one criterion of one series.

    A run that did not complete is an ERROR with its outcome, before any number is looked at, except to a criterion on outcomes.
    """
    if evidence.incomplete and not isinstance(criterion, OnOutcomes):
        return Verdict.ERROR, evidence.incomplete
    if not evidence.outcomes:
        return Verdict.ERROR, "no level was run"
    try:
        return criterion.judge(evidence)
    except KeyError as missing:
        return (
            Verdict.ERROR,
            f"{missing} was not measured on this series: the solver does not return it, or the results are old",
        )
