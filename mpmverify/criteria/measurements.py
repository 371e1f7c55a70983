"""Measurements on sampled waves: coefficients and frequency of a mode, amplitude, delay and gain of a pulse.

Sample points may be unevenly spaced; sums over them are weighted. Samples that are not finite give NaN.
"""

import math
from collections.abc import Callable

import numpy as np

from mpmverify.exact.waves import oscillating_root
from mpmverify.problem import Array

ITERATIONS = 50
"""Largest number of Gauss-Newton steps in `delay_and_gain`; a pulse takes about five."""
SCAN = 32
"""Number of delays on either side that `delay_and_gain` scans for its starting point."""


def modal_history(values: Array, position: Array, weight: Array, wavenumber: float) -> Array:
    """Fourier coefficients of one wave number over time.

    Parameters
    ----------
    values : Array
        Samples (T, P).
    position : Array
        Sample points (P,) [m].
    weight : Array
        Quadrature weights (P,) [m].
    wavenumber : float
        k [rad/m].

    Returns
    -------
    Array
        2 sum_p w_p f_p (cos k x_p, sin k x_p) / sum_p w_p, (T, 2), in the unit of the values.
    """
    shapes = np.stack([np.cos(wavenumber * position), np.sin(wavenumber * position)], axis=-1)
    values = np.where(np.isfinite(values), values, np.nan)
    coefficients: Array = 2 * (values * weight) @ shapes / weight.sum()
    return coefficients


def step_factor(history: Array) -> complex:
    """Factor z of one time step of a damped oscillation s^n = Re(C z^n): |z| is its growth and arg z its phase angle per step.

    Parameters
    ----------
    history : Array
        Samples of the oscillation at equal time steps, in m coefficients (T, m); T >= 5.

    Returns
    -------
    complex
        NaN if the history is not finite, is too short, or does not oscillate (zero, constant, or multiplied by a real factor).

    Notes
    -----
    Prony's method: s^{n+1} = 2 Re(z) s^n - |z|^2 s^{n-1}, by least squares over all n and coefficients. Noise of relative size
    e changes the angle by about e/angle^2.
    """
    if len(history) < 5 or not np.all(np.isfinite(history)):
        return complex(math.nan, math.nan)
    size = np.abs(history).max()
    if size == 0:
        return complex(math.nan, math.nan)
    before, now, after = (np.ravel(part) / size for part in (history[:-2], history[1:-1], history[2:]))
    (trace, minus), _, rank, _ = np.linalg.lstsq(np.stack([now, before], axis=-1), after, rcond=1e-9)
    return complex(oscillating_root(trace, -minus)) if rank == 2 else complex(math.nan, math.nan)


def amplitude(values: Array, weight: Array) -> float:
    """Root mean square sqrt(sum_p w_p f_p^2 / sum_p w_p) of samples (P,)."""
    return float(np.sqrt(np.sum(weight * values**2) / np.sum(weight)))


def delay_and_gain(
    values: Array, weight: Array, field: Callable[[float], Array], reach: float, step: float
) -> tuple[float, float]:
    """Delay d and gain g of the best fit of a known pulse to samples: they minimise sum_p w_p (f_p - g field(d)_p)^2.

    Parameters
    ----------
    values : Array
        Samples (P,).
    weight : Array
        Quadrature weights (P,).
    field : callable
        The pulse at the sample points (P,) as a function of its delay [s], or of a shift [m]; the result has the same unit.
    reach : float
        Largest magnitude of the delay that is searched; a pulse must be wider than reach/`SCAN`.
    step : float
        Step of the difference quotients in the delay; choose it much smaller than the duration of the pulse.

    Returns
    -------
    (float, float)
        Delay, positive if the samples lag behind, and gain; both NaN if a value is not finite, or the pulse is not found within reach.

    Notes
    -----
    The best fit maximises the normalised cross-correlation. A scan over delays gives the starting point for the Gauss-Newton
    method. The pulse is known in closed form, so no sample is interpolated.
    """
    nothing = math.nan, math.nan
    scan = reach * np.arange(-SCAN, SCAN + 1) / SCAN
    shapes = np.array([field(float(d)) for d in scan])
    if not all(np.all(np.isfinite(array)) for array in (values, weight, shapes)):
        return nothing
    sizes = np.sqrt((shapes**2) @ weight)
    correlation = np.where(sizes > 0, shapes @ (weight * values), 0.0) / np.where(sizes > 0, sizes, 1.0)
    if not correlation.max() > 0:
        return nothing
    delay, gain, root = float(scan[np.argmax(correlation)]), 0.0, np.sqrt(weight)
    for _ in range(ITERATIONS):
        rate = (field(delay + step) - field(delay - step)) / (2 * step)
        (gain, slope), _, rank, _ = np.linalg.lstsq(np.stack([field(delay), rate], axis=-1) * root[:, None], root * values)
        if rank < 2 or not gain > 0:
            return nothing
        change = float(np.clip(slope / gain, -reach / SCAN, reach / SCAN))
        delay += change
        if not abs(delay) <= reach:
            return nothing
        if abs(change) <= 1e-13 * reach:
            break
    return delay, float(gain)
