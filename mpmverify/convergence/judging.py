"""How an error series becomes a verdict."""

from mpmverify.convergence.series import STEP_SLACK, Classification, Convergence
from mpmverify.verdict import Judgement, Verdict

PLAUSIBLE = 12.0
"""No scheme has a higher order in h or dt: a coarse level blew up, or a fine one is exact by accident."""


def judge_order(series: Convergence, low: float, high: float) -> Judgement:
    """Judge an order; the fit and the finest step of refinement must agree, or nothing is concluded.

    PASS when the interval lies in the band, the finest step strays from it by no more than `STEP_SLACK`, and the order is not
    falling out of it unchecked. FAIL when the error stops, grows or its interval lies wholly outside, and the finest step
    lies outside on the same side and is not on its way in: levels that are not asymptotic yet accuse nobody. No band reaches
    down to what does not converge, nor beyond `PLAUSIBLE`.
    """
    kind, fit, used = series.classification, series.fit, int(series.kept.sum())
    if kind is Classification.NON_FINITE:
        return Verdict.ERROR, "the error is not finite on at least one level"
    if used < 3 or fit is None:
        return Verdict.INCONCLUSIVE, f"{used} of {len(series.h)} levels can be used ({kind}); an order needs three"
    high = min(high, PLAUSIBLE)
    band = f"[{low:g}, {high:g}]"
    measured = f"order {fit.order:.3f}, interval [{fit.low:.3f}, {fit.high:.3f}] from {used} levels ({kind})"
    if series.dropped:
        measured += f", without {'; '.join(series.dropped)}"
    change, lasts = series.trend()
    step, ahead = series.finest_step(low, high), series.finest_step(low, high, change)
    too_slow, too_fast = max(step, ahead) < 0, min(step, ahead) > 0
    if series.floor is not None:
        reason = f"the error stops at a floor of {series.floor.floor:.2e} of the solution: {measured}"
        return Verdict.FAIL if too_slow else Verdict.INCONCLUSIVE, reason
    if kind in (Classification.STAGNANT, Classification.DIVERGENT):
        return Verdict.FAIL if too_slow else Verdict.INCONCLUSIVE, f"the error does not converge: {measured}"
    if fit.high < low or fit.low > high:
        if too_slow if fit.high < low else too_fast:
            return Verdict.FAIL, f"{measured} lies outside {band}"
        return Verdict.INCONCLUSIVE, f"{measured} lies outside {band}, but the finest levels approach it: add a finer level"
    if not (low <= fit.low and fit.high <= high):
        return Verdict.INCONCLUSIVE, f"{measured} straddles an edge of {band}"
    if series.plunges(high):
        return Verdict.INCONCLUSIVE, f"{measured} lies in {band}, but no such order takes the error to round-off in one step"
    if not abs(step) <= STEP_SLACK or (lasts and ahead < -STEP_SLACK):
        return Verdict.INCONCLUSIVE, f"{measured} lies in {band}, but the finest levels leave it: add a finer level"
    return Verdict.PASS, measured
