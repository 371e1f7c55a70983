"""Verdict on an error series from its observed order."""

import numpy as np

from mpmverify.convergence.levels import Numbers, numbers
from mpmverify.convergence.series import FLAT, ROUND_OFF, STEP_SLACK, Classification, Convergence, analyse
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.errors import UsageError

PLAUSIBLE = 12.0
"""Largest credible order in h or dt. A higher one means that a coarse level is unstable, or that a fine level is exact by chance."""
NOT_FINITE = "the error is not finite on at least one level"


def judge_order(series: Convergence, low: float, high: float) -> Judgement:
    """Judge the order of a series; INCONCLUSIVE unless the fit and the finest refinement step agree.

    Parameters
    ----------
    series : Convergence
        Result of `analyse`.
    low, high : float
        Accepted band of orders.

    Returns
    -------
    (Verdict, str)
        The verdict and its reason in one sentence.

    Notes
    -----
    PASS if the confidence interval lies inside the band, the finest step leaves the band by no more than `STEP_SLACK`, and the trend
    of the observed orders does not lead below it. FAIL if the error has a floor, stagnates or grows, or the interval lies wholly
    outside the band, and the finest step lies outside on the same side and does not approach the band: levels that are not yet
    asymptotic are no proof of a fault. A series that does not converge passes in no band, and `PLAUSIBLE` bounds every band from
    above. An error that grows in the finest step, but decreased fast enough over the last two steps together, is
    INCONCLUSIVE, because it may alternate.
    """
    kind, fit, used = series.classification, series.fit, int(series.kept.sum())
    if kind is Classification.NON_FINITE:
        return Verdict.ERROR, NOT_FINITE
    if kind is Classification.EXACT:
        return (
            Verdict.INCONCLUSIVE,
            f"exact: the error is at most {series.error.max():.1e} on every level, which is round-off and has no order",
        )
    without = f", without {'; '.join(series.dropped)}" if series.dropped else ""
    if used < 3 or fit is None:
        return Verdict.INCONCLUSIVE, f"{used} of {len(series.h)} levels can be used ({kind}){without}; an order needs three"
    high = min(high, PLAUSIBLE)
    band = f"[{low:g}, {high:g}]"
    measured = f"order {fit.order:.3f}, interval [{fit.low:.3f}, {fit.high:.3f}] from {used} levels ({kind}){without}"
    change, lasts = series.trend()
    step, ahead = series.finest_step(low, high), series.finest_step(low, high, change)
    approaches = series.approaches(low, high)
    too_slow, too_fast = step < 0 and not approaches, step > 0 and not approaches
    if series.floor is not None:
        reason = f"the error stops at a floor of {series.floor.floor:.2e}: {measured}"
        return Verdict.FAIL if too_slow else Verdict.INCONCLUSIVE, reason
    if kind in (Classification.STAGNANT, Classification.DIVERGENT):
        if too_slow and series.last_two_steps(low) < 0:
            return Verdict.FAIL, f"the error does not converge: {measured}"
        return Verdict.INCONCLUSIVE, f"the error does not converge on these levels: {measured}"
    if fit.high < low or fit.low > high:
        if too_slow if fit.high < low else too_fast:
            return Verdict.FAIL, f"{measured} lies outside {band}"
        return Verdict.INCONCLUSIVE, f"{measured} lies outside {band}, but the finest levels approach it: add a finer level"
    if not (low <= fit.low and fit.high <= high):
        return Verdict.INCONCLUSIVE, f"{measured} straddles an edge of {band}"
    if series.plunges(high):
        return Verdict.INCONCLUSIVE, f"{measured} lies in {band}, but no such order makes the error vanish in one step"
    if not abs(step) <= STEP_SLACK or (lasts and ahead < -STEP_SLACK):
        return Verdict.INCONCLUSIVE, f"{measured} lies in {band}, but the finest levels leave it: add a finer level"
    return Verdict.PASS, measured


def verdict(
    h: Numbers,
    error: Numbers | None = None,
    *,
    band: tuple[float, float] | None = None,
    round_off: float = ROUND_OFF,
    uncertainty: float = 0.0,
    exact: float | None = None,
) -> Judgement:
    """Judge an error series from any code.

    Parameters
    ----------
    h, error, round_off, uncertainty
        As in `analyse`.
    band : (float, float), optional
        Accepted band of orders. Without a band, an error that does not converge fails and nothing passes, because an order without
        an expected value verifies nothing.
    exact : float, optional
        Demand that no error exceeds this tolerance, instead of an order.

    Returns
    -------
    (Verdict, str)
        The verdict and its reason in one sentence.

    Raises
    ------
    UsageError
        If `analyse` refuses the series, the band is not two numbers in ascending order, the tolerance is negative or not a number, or
        both are given.
    """
    if exact is not None:
        return _judge_exact(analyse(h, error), exact, band)
    edges = numbers((FLAT, PLAUSIBLE) if band is None else band, "the band of orders")
    if edges.shape != (2,):
        raise UsageError(f"the band of orders must be two numbers, its lower edge first, not {band!r}")
    low, high = edges.tolist()
    if not low < high:
        raise UsageError(f"the band of orders [{low:g}, {high:g}] is empty: give its lower edge first")
    series = analyse(h, error, expected=band, round_off=round_off, uncertainty=uncertainty)
    found, reason = judge_order(series, low, high)
    if band is None and found is Verdict.PASS:
        return Verdict.INCONCLUSIVE, f"{reason}; without a band to expect it in, no order passes"
    return found, reason


def _judge_exact(series: Convergence, tolerance: float, band: object) -> Judgement:
    if band is not None:
        raise UsageError("an exact error has no order: give a band of orders or a tolerance, not both")
    if not tolerance >= 0:
        raise UsageError(f"the tolerance of an exact error must not be negative or NaN, but is {tolerance:g}")
    if series.classification is Classification.NON_FINITE:
        return Verdict.ERROR, NOT_FINITE
    largest = int(np.argmax(series.error))
    found = f"the largest error is {series.error[largest]:.2e}, at h={series.h[largest]:g}"
    if series.error[largest] <= tolerance:
        return Verdict.PASS, f"exact to {tolerance:g}: {found}"
    return Verdict.FAIL, f"not exact to {tolerance:g}: {found}"
