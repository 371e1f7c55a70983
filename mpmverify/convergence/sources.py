"""Separation of error sources: from a small design of runs, the amplitude, exponent and confidence interval of each source."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from mpmverify.convergence import ROUND_OFF
from mpmverify.convergence.levels import Array
from mpmverify.convergence.student import student_quantile
from mpmverify.convergence.superposition import CONFIDENCE, EXPONENTS, Model, SumFit
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.errors import UsageError

REST = "rest"
"""The constant error that remains when the only varied size of a design goes to zero."""
KNOWN_EXPONENTS = {REST: 0.0}
"""Exponents that are not fitted."""
LEAST_SHARE = 0.05
"""Smallest share of the error that a source must have on some run; a smaller one may be a higher-order term of another source."""
SIGNIFICANCE = 1e-3
"""Significance level of the F test: a source whose p-value is at or above it may be noise."""
MISFIT = 0.03
"""Root mean square of log(E/fit) above which the sources do not explain the errors."""
FAR_ABOVE = 100.0
"""Ratio of a predicted error to round-off at and above which a run must not be at round-off."""
EXACT_SQUARES = 1e-24
"""Sum of squares of relative deviations at which a fit is exact to round-off."""
LEAST_EIGENVALUE = 0.1
"""Smallest allowed eigenvalue of the correlation matrix of the log sizes; it is zero if one size is a product of powers of others."""


@dataclass(frozen=True)
class Source:
    """One source of error, whose error field has the norm amplitude * size^exponent.

    Parameters
    ----------
    size : str
        Name of the size with which the source vanishes.
    amplitude : float
        In the unit of the error per unit of size^exponent; 0 if the source is not seen.
    exponent, low, high : float
        Exponent and the ends of its confidence interval; NaN if the source is not seen.
    share : float
        Largest share in the sum of all sources on any run [1]; 0 if the source is not seen.
    """

    size: str
    amplitude: float = 0.0
    exponent: float = np.nan
    low: float = np.nan
    high: float = np.nan
    share: float = 0.0

    @property
    def seen(self) -> bool:
        """Whether the source is significant on these runs."""
        return self.share > 0


@dataclass(frozen=True)
class Separation:
    """The sources of an error over a design of runs.

    Parameters
    ----------
    sources : tuple of Source
        Empty if they cannot be separated.
    cosine : mapping of (str, str) to float
        Cosine between the error fields of two seen sources: 1 where they add, 0 where they are orthogonal, -1 where they cancel.
    residual : float
        Root mean square of log(E/fit), with the degrees of freedom as divisor; NaN if nothing was fitted.
    obstacle : str
        Why the sources cannot be separated, or why the separation is not reliable; "" if it is.
    """

    sources: tuple[Source, ...] = ()
    cosine: Mapping[tuple[str, str], float] = field(default_factory=dict)
    residual: float = np.nan
    obstacle: str = ""


def separate(sizes: Mapping[str, ArrayLike], error: ArrayLike) -> Separation:
    """Separate the sources of an error.

    Parameters
    ----------
    sizes : mapping of str to array-like
        The sizes that the design varies, each (n,), positive and finite: h, dt, 1/ppc or h/ppc. Each source vanishes with its size.
        A single size is fitted together with a constant, the `REST`.
    error : array-like
        Errors (n,) relative to the size of the exact solution, in the L2 norm or another one that an inner product defines.

    Returns
    -------
    Separation

    Raises
    ------
    UsageError
        If the shapes do not match, a size is not positive and finite, or an error is negative.

    Notes
    -----
    Source j has an error field of norm a_j s_j^p_j. The fields add as vectors; the cosines between them are assumed equal on all
    runs. Log E is fitted by least squares. The interval of an exponent is the 99 % interval of the linearised fit by Student's t,
    extended as far as a fit with another exponent is equally good. A source is not seen, and has no exponent, if the fit without it
    is as good (F test) or if its share of the error is below 5 % on every run.
    """
    table = {name: np.asarray(size, dtype=float) for name, size in sizes.items()}
    error = np.asarray(error, dtype=float)
    if not table or any(size.shape != error.shape or error.ndim != 1 for size in table.values()):
        raise UsageError("the error and every size must be lists of the same length")
    if not all(np.all(np.isfinite(size) & (size > 0)) for size in table.values()):
        raise UsageError("every size must be positive and finite")
    if np.any(np.isfinite(error) & (error < 0)):
        raise UsageError("an error norm cannot be negative")
    if not np.all(np.isfinite(error)):
        return Separation(obstacle="the error is not finite on at least one run")
    return _separated(table, error)


def _separated(table: Mapping[str, Array], error: Array) -> Separation:
    kept = error > ROUND_OFF
    logs = {name: np.log(size[kept]) for name, size in table.items()}
    if obstacle := _obstacle(logs, int(kept.sum())):
        return Separation(obstacle=obstacle)
    centred = {name: log - log.mean() for name, log in logs.items()}
    if len(table) == 1:
        centred[REST] = np.zeros(int(kept.sum()))
    model = Model(centred, np.log(error[kept]), KNOWN_EXPONENTS)
    fit = model.fit()
    while len(centred) > 1 and (unseen := _least_unseen(centred, model.log_error, fit)):
        del centred[unseen]
        model = Model(centred, model.log_error, KNOWN_EXPONENTS)
        fit = model.fit()
    known = {}
    for k, (name, log_size) in enumerate(centred.items()):
        exponent = float(fit.exponent[k])
        mean = logs[name].mean() if name in logs else 0.0
        amplitude = float(np.exp(np.log(fit.magnitude[k, 0]) - exponent * (log_size[0] + mean)))
        low, high = (
            (np.nan, np.nan)
            if name in KNOWN_EXPONENTS
            else (_interval_end(centred, model.log_error, fit, k, side) for side in (-1, 1))
        )
        known[name] = Source(name, amplitude, exponent, low, high, float(fit.share[k]))
    names = (*table, *([REST] if len(table) == 1 else []))
    obstacle = f"the sources do not explain the errors: they are off by {fit.residual:.0%}" if fit.residual > MISFIT else ""
    if unlike := int(
        np.sum(_predicted(known, fit.cosine, {n: size[~kept] for n, size in table.items()}) > FAR_ABOVE * ROUND_OFF)
    ):
        obstacle = f"{unlike} runs are at round-off, where the sources of the others have errors far above it"
    return Separation(tuple(known.get(name, Source(name)) for name in names), fit.cosine, fit.residual, obstacle)


def _predicted(known: Mapping[str, Source], cosine: Mapping[tuple[str, str], float], table: Mapping[str, Array]) -> Array:
    """Errors that the fitted sources predict on other runs."""
    parts = {name: source.amplitude * table[name] ** source.exponent for name, source in known.items() if name in table}
    square = sum((part**2 for part in parts.values()), np.zeros(len(next(iter(table.values())))))
    for (one, other), value in cosine.items():
        if one in parts and other in parts:
            square = square + 2 * value * parts[one] * parts[other]
    return np.asarray(np.sqrt(np.maximum(square, 0)))


def _obstacle(logs: Mapping[str, Array], runs: int) -> str:
    """Return why a design cannot separate the sources; "" if it can."""
    few = [name for name, log in logs.items() if len(np.unique(log.round(9))) < 3]
    if few:
        return f"an exponent needs three values of {few[0]} on runs above round-off"
    if np.linalg.eigvalsh(np.atleast_2d(np.corrcoef(list(logs.values())))).min() < LEAST_EIGENVALUE:
        return f"{' and '.join(logs)} fall together: such runs measure the least of their exponents only"
    sources = max(2, len(logs))
    parameters = sources + len(logs) + sources * (sources - 1) // 2
    if runs < parameters + 2:
        return f"{runs} runs above round-off for {parameters} parameters: two more than parameters are needed"
    return ""


def _least_unseen(centred: Mapping[str, Array], log_error: Array, fit: SumFit) -> str:
    """Return the smallest source that is not seen; "" if all are seen."""
    from scipy.special import fdtrc  # as SciPy in `Model.fit`

    for k in np.argsort(fit.share, kind="stable"):
        name = tuple(centred)[k]
        without = Model({other: size for other, size in centred.items() if other != name}, log_error, KNOWN_EXPONENTS).fit()
        removed = without.degrees_of_freedom - fit.degrees_of_freedom
        variance = max(fit.squares / fit.degrees_of_freedom, EXACT_SQUARES)
        f_statistic = max(without.squares - fit.squares, 0.0) / removed / variance
        if fit.share[k] < LEAST_SHARE or fdtrc(removed, fit.degrees_of_freedom, f_statistic) >= SIGNIFICANCE:
            return name
    return ""


def _interval_end(centred: Mapping[str, Array], log_error: Array, fit: SumFit, k: int, side: int) -> float:
    """Return the lower (side -1) or upper (+1) end of the interval of exponent k.

    It is the end of the linearised interval, moved outwards as long as a fit with the exponent fixed there is equally good. Some sources
    can be confused with one of another exponent and cosine, which the linearisation does not show.
    """
    name, exponent, half_width = tuple(centred)[k], float(fit.exponent[k]), float(fit.half_width[k])
    if not np.isfinite(half_width):
        return side * np.inf
    worst = (
        fit.squares * (1 + student_quantile(fit.degrees_of_freedom, CONFIDENCE) ** 2 / fit.degrees_of_freedom) + EXACT_SQUARES
    )
    end, step = exponent + side * half_width, max(0.25 * half_width, 0.01)
    while 0 < end + side * step < 2 * EXPONENTS[1]:
        other = Model(centred, log_error, KNOWN_EXPONENTS | {name: end + side * step}).fit(starts=2)
        if other.squares > worst:
            break
        end, step = end + side * step, 2 * step
    return end


def judge_sources(found: Separation, bands: Sequence[tuple[str, float, float]]) -> Judgement:
    """Judge the exponents of separated sources.

    Parameters
    ----------
    found : Separation
    bands : sequence of (size, low, high)
        Accepted band of the exponent of each judged source, by the size with which the source vanishes.

    Returns
    -------
    (Verdict, str)
        The verdict and its reason: FAIL if an interval lies wholly outside its band, PASS if all lie inside, else INCONCLUSIVE.
    """
    if found.obstacle:
        return Verdict.INCONCLUSIVE, found.obstacle
    by_size = {entry.size: entry for entry in found.sources}
    verdicts = [_judge(by_size[size], low, high) for size, low, high in bands]
    reason = f"{', '.join(describe(by_size[size]) for size, _, _ in bands)}; the fit is off by {found.residual:.1%}"
    if Verdict.FAIL in verdicts:
        return Verdict.FAIL, reason
    return Verdict.INCONCLUSIVE if Verdict.INCONCLUSIVE in verdicts else Verdict.PASS, reason


def _judge(source: Source, low: float, high: float) -> Verdict:
    if source.high < low or source.low > high:
        return Verdict.FAIL
    return Verdict.PASS if low <= source.low and source.high <= high else Verdict.INCONCLUSIVE


def describe(source: Source) -> str:
    """Return the exponent, interval and share of a source as text."""
    if not source.seen:
        return f"{source.size}: not seen"
    return f"{source.size}: {source.exponent:.3f}, interval [{source.low:.3f}, {source.high:.3f}], up to {source.share:.0%}"
