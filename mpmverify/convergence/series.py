"""Analysis of an error series: its class, and its order with a confidence interval.

A series is a set of levels (h, error). The levels are sorted by h. Levels at round-off are dropped, then levels whose error is too
close to the uncertainty of a numerical reference, then coarse levels that are not yet asymptotic. Each dropped level is named with
the reason. The order at the finest level is estimated from the remaining levels.
"""

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from mpmverify.convergence.estimate import SCATTER, Estimate, estimate
from mpmverify.convergence.fits import CONFIDENCE, Fit, FloorFit, fit_order, pairwise_orders, significant_floor
from mpmverify.convergence.levels import Array, Numbers, by_size, levels
from mpmverify.errors import UsageError

ROUND_OFF = 1e-12
"""Relative error at and below which round-off of double precision hides the order."""
REFERENCE_MARGIN = 10.0
"""Smallest ratio of a usable error to the uncertainty of the numerical reference."""
FLAT = 0.25
"""Largest magnitude of an order at which a series is stagnant."""
VAGUE = 0.25
"""Half-width of the interval of an order, relative to the order or 1, above which the levels are not yet asymptotic."""
GROWTH = 1.1
"""Growth of the error in the finest step that is no scatter."""


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
        All levels (n,), sorted by decreasing h; replicates have the same h.
    pairwise : Array
        Observed order from the next coarser size to each level but the first (n - 1,), from the geometric means of replicates; NaN
        where an error is zero or not finite, and at replicates of the coarsest size.
    kept : Array of bool
        Levels in the fit (n,).
    dropped : tuple of str
        One sentence for each dropped level or group of levels.
    floor : FloorFit or None
        Fit with an error floor above round-off, where the floor is significant.
    classification : Classification
    limit : float
        Levels with errors at or below it were dropped: round-off, or ten times the uncertainty of the reference.
    estimate : Estimate or None
        Probable laws of the levels above the limit; None with fewer than three usable sizes.
    size : str
        Name of the refined size.
    confidence : float
        Confidence level of the interval of the order.
    """

    h: Array
    error: Array
    pairwise: Array
    kept: np.ndarray
    dropped: tuple[str, ...]
    floor: FloorFit | None
    classification: Classification
    limit: float = ROUND_OFF
    estimate: Estimate | None = None
    size: str = "h"
    confidence: float = CONFIDENCE

    @cached_property
    def fit(self) -> Fit | None:
        """Order at the finest level with its interval; None with fewer than two usable sizes or a non-finite error."""
        if self.estimate is not None:
            found = self.estimate
            return Fit(found.order, *found.interval(self.confidence), found.constant)
        h, error = self.h[self.kept], self.error[self.kept]
        return fit_order(h, error, self.confidence) if len(np.unique(h)) == 2 else None

    def expecting(self, band: tuple[float, float]) -> "Convergence":
        """Return the analysis for an accepted band of orders: an interval wholly above it makes the series superconvergent."""
        known = self.classification in (Classification.ASYMPTOTIC, Classification.PRE_ASYMPTOTIC)
        if not known or self.estimate is None or not self.estimate.step_below(band[1]) < 0.5 - self.confidence / 2:
            return self
        return replace(self, classification=Classification.SUPERCONVERGENT)

    def last_steps(self) -> Array:
        """Observed orders of the two finest steps between kept sizes, and of both together (3,); needs three kept sizes."""
        h, error = by_size(self.h[self.kept], self.error[self.kept])
        both = math.log(error[-3] / error[-1]) / math.log(h[-3] / h[-1])
        return np.append(pairwise_orders(h, error)[-2:], both)

    def plunges(self, order: float) -> bool:
        """Whether the error drops to `limit` in one step, although at an order it would stay above."""
        return any(
            math.log(self.error[k] / self.limit) > order * math.log(self.h[k] / self.h[k + 1])
            for k in np.flatnonzero(self.error[:-1] > self.limit)
            if self.error[k + 1] <= self.limit and self.h[k + 1] < self.h[k]
        )


def analyse(
    h: Numbers,
    error: Numbers | None = None,
    *,
    expected: tuple[float, float] | None = None,
    round_off: float = ROUND_OFF,
    uncertainty: float = 0.0,
    confidence: float = CONFIDENCE,
    size: str = "h",
) -> Convergence:
    """Analyse an error series.

    Parameters
    ----------
    h : array-like
        Level sizes (n,), positive and finite, in any order: cell sizes, time steps, or 1/ppc. Alternatively the errors, in a pandas
        Series with h as its index or an xarray DataArray with h as a coordinate. Levels of the same size are replicates, such as runs
        with several seeds: each enters the fit as it is.
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
        Confidence level of the interval of the order.
    size : str
        Name of the refined size in sentences.

    Returns
    -------
    Convergence

    Raises
    ------
    UsageError
        If the shapes do not match, a size is not positive and finite, or an error or the uncertainty is negative or not a number.
    """
    h, error = levels(h, error, replicates=True)
    if np.any(np.isfinite(error) & (error < 0)):
        raise UsageError("an error norm cannot be negative")
    if not uncertainty >= 0:
        raise UsageError(f"the uncertainty of a reference must not be negative or NaN, but is {uncertainty:g}")
    limit = max(round_off, REFERENCE_MARGIN * uncertainty)
    pairwise = pairwise_orders(h, error)

    def result(
        kind: Classification,
        kept: np.ndarray,
        dropped: list[str],
        floor: FloorFit | None = None,
        found: Estimate | None = None,
    ) -> Convergence:
        return Convergence(h, error, pairwise, kept, tuple(dropped), floor, kind, limit, found, size, confidence)

    if not np.all(np.isfinite(error)):
        bad = [f"{size}={at:g}: not finite ({value})" for at, value in zip(h, error, strict=True) if not np.isfinite(value)]
        nothing = np.zeros(len(h), dtype=bool)
        return result(Classification.NON_FINITE, nothing, [*bad, "every level: a series that is not finite has no order"])
    kept = error > limit
    dropped = [
        f"{size}={at:g}: at round-off ({value:.1e})"
        if value <= round_off
        else f"{size}={at:g}: {value:.1e} is finer than {REFERENCE_MARGIN:g} times the uncertainty of the reference ({uncertainty:.1e})"
        for at, value in zip(h[~kept], error[~kept], strict=True)
    ]
    sizes = len(np.unique(h[kept]))
    if sizes < 3:
        kind = Classification.TOO_SHORT
        if np.all(error <= round_off):
            kind = Classification.EXACT
        elif not kept.all():
            kind = Classification.ROUND_OFF_FLOOR if np.any(error <= round_off) else Classification.FINER_THAN_REFERENCE
        return result(kind, kept, dropped)

    found = estimate(h[kept], error[kept])
    # A floor that the errors of all levels show is no reason to call the coarse ones rough.
    floor = significant_floor(*by_size(h[kept], error[kept]))
    shown = floor is not None and floor.residual < SCATTER
    rough = np.flatnonzero(kept)[: 0 if shown else found.start]
    times = error[kept] / found.predict(h[kept])
    dropped += [
        f"{size}={h[k]:g}: pre-asymptotic ({share:.2g} times what the finer levels predict)"
        for k, share in zip(rough, times, strict=False)
    ]
    kept[rough] = False
    used, means = by_size(h[kept], error[kept])
    if not shown:
        floor = significant_floor(used, means) if found.below(FLAT).limit > 0.5 else None
    order, tail = found.order, 0.5 - confidence / 2
    grows = pairwise_orders(used, means)[-1] < -FLAT and means[-1] > GROWTH * means[-2]
    wide = VAGUE * max(1.0, abs(order))
    if order < -FLAT or grows:
        kind = Classification.DIVERGENT
    elif floor is not None:
        kind = Classification.OTHER_FLOOR
    elif abs(order) <= FLAT:
        kind = Classification.STAGNANT
    elif found.step_below(order - wide) > tail or found.step_below(order + wide) < 1 - tail:
        kind = Classification.PRE_ASYMPTOTIC
    else:
        kind = Classification.ASYMPTOTIC
    series = result(kind, kept, dropped, floor, found)
    return series if expected is None else series.expecting(expected)
