"""Levels of a series from sequences, arrays, pandas or xarray objects; pandas and xarray are not imported."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpmverify.errors import UsageError

Array = NDArray[np.float64]
Numbers = Any
"""Anything that numpy converts to a one-dimensional array of numbers."""
SAME = 1e-6
"""Relative difference up to which two sizes count as equal: 0.1 and 0.30000000000000004 / 3 differ by round-off alone."""


def levels(h: Numbers, value: Numbers | None = None, *, replicates: bool = False) -> tuple[Array, Array]:
    """Sizes and values (n,), coarsest first; replicates in ascending order of their values.

    Parameters
    ----------
    h : array-like
        Sizes (n,). Without `value`: a pandas Series of values whose index holds the sizes, or an xarray DataArray of values whose
        coordinate "h", or else the coordinate of its dimension, holds the sizes.
    value : array-like, optional
        Values (n,). Masked values become NaN.
    replicates : bool
        Whether a size may have several values, such as those of several seeds. Equal sizes are then equal to the last digit.

    Raises
    ------
    UsageError
        If the shapes do not match, the entries are not real numbers, or a size is not positive and finite or is given twice without
        `replicates`.
    """
    if value is None:
        h, value = _sizes_of(h), h
    h, value = numbers(h, "h"), numbers(value, "the values")
    if h.ndim != 1 or h.shape != value.shape or not len(h):
        raise UsageError(
            f"h and the values must be two lists of the same positive length, not of shapes {h.shape} and {value.shape}"
        )
    for size in h[~(np.isfinite(h) & (h > 0))]:
        raise UsageError(f"every h must be positive and finite, not {size:g}")
    coarse_first = np.argsort(-h)
    h, value = h[coarse_first], value[coarse_first]
    new = np.append(True, np.abs(np.diff(h)) > SAME * h[:-1])
    if replicates:
        h = h[new][np.cumsum(new) - 1]
        ascending = np.lexsort((value, -h))
        return h, value[ascending]
    for size in h[~new]:
        raise UsageError(f"h={size:g} is given twice: every level needs a different size")
    return h, value


def by_size(h: Array, error: Array) -> tuple[Array, Array]:
    """Distinct sizes and the geometric mean of the errors at each (m,), coarsest first; that of positive and finite errors alone."""
    sizes, level = np.unique(-h, return_inverse=True)
    return -sizes, np.exp(np.bincount(level, np.log(error)) / np.bincount(level))


def numbers(values: Numbers, what: str) -> Array:
    """Real numbers as an array of floats.

    Parameters
    ----------
    values : array-like
        Masked values become NaN; `numpy.asarray` would return the numbers under the mask.
    what : str
        Name of the values in the error message.

    Raises
    ------
    UsageError
        If they are not real numbers.
    """
    try:
        if np.iscomplexobj(values):
            raise TypeError("complex")
        if isinstance(values, np.ma.MaskedArray):
            return np.asarray(np.ma.filled(values.astype(float), np.nan))
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise UsageError(f"{what} must be real numbers ({error})") from error


def _sizes_of(series: Numbers) -> Numbers:
    if hasattr(series, "coords"):
        names = [name for name in ("h", *series.dims) if name in series.coords]
        if names:
            return series.coords[names[0]]
    elif hasattr(series, "to_numpy") and hasattr(series, "index"):
        return series.index
    raise UsageError(
        "without h, the errors must be a pandas Series with h as its index, or an xarray DataArray with a coordinate h"
    )
