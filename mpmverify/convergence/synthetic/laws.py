"""Laws of error series without their scatter, and what may spoil the errors when it is known."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence import ROUND_OFF
from mpmverify.convergence.levels import Array

MARGIN = 0.3
"""Distance from the band at which an order is outside beyond doubt."""
UNCERTAINTY = 1e-6
"""Of the reference of those series that have one."""


@dataclass(frozen=True)
class Setting:
    """What a law may draw from.

    Parameters
    ----------
    generator : numpy.random.Generator
    x : Array
        Sizes (n,) over the finest one, coarsest first.
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

    def inside(self) -> float:
        """Draw an order in the inner half of the band."""
        quarter = (self.high - self.low) / 4
        return self.uniform(self.low + quarter, self.high - quarter)

    def below(self) -> float:
        """Draw an order that is below the band by the margin or more, and positive."""
        return max(0.05, self.low - self.uniform(MARGIN, 1.5))

    def above(self) -> float:
        return self.high + self.uniform(MARGIN, 1.5)


Law = Callable[[Setting], Array]


# Laws whose order is inside.


def power_law(s: Setting) -> Array:
    return s.x ** s.inside()


def approached(s: Setting, sign: int) -> Array:
    """A correction of up to a quarter at the third finest level; the order comes from above (+1) or below (-1)."""
    correction = s.uniform(0, 0.25) * (s.x / s.x[-3]) ** s.uniform(0.5, 3)
    return s.x ** s.inside() * np.abs(1 + sign * correction) + 1e-300


def rough_start(s: Setting) -> Array:
    """Coarse levels that miss the wave: all but four at most have errors up to five times too small or half too large."""
    levels = len(s.x)
    start = int(s.generator.integers(0, max(1, levels - 3)))
    factor = np.ones(levels)
    factor[:start] = np.exp(s.generator.uniform(-1.6, 0.4, start))
    return s.x ** s.inside() * factor


def mixed(s: Setting) -> Array:
    """A h^p + B h^q with p inside, q faster by up to 2, and less than a third of the finest error B's."""
    share, slow = s.uniform(0, 1 / 3), s.inside()
    return (1 - share) * s.x**slow + share * s.x ** (slow + s.uniform(0.3, 2))


def alternating(s: Setting, order: Callable[[Setting], float]) -> Array:
    """Odd and even levels lie on two lines, or on two curves that meet."""
    amplitude = s.uniform(0.05, 0.5) * (s.x / s.x[0] if s.coin() else 1.0)
    return s.x ** order(s) * (1 + amplitude * (-1.0) ** np.arange(len(s.x)) * (1 if s.coin() else -1))


# Laws whose order is outside.


def other_order(s: Setting, side: Callable[[Setting], float]) -> Array:
    return s.x ** side(s)


def stagnant(s: Setting) -> Array:
    return s.x ** min(s.low - MARGIN, s.uniform(-0.2, 0.2))


def equal(s: Setting) -> Array:
    return np.ones_like(s.x)


def divergent(s: Setting) -> Array:
    return s.x ** s.uniform(-4, -0.3)


def with_tail(s: Setting, order: float, tail: float) -> Array:
    """A slower term that has taken over at the finest level, by so much that the order is outside there."""
    least = (order - (s.low - MARGIN)) / (order - tail)
    share = s.uniform(max(0.5, min(0.99, least)), 1)
    return (1 - share) * s.x**order + share * s.x**tail


def turns_up(s: Setting) -> Array:
    return with_tail(s, s.inside(), s.uniform(-3, -0.3))


def floor(s: Setting) -> Array:
    return with_tail(s, s.inside() + (s.uniform(0, 2) if s.coin() else 0), min(0.0, s.low - MARGIN))


def slower_in_the_end(s: Setting) -> Array:
    return with_tail(s, s.inside() + s.uniform(0, 1), s.low - s.uniform(MARGIN, 1.5))


def blows_up(s: Setting) -> Array:
    return _with_finest(power_law(s), 10 ** s.uniform(1, 6))


# Laws that decide nothing.


def too_good(s: Setting) -> Array:
    return _with_finest(power_law(s), 10 ** -s.uniform(2, 8))


def vanishes(s: Setting) -> Array:
    return _with_finest(power_law(s), 0.0)


def _with_finest(error: Array, factor: float) -> Array:
    return np.append(error[:-1], error[-1] * factor)


# Series that are spoiled when their law and their scatter are known.


def as_drawn(s: Setting, error: Array) -> Array:
    return error


def at_round_off(s: Setting, error: Array, least: int) -> Array:
    """At least `least` levels or, if that is none, at most two are above round-off; the others are noise of double precision."""
    levels = len(error)
    above = int(s.generator.integers(least, levels + 1)) if least else int(s.generator.integers(0, 3))
    step = error[max(above - 1, 0)] / error[min(above, levels - 1)]
    last = ROUND_OFF * max(step, 1.1) ** s.uniform(0.05, 0.95)
    scaled = error / error[max(above - 1, 0)] * (last if above else 0.5 * ROUND_OFF)
    return np.abs(scaled + 1e-15 * s.generator.standard_normal(levels))


def against_reference(s: Setting, error: Array) -> Array:
    """A reference is off by no more than `UNCERTAINTY`, which the three coarsest errors at least exceed more than tenfold."""
    last = int(s.generator.integers(2, len(error)))
    scaled = error / error[last] * UNCERTAINTY * s.uniform(11.5, 20)
    return np.abs(scaled + UNCERTAINTY * s.uniform(-1, 1))


def few_levels(s: Setting, error: Array) -> Array:
    return error[: int(s.generator.integers(1, 3))]


def zeros(s: Setting, error: Array) -> Array:
    """All but two levels at most are exactly zero."""
    left = s.generator.permutation(len(error))[: int(s.generator.integers(0, 3))]
    return np.where(np.isin(np.arange(len(error)), left), error, 0.0)


def not_finite(s: Setting, error: Array) -> Array:
    bad = s.generator.permutation(len(error))[: int(s.generator.integers(1, len(error) + 1))]
    spoiled = error.copy()
    spoiled[bad] = s.generator.choice([np.nan, np.inf], len(bad))
    return spoiled
