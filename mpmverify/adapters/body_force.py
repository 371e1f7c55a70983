"""A body force as a sum of a few fields with amplitudes in time, so that a table of it stays small."""

from collections.abc import Callable

import numpy as np

from mpmverify.problem import Array

TOLERANCE = 1e-13
"""Largest error of the sum, as a share of the largest value."""


def in_modes(force: Callable[[Array], Array], times: Array) -> tuple[Array, Array]:
    """Write f(X, t) = sum over k of a_k(t) f_k(X).

    The fields are those at K Chebyshev points of the time, and the amplitudes are the Lagrange polynomials through them. K is the
    least power of two with which the sum agrees at 2 K further times; where that takes more fields than there are times, each time has
    its own field.

    Parameters
    ----------
    force : callable
        Times (T,) [s] -> acceleration (T, P, dim) [m/s^2].
    times : Array
        Times of the table (T,) [s], which rise from 0.

    Returns
    -------
    (Array, Array)
        Amplitudes (T, K) [1] and fields (K, P, dim) [m/s^2].

    References
    ----------
    Berrut and Trefethen, SIAM Review 46 (2004) 501-517, doi:10.1137/S0036144502417715 (barycentric interpolation).
    """
    end, count = times[-1], 1
    while count < len(times):
        nodes, further = chebyshev(count, end), chebyshev(2 * count, end)
        fields, expected = force(nodes), force(further)
        found = np.tensordot(lagrange(nodes, further), fields, axes=1)
        if np.max(np.abs(found - expected)) <= TOLERANCE * np.max(np.abs(expected)):
            return lagrange(nodes, times), fields
        count *= 2
    return np.eye(len(times)), force(times)


def chebyshev(count: int, end: float) -> Array:
    """Return Chebyshev points of the first kind on (0, end), (count,)."""
    return np.asarray(end / 2 * (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)))


def lagrange(nodes: Array, t: Array) -> Array:
    """Return the Lagrange polynomials through Chebyshev nodes (K,) at t (T,), by the barycentric formula, (T, K)."""
    count = len(nodes)
    weights = (-1.0) ** np.arange(count) * np.sin(np.pi * (np.arange(count) + 0.5) / count)
    apart = t[:, None] - nodes
    met = apart == 0
    terms = weights / np.where(met, 1.0, apart)
    values = terms / terms.sum(axis=1, keepdims=True)
    return np.where(met.any(axis=1, keepdims=True), met, values)
