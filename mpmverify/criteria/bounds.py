"""Verdicts on measured defects and errors."""

from collections.abc import Mapping

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.evidence import absent
from mpmverify.problem import Array


def finite_and_non_negative(values: Array) -> bool:
    """Whether there is at least one value and all are finite and not negative."""
    return bool(len(values) and np.all(np.isfinite(values) & (np.asarray(values) >= 0)))


def relative_defect(metric: str, defect: Array, scale: float) -> Mapping[str, float]:
    """Largest magnitude of a defect, relative to its scale; empty if there are fewer than two samples, `absent` if the scale is zero."""
    if len(defect) < 2:
        return {}
    if scale == 0:
        return {absent(metric): 1.0}
    return {metric: float(np.max(np.abs(defect)) / scale) if np.isfinite(scale) else np.nan}


def judge_largest(values: Array, bound: float, what: str) -> Judgement:
    """PASS if no value exceeds the bound, else FAIL; ERROR if a value is not finite or is negative. `what` names the values."""
    if not finite_and_non_negative(values):
        return Verdict.ERROR, f"the {what} is not finite, or negative, on at least one level"
    verdict = Verdict.PASS if values.max() <= bound else Verdict.FAIL
    return verdict, f"largest {what} {values.max():.2e}, bound {bound:g}"
