"""What a criterion is: what it measures on a solution, and how it judges the evidence of a series."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from mpmverify.convergence.verdict import Judgement
from mpmverify.criteria.evidence import Evidence
from mpmverify.exact import VerificationProblem
from mpmverify.problem import Discretisation
from mpmverify.solution import Solution


@dataclass(frozen=True)
class Setting:
    """What a run was to solve: the problem with its exact solution, and on which level."""

    problem: VerificationProblem
    discretisation: Discretisation


class Criterion(Protocol):
    """What must hold."""

    @property
    def source(self) -> str:
        """Where the expectation comes from."""

    @property
    def title(self) -> str:
        """What is judged, in a few words."""

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        """Numbers that the judgement needs and only the solution can give, by name."""

    def judge(self, evidence: Evidence) -> Judgement:
        """Verdict on completed runs, with the reason in one sentence."""


class OnOutcomes:
    """Base of a criterion on how runs end: judged even when runs did not complete."""


class OnLimits:
    """Base of a criterion that expects a limit of the scheme, a stall or an instability: its series has no regression verdict.

    Where particles cross cells the error is noise, and the last digits of another compiler change the first ones. An unstable run
    has no error, and at the limit of stability rounding decides how far a wave has grown.
    """


def has_baseline(criteria: Iterable[Criterion]) -> bool:
    """Whether a series with these criteria is compared with the baseline: not where one expects a limit of the scheme."""
    return not any(isinstance(criterion, OnLimits) for criterion in criteria)
