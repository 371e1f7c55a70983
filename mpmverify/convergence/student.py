"""Student's t for whole degrees of freedom, and mixtures of it, without SciPy, which takes longer to load than a table of errors to judge.

With t = sqrt(n) tan(a), the probability of [-t, t] is a finite sum of powers of cos(a): Abramowitz M., Stegun I. A. (1964), Handbook of
Mathematical Functions, formulas 26.7.3 and 26.7.4.
"""

import itertools
import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from mpmverify.convergence.levels import Array

CLOSE = 1e-15
"""Step of the angle at which Newton's iteration ends, relative to angles above 1."""
LARGEST = 1e150
"""Value beyond which the probability is 0 or 1."""
END = 1e-7
"""Accuracy of the end of an interval of a mixture, which lies between the least and the greatest end by a single distribution."""
NEWTON = 50
"""Number of steps of Newton's iteration to an end, after which it is bisection."""


def student(degrees_of_freedom: int, t: Array) -> tuple[Array, Array]:
    """Probability that Student's t lies below a value, and its density there.

    Parameters
    ----------
    degrees_of_freedom : int
        At least 1.
    t : Array
        Of any shape.
    """
    n, odd = degrees_of_freedom, degrees_of_freedom % 2
    t = np.minimum(np.maximum(t, -LARGEST), LARGEST)  # the square of which can be represented
    inverse = 1 / (n + t * t)
    square, sine = n * inverse, t * np.sqrt(inverse)
    cosine = np.sqrt(square)
    total: Array | float = float(n > 1)
    for k in range((n - odd) // 2 - 1, 0, -1):  # 1 + f_1 cos^2 (1 + f_2 cos^2 (1 + ...))
        total = 1 + (2 * k - 1 + odd) / (2 * k + odd) * square * total
    both = sine * (cosine * total if odd else total)
    below = 0.5 + ((np.arctan(t / math.sqrt(n)) + both) / math.pi if odd else both / 2)
    scale = math.exp(math.lgamma((n + 1) / 2) - math.lgamma(n / 2)) / math.sqrt(math.pi * n)
    density = scale * square if odd else scale * square * cosine
    for _ in range((n - 1) // 2):
        density *= square
    return below, density


def student_probability(degrees_of_freedom: Array, t: Array) -> Array:
    """Probability that Student's t lies below a value, for several degrees of freedom (n,) and values (..., n)."""
    found = np.empty_like(t)
    for n in np.unique(degrees_of_freedom):
        mine = degrees_of_freedom == n
        found[..., mine] = student(int(n), t[..., mine])[0]
    return found


@cache
def student_quantile(degrees_of_freedom: int, confidence: float) -> float:
    """Half-width of the two-sided interval of Student's t, in standard errors.

    Parameters
    ----------
    degrees_of_freedom : int
        At least 1.
    confidence : float
        Probability of the interval, between 0 and 1.

    Notes
    -----
    The probability is concave in the angle, so that Newton's iteration from 0 increases to the solution.
    """
    n = degrees_of_freedom
    angle, step = 0.0, 1.0
    while step > CLOSE * max(angle, 1.0):
        t = math.sqrt(n) * math.tan(angle)
        below, density = (float(value) for value in student(n, np.array(t)))
        step = (confidence - 2 * below + 1) / (2 * density * math.sqrt(n) / math.cos(angle) ** 2)
        angle += step
    return math.sqrt(n) * math.tan(angle)


@dataclass(frozen=True)
class Mixture:
    """Student's t distributions (k,) with probabilities, the most probable one first.

    Parameters
    ----------
    freedom : Array
        Degrees of freedom, whole numbers of at least 1.
    middle, scale : Array
        Middle of each distribution, and its scale.
    weight : Array
        Probabilities, which sum to 1.
    """

    freedom: Array
    middle: Array
    scale: Array
    weight: Array

    @cached_property
    def _by_freedom(self) -> list[tuple[int, Array, Array, Array]]:
        table = np.stack([self.middle, self.scale, self.weight])
        return [(int(n), *table[:, self.freedom == n]) for n in np.unique(self.freedom)]

    def below(self, value: Array) -> tuple[Array, Array]:
        """Probability below each of several values (m,), and the density there."""
        total, density = np.zeros_like(value), np.full_like(value, np.finfo(float).tiny)
        for n, middle, scale, weight in self._by_freedom:
            probability, height = student(n, (value[:, None] - middle) / scale)
            total += probability @ weight
            density += height @ (weight / scale)
        return total, density

    def interval(self, confidence: float) -> tuple[float, float]:
        """Interval with equal probabilities below and above; NaN where they are not finite."""
        tails, whole = np.array([0.5 - confidence / 2, 0.5 + confidence / 2]), self.freedom.astype(int)
        half_width = np.array([student_quantile(n, confidence) for n in range(1, whole.max() + 1)])[whole - 1] * self.scale
        quantiles = self.middle + np.stack([-half_width, half_width])
        low, high, end = quantiles.min(axis=1), quantiles.max(axis=1), quantiles[:, 0]
        # Newton's iteration from the ends by the most probable one; a step that leaves the bracket, or a late one, halves it instead.
        for attempt in itertools.count():
            below, density = self.below(end)
            missing = tails - below
            if not np.all(np.isfinite(missing)):  # of sizes over so many decades that their squares overflow
                break
            low, high = np.where(missing > 0, end, low), np.where(missing > 0, high, end)
            newton = end + missing / density
            following = np.where((low <= newton) & (newton <= high) & (attempt < NEWTON), newton, (low + high) / 2)
            if np.all(np.abs(following - end) <= END * np.maximum(1.0, np.abs(end))):
                return float(following[0]), float(following[1])
            end = following
        return math.nan, math.nan
