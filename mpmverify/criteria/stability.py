"""Criterion on the largest stable time step that a search by bisection has found."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.bounds import judge_largest
from mpmverify.criteria.criterion import OnLimits, Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.errors import UsageError
from mpmverify.exact.stability import LIMITS
from mpmverify.solution import Solution


@dataclass(frozen=True)
class StabilityLimit(OnLimits):
    """On every level, the largest stable Courant number found by a `Bisection` agrees with the limit of von Neumann's analysis.

    Parameters
    ----------
    scheme : str
        Name in `mpmverify.exact.stability.LIMITS`.
    bound : float
        Largest deviation from the limit, relative to it.
    source : str

    Raises
    ------
    UsageError
        If the scheme has no known limit.
    """

    scheme: str
    bound: float
    source: str

    metrics: ClassVar[tuple[str, str]] = ("stability_limit", "theoretical_stability_limit")
    """Courant numbers [1]: measured and theoretical."""

    def __post_init__(self) -> None:
        if self.scheme not in LIMITS:
            raise UsageError(f"the stability limit of {self.scheme!r} is unknown: choose from {', '.join(LIMITS)}")

    @property
    def title(self) -> str:
        return f"limit of stability of {self.scheme} to {self.bound:g}"

    @property
    def change(self) -> float:
        """Half of the bound, above the resolution of the bisection of 0.1 %."""
        return self.bound / 2

    def compared(self, evidence: Evidence, level: int) -> Mapping[str, tuple[float, float]]:
        """Return the measured limit: at it, round-off decides how large the growing wave is, and the error with it."""
        limit = float(evidence.metrics[self.metrics[0]][level])
        return {self.metrics[0]: (limit, limit)}

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        at = setting.discretisation
        measured = solution.dt * setting.problem.problem.material.wave_speed / at.h
        return dict(zip(self.metrics, (measured, LIMITS[self.scheme](at.ppc)), strict=True))

    def judge(self, evidence: Evidence) -> Judgement:
        measured, theory = (evidence.metrics[name] for name in self.metrics)
        if not (evidence.courant > (1 + self.bound) * theory).all():
            return Verdict.ERROR, "a level does not reach beyond the limit: give it a larger Courant number"
        verdict, reason = judge_largest(np.abs(measured / theory - 1), self.bound, "deviation of the limit")
        pairs = ", ".join(
            f"{found:.4f} for {known:.4f} at {ppc:g} ppc"
            for found, known, ppc in zip(measured, theory, evidence.ppc, strict=True)
        )
        return verdict, f"{reason}: nu_C = {pairs}"
