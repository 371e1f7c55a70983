"""Weighted norms of fields that are sampled at quadrature points; every norm of a field with NaN is NaN."""

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.exact import ExactSolution
from mpmverify.problem import Array
from mpmverify.problem.quantities import multiplicity
from mpmverify.solution import Solution

NORMS = ("L1", "L2", "Linf", "L2-max")
"""L1, L2 and Linf are taken at the final time; L2-max is the largest L2 norm over the output times. L1 and L2 are means over the
initial volume of the body, so that every norm has the unit of its field."""


def l1(values: Array, weight: Array) -> Array:
    """Return sum_p w_p |e_p| for values (T, P, components) and weights (T, P), as (T,)."""
    return np.sum(weight * np.linalg.norm(values, axis=-1), axis=-1)


def l2(values: Array, weight: Array) -> Array:
    """Return sqrt(sum_p w_p |e_p|^2) for values (T, P, components) and weights (T, P), as (T,)."""
    return np.sqrt(np.sum(weight * np.sum(values**2, axis=-1), axis=-1))


def linf(values: Array) -> Array:
    """Return max_p |e_p| for values (T, P, components), as (T,)."""
    return np.max(np.linalg.norm(values, axis=-1), axis=-1)


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
    one, two, largest = _over_time(values, weight)
    return np.array([one[-1], two[-1], largest[-1], np.max(two)])


def sizes(values: Array, weight: Array) -> Array:
    """Return the size of an exact field over the whole run by which the errors in all `NORMS` are divided (4,), in its unit.

    It is the largest over the output times of the same norm: L1, L2, Linf and L2. A field that vanishes at the final time has a size.
    The parameters are those of `norms`.
    """
    one, two, largest = np.max(_over_time(values, weight), axis=1)
    return np.array([one, two, largest, two])


def _over_time(values: Array, weight: Array) -> Array:
    """Return L1, L2 and Linf at every output time (3, T); all NaN for weights that are not valid, see `norms`."""
    measure = weight.sum(axis=-1)
    if not (np.all(weight >= 0) and np.all(np.isfinite(measure) & (measure > 0))):
        return np.full((3, len(weight)), np.nan)
    weight = weight / measure[0]
    return np.array([l1(values, weight), l2(values, weight), linf(values)])


def errors(solution: Solution, exact: ExactSolution) -> dict[str, tuple[Array, Array]]:
    """Norms of the error and sizes of the exact field, for each quantity that both the solution and the exact solution have.

    Parameters
    ----------
    solution : Solution
    exact : ExactSolution

    Returns
    -------
    dict of str to (Array, Array)
        (error `norms` (4,), `sizes` of the exact field (4,)) in the order of `NORMS` and the unit of the quantity.

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
    table = {}
    for quantity, closed_form in exact.fields.items():
        if quantity in solution.fields:
            expected = closed_form(solution.reference, solution.time)
            found = solution.fields[quantity].shape
            entries = np.sqrt(multiplicity(quantity, solution.reference.shape[1]))
            if not found == expected.shape == (*samples, len(entries)):
                raise UsageError(
                    f"a solver must return {quantity} as (T, P, components) = {(*samples, len(entries))}, not {found}"
                )
            table[quantity] = (
                norms((solution.fields[quantity] - expected) * entries, solution.weight),
                sizes(expected * entries, solution.weight),
            )
    return table
