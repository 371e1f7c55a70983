"""Order at the finest level and as h goes to zero, averaged over all laws that explain the errors, each weighted by its evidence.

A law says which levels are asymptotic and how their errors fall. The asymptotic levels are a run of the finest ones. Their errors are
A h^p, or A h^p with one further term: B h^q of either sign, as Taylor expansions of errors have it, or a part that alternates from
level to level. A term of the other sign may change the sign of the error; then its magnitude counts, and a level next to the change
tells nothing. The coarser levels are rough: their errors lie anywhere. A run of three levels is allowed, but it leaves one degree of
freedom, so that its interval is wide.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.student import Mixture, student_probability

SCATTER = 0.005
"""Standard deviation of log E about a law that is expected before the errors are seen."""
SCATTER_WEIGHT = 1
"""Weight of this expectation, in degrees of freedom: so many levels teach as much."""
ROUGH_RANGE = math.log(100.0)
"""Range of log E in which the error of a rough level lies with equal probability."""
LEAST_RUN, LEAST_ALTERNATING = 3, 5
"""Least number of sizes in a run of finest levels, and in an alternating one."""
STRAIGHT, FURTHER_TERM, ALTERNATING = 0.6, 0.3, 0.1
"""Probabilities of the three kinds of laws before the errors are seen."""
FURTHER_ORDERS = np.array([0.3, 0.4, 0.5, 0.65, 0.8, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 3.5, 4, 5, 6])
"""Differences q - p of the orders of the two terms; a negative one exchanges the terms."""
TERM_STEPS = np.linspace(1, 0, 24)
"""Positions of the share of the further term, on a logarithmic scale from `LEAST_TERM` at the third finest level to 1 at the finest."""
LEAST_TERM = 0.003
"""Least ratio of the further term to the first one at the third finest level."""
LARGEST_NEGATIVE_TERM = 0.9
"""Largest ratio of a further term of the other sign to the first one on the three finest sizes of a run."""
NEAR_ZERO = 0.1
"""Least ratio of an error to its first term at which the error tells its order: nearer to a change of its sign, scatter rules it."""
AMPLITUDES = np.linspace(-0.55, 0.55, 48)
"""Ratios of the alternating part to the other one at the coarsest size."""
NEGLIGIBLE = 1e-3
"""Probability of the least probable laws, all together, that are left out."""


@dataclass(frozen=True)
class Law:
    """Deviation of an error from a power law A h^p: a further term, which may alternate.

    Parameters
    ----------
    ratio : float
        Ratio of the further term to A h^p at the finest level.
    power : float
        Order of the further term less p.
    alternates : bool
        Whether its sign changes from level to level.
    """

    ratio: float
    power: float
    alternates: bool

    def deviation(self, x: Array, level: np.ndarray) -> Array:
        """Log E less log(A h^p).

        Parameters
        ----------
        x : Array
            Logarithms of the sizes relative to the finest one (n,).
        level : Array
            Number of sizes between each level and the finest one (n,); negative beyond it.
        """
        sign = (-1.0) ** level if self.alternates else 1.0
        return np.log(np.maximum(np.abs(1 + self.ratio * np.exp(self.power * x) * sign), NEAR_ZERO))


class Tail(NamedTuple):
    """Probabilities that an order lies on one side of a value."""

    step: float
    """Of the order of the finest step."""
    finest: float
    """Of the order at the finest level."""
    limit: float
    """Of the order as h goes to zero."""
    both: float


@dataclass(frozen=True)
class Estimate:
    """Probable laws of an error series (k,), the most probable one of the most probable run first.

    Parameters
    ----------
    weight : Array
        Probability of each law; their sum is 1.
    limit : Array
        Order p as h goes to zero.
    step : Array
        Order of the finest step less p.
    ahead : Array
        Order at the finest level less p.
    error : Array
        Scale of the distribution of p, which is Student's t.
    freedom : Array
        Degrees of freedom of this distribution.
    start : int
        Index of the coarsest level of the most probable run.
    law : Law
        The most probable law.
    finest : (float, float)
        Size of the finest level, and its error by the most probable law.
    """

    weight: Array
    limit: Array
    step: Array
    ahead: Array
    error: Array
    freedom: Array
    start: int
    law: Law
    finest: tuple[float, float]

    @property
    def order(self) -> float:
        """Order of the finest step by the most probable law."""
        return float(self.limit[0] + self.step[0])

    @property
    def constant(self) -> float:
        """A of the power law A h^order through the finest level."""
        size, error = self.finest
        return math.exp(min(700.0, math.log(error) - self.order * math.log(size)))

    def predict(self, h: Array) -> Array:
        """Errors by the most probable law at sizes (n,) that begin or end with the finest one."""
        size, error = self.finest
        x = np.log(h / size)
        level = np.searchsorted(np.unique(h), h) - np.searchsorted(np.unique(h), size)
        shift = self.law.deviation(x, level) - self.law.deviation(np.zeros(1), np.zeros(1))
        return error * np.exp(self.limit[0] * x + shift)

    def interval(self, confidence: float) -> tuple[float, float]:
        """Interval of the order of the finest step, with equal probabilities below and above."""
        low, high = self._steps.interval(confidence)
        return min(low, self.order), max(high, self.order)

    def step_below(self, order: float) -> float:
        """Probability that the order of the finest step lies below a value."""
        return float(self._steps.below(np.array([float(order)]))[0][0])

    @cached_property
    def _steps(self) -> Mixture:
        return Mixture(self.freedom, self.limit + self.step, self.error, self.weight)

    def below(self, order: float) -> Tail:
        """Probabilities that the order lies below a value."""
        return self._tail(order, 1)

    def above(self, order: float) -> Tail:
        """Probabilities that the order lies above a value."""
        return self._tail(order, -1)

    def _tail(self, order: float, side: int) -> Tail:
        away = side * (order - self.limit - np.stack([self.step, self.ahead, 0 * self.step]))
        probability = student_probability(self.freedom, away / self.error)
        step, finest, limit = (probability @ self.weight).tolist()
        return Tail(step, finest, limit, float(np.minimum(probability[1], probability[2]) @ self.weight))


def laws(x: Array, level: np.ndarray) -> tuple[Array, Array, np.ndarray, Array]:
    """Laws that are weighed.

    Parameters
    ----------
    x, level : Array
        As in `Law.deviation`, coarsest first.

    Returns
    -------
    ratio, power, alternates : Array
        Parameters of each `Law` (laws,).
    probability : Array
        Probability before the errors are seen (laws,).
    """
    third = x[level == min(2, level[0])][0]
    ratio = np.exp(np.outer(math.log(LEAST_TERM) - FURTHER_ORDERS * third, TERM_STEPS)).ravel()
    power = FURTHER_ORDERS.repeat(len(TERM_STEPS))
    negative = ratio < LARGEST_NEGATIVE_TERM
    amplitude = AMPLITUDES if level[0] + 1 >= LEAST_ALTERNATING else AMPLITUDES[:0]
    falling = amplitude * math.exp(-x[0])
    counts = (1, len(ratio) + int(negative.sum()), 2 * len(amplitude))
    return (
        np.concatenate([[0.0], ratio, -ratio[negative], amplitude, falling]),
        np.concatenate([[0.0], power, power[negative], 0 * amplitude, 0 * amplitude + 1]),
        np.repeat([False, False, True], counts),
        np.repeat(np.array([STRAIGHT, FURTHER_TERM, ALTERNATING]) / np.maximum(counts, 1), counts),
    )


@lru_cache(maxsize=64)
def _possible(sizes: bytes) -> tuple[np.ndarray, ...]:
    """What `estimate` needs of the laws at sizes x = log h/h[-1] (n,), of which many series have the same; nothing of it is written to."""
    x = np.frombuffer(sizes)
    level = np.cumsum(np.append(0, np.diff(x) != 0))
    level = level[-1] - level
    ratio, power, alternates, probability = laws(x, level)
    term = ratio[:, None] * np.exp(np.outer(power, x))
    term[alternates] *= (-1.0) ** level
    possible = np.all(term[:, level < LEAST_RUN] >= -LARGEST_NEGATIVE_TERM, axis=1)
    ratio, power, alternates, probability, term = (part[possible] for part in (ratio, power, alternates, probability, term))
    used = np.abs(1 + term) >= NEAR_ZERO
    deviation = np.log(np.where(used, np.abs(1 + term), 1.0))
    within = (level[:, None] <= level[0] - np.arange(max(1, level[0] + 2 - LEAST_RUN))).astype(float)
    n, sum_x, sum_xx = (used * part @ within for part in (1.0, x, x * x))
    mean_x = sum_x / n
    return level, ratio, power, alternates, probability, used, deviation, within, n, mean_x, sum_xx - n * mean_x**2


def estimate(h: Array, error: Array) -> Estimate:
    """Weigh all laws of an error series.

    Parameters
    ----------
    h, error : Array
        Sizes and errors (n,), coarsest first, positive and finite; at least three different sizes.

    Notes
    -----
    On the levels of a run log E = log A + p log h + deviation + scatter. Before the errors are seen, log A and p have flat
    distributions and the squared scatter has a scaled inverse chi-squared one. The evidence of a law and the distribution of its p
    then have closed forms [1]. A rough level costs a factor of 1/`ROUGH_RANGE`, so that a level is dropped where it deviates by some
    three standard deviations.

    References
    ----------
    [1] A. Gelman and others, Bayesian Data Analysis, third edition (2013), sections 3.2, 7.4 and 14.2.
    """
    x = np.log(np.asarray(h / h[-1], dtype=float))
    level, ratio, power, alternates, probability, used, deviation, within, n, mean_x, sxx = _possible(x.tobytes())
    z = np.log(error / error[-1]) - deviation
    sum_z, sum_zz, sum_xz = (used * part @ within for part in (z, z * z, x * z))
    mean_z, runs = sum_z / n, np.arange(within.shape[1])  # by their number of rough sizes
    sxz, szz = sum_xz - n * mean_x * mean_z, sum_zz - n * mean_z**2
    limit = sxz / sxx
    squares = np.maximum(szz - limit * sxz, 0.0) + SCATTER_WEIGHT * SCATTER**2
    freedom = SCATTER_WEIGHT + n - 2
    log_gamma = np.array([math.inf, *(math.lgamma(number / 2) for number in range(1, int(freedom.max()) + 1))])
    evidence = (
        np.log(probability)[:, None]
        - (len(x) - n) * math.log(ROUGH_RANGE)
        + log_gamma[freedom.astype(int)]
        - (np.log(n * sxx) + (n - 2) * math.log(math.pi) + freedom * np.log(squares)) / 2
    )
    short = level[0] + 1 - runs < LEAST_ALTERNATING
    evidence[np.logical_and.outer(alternates, short)] = -np.inf
    weight = np.exp(evidence - evidence.max())
    weight /= weight.sum()

    run = int(np.argmax(weight.sum(axis=0)))
    best = int(np.argmax(weight[:, run])) * len(runs) + run
    order = np.argsort(weight, axis=None)[::-1]
    order = order[: int(np.searchsorted(np.cumsum(weight.ravel()[order]), 1 - NEGLIGIBLE)) + 1]
    probable, of_run = np.unravel_index(np.append(best, order[order != best]), weight.shape)
    kept, law = weight[probable, of_run], int(probable[0])
    return Estimate(
        kept / kept.sum(),
        limit[probable, of_run],
        np.where(alternates, 0.0, (deviation[:, level == 1][:, 0] - deviation[:, -1]) / x[level == 1][0])[probable],
        np.where(alternates, 0.0, power * ratio / (1 + ratio))[probable],
        np.sqrt(squares / freedom / sxx)[probable, of_run],
        freedom[probable, of_run],
        int(np.sum(within[:, run] == 0)),
        Law(float(ratio[law]), float(power[law]), bool(alternates[law])),
        (float(h[-1]), float(error[-1] * math.exp(mean_z[law, run] - limit[law, run] * mean_x[law, run] + deviation[law, -1]))),
    )
