"""Grid convergence index: order, limit and uncertainty of a quantity from its own refinement, without an exact solution."""

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from mpmverify.convergence.levels import Array, Numbers, levels, numbers
from mpmverify.errors import UsageError

AGREEMENT = 0.1
"""Largest relative difference at which the observed and the formal order agree."""
CONFIRMED, UNCONFIRMED = 1.25, 3.0
"""Factors of safety: where the order observed on three levels agrees with the formal one, and elsewhere."""
PRECISION = 1e-15
"""Width of the bracket at which the search for an order ends, relative to orders above 1."""
LARGEST = 300.0
"""Bound on |p log r| in the search for the order p; double precision cannot show a faster change."""


class Behaviour(StrEnum):
    """How a quantity changes over the three finest levels."""

    MONOTONE = "monotone"
    OSCILLATORY = "oscillatory"
    DIVERGENT = "divergent"
    CONSTANT = "constant"
    TOO_SHORT = "two levels"
    NON_FINITE = "non-finite"


@dataclass(frozen=True)
class GridConvergence:
    """Observed order, limit and uncertainty of a quantity from its finest levels.

    Parameters
    ----------
    behaviour : Behaviour
    order : float
        Observed order; NaN where there is none.
    limit : float
        Richardson extrapolation at the observed order; NaN where there is no order, and for norms of differences.
    factor : float
        Factor of safety.
    uncertainty : float
        Half-width of the band around the finest value that contains the limit, in the unit of the quantity; infinite where no bound
        is known.
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
        Sizes and values (n,) as `levels` takes them: in any order, at any refinement ratios. At least two levels are needed; the
        three finest are used.
    formal : float
        Theoretical order of the scheme.

    Raises
    ------
    UsageError
        If `levels` refuses the series, it has a single level, or the formal order is not positive and finite.

    Notes
    -----
    With f_1, f_2, f_3 from fine to coarse and r = h_coarse/h_fine, the observed order p solves

        (f_3 - f_2)/(f_2 - f_1) = r_21^p (r_32^p - 1)/(r_21^p - 1).

    Celik et al. solve this equation by fixed-point iteration, which need not converge. The right-hand side increases monotonically
    with p, so p is bracketed here; it may be negative. The uncertainty is F |f_2 - f_1|/(r_21^p - 1), where p is the smaller of the
    observed and the formal order, F = 1.25 if the two agree within 10 % and F = 3 otherwise. Oberkampf and Roy use p >= 1/2; this
    lower bound is not applied, because the band of a quantity that converges more slowly would miss its limit. For oscillations
    that decrease, the uncertainty is three times half the range of the values; for divergent values it is infinite. With two
    levels, p is the formal order and F = 3.

    References
    ----------
    Roache P. J. (1994). Perspective: a method for uniform reporting of grid refinement studies. Journal of Fluids Engineering
    116(3), 405-413, https://doi.org/10.1115/1.2910291
    Celik I. B., Ghia U., Roache P. J., Freitas C. J. (2008). Procedure for estimation and reporting of uncertainty due to
    discretization in CFD applications. Journal of Fluids Engineering 130(7), 078001, https://doi.org/10.1115/1.2960953
    Oberkampf W. L., Roy C. J. (2010). Verification and Validation in Scientific Computing. Cambridge University Press, chapter 8 (the
    10 % and the smaller order).
    Stern F., Wilson R. V., Coleman H. W., Paterson E. G. (2001). Comprehensive approach to verification and validation of CFD
    simulations, part 1. Journal of Fluids Engineering 123(4), 793-802, https://doi.org/10.1115/1.1412235 (half the range).
    """
    h, value = levels(h, value)
    found = _from_changes(h, np.diff(value), formal)
    if found.behaviour is not Behaviour.MONOTONE:
        return found
    rest = (value[-1] - value[-2]) / math.expm1(found.order * math.log(h[-2] / h[-1]))
    return replace(found, limit=float(value[-1] + rest))


def grid_convergence_of_differences(h: Numbers, difference: Numbers, *, formal: float) -> GridConvergence:
    """Grid convergence index of a field, from norms of the differences between solutions on neighbouring levels.

    Parameters
    ----------
    h : array-like
        Sizes (n,), coarsest first.
    difference : array-like
        Norm of the difference of the solutions at h[k] and h[k + 1], (n - 1,).
    formal : float
        Theoretical order of the scheme in that norm.

    Raises
    ------
    UsageError
        If the sizes do not decrease, a norm is negative, the lengths do not match or the formal order is not positive and finite.

    Notes
    -----
    The differences take the place of the changes of a scalar in `grid_convergence`: for u_h = u + h^p w, the norm of a difference is
    |h_k^p - h_{k+1}^p| |w|. Norms have no sign, so oscillation cannot be detected.
    """
    h, difference = numbers(h, "h"), numbers(difference, "the differences")
    if h.ndim != 1 or difference.shape != (max(len(h) - 1, 0),):
        raise UsageError(f"n sizes have n - 1 differences: shapes {h.shape} and {difference.shape} do not match")
    levels(h, h)
    if np.any(np.diff(h) > 0) or np.any(difference < 0):
        raise UsageError("give decreasing sizes, and norms of differences that are not negative")
    return _from_changes(h, difference, formal)


def observed_order(coarse_ratio: float, fine_ratio: float, growth: float, *, alternating: bool = False) -> float:
    """Observed order p of a quantity on three levels; -inf or inf where |p| exceeds what double precision can show.

    Parameters
    ----------
    coarse_ratio, fine_ratio : float
        Refinement ratios (coarser size over finer size, above 1) of the two coarser levels and of the two finer levels.
    growth : float
        Change between the two coarser levels over the change between the two finer ones; positive.
    alternating : bool
        Whether the two changes have opposite signs. The equation of `grid_convergence` then has +1 in place of -1, as in Celik et al.
    """
    wide, narrow = math.log(coarse_ratio), math.log(fine_ratio)

    def excess(p: float) -> float:
        if alternating:
            return p * narrow + math.log((math.exp(p * wide) + 1) / (math.exp(p * narrow) + 1) / growth)
        # (r^p - 1)/(1 - s^-p): near p = 0 both terms are small, so use expm1, and the limit at p = 0.
        of_steps = math.expm1(p * wide) / -math.expm1(-p * narrow) if abs(p) * max(wide, narrow) > 1e-12 else wide / narrow
        return math.log(of_steps / growth)

    high = LARGEST / max(wide, narrow)
    low = -high
    if excess(high) < 0:
        return math.inf
    if excess(low) > 0:
        return -math.inf
    while high - low > PRECISION * max(1.0, abs(low)):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return (low + high) / 2


def _from_changes(h: Array, steps: Array, formal: float) -> GridConvergence:
    """Grid convergence from the changes (n - 1,) between neighbouring levels of sizes (n,), coarsest first."""
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
