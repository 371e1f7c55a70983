"""Sources of an error told apart: a small design of runs in; the size, exponent and interval of each source out; no solver near."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import fdtrc

from mpmverify.convergence import ROUND_OFF
from mpmverify.convergence.levels import Array
from mpmverify.convergence.superposition import EXPONENTS, Model, Sum, student
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.errors import UsageError

REST = "rest"
"""What stays when the one size that a design varies goes to zero."""
HELD = {REST: 0.0}
"""Exponents that are known."""
SEEN = 0.05
"""Part of the error that a source must have on some run: less may be the higher terms of another one."""
SIGNIFICANCE = 1e-3
"""Probability at and above which it may be noise that a source improves the fit."""
MISFIT = 0.03
"""Root mean square of log(E/fit) above which the sources do not explain the errors."""
FAR = 100.0
"""How far above round-off an error is that no run may lack."""
EXACT = 1e-24
"""Sum of squares of relative deviations at which a fit is exact to round-off."""
INDEPENDENT = 0.1
"""Least eigenvalue of the correlation of the log sizes; at zero, one of them follows from the others."""


@dataclass(frozen=True)
class Source:
    """One source of error, of norm amplitude * size^exponent.

    Parameters
    ----------
    size : str
        Name of its size.
    amplitude : float
        In the unit of the error per unit of size^exponent; 0 when the source is not seen.
    exponent, low, high : float
        With its interval; NaN when the source is not seen.
    share : float
        Largest part that it has in the sum of all sources, on any run; 0 when it is not seen.
    """

    size: str
    amplitude: float = 0.0
    exponent: float = np.nan
    low: float = np.nan
    high: float = np.nan
    share: float = 0.0

    @property
    def seen(self) -> bool:
        return self.share > 0


@dataclass(frozen=True)
class Separation:
    """The sources of an error over a design.

    Parameters
    ----------
    sources : tuple of Source
        Empty when they cannot be told apart.
    cosine : mapping of (str, str) to float
        Between the error fields of two sources that are seen: 1 where they add, 0 where they are orthogonal, -1 where they cancel.
    residual : float
        Root mean square of log(E/fit) by its degrees of freedom; NaN when nothing was fitted.
    obstacle : str
        Why the sources cannot be told apart, or may not be; "" when they are.
    """

    sources: tuple[Source, ...] = ()
    cosine: Mapping[tuple[str, str], float] = field(default_factory=dict)
    residual: float = np.nan
    obstacle: str = ""


def separate(sizes: Mapping[str, ArrayLike], error: ArrayLike) -> Separation:
    """Tell the sources of an error apart.

    Parameters
    ----------
    sizes : mapping of str to array-like
        The sizes that a design varies, each (n,), positive and finite, vanishing with its source: h, dt, 1/ppc or h/ppc. A
        single one is fitted beside a constant, the `REST`.
    error : array-like
        Errors (n,), relative to the size of the exact solution, in the L2 norm or one that fields add in like vectors.

    Raises
    ------
    UsageError
        If the arrays do not match, a size is not positive and finite, or an error is negative.

    Notes
    -----
    Source j has an error field of norm a_j s_j^p_j; fields add as vectors, with cosines that the design does not change. Log E
    is fitted by least squares. Exponents have the 99 % interval of the linearised fit by Student's t, as far beyond it as another
    fit is as good. A source without which the fit is as good (F test), or which has less than a twentieth of the error on every
    run, is not seen and has no exponent.
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
    model = Model(centred, np.log(error[kept]), HELD)
    fit = model.fit()
    while len(centred) > 1 and (unseen := _unseen(centred, model.log_error, fit)):
        del centred[unseen]
        model = Model(centred, model.log_error, HELD)
        fit = model.fit()
    known = {}
    for k, (name, log_size) in enumerate(centred.items()):
        exponent = float(fit.exponent[k])
        mean = logs[name].mean() if name in logs else 0.0
        amplitude = float(np.exp(np.log(fit.magnitude[k, 0]) - exponent * (log_size[0] + mean)))
        low, high = (np.nan, np.nan) if name in HELD else (_end(centred, model.log_error, fit, k, side) for side in (-1, 1))
        known[name] = Source(name, amplitude, exponent, low, high, float(fit.share[k]))
    names = (*table, *([REST] if len(table) == 1 else []))
    obstacle = f"the sources do not explain the errors: they are off by {fit.residual:.0%}" if fit.residual > MISFIT else ""
    if unlike := int(np.sum(_predicted(known, fit.cosine, {n: size[~kept] for n, size in table.items()}) > FAR * ROUND_OFF)):
        obstacle = f"{unlike} runs are at round-off, where the sources of the others have errors far above it"
    return Separation(tuple(known.get(name, Source(name)) for name in names), fit.cosine, fit.residual, obstacle)


def _predicted(known: Mapping[str, Source], cosine: Mapping[tuple[str, str], float], table: Mapping[str, Array]) -> Array:
    """Errors that the sources would have on other runs."""
    parts = {name: source.amplitude * table[name] ** source.exponent for name, source in known.items() if name in table}
    square = sum((part**2 for part in parts.values()), np.zeros(len(next(iter(table.values())))))
    for (one, other), value in cosine.items():
        if one in parts and other in parts:
            square = square + 2 * value * parts[one] * parts[other]
    return np.asarray(np.sqrt(np.maximum(square, 0)))


def _obstacle(logs: Mapping[str, Array], runs: int) -> str:
    """Say why a design cannot tell the sources apart; "" when it can."""
    few = [name for name, log in logs.items() if len(np.unique(log.round(9))) < 3]
    if few:
        return f"an exponent needs three values of {few[0]} on runs above round-off"
    if np.linalg.eigvalsh(np.atleast_2d(np.corrcoef(list(logs.values())))).min() < INDEPENDENT:
        return f"{' and '.join(logs)} fall together: such runs measure the least of their exponents only"
    sources = max(2, len(logs))
    parameters = sources + len(logs) + sources * (sources - 1) // 2
    if runs < parameters + 2:
        return f"{runs} runs above round-off for {parameters} parameters: two more than parameters are needed"
    return ""


def _unseen(centred: Mapping[str, Array], log_error: Array, fit: Sum) -> str:
    """Return the least of the sources that are not seen; "" when all are."""
    for k in np.argsort(fit.share, kind="stable"):
        name = tuple(centred)[k]
        without = Model({other: size for other, size in centred.items() if other != name}, log_error, HELD).fit()
        spared = without.freedom - fit.freedom
        gain = max(without.squares - fit.squares, 0.0) / spared / max(fit.squares / fit.freedom, EXACT)
        if fit.share[k] < SEEN or fdtrc(spared, fit.freedom, gain) >= SIGNIFICANCE:
            return name
    return ""


def _end(centred: Mapping[str, Array], log_error: Array, fit: Sum, k: int, side: int) -> float:
    """Return the end of the interval of an exponent: that of the linearised fit, or beyond it as far as another fit is as good.

    Near the end of its range a source may be mistaken for one of another exponent and cosine, which no linearisation shows.
    """
    name, exponent, spread = tuple(centred)[k], float(fit.exponent[k]), float(fit.spread[k])
    if not np.isfinite(spread):
        return side * np.inf
    worst = fit.squares * (1 + student(fit.freedom) ** 2 / fit.freedom) + EXACT
    end, step = exponent + side * spread, max(0.25 * spread, 0.01)
    while 0 < end + side * step < 2 * EXPONENTS[1]:
        other = Model(centred, log_error, HELD | {name: end + side * step}).fit(starts=2)
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
        Accepted band of the exponent of each source that is judged, by the size that it vanishes with.

    Returns
    -------
    (Verdict, str)
        FAIL when an interval lies wholly outside its band, PASS when all lie inside, else INCONCLUSIVE; with the reason.
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
    """Say what is known of a source."""
    if not source.seen:
        return f"{source.size}: not seen"
    return f"{source.size}: {source.exponent:.3f}, interval [{source.low:.3f}, {source.high:.3f}], up to {source.share:.0%}"
