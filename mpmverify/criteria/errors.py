"""Criteria on error norms: orders, sizes, stalls, exactness and published values."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence import ROUND_OFF, Classification, judge_order
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.bounds import finite_and_non_negative, judge_largest
from mpmverify.criteria.criterion import OnLimits, Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.norms import NORMS, onset_of
from mpmverify.errors import UsageError
from mpmverify.problem import UNITS, Block
from mpmverify.solution import Solution

LARGEST_ROUND_OFF = 1e-5
"""Largest relative error that may be called round-off: single precision has 6e-8, which many steps add up."""


class ErrorCriterion:
    """Base class of criteria on the stored error norms, which measure nothing else."""

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        return {}


@dataclass(frozen=True)
class Order(ErrorCriterion):
    """The order of the finest refinement step, as far as all levels tell it, lies in [low, high].

    Parameters
    ----------
    quantity, norm : str
    low, high : float
        Accepted band of orders in the refined size.
    source : str
    round_off : float
        Relative error at and below which round-off hides the order; larger for a code in single precision.

    Raises
    ------
    UsageError
        If `round_off` is negative, or above `LARGEST_ROUND_OFF`.
    """

    quantity: str
    norm: str
    low: float
    high: float
    source: str
    round_off: float = ROUND_OFF

    def __post_init__(self) -> None:
        if not 0 <= self.round_off <= LARGEST_ROUND_OFF:
            raise UsageError(
                f"a relative error of {self.round_off:g} is not round-off: give at most {LARGEST_ROUND_OFF:g}, as in single precision"
            )

    @property
    def title(self) -> str:
        above = "" if self.round_off == ROUND_OFF else f" above {self.round_off:g}"
        return f"order of {self.quantity} in {self.norm} in [{self.low:g}, {self.high:g}]{above}"

    def judge(self, evidence: Evidence) -> Judgement:
        series = evidence.convergence(self.quantity, self.norm, (self.low, self.high), self.round_off)
        if series is None:
            return Verdict.INCONCLUSIVE, evidence.axis.note
        verdict, reason = judge_order(series, self.low, self.high)
        remarks = [evidence.axis.note, self._remaining(evidence) if verdict is Verdict.FAIL else ""]
        return verdict, "; ".join(part for part in (reason, *remarks) if part)

    def _remaining(self, evidence: Evidence) -> str:
        """Say how large the error of the finest level is, and from when on it shows."""
        finest = int(np.argmin(evidence.sizes[evidence.axis.size]))
        said = (
            f"at {evidence.names[finest]} the error is {evidence.relative(self.quantity, self.norm)[finest]:.2g} of the field"
        )
        time = evidence.metrics.get(onset_of(self.quantity), np.full(finest + 1, np.nan))[finest]
        return said if np.isnan(time) else f"{said}, and shows from t = {time:.3g} s on"


@dataclass(frozen=True)
class Size(ErrorCriterion):
    """The error of the finest level, or of that of a cell size, has a known size, which an order over few levels does not tell.

    Parameters
    ----------
    quantity, norm : str
    low, high : float
        Accepted relative errors.
    source : str
    h : float
        The cell size [m]; 0 for the finest level of a ladder, or for all levels of a design with the smallest cells.
    """

    quantity: str
    norm: str
    low: float
    high: float
    source: str
    h: float = 0.0

    @property
    def title(self) -> str:
        level = f"h={self.h:g}" if self.h else "the finest level"
        return f"error of {self.quantity} in {self.norm} in [{self.low:.3g}, {self.high:.3g}] at {level}"

    def judge(self, evidence: Evidence) -> Judgement:
        error = evidence.relative(self.quantity, self.norm)
        if not finite_and_non_negative(error):
            return Verdict.ERROR, "the error is not finite on at least one level"
        size = evidence.h if self.h else evidence.sizes[evidence.axis.size or "h"]
        judged = error[np.isclose(size, self.h or size.min(), rtol=1e-9, atol=0)]
        if not judged.size:
            return Verdict.INCONCLUSIVE, f"no level has h={self.h:g}"
        verdict = Verdict.PASS if self.low <= judged.min() and judged.max() <= self.high else Verdict.FAIL
        return verdict, f"relative error {' to '.join(dict.fromkeys(f'{e:.3g}' for e in (judged.min(), judged.max())))}"


@dataclass(frozen=True)
class Stall(ErrorCriterion, OnLimits):
    """The scheme is known not to converge: the last two observed orders are below a bound, at an error of a known size.

    Parameters
    ----------
    quantity, norm : str
    below : float
        Bound on the order.
    low, high : float
        Relative errors between which those of the two finest levels lie: what stalls at another error has not this limit. That of a
        body that never moves is 1.
    source : str
    change : float
        Relative change of an error up to which the run counts as unchanged against the baseline.
    """

    quantity: str
    norm: str
    below: float
    low: float
    high: float
    source: str
    change: float = 0.01

    @property
    def title(self) -> str:
        bounds = f"order below {self.below:g}, error in [{self.low:g}, {self.high:g}]"
        return f"{self.quantity} in {self.norm} stalls or diverges ({bounds})"

    def judge(self, evidence: Evidence) -> Judgement:
        series = evidence.convergence(self.quantity, self.norm)
        if series is None:
            return Verdict.INCONCLUSIVE, evidence.axis.note
        last = series.pairwise[-2:]
        if series.classification is Classification.NON_FINITE:
            return Verdict.ERROR, "the error is not finite on at least one level"
        if len(last) < 2:
            return Verdict.INCONCLUSIVE, f"a stall needs three levels, not {len(series.h)}"
        if np.any(series.error[-3:] <= ROUND_OFF):
            return Verdict.FAIL, "the error does not stall: it is at round-off on one of the three finest levels"
        before, finest = series.error[-2:]
        orders = f"last observed orders {last[0]:.2f} and {last[1]:.2f} ({series.classification})"
        measured = f"{orders} at errors of {before:.3g} and {finest:.3g}"
        if not (self.low <= min(before, finest) and max(before, finest) <= self.high):
            return Verdict.FAIL, f"{measured}, which are not of the size that is known of the scheme"
        if np.all(last < self.below):
            return Verdict.PASS, measured
        return (
            Verdict.FAIL if np.all(last >= self.below) else Verdict.INCONCLUSIVE
        ), f"{measured}, not both below {self.below:g}"


@dataclass(frozen=True)
class Exact(ErrorCriterion):
    """The scheme has no error on this problem: every level is within round-off.

    Parameters
    ----------
    quantity, norm : str
    bound : float
        Largest relative error.
    source : str
    """

    quantity: str
    norm: str
    bound: float
    source: str

    @property
    def title(self) -> str:
        return f"{self.quantity} exact in {self.norm} to {self.bound:g}"

    def judge(self, evidence: Evidence) -> Judgement:
        return judge_largest(evidence.relative(self.quantity, self.norm), self.bound, "relative error")


@dataclass(frozen=True)
class Published(ErrorCriterion):
    """The absolute errors agree with published ones to a number of significant digits.

    Parameters
    ----------
    quantity, norm : str
    values : tuple of (h, error)
        Published absolute errors; only levels with the same h are compared.
    digits : int
        Significant digits that must agree: the deviation is at most half a unit of the last one.
    source : str
    """

    quantity: str
    norm: str
    values: tuple[tuple[float, float], ...]
    digits: int
    source: str

    @property
    def title(self) -> str:
        return f"published {self.quantity} errors in {self.norm} to {self.digits} digits"

    def judge(self, evidence: Evidence) -> Judgement:
        if not np.all(np.isfinite(evidence.relative(self.quantity, self.norm))):
            return Verdict.ERROR, "the error is not finite on at least one level"
        errors = zip(evidence.h, evidence.error[self.quantity][:, NORMS.index(self.norm)], strict=True)
        pairs = np.array([(mine, theirs) for size, mine in errors for h, theirs in self.values if h == size])
        if len(pairs) < 3:
            return Verdict.INCONCLUSIVE, f"{len(pairs)} of {len(self.values)} published levels were run; three are needed"
        units = np.abs(pairs[:, 0] - pairs[:, 1]) / 10.0 ** (np.floor(np.log10(pairs[:, 1])) - self.digits + 1)
        verdict, reason = judge_largest(units, 0.5, f"deviation in units of digit {self.digits}")
        return verdict, f"{reason}, {len(pairs)} levels"


@dataclass(frozen=True)
class Reproduced:
    """The scheme reproduces a field at every point and at every time, or deviates from it by a known amount.

    Parameters
    ----------
    quantity : str
    scale : float
        Size by which the deviation is divided, in the unit of the quantity.
    bound : float
        Largest deviation relative to the scale.
    source : str
    low : float
        Least deviation; above zero for a known limit of the scheme.
    inside : float
        Distance from the surface of the body, or of the box that it fills, of the points that are compared [m].
    """

    quantity: str
    scale: float
    bound: float
    source: str
    low: float = 0.0
    inside: float = 0.0

    @property
    def title(self) -> str:
        where = f", {self.inside:g} m inside" if self.inside else ""
        amount = f"off by {self.low:g} to {self.bound:g}" if self.low else f"reproduced to {self.bound:g}"
        return f"{self.quantity} {amount} of {self.scale:g} {UNITS[self.quantity]}{where}"

    @property
    def marker(self) -> str:
        """What a PASS on an expected deviation is marked with."""
        return OnLimits.marker if self.low else ""

    @property
    def _metric(self) -> str:
        return f"{self.quantity}_deviation{f'_{self.inside:g}_inside' if self.inside else ''}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        problem, X = setting.problem.problem, solution.reference
        if self.quantity not in solution.fields:
            return {}
        deviation = np.abs(solution.fields[self.quantity] - setting.problem.exact.fields[self.quantity](X, solution.time))
        if self.inside:
            body = problem.shape if isinstance(problem.shape, Block) else Block(problem.lower, problem.upper)
            depth = np.minimum(X - body.lower, np.array(body.upper) - X).min(axis=1)
            deviation = deviation[:, depth >= self.inside]
        return {self._metric: float(np.max(deviation, initial=-np.inf)) / self.scale}

    def judge(self, evidence: Evidence) -> Judgement:
        values = evidence.metrics[self._metric]
        verdict, reason = judge_largest(values, self.bound, "deviation")
        if verdict is Verdict.PASS and values.min() < self.low:
            return Verdict.FAIL, f"least deviation {values.min():.2e}, below {self.low:g}"
        return verdict, reason
