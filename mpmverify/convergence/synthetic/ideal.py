"""The ideal judge: how many random series anyone could decide who knows the law and the scatter of their kind.

It compares the likelihood of a series under the law with an order inside the band to that with an order outside, each with the
best of its other parameters. It passes or fails a series where the ratio exceeds a threshold, which is set so that it is wrong as
often as a judge may be. No judge that looks at the errors alone can decide much more. Every law is log E = a + p log x + g(x), where
g has one or two parameters on a grid; a and p follow by least squares.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.series import REFERENCE_MARGIN
from mpmverify.convergence.synthetic.kinds import KINDS, RandomSeries, Truth, draw_series
from mpmverify.convergence.synthetic.laws import LEAST_ORDER, MARGIN, UNCERTAINTY

WRONG_PASS, WRONG_FAIL = 0.001, 0.005
"""Largest rates of wrong verdicts in any kind."""
GRID_ERROR = 1e-3
"""Error of log E by the grid of the parameters of g, added to the scatter."""


@dataclass(frozen=True)
class Hypotheses:
    """Values of g, and which of them belong to an order inside the band or outside.

    Parameters
    ----------
    straight : Array
        log E less g (candidates, n).
    used : Array of bool
        Levels that follow the law (candidates, n).
    cost : Array
        Negative log likelihood of the other levels (candidates,).
    ahead : Array
        Order at the finest level less the order as h goes to zero (candidates,).
    inside, outside : Array of bool
        (candidates,).
    """

    straight: Array
    used: np.ndarray
    cost: Array
    ahead: Array
    inside: np.ndarray
    outside: np.ndarray


Family = Callable[[Array, Array, float], Hypotheses]
"""From log of the sizes relative to the finest, errors (n,) and the scatter."""


def _of(straight: Array, **parts: np.ndarray) -> Hypotheses:
    straight = np.atleast_2d(straight)
    some = np.ones(len(straight), dtype=bool)
    given = {
        "used": np.ones(straight.shape, dtype=bool),
        "cost": 0.0 * some,
        "ahead": 0.0 * some,
        "inside": some,
        "outside": some,
    }
    return Hypotheses(straight, **(given | parts))


def _grid(*axes: Array) -> list[Array]:
    return [axis.reshape(-1, 1) for axis in np.meshgrid(*axes, indexing="ij")]


def power(x: Array, error: Array, scatter: float) -> Hypotheses:
    return _of(np.log(error))


def reference(x: Array, error: Array, scatter: float) -> Hypotheses:
    return _of(np.log(error - UNCERTAINTY * np.linspace(-1, 1, 41).reshape(-1, 1)))


def approached(x: Array, error: Array, scatter: float, sign: int) -> Hypotheses:
    """Levels near a sign change of the error tell next to nothing and count as if they lay anywhere."""
    third = np.unique(x)[2]
    share, order = _grid(np.linspace(0, 0.25, 41), np.linspace(0.5, 3, 41))
    term = sign * share * np.exp(order * (x - third))
    finest = sign * share * np.exp(-order * third)
    used = np.abs(1 + term) > 0.3
    straight = np.log(error) - np.log(np.where(used, np.abs(1 + term), 1.0))
    return _of(straight, used=used, cost=_cost(used, scatter), ahead=(order * finest / (1 + finest))[:, 0])


def rough(x: Array, error: Array, scatter: float) -> Hypotheses:
    sizes = np.unique(x)
    starts = np.arange(1, min(3, len(sizes) - 4) + 1).reshape(-1, 1)
    used = x < sizes[-starts]
    return _of(np.log(error) + 0.0 * starts, used=used, cost=_cost(used, scatter))


def _cost(used: np.ndarray, scatter: float) -> Array:
    """Negative log likelihood of levels that lie anywhere in a range of 4.6 of log E, less that of levels on the law."""
    on_law = np.log(np.hypot(scatter, GRID_ERROR) * np.sqrt(2 * np.pi))
    cost: Array = np.sum(~used, axis=1) * (np.log(4.6) - on_law)
    return cost


def alternating(x: Array, error: Array, scatter: float) -> Hypotheses:
    level = len(np.unique(x)) - 1 - np.unique(x, return_inverse=True)[1]
    amplitude, mode = _grid(np.concatenate([np.linspace(-0.5, -0.05, 60), np.linspace(0.05, 0.5, 60)]), np.array([0.0, 1.0]))
    return _of(np.log(error) - np.log(1 + amplitude * np.exp(mode * (x - x.max())) * (-1.0) ** level))


def two_terms(x: Array, error: Array, scatter: float) -> Hypotheses:
    share, more = _grid(np.linspace(0, 0.5, 31), np.geomspace(0.3, 8, 24))
    fast = share[:, 0]
    return _of(
        np.log(error) - np.log(1 - share + share * np.exp(more * x)),
        ahead=fast * more[:, 0],
        inside=(fast <= 0.34) & (more[:, 0] <= 2.05),
    )


FAMILIES: Mapping[str, Family] = {
    "approached from above": partial(approached, sign=1),
    "approached from below": partial(approached, sign=-1),
    "rough start": rough,
    "alternating": alternating,
    "numerical reference": reference,
    "mixed orders": two_terms,
}
"""Laws by the kind with an order inside the band; all other kinds are power laws."""
TOLD_APART: Mapping[str, Sequence[str]] = {
    "power law, much scatter": ("stagnant", "equal errors", "divergent"),
    "mixed orders": ("slower in the end", "other floor", "turns up"),
}
"""Kinds outside the band beside those that are named after the kind inside it."""


def log_ratio(family: Family, series: RandomSeries, limit: float) -> float:
    """Logarithm of the ratio of the likelihoods inside and outside the band."""
    usable = series.error > limit
    h, error = series.h[usable], series.error[usable]
    x = np.log(h / h.min())
    found = family(x, error, series.scatter)
    weight = found.used / found.used.sum(axis=1, keepdims=True)
    dx = x - np.sum(weight * x, axis=1, keepdims=True)
    sxx = np.sum(found.used * dx**2, axis=1)
    order = np.sum(found.used * dx * found.straight, axis=1) / sxx
    residual = found.straight - np.sum(weight * found.straight, axis=1, keepdims=True) - order[:, None] * dx
    squares = np.sum(found.used * residual**2, axis=1)
    quarter = (series.high - series.low) / 4
    below = max(series.low - MARGIN, LEAST_ORDER) - np.maximum(found.ahead, 0)
    above = series.high + MARGIN - np.minimum(found.ahead, 0)
    outwards = np.maximum(order - (series.high - quarter), 0) + np.maximum(series.low + quarter - order, 0)
    inwards = np.minimum(np.maximum(order - below, 0), np.maximum(above - order, 0))
    variance = series.scatter**2 + GRID_ERROR**2

    def likelihood(away: Array, allowed: np.ndarray) -> float:
        return float(np.max(np.where(allowed, -(squares + sxx * away**2) / (2 * variance) - found.cost, -np.inf)))

    return likelihood(outwards, found.inside) - likelihood(inwards, found.outside)


def ideal_rates(count: int, seed: int = 0) -> dict[str, float]:
    """Share of the series of each kind that the ideal judge decides rightly; 1 for kinds without a law that it knows.

    Parameters
    ----------
    count : int
        Number of series of each kind.
    seed : int
        The same seed gives the same series.
    """
    rates = {name: 1.0 for name, kind in KINDS.items() if kind.truth in (Truth.INSIDE, Truth.OUTSIDE)}
    for inside in (name for name, kind in KINDS.items() if kind.truth is Truth.INSIDE):
        names = [f"{inside}, too low", f"{inside}, too high", *TOLD_APART.get(inside, ())]
        family = FAMILIES.get(inside, power)
        right = _log_ratios(family, inside, count, seed)
        wrong = {name: _log_ratios(family, name, count, seed) for name in names if name in KINDS}
        passes = max(0.0, *(float(np.quantile(ratio, 1 - WRONG_PASS)) for ratio in wrong.values()))
        fails = min(0.0, float(np.quantile(right, WRONG_FAIL)))
        rates[inside] = float(np.mean(right > passes))
        rates |= {name: float(np.mean(ratio < fails)) for name, ratio in wrong.items()}
    return rates


def _log_ratios(family: Family, name: str, count: int, seed: int) -> Array:
    kind, generator = KINDS[name], np.random.default_rng((seed, list(KINDS).index(name)))
    limit = max(kind.round_off, REFERENCE_MARGIN * kind.uncertainty)
    return np.array([log_ratio(family, draw_series(kind, generator), limit) for _ in range(count)])
