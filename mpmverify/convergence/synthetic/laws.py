"""Laws of error series without scatter, and changes that are applied to the errors afterwards."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence import ROUND_OFF
from mpmverify.convergence.levels import Array

MARGIN = 0.3
"""Smallest distance between the band and an order drawn outside it."""
LEAST_ORDER = 0.05
"""Smallest positive order that is drawn below a band."""
UNCERTAINTY = 1e-6
"""Relative uncertainty of the numerical reference in `against_reference`."""
SINGLE_ROUND_OFF = 1e-5
"""Relative error at and below which round-off of single precision hides the order: noise of 1e-7 is 1 % of it."""


@dataclass(frozen=True)
class LawInputs:
    """Input of a law.

    Parameters
    ----------
    generator : numpy.random.Generator
    x : Array
        Sizes relative to the finest one (n,), coarsest first.
    low, high : float
        Band of orders.
    """

    generator: np.random.Generator
    x: Array
    low: float
    high: float

    def uniform(self, low: float, high: float) -> float:
        return float(self.generator.uniform(low, high))

    def coin(self) -> bool:
        return bool(self.generator.random() < 0.5)

    def sign(self) -> int:
        return 1 if self.coin() else -1

    def inside(self) -> float:
        """Draw an order in the inner half of the band."""
        quarter = (self.high - self.low) / 4
        return self.uniform(self.low + quarter, self.high - quarter)

    def below(self) -> float:
        """Draw a positive order below the band: `MARGIN` to 1.5 below it where that is above `LEAST_ORDER`, else that."""
        return max(LEAST_ORDER, self.low - self.uniform(MARGIN, 1.5))

    def above(self) -> float:
        """Draw an order `MARGIN` to 1.5 above the band."""
        return self.high + self.uniform(MARGIN, 1.5)


Law = Callable[[LawInputs], Array]
DrawnOrder = Callable[[LawInputs], float]
"""How the order of a law is drawn: `LawInputs.inside`, `below` or `above`."""


# Laws whose order may lie inside the band or outside.


def power_law(s: LawInputs, order: DrawnOrder) -> Array:
    return s.x ** order(s)


def approached(s: LawInputs, order: DrawnOrder, sign: int) -> Array:
    """A correction term of up to 25 % at the third finest level; the order approaches its limit from above (+1) or below (-1).

    Outside a band, the limit lies so far off that the order of the finest level lies outside by `MARGIN` too.
    """
    share, power = s.uniform(0, 0.25), s.uniform(0.5, 3)
    correction = share * (s.x / s.x[-3]) ** power
    ahead = sign * power * correction[-1] / (1 + sign * correction[-1])
    limit = order(s)
    if order is LawInputs.below:
        limit -= max(ahead, 0.0)
    elif order is LawInputs.above:
        limit -= min(ahead, 0.0)
    return s.x**limit * np.abs(1 + sign * correction) + 1e-300


def rough_start(s: LawInputs, order: DrawnOrder) -> Array:
    """One to three coarse levels that do not resolve the solution: their errors are up to 5 times too small or 20 times too large.

    At least the four finest levels follow the power law.
    """
    start = int(s.generator.integers(1, min(3, len(s.x) - 4) + 1))
    factor = np.ones(len(s.x))
    factor[:start] = np.exp(s.generator.uniform(-1.6, 3.0, start))
    return s.x ** order(s) * factor


def mixed(s: LawInputs, order: DrawnOrder) -> Array:
    """A h^p + B h^q with q up to 2 above p; the second term is less than a third of the finest error."""
    share, slow = s.uniform(0, 1 / 3), order(s)
    return (1 - share) * s.x**slow + share * s.x ** (slow + s.uniform(0.3, 2))


def alternating(s: LawInputs, order: DrawnOrder) -> Array:
    """Odd and even levels lie on two parallel lines, or on two curves that converge, in the plane of log h and log E."""
    amplitude = s.sign() * s.uniform(0.05, 0.5) * (s.x / s.x[0] if s.coin() else 1.0)
    return s.x ** order(s) * (1 + amplitude * (-1.0) ** np.arange(len(s.x)))


# Laws whose order lies outside the band.


def stagnant(s: LawInputs) -> Array:
    return s.x ** min(s.low - MARGIN, s.uniform(-0.2, 0.2))


def equal(s: LawInputs) -> Array:
    return np.ones_like(s.x)


def divergent(s: LawInputs) -> Array:
    return s.x ** s.uniform(-4, -0.3)


def with_tail(s: LawInputs, order: float, tail: float) -> Array:
    """Add a term of order `tail` to one of order `order`; at the finest level it dominates, and the order is outside the band."""
    least = (order - (s.low - MARGIN)) / (order - tail)
    share = s.uniform(max(0.5, min(0.99, least)), 1)
    return (1 - share) * s.x**order + share * s.x**tail


def turns_up(s: LawInputs) -> Array:
    return with_tail(s, s.inside(), s.uniform(-3, -0.3))


def floor(s: LawInputs) -> Array:
    return with_tail(s, s.inside() + (s.uniform(0, 2) if s.coin() else 0), min(0.0, s.low - MARGIN))


def slower_in_the_end(s: LawInputs) -> Array:
    return with_tail(s, s.inside() + s.uniform(0, 1), s.low - s.uniform(MARGIN, 1.5))


def blows_up(s: LawInputs) -> Array:
    return _with_finest(power_law(s, LawInputs.inside), 10 ** s.uniform(1, 6))


# Laws that allow no decision.


def too_good(s: LawInputs) -> Array:
    return _with_finest(power_law(s, LawInputs.inside), 10 ** -s.uniform(2, 8))


def vanishes(s: LawInputs) -> Array:
    return _with_finest(power_law(s, LawInputs.inside), 0.0)


def _with_finest(error: Array, factor: float) -> Array:
    return np.append(error[:-1], error[-1] * factor)


# Changes of the errors after the law and the scatter.


def unaltered(s: LawInputs, error: Array) -> Array:
    return error


def at_round_off(s: LawInputs, error: Array, least: int, round_off: float = ROUND_OFF, noise: float = 1e-15) -> Array:
    """Replace the finest levels by noise of the arithmetic.

    At least `least` levels stay above round-off; if `least` is 0, at most two do.
    """
    levels = len(error)
    counts = range(least, levels + 1) if least else range(3)
    smallest = np.minimum.accumulate(np.append(np.inf, error))  # of so many coarse levels
    largest = np.append(np.maximum.accumulate(error[::-1])[::-1], 0.0)  # of the other ones
    above = int(s.generator.choice([count for count in counts if smallest[count] > 1.02 * largest[count]]))
    upper, lower = smallest[above], largest[above]
    if not above:
        upper = 4 * lower
    elif above == levels:
        lower = upper / 4
    share = s.uniform(0.05, 0.95)
    scaled = error * round_off / (upper**share * lower ** (1 - share))
    return np.abs(scaled + noise * s.generator.standard_normal(levels))


def in_single_precision(s: LawInputs, error: Array) -> Array:
    """Hide the three finest of at least four levels under noise of single precision, of which the judge is not told."""
    noise = 1e-7 * np.exp(0.5 * s.generator.standard_normal(len(error)))
    return error / error[-3] * 1e-7 * s.uniform(0, 0.5) + noise


def against_reference(s: LawInputs, error: Array) -> Array:
    """Shift all errors by an error of the reference of at most `UNCERTAINTY`; at least three levels exceed ten times that."""
    last = int(s.generator.integers(2, len(error)))
    scaled = error / error[last] * UNCERTAINTY * s.uniform(11.5, 20)
    return np.abs(scaled + UNCERTAINTY * s.uniform(-1, 1))


def few_levels(s: LawInputs, error: Array) -> Array:
    return error[: int(s.generator.integers(1, 3))]


def zeros(s: LawInputs, error: Array) -> Array:
    """Set all levels but at most two to zero."""
    left = s.generator.permutation(len(error))[: int(s.generator.integers(0, 3))]
    return np.where(np.isin(np.arange(len(error)), left), error, 0.0)


def not_finite(s: LawInputs, error: Array) -> Array:
    bad = s.generator.permutation(len(error))[: int(s.generator.integers(1, len(error) + 1))]
    altered = error.copy()
    altered[bad] = s.generator.choice([np.nan, np.inf], len(bad))
    return altered
