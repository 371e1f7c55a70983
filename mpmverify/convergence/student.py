"""Quantiles of Student's t without SciPy, which takes longer to load than a table of errors to judge."""

import math
from functools import cache

CLOSE = 1e-15
"""Step of the angle at which Newton's iteration ends, relative to angles above 1."""


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
    With t = sqrt(n) tan(a), the probability of [-t, t] is a finite sum [1], whose derivative is a multiple of cos(a)^(n - 1). It is concave,
    so that Newton's iteration from a = 0 increases to the solution.

    References
    ----------
    [1] Abramowitz M., Stegun I. A. (1964). Handbook of Mathematical Functions, formulas 26.7.3 and 26.7.4.
    """
    n = degrees_of_freedom
    density = 2 / math.sqrt(math.pi) * math.exp(math.lgamma((n + 1) / 2) - math.lgamma(n / 2))
    angle, step = 0.0, 1.0
    while step > CLOSE * max(angle, 1.0):
        step = (confidence - _probability(n, angle)) / (density * math.cos(angle) ** (n - 1))
        angle += step
    return math.sqrt(n) * math.tan(angle)


def _probability(n: int, angle: float) -> float:
    """Probability of [-t, t]."""
    sine, cosine = math.sin(angle), math.cos(angle)
    total, term = 0.0, cosine if n % 2 else 1.0
    for k in range(1 + n % 2, n, 2):
        total += term
        term *= cosine**2 * k / (k + 1)
    return 2 / math.pi * (angle + sine * total) if n % 2 else sine * total
