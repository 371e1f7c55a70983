"""Grid convergence index: order, limit and uncertainty of a quantity from its own ladder, where nothing exact is known."""

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from mpmverify.convergence.levels import Array, Numbers, levels, numbers
from mpmverify.errors import UsageError

AGREEMENT = 0.1
"""Largest relative distance of the observed order from the formal one at which they agree."""
CONFIRMED, UNCONFIRMED = 1.25, 3.0
"""Factors of safety where three levels observe the formal order, and elsewhere."""
LARGEST = 300.0
"""Bound on |p log r| in the search for an order p: no quantity of doubles changes faster."""


class Behaviour(StrEnum):
    """How the three finest levels follow one another."""

    MONOTONE = "monotone"
    OSCILLATORY = "oscillatory"
    DIVERGENT = "divergent"
    CONSTANT = "constant"
    TOO_SHORT = "two levels"
    NON_FINITE = "non-finite"


@dataclass(frozen=True)
class GridConvergence:
    """What the finest levels of a quantity say about its limit.

    Parameters
    ----------
    behaviour : Behaviour
    order : float
        Observed order, NaN where there is none.
    limit : float
        Value that the quantity tends to, by Richardson extrapolation at the observed order; NaN where there is none, and for norms
        of differences.
    factor : float
        Factor of safety.
    uncertainty : float
        Half-width of the band around the finest value that holds the limit, in the unit of the quantity; infinite where nothing
        bounds it.
    """

    behaviour: Behaviour
    order: float
    limit: float
    factor: float
    uncertainty: float


def grid_convergence(h: Numbers, value: Numbers | None = None, *, formal: float) -> GridConvergence:
    """Grid convergence index of a scalar quantity, such as an energy, a norm of the solution or its value at a point.

    Parameters
    ----------
    h, value : array-like
        Sizes and values (n,) in any order, at whatever ratios, as `levels` takes them; at least two, of which the finest three count.
    formal : float
        Order that the scheme has by theory.

    Raises
    ------
    UsageError
        If the series is none, or has one level, or the formal order is not positive.

    Notes
    -----
    With f_1, f_2, f_3 from fine to coarse and r = h_coarse/h_fine, the observed order p solves

        (f_3 - f_2)/(f_2 - f_1) = r_21^p (r_32^p - 1)/(r_21^p - 1).

    It is the fixed point of Celik et al.; but the right-hand side grows with p throughout, so that p is bracketed here, where their
    iteration need not converge, and keeps its sign. The uncertainty is F |f_2 - f_1|/(r_21^p - 1), with F = 1.25 where p is within 10 % of
    the formal order and F = 3 elsewhere, and with the lesser of both orders; it is not raised to 1/2, as Oberkampf and Roy have
    it, since the band of a slower quantity would then miss its limit. Where the values oscillate ever less it is three
    times half of their range; where they diverge nothing bounds it. Two levels have the formal order and F = 3.

    References
    ----------
    Roache P. J. (1994). Perspective: a method for uniform reporting of grid refinement studies. Journal of Fluids Engineering
    116(3), 405-413, https://doi.org/10.1115/1.2910291
    Celik I. B., Ghia U., Roache P. J., Freitas C. J. (2008). Procedure for estimation and reporting of uncertainty due to
    discretization in CFD applications. Journal of Fluids Engineering 130(7), 078001, https://doi.org/10.1115/1.2960953
    Oberkampf W. L., Roy C. J. (2010). Verification and Validation in Scientific Computing. Cambridge University Press, chapter 8, for
    the 10 % and the lesser order.
    Stern F., Wilson R. V., Coleman H. W., Paterson E. G. (2001). Comprehensive approach to verification and validation of CFD
    simulations, part 1. Journal of Fluids Engineering 123(4), 793-802, https://doi.org/10.1115/1.1412235, for the half range.
    """
    h, value = levels(h, value)
    found = _of_steps(h, np.diff(value), formal)
    if found.behaviour is not Behaviour.MONOTONE:
        return found
    rest = (value[-1] - value[-2]) / math.expm1(found.order * math.log(h[-2] / h[-1]))
    return replace(found, limit=float(value[-1] + rest))


def grid_convergence_of_differences(h: Numbers, difference: Numbers, *, formal: float) -> GridConvergence:
    """Grid convergence index of a field, from the norms of the differences of its solutions on neighbouring levels.

    Parameters
    ----------
    h : array-like
        Sizes (n,), coarsest first.
    difference : array-like
        Norm of the difference of the solutions at h[k] and h[k + 1], (n - 1,).
    formal : float
        Order that the scheme has by theory in that norm.

    Raises
    ------
    UsageError
        If the sizes do not fall, a norm is negative, the lengths do not match or the formal order is not positive.

    Notes
    -----
    As `grid_convergence` of a quantity whose steps are the differences: u_h = u + h^p w gives |h_k^p - h_{k+1}^p| |w|. Norms have no
    sign, so that no oscillation shows.
    """
    h, difference = numbers(h, "h"), numbers(difference, "the differences")
    if h.ndim != 1 or difference.shape != (max(len(h) - 1, 0),):
        raise UsageError(f"n sizes have n - 1 differences: shapes {h.shape} and {difference.shape} do not match")
    levels(h, h)
    if np.any(np.diff(h) > 0) or np.any(difference < 0):
        raise UsageError("give sizes from coarse to fine, and norms of differences, which are not negative")
    return _of_steps(h, difference, formal)


def observed_order(coarse_ratio: float, fine_ratio: float, growth: float) -> float:
    """Order p > -inf of a quantity that changes from level to level; infinite where it exceeds what doubles can show.

    Parameters
    ----------
    coarse_ratio, fine_ratio : float
        Ratios of neighbouring sizes, coarser over finer, above 1: of the coarsest two levels and of the finest two.
    growth : float
        The coarse step over the fine one, positive.
    """
    from scipy.optimize import brentq  # a fifth of a second that only references need

    wide, narrow = math.log(coarse_ratio), math.log(fine_ratio)

    def excess(p: float) -> float:
        # (r^p - 1)/(1 - s^-p) by expm1, and its limit: near p = 0 both are small.
        of_steps = math.expm1(p * wide) / -math.expm1(-p * narrow) if abs(p) * max(wide, narrow) > 1e-12 else wide / narrow
        return math.log(of_steps / growth)

    bound = LARGEST / max(wide, narrow)
    if excess(bound) < 0:
        return math.inf
    if excess(-bound) > 0:
        return -math.inf
    return float(brentq(excess, -bound, bound, xtol=1e-14, rtol=1e-14))


def _of_steps(h: Array, steps: Array, formal: float) -> GridConvergence:
    """Grid convergence from the changes (n - 1,) between neighbouring levels (n,), coarsest first."""
    if not (math.isfinite(formal) and formal > 0):
        raise UsageError(f"the formal order must be positive, not {formal:g}")
    if not len(steps):
        raise UsageError("a grid convergence index needs two levels: refine once")

    def found(kind: Behaviour, order: float = math.nan, uncertainty: float = math.inf) -> GridConvergence:
        return GridConvergence(kind, order, math.nan, UNCONFIRMED, uncertainty)

    if not np.all(np.isfinite(steps)):
        return found(Behaviour.NON_FINITE)
    fine, fine_width = abs(float(steps[-1])), math.log(h[-2] / h[-1])
    if fine == 0:
        return found(Behaviour.CONSTANT)
    if len(steps) == 1:
        return found(Behaviour.TOO_SHORT, uncertainty=UNCONFIRMED * fine / math.expm1(formal * fine_width))
    coarse = abs(float(steps[-2]))
    if steps[-2] * steps[-1] < 0:
        if fine < coarse:
            return found(Behaviour.OSCILLATORY, uncertainty=UNCONFIRMED * coarse / 2)
        return found(Behaviour.DIVERGENT)
    order = observed_order(h[-3] / h[-2], h[-2] / h[-1], coarse / fine) if coarse else -math.inf
    if not order > 0:
        return found(Behaviour.DIVERGENT, order)
    factor = CONFIRMED if abs(order - formal) <= AGREEMENT * formal else UNCONFIRMED
    uncertainty = factor * fine / math.expm1(min(order, formal) * fine_width)
    return GridConvergence(Behaviour.MONOTONE, order, math.nan, factor, uncertainty)
