"""Analysis of an error series: its class, and its order with a confidence interval.

A series is a set of levels (h, error). The levels are sorted by h. Levels at round-off are dropped, then levels whose error is too
close to the uncertainty of a numerical reference, then coarse levels that are not yet asymptotic. Each dropped level is named with
the reason. The remaining levels are fitted.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mpmverify.convergence.fits import CONFIDENCE, Fit, FloorFit, fit_order, pairwise_orders, significant_floor
from mpmverify.convergence.levels import Array, Numbers, levels
from mpmverify.errors import UsageError

ROUND_OFF = 1e-12
"""Relative error at and below which round-off of double precision hides the order."""
REFERENCE_MARGIN = 10.0
"""Smallest ratio of a usable error to the uncertainty of the numerical reference."""
FLAT = 0.25
"""Largest magnitude of a fitted order at which a series is stagnant."""
SHARP = 0.05
"""Width of the interval of the order below which no further coarse level is dropped."""
STEP_SLACK = 0.1
"""Change of log E in one refinement step that may be noise: four standard deviations where errors scatter by 2 %."""


class Classification(StrEnum):
    """Class of an error series."""

    ASYMPTOTIC = "asymptotic"
    PRE_ASYMPTOTIC = "pre-asymptotic"
    EXACT = "exact"
    ROUND_OFF_FLOOR = "round-off floor"
    FINER_THAN_REFERENCE = "finer than its reference"
    OTHER_FLOOR = "other-error floor"
    STAGNANT = "stagnant"
    DIVERGENT = "divergent"
    SUPERCONVERGENT = "superconvergent"
    NON_FINITE = "non-finite"
    TOO_SHORT = "too few levels"


@dataclass(frozen=True)
class Convergence:
    """Analysis of one error series, coarsest level first.

    Parameters
    ----------
    h, error : Array
        All levels (n,), sorted by decreasing h.
    pairwise : Array
        Observed order of each neighbouring pair (n - 1,); NaN where an error is zero or not finite.
    kept : Array of bool
        Levels in the fit (n,).
    dropped : tuple of str
        One sentence for each dropped level or group of levels.
    fit : Fit or None
        None with fewer than two usable levels or a non-finite error.
    floor : FloorFit or None
        Fit with an error floor above round-off, where the floor is significant.
    classification : Classification
    limit : float
        Levels with errors at or below it were dropped: round-off, or ten times the uncertainty of the reference.
    """

    h: Array
    error: Array
    pairwise: Array
    kept: np.ndarray
    dropped: tuple[str, ...]
    fit: Fit | None
    floor: FloorFit | None
    classification: Classification
    limit: float = ROUND_OFF

    def finest_step(self, low: float, high: float, change: float = 0.0) -> float:
        """Deviation of the finest refinement step from a band of orders; at least two levels must be kept.

        Parameters
        ----------
        low, high : float
            Band of orders.
        change : float
            Added to the observed order of the step; see `trend`.

        Returns
        -------
        float
            log(E_coarse/E_fine) of the step, less the nearest value that the band allows: zero inside the band, negative if the error
            decreases too little, positive if it decreases too much.

        Notes
        -----
        A fit yields the interval of the mean slope. After many levels on a straight line, this interval does not show that the finest
        level has reached a floor, has grown or is implausibly small; the last step does.
        """
        coarse, fine = np.flatnonzero(self.kept)[-2:]
        width = math.log(self.h[coarse] / self.h[fine])
        reduction = math.log(self.error[coarse] / self.error[fine]) + change * width
        return min(0.0, reduction - low * width) + max(0.0, reduction - high * width)

    def last_two_steps(self, low: float) -> float:
        """Deviation of the two finest steps together below the order `low`, as in `finest_step`: zero or negative.

        If a correction term alternates in sign, single steps overestimate and underestimate the order in turn.
        """
        coarse, _, fine = np.flatnonzero(self.kept)[-3:]
        return min(0.0, math.log(self.error[coarse] / self.error[fine]) - low * math.log(self.h[coarse] / self.h[fine]))

    def approaches(self, low: float, high: float) -> bool:
        """Whether the order at the finest step lies outside the band [low, high] but approaches it; needs at least three kept levels.

        Notes
        -----
        Either of two estimates suffices. First: on a parabola fitted to (log h, log E), the order has changed towards the band, from
        the first step to the last, by at least the distance that remains. Second: the order reaches the band if the `trend` of the
        last three orders continues. A trend that lasts continues with changes of two thirds of the one before, in total
        twice the last change; a trend that does not last continues with one more change equal to the last one.
        """
        x = np.log(self.h[self.kept])
        order = np.polynomial.Polynomial.fit(x, np.log(self.error[self.kept]), 2).deriv()
        first, last = float(order((x[0] + x[1]) / 2)), float(order((x[-2] + x[-1]) / 2))
        step = self.finest_step(low, high)
        turned = first - last >= max(last - high, 0.0) if step > 0 else last - first >= max(low - last, 0.0)
        change, lasts = self.trend()
        return step != 0 and (turned or step * self.finest_step(low, high, 2 * change if lasts else change) <= 0)

    def plunges(self, high: float) -> bool:
        """Whether the error drops to `limit` in one step, although at order `high` it would stay above."""
        return any(
            math.log(self.error[k] / self.limit) > high * math.log(self.h[k] / self.h[k + 1]) + STEP_SLACK
            for k in np.flatnonzero(self.kept[:-1])
            if self.error[k + 1] <= self.limit
        )

    def trend(self) -> tuple[float, bool]:
        """Last change of the observed order, and whether the trend lasts.

        The change is zero unless the last three observed orders increase or decrease monotonically. The trend lasts if this change is
        at least two thirds of the one before it.
        """
        changes = np.diff(pairwise_orders(self.h[self.kept], self.error[self.kept])[-3:])
        if len(changes) < 2 or changes[0] * changes[1] <= 0:
            return 0.0, False
        return float(changes[1]), bool(3 * abs(changes[1]) >= 2 * abs(changes[0]))


def analyse(
    h: Numbers,
    error: Numbers | None = None,
    *,
    expected: tuple[float, float] | None = None,
    round_off: float = ROUND_OFF,
    uncertainty: float = 0.0,
    confidence: float = CONFIDENCE,
) -> Convergence:
    """Analyse an error series.

    Parameters
    ----------
    h : array-like
        Level sizes (n,), positive, finite and distinct, in any order: cell sizes, time steps, or 1/ppc. Alternatively the errors, in
        a pandas Series with h as its index or an xarray DataArray with h as a coordinate.
    error : array-like, optional
        Errors (n,), paired with h by position. The default of `round_off` assumes errors relative to the size of the exact solution.
    expected : (float, float), optional
        Accepted band of orders; an interval wholly above it makes the series superconvergent.
    round_off : float
        Levels with errors at or below it are dropped.
    uncertainty : float
        Uncertainty of the numerical reference (`Reference.uncertainty`) in the unit of the error; 0 for an exact solution. Levels with
        errors of at most ten times the uncertainty are dropped.
    confidence : float
        Confidence level of the interval of the fitted order.

    Returns
    -------
    Convergence

    Raises
    ------
    UsageError
        If the shapes do not match, a size is not positive, finite and distinct, or an error or the uncertainty is negative or not a
        number.
    """
    h, error = levels(h, error)
    if np.any(np.isfinite(error) & (error < 0)):
        raise UsageError("an error norm cannot be negative")
    if not uncertainty >= 0:
        raise UsageError(f"the uncertainty of a reference must not be negative or NaN, but is {uncertainty:g}")
    limit = max(round_off, REFERENCE_MARGIN * uncertainty)
    pairwise = pairwise_orders(h, error)

    def result(
        kind: Classification, kept: np.ndarray, dropped: list[str], fit: Fit | None = None, floor: FloorFit | None = None
    ) -> Convergence:
        return Convergence(h, error, pairwise, kept, tuple(dropped), fit, floor, kind, limit)

    everything = np.ones(len(h), dtype=bool)
    if not np.all(np.isfinite(error)):
        bad = [f"h={size:g}: not finite ({value})" for size, value in zip(h, error, strict=True) if not np.isfinite(value)]
        return result(Classification.NON_FINITE, ~everything, [*bad, "every level: a series that is not finite has no order"])
    kept = error > limit
    dropped = [
        f"h={size:g}: at round-off ({value:.1e})"
        if value <= round_off
        else f"h={size:g}: {value:.1e} is finer than {REFERENCE_MARGIN:g} times the uncertainty of the reference ({uncertainty:.1e})"
        for size, value in zip(h[~kept], error[~kept], strict=True)
    ]
    if kept.sum() < 3:
        kind = Classification.TOO_SHORT
        if np.all(error <= round_off):
            kind = Classification.EXACT
        elif not kept.all():
            kind = Classification.ROUND_OFF_FLOOR if np.any(error <= round_off) else Classification.FINER_THAN_REFERENCE
        return result(kind, kept, dropped, fit_order(h[kept], error[kept], confidence) if kept.sum() == 2 else None)

    floor = significant_floor(h[kept], error[kept])
    fit = fit_order(h[kept], error[kept], confidence)
    # Drop the coarsest level while at least four levels remain, the interval is wider than SHARP, and dropping at least halves it.
    while kept.sum() > 4 and floor is None and fit.high - fit.low > SHARP:
        finer = kept.copy()
        finer[np.flatnonzero(kept)[0]] = False
        without = fit_order(h[finer], error[finer], confidence)
        if without.high - without.low > 0.5 * (fit.high - fit.low):
            break
        dropped.append(
            f"h={h[np.flatnonzero(kept)[0]]:g}: pre-asymptotic (order {fit.order:.2f} with it, {without.order:.2f} without)"
        )
        kept, fit = finer, without

    last = pairwise_orders(h[kept], error[kept])[-1]
    grows = last < -FLAT and error[kept][-1] > (1 + STEP_SLACK) * error[kept][-2]
    if fit.order < -FLAT or grows:
        kind = Classification.DIVERGENT
    elif floor is not None:
        kind = Classification.OTHER_FLOOR
    elif abs(fit.order) <= FLAT:
        kind = Classification.STAGNANT
    elif expected is not None and fit.low > expected[1]:
        kind = Classification.SUPERCONVERGENT
    elif fit.high - fit.low > 0.5 * max(1.0, abs(fit.order)):
        kind = Classification.PRE_ASYMPTOTIC
    else:
        kind = Classification.ASYMPTOTIC
    return result(kind, kept, dropped, fit, floor)
