"""How a measured defect or error becomes a verdict."""

from collections.abc import Mapping

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.problem import Array


def are_sizes(values: Array) -> bool:
    """Whether there are values, all finite and none negative."""
    return bool(len(values) and np.all(np.isfinite(values) & (np.asarray(values) >= 0)))


def relative_defect(metric: str, defect: Array, scale: float) -> Mapping[str, float]:
    """Largest defect over its scale; nothing is measured on one sample, or on histories that are zero throughout."""
    if len(defect) < 2 or scale == 0:
        return {}
    return {metric: float(np.max(np.abs(defect)) / scale) if np.isfinite(scale) else np.nan}


def judge_largest(values: Array, bound: float, what: str) -> Judgement:
    if not are_sizes(values):
        return Verdict.ERROR, f"the {what} is not finite, or negative, on at least one level"
    verdict = Verdict.PASS if values.max() <= bound else Verdict.FAIL
    return verdict, f"largest {what} {values.max():.2e}, bound {bound:g}"
