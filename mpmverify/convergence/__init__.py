"""Orders of convergence, what they are worth, and verdicts on them: plain arrays from any code in, no solver near."""

from mpmverify.convergence.fits import CONFIDENCE, Fit, FloorFit, fit_floor, fit_order, pairwise_orders
from mpmverify.convergence.judging import PLAUSIBLE, judge_order, verdict
from mpmverify.convergence.series import ROUND_OFF, Classification, Convergence, analyse

__all__ = [
    "CONFIDENCE",
    "PLAUSIBLE",
    "ROUND_OFF",
    "Classification",
    "Convergence",
    "Fit",
    "FloorFit",
    "analyse",
    "fit_floor",
    "fit_order",
    "judge_order",
    "pairwise_orders",
    "verdict",
]
