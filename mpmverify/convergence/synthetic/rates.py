"""Rates of right, inconclusive and wrong verdicts on random series, by kind of series."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mpmverify.convergence import analyse
from mpmverify.convergence.levels import Array
from mpmverify.convergence.order_verdict import decide
from mpmverify.convergence.synthetic.kinds import KINDS, Kind, LawInputs, Truth, draw_series
from mpmverify.convergence.verdict import Verdict

RIGHT = {
    Truth.INSIDE: Verdict.PASS,
    Truth.OUTSIDE: Verdict.FAIL,
    Truth.UNDECIDABLE: Verdict.INCONCLUSIVE,
    Truth.NOT_FINITE: Verdict.ERROR,
}


@dataclass(frozen=True)
class Rate:
    """Numbers of verdicts on the series of one kind, or of several.

    Parameters
    ----------
    kind : str
    truth : str
    series : int
        Judged series: the sum of the numbers below.
    right : int
        PASS inside, FAIL outside, INCONCLUSIVE for undecidable series, ERROR where a level is not finite.
    inconclusive : int
        INCONCLUSIVE although PASS, FAIL or ERROR was right.
    wrong_pass, wrong_fail : int
        Wrong verdicts; a wrong ERROR counts as a wrong FAIL.
    """

    kind: str
    truth: str
    series: int
    right: int
    inconclusive: int
    wrong_pass: int
    wrong_fail: int


def rate(name: str, kind: Kind, count: int, seed: Sequence[int]) -> Rate:
    """Judge `count` random series of one kind."""
    generator = np.random.default_rng(seed)
    found: Counter[Verdict] = Counter()
    for _ in range(count):
        drawn = draw_series(kind, generator)
        series = analyse(drawn.h, drawn.error, round_off=kind.round_off, uncertainty=kind.uncertainty)
        found[decide(series, drawn.low, drawn.high)[0]] += 1
    return rate_of_verdicts(name, kind.truth, found)


def rate_of_verdicts(name: str, truth: Truth, found: Mapping[Verdict, int]) -> Rate:
    """Count the right and wrong verdicts among those found on series of one truth."""
    rest = Counter(found)
    right, undecided, passed = (rest.pop(verdict, 0) for verdict in (RIGHT[truth], Verdict.INCONCLUSIVE, Verdict.PASS))
    return Rate(name, truth, sum(found.values()), right, undecided, passed, rest.total())


def measure(count: int = 20_000, seed: int = 0) -> list[Rate]:
    """Judge random series of every kind.

    Parameters
    ----------
    count : int
        Total number of series, rounded up so that every kind has the same number.
    seed : int
        The same seed gives the same series.
    """
    each = -(-count // len(KINDS))
    return [rate(name, kind, each, (seed, k)) for k, (name, kind) in enumerate(KINDS.items())]


MARGINS = (-0.05, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
"""Distances outside the band of the orders in `measure_limits`; negative ones are inside."""
SHARES = (0.01, 0.1, 0.3, 0.5)
"""Shares of a slower term in the finest error in `measure_limits`."""


def measure_limits(count: int = 8_000, seed: int = 0) -> list[Rate]:
    """Judge series that are hard to decide: orders close to an edge of the band, and slower terms that do not dominate yet.

    Parameters
    ----------
    count : int
        Total number of series, rounded up so that every kind has the same number.
    seed : int
        The same seed gives the same series.

    Notes
    -----
    `measure` leaves these series out because wrong verdicts on them are inevitable: a finite number of levels can neither resolve
    orders closer than the confidence interval nor show the error beyond the finest level. These rates show how close an order may be.
    """

    def beside(s: LawInputs, margin: float) -> Array:
        return s.x ** (s.high + margin if s.coin() else s.low - margin)

    def hidden(s: LawInputs, share: float) -> Array:
        return (1 - share) * s.x ** s.inside() + share * s.x ** s.below()

    edges = {
        f"{abs(margin):g} {'outside' if margin > 0 else 'inside'} the edge": Kind(
            Truth.OUTSIDE if margin > 0 else Truth.INSIDE, partial(beside, margin=margin)
        )
        for margin in MARGINS
    }
    tails = {f"slower term, {share:.0%}": Kind(Truth.OUTSIDE, partial(hidden, share=share)) for share in SHARES}
    kinds = edges | tails
    each = -(-count // len(kinds))
    return [rate(name, kind, each, (seed, len(KINDS) + k)) for k, (name, kind) in enumerate(kinds.items())]


def total(rates: Iterable[Rate], *truths: Truth) -> Rate:
    """Sum of the rates of the given truths, by default of all."""
    some = [r for r in rates if not truths or r.truth in truths]
    sums = {
        name: sum(getattr(r, name) for r in some) for name in ("series", "right", "inconclusive", "wrong_pass", "wrong_fail")
    }
    return Rate("all", ", ".join(truths) or "any", **sums)
