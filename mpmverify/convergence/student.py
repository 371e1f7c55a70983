"""Student's t for whole degrees of freedom, without SciPy, which takes longer to load than a table of errors to judge.

With t = sqrt(n) tan(a), the probability of [-t, t] is a finite sum of powers of cos(a): Abramowitz M., Stegun I. A. (1964), Handbook of
Mathematical Functions, formulas 26.7.3 and 26.7.4.
"""

import math
from functools import cache

import numpy as np

from mpmverify.convergence.levels import Array

CLOSE = 1e-15
"""Step of the angle at which Newton's iteration ends, relative to angles above 1."""


def student_probability(degrees_of_freedom: Array, t: Array) -> Array:
    """Probability that Student's t lies below a value.

    Parameters
    ----------
    degrees_of_freedom : Array
        Whole numbers of at least 1, of any shape that fits `t`.
    t : Array
    """
    n = degrees_of_freedom
    angle = np.arctan2(t, np.sqrt(n))
    cosine, odd = np.cos(angle), n % 2
    total, term = np.zeros_like(angle), np.where(odd, cosine, 1.0)
    for k in range(1, int(n.max()), 2):
        term = np.where(k + odd < n, term, 0.0)
        total += term
        term = term * cosine**2 * (k + odd) / (k + odd + 1)
    both = np.sin(angle) * total
    return 0.5 + np.where(odd, (angle + both) / math.pi, both / 2)


def student_density(degrees_of_freedom: Array, t: Array) -> Array:
    """Density of Student's t; the parameters are those of `student_probability`."""
    n = degrees_of_freedom
    log_gamma = np.array([math.lgamma(k / 2) for k in range(1, int(n.max()) + 2)])
    whole = n.astype(int)
    return np.exp(log_gamma[whole] - log_gamma[whole - 1]) / np.sqrt(math.pi * n) * (1 + t * t / n) ** (-(n + 1) / 2)


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
    density = 2 / math.sqrt(math.pi) * math.exp(math.lgamma((n + 1) / 2) - math.lgamma(n / 2))
    angle, step = 0.0, 1.0
    while step > CLOSE * max(angle, 1.0):
        t = math.sqrt(n) * math.tan(angle)
        inside = 2 * float(student_probability(np.array(n), np.array(t))) - 1
        step = (confidence - inside) / (density * math.cos(angle) ** (n - 1))
        angle += step
    return math.sqrt(n) * math.tan(angle)
