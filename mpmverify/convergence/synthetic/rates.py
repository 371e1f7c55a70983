"""How often the judge is right, undecided and wrong, by kind of series."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mpmverify.convergence import verdict
from mpmverify.convergence.levels import Array
from mpmverify.convergence.synthetic.kinds import KINDS, Kind, Setting, Truth, specimen
from mpmverify.convergence.verdict import Verdict

RIGHT = {
    Truth.INSIDE: Verdict.PASS,
    Truth.OUTSIDE: Verdict.FAIL,
    Truth.UNDECIDABLE: Verdict.INCONCLUSIVE,
    Truth.NOT_FINITE: Verdict.ERROR,
}


@dataclass(frozen=True)
class Rate:
    """Verdicts on the series of one kind, or of several.

    Parameters
    ----------
    kind : str
    truth : str
    series : int
        How many were judged: the sum of those that follow.
    right : int
        PASS inside, FAIL outside, INCONCLUSIVE where nothing can be decided, ERROR where a level is not finite.
    inconclusive : int
        Where a verdict was possible.
    wrong_pass, wrong_fail : int
        ERROR counts as a wrong FAIL where every level is finite.
    """

    kind: str
    truth: str
    series: int
    right: int
    inconclusive: int
    wrong_pass: int
    wrong_fail: int


def rate(name: str, kind: Kind, count: int, seed: Sequence[int]) -> Rate:
    """Judge series of one kind."""
    generator = np.random.default_rng(seed)
    found: Counter[Verdict] = Counter()
    for _ in range(count):
        drawn = specimen(kind, generator)
        found[verdict(drawn.h, drawn.error, band=(drawn.low, drawn.high), uncertainty=kind.uncertainty)[0]] += 1
    return counted(name, kind.truth, found)


def counted(name: str, truth: Truth, found: Mapping[Verdict, int]) -> Rate:
    """Rate of the verdicts that were found on series of one truth."""
    rest = Counter(found)
    right, undecided, passed = (rest.pop(verdict, 0) for verdict in (RIGHT[truth], Verdict.INCONCLUSIVE, Verdict.PASS))
    return Rate(name, truth, sum(found.values()), right, undecided, passed, rest.total())


def measure(count: int = 20_000, seed: int = 0) -> list[Rate]:
    """Judge random series of every kind.

    Parameters
    ----------
    count : int
        Of series in all, rounded up to the same number of every kind.
    seed : int
        The same seed gives the same series.
    """
    each = -(-count // len(KINDS))
    return [rate(name, kind, each, (seed, k)) for k, (name, kind) in enumerate(KINDS.items())]


MARGINS = (-0.05, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
"""Distances outside the band at which `measure_limits` looks; a negative one is inside."""
SHARES = (0.01, 0.1, 0.3, 0.5)
"""Shares of the finest error that a slower term has where `measure_limits` looks for it."""


def measure_limits(count: int = 8_000, seed: int = 0) -> list[Rate]:
    """Judge series at the limits of what a judge can see: orders close to an edge, and slower terms that have not taken over.

    Notes
    -----
    `measure` leaves these out, since a wrong verdict on them is inherent: a finite ladder cannot tell an order from one that is
    closer than its interval, nor what the error will do beyond the finest level. These rates say how close is too close.
    """

    def beside(s: Setting, margin: float) -> Array:
        return s.x ** (s.high + margin if s.coin() else s.low - margin)

    def hidden(s: Setting, share: float) -> Array:
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
    """Sum of the rates of some truths, by default of all."""
    some = [r for r in rates if not truths or r.truth in truths]
    sums = {
        name: sum(getattr(r, name) for r in some) for name in ("series", "right", "inconclusive", "wrong_pass", "wrong_fail")
    }
    return Rate("all", ", ".join(truths) or "any", **sums)
