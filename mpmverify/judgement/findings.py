"""Findings: verdicts of criteria, with the information that a reader needs to act on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.criterion import Criterion, OnOutcomes
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.metrics import NotMeasuredError


@dataclass(frozen=True)
class Finding:
    """One verdict, with the information that a reader needs to act on it.

    Parameters
    ----------
    study, case, solver, refinement : str
        Series that was judged.
    gate : str
        "verification" or "regression".
    criterion : str
        Title of the criterion.
    verdict : Verdict
    reason : str
        What was measured.
    source : str
        Source of the expectation.
    limit : str
        "known limit" if the criterion expects a limit of the scheme, else "".
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
    limit: str = ""

    @property
    def word(self) -> str:
        """The verdict as people read it: to pass by a limit of the scheme is no plain success."""
        return f"{self.verdict} ({self.limit})" if self.limit and self.verdict is Verdict.PASS else str(self.verdict)

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> "Finding":
        """Make a finding from its fields as stored in a file; an unknown verdict raises a `ValueError`."""
        return cls(**(dict(fields) | {"verdict": Verdict(fields["verdict"])}))

    def __str__(self) -> str:
        return f"{self.word} {self.study}/{self.case}/{self.solver} ({self.refinement}): {self.criterion}: {self.reason}"


def judge_criterion(criterion: Criterion, evidence: Evidence) -> Judgement:
    """Judge one criterion on one series.

    If a run did not complete, the verdict is ERROR with the outcome of the run, unless the criterion is on outcomes.
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
            f"{missing} was not measured on this series: {_cause(missing, evidence)}, it is not finite, or the results are old",
        )


def _cause(missing: KeyError, evidence: Evidence) -> str:
    """Say why something was not measured: a field is compared with the exact one, which a problem may lack."""
    if isinstance(missing, NotMeasuredError):
        return "the solver does not return it"
    both = ", ".join(evidence.error) or "none"
    return f"the solver does not return it, the exact solution does not have it (both have {both})"
