"""Kinds of random error series, each with a known truth.

A series is drawn together with a band of orders, centred at 1/2, 1, 3/2, 2, 3 or 4, with a half-width of 0.1 to 0.4. Its three to
twelve levels have equal ratios, mostly of 2, or unequal ones, from 1.1 to 4, and are shuffled; the coarsest size is at most 4096
times the finest. The relative error of the second finest level lies between 1e-9 and 1. Every error has a log-normal scatter, whose
size depends on the kind.

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

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np

from mpmverify.convergence import ROUND_OFF
from mpmverify.convergence.levels import Array
from mpmverify.convergence.synthetic import laws
from mpmverify.convergence.synthetic.laws import DrawnOrder, Law, LawInputs

LOG_RATIOS = math.log(1.1), math.log(4.0)
"""Range of the logarithm of a refinement ratio."""
SPAN = 4096.0
"""Largest ratio of the coarsest to the finest size."""


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
    least : int
        Least number of levels.
    replicates : int
        Largest number of errors at one size.
    uncertainty : float
        Uncertainty of the numerical reference, relative to the solution; 0 for an exact solution.
    round_off : float
        Relative error at and below which the judge is told that round-off hides the order.
    """

    truth: Truth
    law: Law
    scatter: tuple[float, float] = (0.0, 0.02)
    altered: Callable[[LawInputs, Array], Array] = laws.unaltered
    unequal: bool | None = None
    least: int = 3
    replicates: int = 1
    uncertainty: float = 0.0
    round_off: float = ROUND_OFF


def _kinds(truth: Truth, order: DrawnOrder, suffix: str) -> Mapping[str, Kind]:
    """Kinds whose laws take any order, with an order that is drawn by `order`."""
    power = partial(laws.power_law, order=order)
    above, below = (partial(laws.approached, order=order, sign=sign) for sign in (1, -1))
    single = partial(laws.at_round_off, least=3, round_off=laws.SINGLE_ROUND_OFF, noise=1e-7)
    kinds = {
        "power law, equal ratios": Kind(truth, power, unequal=False),
        "power law, unequal ratios": Kind(truth, power, unequal=True),
        "power law, much scatter": Kind(truth, power, (0.02, 0.1)),
        "approached from above": Kind(truth, above),
        "approached from below": Kind(truth, below),
        "rough start": Kind(truth, partial(laws.rough_start, order=order), least=5),
        "alternating": Kind(truth, partial(laws.alternating, order=order)),
        "round-off after three levels": Kind(truth, power, altered=partial(laws.at_round_off, least=3)),
        "single precision": Kind(truth, power, altered=single, round_off=laws.SINGLE_ROUND_OFF),
        "numerical reference": Kind(truth, power, altered=laws.against_reference, uncertainty=laws.UNCERTAINTY),
        "replicates": Kind(truth, power, (0.02, 0.2), replicates=5),
    }
    return {f"{name}{suffix}": kind for name, kind in kinds.items()}


FIXED = partial(laws.power_law, order=LawInputs.inside)
KINDS: Mapping[str, Kind] = {
    **_kinds(Truth.INSIDE, LawInputs.inside, ""),
    "mixed orders": Kind(Truth.INSIDE, partial(laws.mixed, order=LawInputs.inside)),
    **_kinds(Truth.OUTSIDE, LawInputs.below, ", too low"),
    **_kinds(Truth.OUTSIDE, LawInputs.above, ", too high"),
    "mixed orders, too high": Kind(Truth.OUTSIDE, partial(laws.mixed, order=LawInputs.above)),
    "slower in the end": Kind(Truth.OUTSIDE, laws.slower_in_the_end),
    "other floor": Kind(Truth.OUTSIDE, laws.floor),
    "single precision, untold": Kind(Truth.OUTSIDE, FIXED, altered=laws.in_single_precision, least=4),
    "stagnant": Kind(Truth.OUTSIDE, laws.stagnant, (0.0, 0.2)),
    "equal errors": Kind(Truth.OUTSIDE, laws.equal, (0.0, 0.0)),
    "divergent": Kind(Truth.OUTSIDE, laws.divergent, (0.0, 0.1)),
    "turns up": Kind(Truth.OUTSIDE, laws.turns_up),
    "blows up": Kind(Truth.OUTSIDE, laws.blows_up),
    "finest level too good": Kind(Truth.UNDECIDABLE, laws.too_good),
    "finest level vanishes": Kind(Truth.UNDECIDABLE, laws.vanishes),
    "fewer than three levels": Kind(Truth.UNDECIDABLE, FIXED, altered=laws.few_levels),
    "round-off before three levels": Kind(Truth.UNDECIDABLE, FIXED, altered=partial(laws.at_round_off, least=0)),
    "zeros": Kind(Truth.UNDECIDABLE, FIXED, altered=laws.zeros),
    "NaN or infinite": Kind(Truth.NOT_FINITE, FIXED, altered=laws.not_finite),
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
    scatter : float
        Standard deviation of log E.
    """

    h: Array
    error: Array
    low: float
    high: float
    scatter: float


def band(generator: np.random.Generator) -> tuple[float, float]:
    """Draw a band of orders."""
    centre = generator.choice([0.5, 1, 1.5, 2, 3, 4])
    half_width = generator.uniform(0.1, 0.15 if centre < 1 else 0.4)
    return centre - half_width, centre + half_width


def ladder(generator: np.random.Generator, unequal: bool, least: int = 3) -> Array:
    """Draw `least` to twelve sizes, coarsest first."""
    levels = int(generator.integers(least, 13))
    ratio = np.exp(generator.uniform(*LOG_RATIOS, levels - 1))
    if not unequal:
        ratio[:] = 2.0 if generator.random() < 0.6 else ratio[0]
    sizes = 1 / np.cumprod([1.0, *ratio])
    within = sizes * SPAN >= 1
    within[:least] = True
    return 10 ** generator.uniform(-3, 2) * sizes[within]


def draw_series(kind: Kind, generator: np.random.Generator) -> RandomSeries:
    """Draw one series of a kind."""
    low, high = band(generator)
    h = ladder(generator, generator.random() < 0.5 if kind.unequal is None else kind.unequal, kind.least)
    setting = LawInputs(generator, h / h[-1], low, high)
    law = kind.law(setting)
    size = 10 ** generator.uniform(-9, 0)
    # Scale by the second finest error, because the finest one may be zero.
    level = np.arange(len(h)).repeat(generator.integers(1, kind.replicates + 1, len(h)))
    scatter = generator.uniform(*kind.scatter)
    error = kind.altered(setting, (law / law[-2] * size)[level] * np.exp(scatter * generator.standard_normal(len(level))))
    shuffled = generator.permutation(len(error))
    return RandomSeries(h[level][: len(error)][shuffled], error[shuffled], low, high, scatter)
