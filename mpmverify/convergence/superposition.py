"""Least-squares fit of superposed error fields, each with a power law for its norm, to the norm of the total error.

Source j contributes an error field of norm a_j s_j^p_j, where s_j is its size. The cosine c_jk between two fields is assumed equal on
all levels: E^2 = sum_jk c_jk a_j s_j^p_j a_k s_k^p_k. With all c_jk = 1 this is E = A h^p + B dt^q + C ppc^-r.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.student import student_quantile

CONFIDENCE = 0.99
"""Confidence level of the intervals; above 95 % because several exponents are judged at once."""
EXPONENTS = (0.2, 8.0)
"""Bounds of the fitted exponents."""
GRID = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
"""Exponents of the starting points."""
LARGEST = 50.0
"""Bound on |log| of the ratio of a source to the error: sources that cancel may exceed the error, but must not overflow."""
STARTS = 4
"""Number of starting points of a fit."""
NEGLIGIBLE = 1e-6
"""Squared share of the error at which a source starts if the linear problem makes its square smaller or negative."""
LEAST_SQUARE = 1e-300
"""Smallest E^2 of a fit, so that its logarithm exists where sources cancel."""


@dataclass(frozen=True)
class SumFit:
    """A fitted superposition of m sources on n runs, in the order of their names.

    Parameters
    ----------
    magnitude : Array
        Norm of each source on each run (m, n), in the unit of the error.
    exponent : Array
        (m,).
    half_width : Array
        Half-width of the confidence interval of each exponent (m,), by Student's t from the linearised fit; NaN for known exponents.
    cosine : mapping of (str, str) to float
        Cosine between the error fields of two sources, by their names.
    squares : float
        Sum of the squares of log(E/fit).
    degrees_of_freedom : int
        Number of runs less number of parameters.
    """

    magnitude: Array
    exponent: Array
    half_width: Array
    cosine: Mapping[tuple[str, str], float]
    squares: float
    degrees_of_freedom: int

    @property
    def residual(self) -> float:
        """Root mean square of log(E/fit), with the degrees of freedom as divisor."""
        return float(np.sqrt(self.squares / self.degrees_of_freedom))

    @property
    def share(self) -> Array:
        """Largest share of each source in the sum of all sources, over the runs (m,)."""
        largest: Array = np.max(self.magnitude / self.magnitude.sum(axis=0), axis=1)
        return largest


class Model:
    """Log E on n runs as a function of x = (log a (m), free exponents (f), cosines (m (m - 1)/2)).

    Parameters
    ----------
    log_sizes : mapping of str to Array
        Log of the size of each source (n,), with zero mean.
    log_error : Array
        (n,).
    held : mapping of str to float
        Exponents that are known and not fitted, by the name of the source.
    """

    def __init__(self, log_sizes: Mapping[str, Array], log_error: Array, held: Mapping[str, float]) -> None:
        self.names, self.log_error = tuple(log_sizes), log_error
        self.log_sizes = np.array(list(log_sizes.values()))
        self.free = np.flatnonzero([name not in held for name in self.names])
        self.held = np.array([held.get(name, 0.0) for name in self.names])
        self.first, self.second = np.triu_indices(len(self.names), 1)
        self.m, self.f = len(self.names), len(self.free)

    @property
    def parameters(self) -> int:
        return self.m + self.f + len(self.first)

    def residuals(self, x: Array) -> Array:
        """Log of the fit over the error (n,)."""
        square, _, _ = self._squares(x)
        residual: Array = 0.5 * np.log(square) - self.log_error
        return residual

    def jacobian(self, x: Array) -> Array:
        """Derivatives of the residuals (n, parameters)."""
        square, own, product = self._squares(x)
        by_log_a = own / square
        return np.concatenate([by_log_a, (by_log_a * self.log_sizes)[self.free], product / square]).T

    def fit(self, starts: int = STARTS) -> SumFit:
        """Best of the fits from several starts."""
        from scipy.optimize import least_squares  # takes a third of a second, which most studies do without

        size = float(np.mean(self.log_error))
        amplitudes = [(size - LARGEST, size + LARGEST)] * self.m
        bounds = np.array(amplitudes + [EXPONENTS] * self.f + [(-1.0, 1.0)] * len(self.first)).T
        exact = {"xtol": 1e-10, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 60}
        fits = [
            least_squares(self.residuals, x, self.jacobian, bounds=bounds, **exact)
            for x in np.clip(self._starts()[:starts], *bounds)
        ]
        best = min(fits, key=lambda found: float(found.cost))
        x, degrees_of_freedom, squares = best.x, len(self.log_error) - self.parameters, 2 * float(best.cost)
        # Parameters at a bound are left out of the linearisation: the interval of such an exponent is unknown.
        inside = np.all(np.abs(x - bounds) > 1e-6, axis=0)
        slopes = self.jacobian(x)[:, inside]
        variance = np.full(self.parameters, np.inf)
        variance[inside] = np.diag(np.linalg.pinv(slopes.T @ slopes, hermitian=True)) * squares / degrees_of_freedom
        half_width = np.full(self.m, np.nan)
        half_width[self.free] = student_quantile(degrees_of_freedom, CONFIDENCE) * np.sqrt(variance[self.m : self.m + self.f])
        pairs = [(self.names[i], self.names[j]) for i, j in zip(self.first, self.second, strict=True)]
        _, exponent, cosine = self._parts(x)
        return SumFit(
            self._magnitudes(x),
            exponent,
            half_width,
            dict(zip(pairs, cosine.tolist(), strict=True)),
            squares,
            degrees_of_freedom,
        )

    def _parts(self, x: Array) -> tuple[Array, Array, Array]:
        exponent = self.held.copy()
        exponent[self.free] = x[self.m : self.m + self.f]
        return x[: self.m], exponent, x[self.m + self.f :]

    def _magnitudes(self, x: Array) -> Array:
        log_a, exponent, _ = self._parts(x)
        magnitude: Array = np.exp(log_a[:, None] + exponent[:, None] * self.log_sizes)
        return magnitude

    def _squares(self, x: Array) -> tuple[Array, Array, Array]:
        """E^2 (n,), half its derivatives by log a (m, n) and by the cosines (pairs, n)."""
        magnitude, cosine = self._magnitudes(x), self._parts(x)[2]
        product = magnitude[self.first] * magnitude[self.second]
        own = magnitude**2
        for k, mixed in enumerate(cosine[:, None] * product):
            own[[self.first[k], self.second[k]]] += mixed
        return np.maximum(own.sum(axis=0), LEAST_SQUARE), own, product

    def _starts(self) -> Array:
        """Starting points: the best on a grid of exponents, where E^2 is linear in the products c_jk a_j a_k and is fitted by them."""
        grid = np.array(list(itertools.product(GRID, repeat=self.f))).reshape(len(GRID) ** self.f, self.f)
        exponent = np.tile(self.held, (len(grid), 1))
        exponent[:, self.free] = grid
        part = np.exp(exponent[:, :, None] * self.log_sizes - self.log_error)
        columns = np.concatenate([part**2, 2 * part[:, self.first] * part[:, self.second]], axis=1)
        products = np.linalg.pinv(columns.transpose(0, 2, 1), rcond=1e-8) @ np.ones(len(self.log_error))
        log_a = 0.5 * np.log(np.maximum(products[:, : self.m], NEGLIGIBLE / np.max(part**2, axis=2)))
        cosine = products[:, self.m :] / np.exp(log_a[:, self.first] + log_a[:, self.second])
        starts = np.concatenate([log_a, grid, np.clip(cosine, -0.999999, 0.999999)], axis=1)
        cost = [np.sum(self.residuals(x) ** 2) for x in starts]
        best: Array = starts[np.argsort(cost, kind="stable")[:STARTS]]
        return best
