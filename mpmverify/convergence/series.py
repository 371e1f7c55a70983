"""What kind of error series it is, and its order with an interval.

A series is a set of levels (h, error). It is sorted by h; its levels at round-off are dropped, then those that its reference is
too coarse for, then its coarse levels that are not yet asymptotic, each by name and with the reason; what is left is fitted.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mpmverify.convergence.fits import CONFIDENCE, Fit, FloorFit, fit_order, pairwise_orders, significant_floor
from mpmverify.convergence.levels import Array, Numbers, levels
from mpmverify.errors import UsageError

ROUND_OFF = 1e-12
"""Relative error at and below which a level says nothing about the order of a double-precision scheme."""
REFERENCE_MARGIN = 10.0
"""An error is told from that of its reference when it is so many times the reference's uncertainty."""
FLAT = 0.25
"""A series whose fitted order is smaller in magnitude does not converge (stagnant) nor diverge."""
SHARP = 0.05
"""No level is left out to sharpen an interval of the order that is narrower."""
STEP_SLACK = 0.1
"""Relative change of an error that one step of refinement may owe to noise: four standard deviations where errors scatter by 2 %."""


class Classification(StrEnum):
    """What kind of error series it is."""

    ASYMPTOTIC = "asymptotic"
    PRE_ASYMPTOTIC = "pre-asymptotic"
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
    """Full analysis of one error series, coarsest level first.

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
        Set when the series is at an error floor above round-off.
    classification : Classification
    limit : float
        Levels at or below it were dropped: round-off, or what the reference cannot tell.
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
        """How far the finest step of refinement strays from a band of orders; at least two levels must be kept.

        Parameters
        ----------
        low, high : float
            Band of orders.
        change : float
            Added to the observed order of the step; see `trend`.

        Returns
        -------
        float
            Zero inside; below zero, log of how much too little the step reduces the error; above zero, how much too much.

        Notes
        -----
        The interval of a fit is that of its mean slope. A long straight start hides in it that the finest level has come to a
        floor, turns up, or is too good to be true; the last step does not.
        """
        coarse, fine = np.flatnonzero(self.kept)[-2:]
        width = math.log(self.h[coarse] / self.h[fine])
        reduction = math.log(self.error[coarse] / self.error[fine]) + change * width
        return min(0.0, reduction - low * width) + max(0.0, reduction - high * width)

    def last_two_steps(self, low: float) -> float:
        """How far the finest two steps together stray below the order `low`, as `finest_step` has it: zero or less.

        Where the sign of a correction alternates, every other step overstates the order and the next one understates it.
        """
        coarse, _, fine = np.flatnonzero(self.kept)[-3:]
        return min(0.0, math.log(self.error[coarse] / self.error[fine]) - low * math.log(self.h[coarse] / self.h[fine]))

    def approaches(self, low: float, high: float) -> bool:
        """Whether the order leaves the band [low, high] at the finest step and is on its way in; three levels must be kept at least.

        Notes
        -----
        It is when it has changed as much as it still has to go, from the first step to the last along a parabola through (log h,
        log E); or when it gets there if the trend of the last three orders goes on: each change two thirds of the one before
        where the trend lasts, in all twice the last one, and once more the last one where it does not.
        """
        x = np.log(self.h[self.kept])
        order = np.polynomial.Polynomial.fit(x, np.log(self.error[self.kept]), 2).deriv()
        first, last = float(order((x[0] + x[1]) / 2)), float(order((x[-2] + x[-1]) / 2))
        step = self.finest_step(low, high)
        turned = first - last >= max(last - high, 0.0) if step > 0 else last - first >= max(low - last, 0.0)
        change, lasts = self.trend()
        return step != 0 and (turned or step * self.finest_step(low, high, 2 * change if lasts else change) <= 0)

    def plunges(self, high: float) -> bool:
        """Whether a step takes the error to the limit that an order of `high` would leave above it."""
        return any(
            math.log(self.error[k] / self.limit) > high * math.log(self.h[k] / self.h[k + 1]) + STEP_SLACK
            for k in np.flatnonzero(self.kept[:-1])
            if self.error[k + 1] <= self.limit
        )

    def trend(self) -> tuple[float, bool]:
        """Last change of the observed order when the last three rise or fall throughout, else zero; and whether it lasts.

        A change lasts that is at least two thirds of the one before it: the order is not settling.
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
        Level sizes (n,), positive, finite and distinct, in any order: a cell size, a time step, or 1/ppc. Or the errors, in a
        pandas Series with h as its index or an xarray DataArray with h as a coordinate.
    error : array-like, optional
        Errors (n,), relative to the size of the exact solution for `round_off` to mean what it says; paired with h by position.
    expected : (float, float), optional
        Accepted band of orders; an interval wholly above it makes the series superconvergent.
    round_off : float
        Levels at or below it are dropped.
    uncertainty : float
        Of a numerical reference that stands for the exact solution, in the unit of the error (`Reference.uncertainty`): levels
        of less than ten times as much are dropped.
    confidence : float
        Of the interval of the fitted order.

    Raises
    ------
    UsageError
        If the arrays do not match, or an h is not positive, finite and distinct, or an error is negative or no number, or the
        uncertainty is.
    """
    h, error = levels(h, error)
    if np.any(np.isfinite(error) & (error < 0)):
        raise UsageError("an error norm cannot be negative")
    if not uncertainty >= 0:
        raise UsageError(f"the uncertainty of a reference cannot be {uncertainty:g}: give a number that is not negative")
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
        if not kept.all():
            exact = bool(np.any(error <= round_off))
            kind = Classification.ROUND_OFF_FLOOR if exact else Classification.FINER_THAN_REFERENCE
        return result(kind, kept, dropped, fit_order(h[kept], error[kept], confidence) if kept.sum() == 2 else None)

    floor = significant_floor(h[kept], error[kept])
    fit = fit_order(h[kept], error[kept], confidence)
    # A coarse level goes when four finer ones are left and the interval, not sharp yet, at least halves without it.
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
    if fit.high < 0 or fit.order < -FLAT or grows:
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
