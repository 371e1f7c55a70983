"""Weighted norms of fields that are sampled at quadrature points; every norm of a field with NaN is NaN."""

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact import ExactSolution
from mpmverify.exact.solution import ExactField
from mpmverify.problem import Array
from mpmverify.problem.quantities import multiplicity
from mpmverify.solution import Solution

NORMS = ("L1", "L2", "Linf", "L2-max")
"""L1, L2 and Linf are taken at the final time; L2-max is the largest L2 norm over the output times. L1 and L2 are means over the
initial volume of the body, so that every norm has the unit of its field."""


BLOCK = 4096
"""Number of values at points, counted at every time, that are compared at once: their arrays fit a cache."""


def magnitude(values: Array) -> Array:
    """Return |e_p| (T, P) of values (T, P, components)."""
    return np.abs(values[..., 0]) if values.shape[-1] == 1 else np.sqrt(np.einsum("...c,...c->...", values, values))


def l1(size: Array, weight: Array) -> Array:
    """Return sum_p w_p |e_p| for magnitudes and weights (T, P), as (T,)."""
    return np.sum(weight * size, axis=-1)


def l2(size: Array, weight: Array) -> Array:
    """Return sqrt(sum_p w_p |e_p|^2) for magnitudes and weights (T, P), as (T,)."""
    return np.sqrt(np.sum(weight * size**2, axis=-1))


def linf(size: Array) -> Array:
    """Return max_p |e_p| for magnitudes (T, P), as (T,)."""
    return np.max(size, axis=-1)


def norms(values: Array, weight: Array) -> Array:
    """Return all `NORMS` of one field (4,), in the unit of the field.

    Parameters
    ----------
    values : Array
        (T, P, components).
    weight : Array
        Quadrature weights (T, P) [m^dim]; at the first time they sum to the measure |Omega| of the body.

    Returns
    -------
    Array
        All NaN if a weight is negative, or the sum of the weights at one time is not positive and finite.

    Notes
    -----
    L1 is (sum_p w_p |e_p|) / |Omega| and L2 is sqrt(sum_p w_p |e_p|^2 / |Omega|).
    """
    return _norms(_over_time(values, _shares(weight)))


def _norms(over_time: Array) -> Array:
    one, two, largest = over_time
    return np.array([one[-1], two[-1], largest[-1], np.max(two)])


def _sizes(over_time: Array) -> Array:
    """Return the size of an exact field over the run by which the errors in all `NORMS` are divided (4,), in its unit.

    It is the largest over the output times of the same norm: L1, L2, Linf and L2. A field that vanishes at the final time has a size.
    """
    one, two, largest = np.max(over_time, axis=1)
    return np.array([one, two, largest, two])


def _shares(weight: Array) -> Array:
    """Return the weights (T, P) as shares of the measure of the body [1]; all NaN for weights that are not valid, see `norms`."""
    measure = weight.sum(axis=-1)
    if not (np.all(weight >= 0) and np.all(np.isfinite(measure) & (measure > 0))):
        return np.full_like(weight, np.nan, dtype=float)
    return weight / measure[0]


def _over_time(values: Array, share: Array) -> Array:
    """Return L1, L2 and Linf at every output time (3, T); all NaN where the shares are."""
    size = magnitude(values)
    return np.array([l1(size, share), l2(size, share), np.where(np.isnan(share[:, 0]), np.nan, linf(size))])


def errors(solution: Solution, exact: ExactSolution) -> dict[str, tuple[Array, Array]]:
    """Norms of the error and sizes of the exact field by quantity, see `compare`."""
    return compare(solution, exact)[0]


def compare(solution: Solution, exact: ExactSolution) -> tuple[dict[str, tuple[Array, Array]], dict[str, float]]:
    """Compare a solution with the exact one, for each quantity that both have.

    Parameters
    ----------
    solution : Solution
    exact : ExactSolution

    Returns
    -------
    table : dict of str to (Array, Array)
        (error `norms` (4,), size of the exact field over the run (4,)) in the order of `NORMS` and the unit of the quantity.
    onsets : dict of str to float
        When each error begins to show, by the name of the metric, see `onset`; without those that have no error.

    Raises
    ------
    UsageError
        If a field or the weights do not have the shape that `Solution` requires; numpy would broadcast them silently.

    Notes
    -----
    The magnitude of a vector or tensor at a point is its Euclidean (Frobenius) norm over all entries: an off-diagonal component of the
    stress counts twice.
    """
    samples = (len(solution.time), len(solution.reference))
    if solution.weight.shape != samples or not all(samples):
        raise UsageError(f"a solver must return weights (T, P) = {samples} of at least one point, not {solution.weight.shape}")
    share, table, onsets = _shares(solution.weight), {}, {}
    for quantity, closed_form in exact.fields.items():
        if quantity in solution.fields:
            error, field = _compared(quantity, solution, closed_form, share)
            table[quantity] = (_norms(error), _sizes(field))
            onsets[onset_of(quantity)] = onset(error[1], solution.time)
    return table, {name: time for name, time in onsets.items() if np.isfinite(time)}


ONSET = 0.1
"""Share of its largest size from which on an error is said to show."""


def onset_of(quantity: str) -> str:
    """Name of the metric that holds when the error of a quantity begins to show."""
    return f"onset_{quantity}"


def onset(size: Array, time: Array) -> float:
    """Return the first output time at which an error, of L2 norms (T,) at times (T,) [s], is more than `ONSET` of its largest [s].

    It is NaN where there is no error, or it is not finite.
    """
    return float(time[np.argmax(size > ONSET * size.max())]) if 0 < size.max() < np.inf else np.nan


def _compared(quantity: str, solution: Solution, closed_form: ExactField, share: Array) -> Array:
    """Return L1, L2 and Linf of the error and of the exact field at every output time (2, 3, T)."""
    times, points = share.shape
    entries = np.sqrt(multiplicity(quantity, solution.reference.shape[1]))
    required, found = (times, points, len(entries)), solution.fields[quantity].shape
    parts = []
    for some in np.array_split(np.arange(times), min(times, 1 + times * points // BLOCK)):
        expected = closed_form(solution.reference, solution.time[some])
        if not (found == required and expected.shape == (len(some), *required[1:])):
            raise UsageError(f"a solver must return {quantity} as (T, P, components) = {required}, not {found}")
        difference = (solution.fields[quantity][some] - expected) * entries
        parts.append([_over_time(values, share[some]) for values in (difference, expected * entries)])
    return np.concatenate(parts, axis=-1)
