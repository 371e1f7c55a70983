"""Protocol of a criterion: it measures quantities on each solution and judges the evidence of a series."""

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
    """Problem, with its exact solution, and discretisation of a run."""

    problem: VerificationProblem
    discretisation: Discretisation


class Criterion(Protocol):
    """A requirement on a series of runs."""

    @property
    def source(self) -> str:
        """Source of the expectation, such as a citation."""

    @property
    def title(self) -> str:
        """Short description of what is judged."""

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        """Return the numbers that the judgement needs from a solution, in addition to its error norms, by name."""

    def judge(self, evidence: Evidence) -> Judgement:
        """Return the verdict on the runs of a series, with the reason in one sentence."""


class OnOutcomes:
    """Base class of criteria on the outcomes of runs: judged even when runs did not complete."""


class OnLimits:
    """Base class of criteria that expect a limit of the scheme (a stall or an instability): their series have no regression verdict.

    The errors of such series are not reproducible. Cell crossings of particles amplify differences in round-off between compilers,
    an unstable run has no error, and at the stability limit round-off determines the amplitude of the growing wave.
    """


def has_baseline(criteria: Iterable[Criterion]) -> bool:
    """Whether a series with these criteria is compared with the baseline: no criterion expects a limit of the scheme."""
    return not any(isinstance(criterion, OnLimits) for criterion in criteria)
