"""Criterion on the outcomes of runs: above its stability limit, a solver must report instability."""

from collections.abc import Mapping
from dataclasses import dataclass

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.criterion import OnLimits, OnOutcomes, Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.solution import Solution, Status


@dataclass(frozen=True)
class Unstable(OnOutcomes, OnLimits):
    """Every run above the stability limit ends with the status unstable; completed, crashed and non-finite runs do not pass.

    The initial data must contain an unstable mode, so that its growth does not depend on round-off.

    Parameters
    ----------
    limit : float
        Courant number up to which the scheme is stable; all levels must lie above it.
    source : str
    """

    limit: float
    source: str

    @property
    def title(self) -> str:
        return f"unstable above nu_C = {self.limit:.4g}"

    @property
    def change(self) -> float:
        """5 %: the initial data hold the unstable mode, so that its growth, and with it the last step, does not hang on round-off."""
        return 0.05

    def compared(self, evidence: Evidence, level: int) -> Mapping[str, tuple[float, float]]:
        """Return the number of steps until the instability is reported: it measures the growth of the mode."""
        steps = 0.0 if evidence.steps is None else float(evidence.steps[level])
        return {f"steps until {evidence.outcomes[level].partition(';')[0]}": (steps, steps)}

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        return {}

    def judge(self, evidence: Evidence) -> Judgement:
        if not (evidence.courant > self.limit).all():
            return Verdict.ERROR, f"a level at nu_C={evidence.courant.min():g} does not lie above the limit"
        ended = {name: outcome.partition(";")[0] for name, outcome in zip(evidence.names, evidence.outcomes, strict=True)}
        wrong = {name: status for name, status in ended.items() if status != Status.UNSTABLE}
        verdict = Verdict.FAIL if Status.COMPLETED in wrong.values() else Verdict.ERROR
        if wrong:
            return verdict, f"not unstable above the limit: {'; '.join(f'{name}: {status}' for name, status in wrong.items())}"
        return Verdict.PASS, f"unstable on every level, nu_C from {evidence.courant.min():.4g} on"
