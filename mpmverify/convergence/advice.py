"""Advice on the levels that would decide an inconclusive verdict."""

from collections.abc import Callable

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.convergence.series import Classification, Convergence, analyse

MOST_LEVELS = 4
"""Largest number of further levels that is tried."""
DEFAULT_RATIO = 2.0
"""Refinement ratio of a series with one size."""


def what_would_decide(series: Convergence, decided: Callable[[Convergence], bool]) -> str:
    """Say how many finer levels decide a verdict if the error goes on by its most probable law.

    Parameters
    ----------
    series : Convergence
        At least three sizes can be used.
    decided : callable
        Whether the verdict on a longer series is decided.
    """
    assert series.estimate is not None
    usable = series.error > series.limit
    further = _finer(series, MOST_LEVELS)
    predicted = series.estimate.predict(np.append(series.h[usable][-1], further))[1:]
    for more in range(1, MOST_LEVELS + 1):
        if predicted[more - 1] <= 10 * series.limit:
            return "finer errors would not stand out from round-off or from the reference: add levels between these"
        longer = analyse(
            np.append(series.h[usable], further[:more]),
            np.append(series.error[usable], predicted[:more]),
            round_off=series.limit,
        )
        if decided(longer):
            if more == 1:
                return f"add {_named(series, further[:1])}"
            return f"it needs {more} levels more, {_named(series, further[:more])}, if the error goes on as now"
    return f"{MOST_LEVELS} levels more would not decide if the error goes on as now"


def next_levels(series: Convergence) -> str:
    """Say which levels to add where fewer than three sizes can be used."""
    missing = 3 - len(np.unique(series.h[series.kept]))
    if series.classification is Classification.TOO_SHORT:
        return f"add {_named(series, _finer(series, missing))}"
    coarsest = series.h[0] * _ratio(series) ** np.arange(missing, 0, -1)
    return f"add {_named(series, coarsest)}, where errors are larger, or levels between"


def _ratio(series: Convergence) -> float:
    sizes = np.unique(series.h)
    return float(sizes[1] / sizes[0]) if len(sizes) > 1 else DEFAULT_RATIO


def _finer(series: Convergence, count: int) -> Array:
    finer: Array = series.h[-1] / _ratio(series) ** np.arange(1, count + 1)
    return finer


def _named(series: Convergence, sizes: Array) -> str:
    texts = [f"{series.size} = {natural(size)}" for size in sizes]
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)


def natural(size: float) -> str:
    """A size as people write it: 1/64, but 0.05."""
    short, inverse = f"{size:.3g}", round(1 / size)
    if abs(float(short) / size - 1) < 1e-9 or abs(inverse * size - 1) > 1e-6:
        return f"{size:.4g}"
    return f"1/{inverse}"
