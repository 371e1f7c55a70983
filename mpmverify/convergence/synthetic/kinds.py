"""Kinds of random error series, each with a known truth.

A series is drawn together with a band of orders, centred at 1/2, 1, 3/2, 2, 3 or 4, with a half-width of 0.1 to 0.4. Its three to
eight levels are halved or have ratios from 1.3 to 3, and are shuffled. The relative error of the second finest level lies between
1e-9 and 1. Every error has a log-normal scatter, whose size depends on the kind.

The truth refers to the law without scatter:

inside
    The order as h goes to zero lies in the inner half of the band. Other parts of the error vanish with h or alternate from level to
    level, or they are a rough start, round-off, or the error of a reference of known uncertainty. The other levels reveal them.
outside
    The order as h goes to zero and the order at the finest level lie at least `laws.MARGIN` outside the band, on the same side.
undecidable
    At most two levels carry information, or the finest level contradicts the others.
not finite
    A level is NaN or infinite.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.synthetic import laws
from mpmverify.convergence.synthetic.laws import Law, LawInputs


class Truth(StrEnum):
    """Truth about a series, as defined in the docstring of this module."""

    INSIDE = "inside"
    OUTSIDE = "outside"
    UNDECIDABLE = "undecidable"
    NOT_FINITE = "not finite"


@dataclass(frozen=True)
class Kind:
    """How series of one kind are drawn, and the truth about them.

    Parameters
    ----------
    truth : Truth
    law : callable
        Error without scatter (n,).
    scatter : (float, float)
        Range of the standard deviation of log E.
    altered : callable
        Changes the errors (n,) after the scatter was applied; may return fewer levels.
    unequal : bool or None
        Whether the refinement ratios differ; None for a random choice.
    uncertainty : float
        Uncertainty of the numerical reference, relative to the solution; 0 for an exact solution.
    """

    truth: Truth
    law: Law
    scatter: tuple[float, float] = (0.0, 0.02)
    altered: Callable[[LawInputs, Array], Array] = laws.unaltered
    unequal: bool | None = None
    uncertainty: float = 0.0


KINDS: Mapping[str, Kind] = {
    "power law, equal ratios": Kind(Truth.INSIDE, laws.power_law, unequal=False),
    "power law, unequal ratios": Kind(Truth.INSIDE, laws.power_law, unequal=True),
    "power law, much scatter": Kind(Truth.INSIDE, laws.power_law, (0.02, 0.1)),
    "approached from above": Kind(Truth.INSIDE, partial(laws.approached, sign=1)),
    "approached from below": Kind(Truth.INSIDE, partial(laws.approached, sign=-1)),
    "rough start": Kind(Truth.INSIDE, laws.rough_start),
    "mixed orders": Kind(Truth.INSIDE, laws.mixed),
    "alternating": Kind(Truth.INSIDE, partial(laws.alternating, order=LawInputs.inside)),
    "round-off after three levels": Kind(Truth.INSIDE, laws.power_law, altered=partial(laws.at_round_off, least=3)),
    "numerical reference": Kind(Truth.INSIDE, laws.power_law, altered=laws.against_reference, uncertainty=laws.UNCERTAINTY),
    "order too low": Kind(Truth.OUTSIDE, partial(laws.other_order, side=LawInputs.below), (0.0, 0.1)),
    "order too high": Kind(Truth.OUTSIDE, partial(laws.other_order, side=LawInputs.above), (0.0, 0.1)),
    "slower in the end": Kind(Truth.OUTSIDE, laws.slower_in_the_end),
    "other floor": Kind(Truth.OUTSIDE, laws.floor),
    "stagnant": Kind(Truth.OUTSIDE, laws.stagnant, (0.0, 0.2)),
    "equal errors": Kind(Truth.OUTSIDE, laws.equal, (0.0, 0.0)),
    "divergent": Kind(Truth.OUTSIDE, laws.divergent, (0.0, 0.1)),
    "turns up": Kind(Truth.OUTSIDE, laws.turns_up),
    "blows up": Kind(Truth.OUTSIDE, laws.blows_up),
    "alternating, too low": Kind(Truth.OUTSIDE, partial(laws.alternating, order=LawInputs.below)),
    "alternating, too high": Kind(Truth.OUTSIDE, partial(laws.alternating, order=LawInputs.above)),
    "finest level too good": Kind(Truth.UNDECIDABLE, laws.too_good),
    "finest level vanishes": Kind(Truth.UNDECIDABLE, laws.vanishes),
    "fewer than three levels": Kind(Truth.UNDECIDABLE, laws.power_law, altered=laws.few_levels),
    "round-off before three levels": Kind(Truth.UNDECIDABLE, laws.power_law, altered=partial(laws.at_round_off, least=0)),
    "zeros": Kind(Truth.UNDECIDABLE, laws.power_law, altered=laws.zeros),
    "NaN or infinite": Kind(Truth.NOT_FINITE, laws.power_law, altered=laws.not_finite),
}


@dataclass(frozen=True)
class RandomSeries:
    """One series, in any order of its levels, and its band.

    Parameters
    ----------
    h, error : Array
        Sizes and relative errors (n,).
    low, high : float
        Accepted band of orders.
    """

    h: Array
    error: Array
    low: float
    high: float


def band(generator: np.random.Generator) -> tuple[float, float]:
    """Draw a band of orders."""
    centre = generator.choice([0.5, 1, 1.5, 2, 3, 4])
    half_width = generator.uniform(0.1, 0.15 if centre < 1 else 0.4)
    return centre - half_width, centre + half_width


def ladder(generator: np.random.Generator, unequal: bool) -> Array:
    """Draw three to eight sizes, coarsest first."""
    levels = int(generator.integers(3, 9))
    ratios = generator.uniform(1.3, 3, levels - 1) if unequal else np.full(levels - 1, 2.0)
    return 10 ** generator.uniform(-3, 2) / np.cumprod([1.0, *ratios])


def draw_series(kind: Kind, generator: np.random.Generator) -> RandomSeries:
    """Draw one series of a kind."""
    low, high = band(generator)
    h = ladder(generator, generator.random() < 0.5 if kind.unequal is None else kind.unequal)
    setting = LawInputs(generator, h / h[-1], low, high)
    law = kind.law(setting)
    size = 10 ** generator.uniform(-9, 0)
    scatter = generator.uniform(*kind.scatter) * generator.standard_normal(len(h))
    # Scale by the second finest error, because the finest one may be zero.
    error = kind.altered(setting, law / law[-2] * size * np.exp(scatter))
    shuffled = generator.permutation(len(error))
    return RandomSeries(h[: len(error)][shuffled], error[shuffled], low, high)
