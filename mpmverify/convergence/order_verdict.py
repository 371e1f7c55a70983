"""Verdict on an error series from its observed order."""

import numpy as np

from mpmverify.convergence.advice import next_levels, what_would_decide
from mpmverify.convergence.levels import Numbers, numbers
from mpmverify.convergence.series import FLAT, ROUND_OFF, Classification, Convergence, analyse
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.errors import UsageError

PLAUSIBLE = 12.0
"""Largest credible order in h or dt. A higher one means that a coarse level is unstable, or that a fine level is exact by chance."""
CERTAIN = 0.99
"""Least probability that an order lies outside its band at which a series fails."""
DOUBTFUL = 0.25
"""Probability that the order at the finest level lies outside its band above which a series does not pass."""
LEAVING = 0.9
"""Probability that the order as h goes to zero lies outside its band above which a series does not pass."""
STEP_SLACK = 0.2
"""Distance by which the observed order of the finest step may leave the band."""
NOT_FINITE = "the error is not finite on at least one level"


def judge_order(series: Convergence, low: float, high: float) -> Judgement:
    """Judge the order of a series, and say what would decide where it is INCONCLUSIVE.

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
    PASS if the interval of the order of the finest step lies inside the band, the order at the finest level lies there more probably
    than not, and the one as h goes to zero does not lie outside with the probability `LEAVING`. Beyond the estimate, the two finest
    steps must not both lie outside on one side, and the finest one leaves the band by no more than `STEP_SLACK`, unless both together
    lie inside because the error alternates. FAIL if the order at the finest level and the one as h goes to zero both lie outside on
    one side with the probability `CERTAIN`, and the finest steps confirm it, or if the error grows in the finest step. A series that
    does not converge passes in no band, and `PLAUSIBLE` bounds every band from above.
    """
    found, reason = decide(series, low, high)
    if series.fit is None or series.estimate is None:
        return found, reason
    used, sizes = int(series.kept.sum()), len(np.unique(series.h[series.kept]))
    measured = f"order {series.fit.order:.3f}, interval [{series.fit.low:.3f}, {series.fit.high:.3f}]"
    measured += f" from {used} levels" if sizes == used else f" from {used} errors at {sizes} sizes, each as it is"
    measured += f" ({series.classification}){_without(series)}"
    reason = reason.format(measured=measured)
    if found is Verdict.INCONCLUSIVE:
        advice = what_would_decide(series, lambda longer: decide(longer, low, high)[0] is not Verdict.INCONCLUSIVE)
        return found, f"{reason}: {advice}"
    return found, reason


def _without(series: Convergence) -> str:
    return f", without {'; '.join(series.dropped)}" if series.dropped else ""


def decide(series: Convergence, low: float, high: float) -> Judgement:
    """Judge the order of a series; the reason has the field {measured} for the order, and no advice."""
    kind, laws = series.classification, series.estimate
    if kind is Classification.NON_FINITE:
        return Verdict.ERROR, NOT_FINITE
    if kind is Classification.EXACT:
        largest = series.error.max()
        return (
            Verdict.INCONCLUSIVE,
            f"exact: the error is at most {largest:.1e} on every level, which is round-off and has no order",
        )
    if laws is None:
        usable = f"{series.kept.sum()} of {len(series.h)} levels can be used ({kind}){_without(series)}"
        return Verdict.INCONCLUSIVE, f"{usable}; an order needs three: {next_levels(series)}"
    high = min(high, PLAUSIBLE)
    band = f"[{low:g}, {high:g}]"
    below, above, edge = laws.below(low), laws.above(high), (1 - series.confidence) / 2
    *steps, together = series.last_steps()
    too_slow = below.both >= CERTAIN and min(steps[-1], together) < low
    too_fast = above.both >= CERTAIN and max(steps[:-1]) > high and together > high
    grows = kind is Classification.DIVERGENT and steps[-1] < -FLAT and together < low
    if too_slow or too_fast or grows:
        if series.floor is not None:
            return Verdict.FAIL, f"the error stops at a floor of {series.floor.floor:.2e}: {{measured}}"
        if kind in (Classification.STAGNANT, Classification.DIVERGENT):
            return Verdict.FAIL, "the error does not converge: {measured}"
        return Verdict.FAIL, f"{{measured}} lies outside {band}"
    if kind in (Classification.STAGNANT, Classification.DIVERGENT) or series.floor is not None:
        return Verdict.INCONCLUSIVE, "the error does not converge on these levels: {measured}"
    if below.step > 1 - edge or above.step > 1 - edge:
        return Verdict.INCONCLUSIVE, f"{{measured}} lies outside {band}, but may approach it"
    if not (below.step <= edge and above.step <= edge):
        return Verdict.INCONCLUSIVE, f"{{measured}} straddles an edge of {band}"
    if series.plunges(high + STEP_SLACK):
        return Verdict.INCONCLUSIVE, f"{{measured}} lies in {band}, but no such order makes the error vanish in one step"
    if max(below.finest, above.finest) > DOUBTFUL or max(below.limit, above.limit) > LEAVING:
        return Verdict.INCONCLUSIVE, f"{{measured}} lies in {band}, but leaves it as {series.size} goes to zero"
    in_band = any(low - slack <= step <= high + slack for step, slack in ((steps[-1], STEP_SLACK), (together, 0.0)))
    if max(steps) < low or min(steps) > high or not in_band:
        leave = f"the finest steps, {steps[0]:.2f} and {steps[1]:.2f}, leave it"
        return Verdict.INCONCLUSIVE, f"{{measured}} lies in {band}, but {leave}"
    hidden = series.error <= series.limit
    stray = series.h[hidden & (series.h > np.min(series.h[~hidden]))]
    if stray.size:
        return (
            Verdict.INCONCLUSIVE,
            f"{{measured}} lies in {band}, but at {series.size}={stray.max():g} the error is at round-off, and not on finer levels",
        )
    return Verdict.PASS, "{measured}"


def verdict(
    h: Numbers,
    error: Numbers | None = None,
    *,
    band: tuple[float, float] | None = None,
    round_off: float = ROUND_OFF,
    uncertainty: float = 0.0,
    exact: float | None = None,
    size: str = "h",
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
    size : str
        Name of the sizes in the reason.

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
        return _judge_exact(analyse(h, error, size=size), exact, band)
    edges = numbers((FLAT, PLAUSIBLE) if band is None else band, "the band of orders")
    if edges.shape != (2,):
        raise UsageError(f"the band of orders must be two numbers, its lower edge first, not {band!r}")
    low, high = edges.tolist()
    if not low < high:
        raise UsageError(f"the band of orders [{low:g}, {high:g}] is empty: give its lower edge first")
    series = analyse(h, error, expected=band, round_off=round_off, uncertainty=uncertainty, size=size)
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
    found = f"the largest error is {series.error[largest]:.2e}, at {series.size}={series.h[largest]:g}"
    if series.error[largest] <= tolerance:
        return Verdict.PASS, f"exact to {tolerance:g}: {found}"
    return Verdict.FAIL, f"not exact to {tolerance:g}: {found}"
