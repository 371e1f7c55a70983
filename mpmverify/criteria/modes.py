"""Criteria on Fourier modes: the amplification factor of a scheme."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.bounds import judge_largest
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence, absent, first_absent
from mpmverify.exact.amplification import two_step_taylor_galerkin
from mpmverify.problem import Transport
from mpmverify.solution import Solution


@dataclass(frozen=True)
class Amplification:
    """After n steps of periodic advection, every Fourier mode is multiplied by the scheme's amplification factor G(theta)^n.

    Parameters
    ----------
    passes : int
        Number of mass-matrix passes of two-step Taylor-Galerkin.
    bound : float
        Largest deviation of the coefficient of a mode, relative to its initial value.
    source : str
    """

    passes: int
    bound: float
    source: str
    metric: ClassVar[str] = "amplification_defect"

    @property
    def title(self) -> str:
        return f"amplification factor of every Fourier mode to {self.bound:g}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        problem = setting.problem.problem
        if "u" not in solution.fields or problem.dimension != 1 or not isinstance(problem.material, Transport):
            return {}
        steps = np.round(solution.time / solution.dt)
        modes = np.fft.rfft(solution.fields["u"][:, :, 0], axis=1)
        if not np.all(np.isfinite(modes)):
            return {self.metric: np.nan, "amplification_modes": np.nan}
        if steps[-1] < 1:
            return {}
        if not modes[0].any():
            return {absent(self.metric): 1.0}
        theta = 2 * np.pi * np.arange(modes.shape[1]) / solution.reference.shape[0]
        h = problem.lengths[0] / solution.reference.shape[0]
        factor = two_step_taylor_galerkin(theta, problem.material.velocity * solution.dt / h, self.passes)
        # Modes that are (nearly) absent from the initial profile are skipped, such as the shortest mode sampled at its zeros.
        carried = np.abs(modes[0]) > 1e-3 * np.abs(modes[0]).max()
        initial = modes[0, carried]
        defect = np.abs(modes[:, carried] - initial * factor[carried] ** steps[:, None]) / np.abs(initial)
        return {self.metric: float(defect.max()), "amplification_modes": float(carried.sum() / len(carried))}

    def judge(self, evidence: Evidence) -> Judgement:
        if where := first_absent(self.metric, evidence):
            return Verdict.FAIL, f"the profile is zero at the start at {where}"
        share = evidence.metrics["amplification_modes"]
        if not np.all((share > 0) & (share <= 1)):
            return Verdict.ERROR, "no Fourier mode was followed on at least one level"
        verdict, reason = judge_largest(evidence.metrics[self.metric], self.bound, "deviation from G^n")
        return verdict, f"{reason}, over {share.min():.0%} of the modes"
