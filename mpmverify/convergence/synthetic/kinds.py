"""Kinds of error series, each with what is true of it.

A series is drawn for a band of orders, that of no particular scheme: centred at 1/2, 1, 3/2, 2, 3 or 4, and 0.1 to 0.4 to either
side. Its ladder has three to eight levels, halved or at ratios from 1.3 to 3, in any order; the error of the second finest lies
between 1e-9 and 1 of the solution, and every error has a log-normal scatter, whose size belongs to the kind.

What is true is said of the law without its scatter:

inside
    The order as h goes to zero lies in the inner half of the band. Whatever else the law holds vanishes with h, alternates from
    level to level, or is a rough start, round-off or the error of a reference of known uncertainty, which other levels show for
    what it is.
outside
    The order as h goes to zero and the one at the finest level both lie at least `laws.MARGIN` outside the band, on one side.
undecidable
    No more than two levels tell anything, or the finest one belies what the others say.
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
from mpmverify.convergence.synthetic.laws import Law, Setting


class Truth(StrEnum):
    """What is true of a series; see the module."""

    INSIDE = "inside"
    OUTSIDE = "outside"
    UNDECIDABLE = "undecidable"
    NOT_FINITE = "not finite"


@dataclass(frozen=True)
class Kind:
    """How series are drawn, and what is true of them.

    Parameters
    ----------
    truth : Truth
    law : callable
        Error without scatter (n,).
    scatter : (float, float)
        Range of the standard deviation of log E.
    spoiled : callable
        What becomes of the errors, and how many levels are left.
    unequal : bool or None
        Whether the ratios of the sizes differ; None leaves it to chance.
    uncertainty : float
        Of the reference that stands for the exact solution.
    """

    truth: Truth
    law: Law
    scatter: tuple[float, float] = (0.0, 0.02)
    spoiled: Callable[[Setting, Array], Array] = laws.as_drawn
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
    "alternating": Kind(Truth.INSIDE, partial(laws.alternating, order=Setting.inside)),
    "round-off after three levels": Kind(Truth.INSIDE, laws.power_law, spoiled=partial(laws.at_round_off, least=3)),
    "numerical reference": Kind(Truth.INSIDE, laws.power_law, spoiled=laws.against_reference, uncertainty=laws.UNCERTAINTY),
    "order too low": Kind(Truth.OUTSIDE, partial(laws.other_order, side=Setting.below), (0.0, 0.1)),
    "order too high": Kind(Truth.OUTSIDE, partial(laws.other_order, side=Setting.above), (0.0, 0.1)),
    "slower in the end": Kind(Truth.OUTSIDE, laws.slower_in_the_end),
    "other floor": Kind(Truth.OUTSIDE, laws.floor),
    "stagnant": Kind(Truth.OUTSIDE, laws.stagnant, (0.0, 0.2)),
    "equal errors": Kind(Truth.OUTSIDE, laws.equal, (0.0, 0.0)),
    "divergent": Kind(Truth.OUTSIDE, laws.divergent, (0.0, 0.1)),
    "turns up": Kind(Truth.OUTSIDE, laws.turns_up),
    "blows up": Kind(Truth.OUTSIDE, laws.blows_up),
    "alternating, too low": Kind(Truth.OUTSIDE, partial(laws.alternating, order=Setting.below)),
    "alternating, too high": Kind(Truth.OUTSIDE, partial(laws.alternating, order=Setting.above)),
    "finest level too good": Kind(Truth.UNDECIDABLE, laws.too_good),
    "finest level vanishes": Kind(Truth.UNDECIDABLE, laws.vanishes),
    "fewer than three levels": Kind(Truth.UNDECIDABLE, laws.power_law, spoiled=laws.few_levels),
    "round-off before three levels": Kind(Truth.UNDECIDABLE, laws.power_law, spoiled=partial(laws.at_round_off, least=0)),
    "zeros": Kind(Truth.UNDECIDABLE, laws.power_law, spoiled=laws.zeros),
    "NaN or infinite": Kind(Truth.NOT_FINITE, laws.power_law, spoiled=laws.not_finite),
}


@dataclass(frozen=True)
class Specimen:
    """One series with a band: sizes and errors (n,), in any order."""

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


def specimen(kind: Kind, generator: np.random.Generator) -> Specimen:
    """Draw one series of a kind."""
    low, high = band(generator)
    h = ladder(generator, generator.random() < 0.5 if kind.unequal is None else kind.unequal)
    setting = Setting(generator, h / h[-1], low, high)
    law = kind.law(setting)
    size = 10 ** generator.uniform(-9, 0)
    scatter = generator.uniform(*kind.scatter) * generator.standard_normal(len(h))
    # The second finest error sets the size: the finest one may vanish.
    error = kind.spoiled(setting, law / law[-2] * size * np.exp(scatter))
    shuffled = generator.permutation(len(error))
    return Specimen(h[: len(error)][shuffled], error[shuffled], low, high)
