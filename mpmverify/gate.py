"""Verdicts: what must hold of a series of runs, judged from stored numbers alone."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, ClassVar, Protocol

import numpy as np

from mpmverify.convergence import ROUND_OFF, STEP_SLACK, Classification, Convergence, analyse
from mpmverify.exact.amplification import two_step_taylor_galerkin
from mpmverify.norms import NORMS
from mpmverify.problem import Array, Problem, Transport
from mpmverify.solution import Solution


class Verdict(StrEnum):
    """Ordered from best to worst."""

    PASS = "PASS"
    INCONCLUSIVE = "INCONCLUSIVE"
    FAIL = "FAIL"
    ERROR = "ERROR"


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst of some verdicts; nothing judged is inconclusive."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.INCONCLUSIVE)


@dataclass(frozen=True)
class Evidence:
    """What one series of runs, n levels of one solver, left behind.

    Parameters
    ----------
    h, dt, courant, ppc : Array
        Levels (n,).
    outcomes : tuple of str
        "completed", or what happened, by level.
    error, reference : mapping of str to Array
        Norms of the error and of the exact field by quantity, (n, norms) in the order of `norms.NORMS`.
    metrics : mapping of str to Array
        Whatever the criteria measured on the solutions, (n,) by name.
    """

    h: Array
    dt: Array
    courant: Array
    ppc: Array
    outcomes: tuple[str, ...]
    error: Mapping[str, Array] = field(default_factory=dict)
    reference: Mapping[str, Array] = field(default_factory=dict)
    metrics: Mapping[str, Array] = field(default_factory=dict)

    def relative(self, quantity: str, norm: str) -> Array:
        """Error over the exact norm (n,); absolute where the exact field vanishes, NaN where its norm is not finite."""
        k = NORMS.index(norm)
        size = np.where(np.isfinite(self.reference[quantity][:, k]), self.reference[quantity][:, k], np.nan)
        return self.error[quantity][:, k] / np.where(size == 0, 1.0, size)

    def convergence(self, quantity: str, norm: str, expected: tuple[float, float] | None = None) -> Convergence:
        """Analyse one relative error over the levels in h."""
        return analyse(self.h, self.relative(quantity, norm), expected=expected)


Judgement = tuple[Verdict, str]


class Criterion(Protocol):
    """What must hold. `source` says where the expectation comes from."""

    source: str

    @property
    def title(self) -> str:
        """What is judged, in a few words."""

    def measure(self, solution: Solution, problem: Problem) -> Mapping[str, float]:
        """Numbers that the judgement needs and only the solution can give, by name."""

    def judge(self, evidence: Evidence) -> Judgement:
        """Verdict on completed runs, with the reason in one sentence."""


class _OfErrors:
    """A criterion that needs the stored error norms alone."""

    def measure(self, solution: Solution, problem: Problem) -> Mapping[str, float]:
        return {}


PLAUSIBLE = 12.0
"""No scheme has a higher order in h or dt: a coarse level blew up, or a fine one is exact by accident."""


@dataclass(frozen=True)
class Order(_OfErrors):
    """The fitted order lies in [low, high], and so does the finest step of refinement.

    Parameters
    ----------
    quantity, norm : str
    low, high : float
        Accepted band of orders in h.
    source : str
    """

    quantity: str
    norm: str
    low: float
    high: float
    source: str

    @property
    def title(self) -> str:
        return f"order of {self.quantity} in {self.norm} in [{self.low:g}, {self.high:g}]"

    def judge(self, evidence: Evidence) -> Judgement:
        return _order(evidence.convergence(self.quantity, self.norm, (self.low, self.high)), self.low, self.high)


@dataclass(frozen=True)
class Stall(_OfErrors):
    """The scheme is known not to converge: the last two observed orders are below a bound.

    Parameters
    ----------
    quantity, norm : str
    below : float
        Bound on the order.
    source : str
    """

    quantity: str
    norm: str
    below: float
    source: str

    @property
    def title(self) -> str:
        return f"{self.quantity} in {self.norm} stalls (order below {self.below:g})"

    def judge(self, evidence: Evidence) -> Judgement:
        series = evidence.convergence(self.quantity, self.norm)
        last = series.pairwise[-2:]
        if series.classification is Classification.NON_FINITE:
            return Verdict.ERROR, "the error is not finite on at least one level"
        if len(last) < 2:
            return Verdict.INCONCLUSIVE, f"a stall needs three levels, not {len(series.h)}"
        if np.any(series.error[-3:] <= ROUND_OFF):
            return Verdict.FAIL, "the error does not stall: it is at round-off on one of the three finest levels"
        measured = f"last observed orders {last[0]:.2f} and {last[1]:.2f} ({series.classification})"
        if np.all(last < self.below):
            return Verdict.PASS, measured
        return (
            Verdict.FAIL if np.all(last >= self.below) else Verdict.INCONCLUSIVE
        ), f"{measured}, not both below {self.below:g}"


@dataclass(frozen=True)
class Exact(_OfErrors):
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
        return _largest(evidence.relative(self.quantity, self.norm), self.bound, "relative error")


@dataclass(frozen=True)
class Published(_OfErrors):
    """Absolute errors of the literature are reproduced to a number of significant digits.

    Parameters
    ----------
    quantity, norm : str
    values : tuple of (h, error)
        Published absolute errors; the levels that were run are compared.
    digits : int
        Significant digits that must agree: the deviation is below half a unit of the last one.
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
        verdict, reason = _largest(units, 0.5, f"deviation in units of digit {self.digits}")
        return verdict, f"{reason}, {len(pairs)} levels"


@dataclass(frozen=True)
class Balance:
    """A history equals its source term to round-off: mass is constant, momentum changes by the impulse.

    Parameters
    ----------
    stock : str
        History, such as "momentum".
    source_term : str
        History that accounts for its change, such as "impulse"; "" when nothing may change it.
    source : str
    bound : float
        Largest defect relative to the largest magnitude of the two; for momentum also to sqrt(2 m E_kin), the size of the
        particles' momenta that may cancel in their sum.
    """

    stock: str
    source_term: str
    source: str
    bound: float = 1e-12

    @property
    def title(self) -> str:
        return (
            f"{self.stock} less {self.source_term} conserved to {self.bound:g}"
            if self.source_term
            else f"{self.stock} conserved"
        )

    @property
    def _metric(self) -> str:
        return f"{self.stock}_defect"

    def measure(self, solution: Solution, problem: Problem) -> Mapping[str, float]:
        if not {self.stock, self.source_term or self.stock} <= solution.histories.keys():
            return {}
        stock = solution.histories[self.stock]
        change = solution.histories[self.source_term] if self.source_term else np.zeros_like(stock)
        defect = stock - stock[0] - (change - change[0])
        scales = [np.max(np.abs(stock)), np.max(np.abs(change))]
        if self.stock == "momentum" and {"mass", "kinetic_energy"} <= solution.histories.keys():
            # The terms that cancel set the scale of round-off: a momentum of zero is a difference of large ones.
            mass, kinetic = (np.abs(solution.histories[name]) for name in ("mass", "kinetic_energy"))
            scales.append(np.sqrt(2 * np.max(mass * kinetic)))
        return _relative(self._metric, defect, np.max(scales))

    def judge(self, evidence: Evidence) -> Judgement:
        return _largest(evidence.metrics[self._metric], self.bound, "relative defect")


DRIFT_ROUND_OFF = 1e-11
"""Relative energy drift at and below which nothing drifts."""


@dataclass(frozen=True)
class EnergyDrift:
    """Kinetic plus strain energy less external work stays: its largest relative drift converges at an order in dt or is bounded.

    Parameters
    ----------
    low : float
        Least order of the drift in dt; the drift may also be at round-off.
    source : str
    """

    low: float
    source: str
    metric: ClassVar[str] = "energy_drift"

    @property
    def title(self) -> str:
        return f"energy drift vanishes at order {self.low:g} or more"

    def measure(self, solution: Solution, problem: Problem) -> Mapping[str, float]:
        history = solution.histories
        if not {"kinetic_energy", "strain_energy", "external_work"} <= history.keys():
            return {}
        total = history["kinetic_energy"] + history["strain_energy"] - history["external_work"]
        scale = np.max(np.abs(history["kinetic_energy"] + history["strain_energy"]))
        return _relative(self.metric, total - total[0], scale)

    def judge(self, evidence: Evidence) -> Judgement:
        drift = evidence.metrics[self.metric]
        if not _are_sizes(drift):
            return Verdict.ERROR, "the energy drift is not finite, or negative, on at least one level"
        if np.all(drift <= DRIFT_ROUND_OFF):
            return Verdict.PASS, f"largest relative drift {drift.max():.1e}: round-off"
        verdict, reason = _order(analyse(evidence.dt, drift, round_off=DRIFT_ROUND_OFF), self.low, PLAUSIBLE)
        return verdict, f"drift {drift.min():.1e} at best, in dt: {reason}"


@dataclass(frozen=True)
class Amplification:
    """Every Fourier mode of a periodic advection run follows the scheme's amplification factor, G(theta)^n after n steps.

    Parameters
    ----------
    passes : int
        Mass passes of two-step Taylor-Galerkin.
    bound : float
        Largest deviation of a mode's coefficient, relative to its initial one.
    source : str
    """

    passes: int
    bound: float
    source: str
    metric: ClassVar[str] = "amplification_defect"

    @property
    def title(self) -> str:
        return f"amplification factor of every Fourier mode to {self.bound:g}"

    def measure(self, solution: Solution, problem: Problem) -> Mapping[str, float]:
        if "u" not in solution.fields or not isinstance(problem.material, Transport):
            return {}
        steps = np.round(solution.time / solution.dt)
        modes = np.fft.rfft(solution.fields["u"][:, :, 0], axis=1)
        if not np.all(np.isfinite(modes)):
            return {self.metric: np.nan, "amplification_modes": np.nan}
        if steps[-1] < 1 or not modes[0].any():
            return {}
        theta = 2 * np.pi * np.arange(modes.shape[1]) / solution.reference.shape[0]
        h = problem.lengths[0] / solution.reference.shape[0]
        factor = two_step_taylor_galerkin(theta, problem.material.velocity * solution.dt / h, self.passes)
        # A mode that the initial profile lacks, the shortest one sampled at its nodes above all, cannot be followed.
        carried = np.abs(modes[0]) > 1e-3 * np.abs(modes[0]).max()
        initial = modes[0, carried]
        defect = np.abs(modes[:, carried] - initial * factor[carried] ** steps[:, None]) / np.abs(initial)
        return {self.metric: float(defect.max()), "amplification_modes": float(carried.sum() / len(carried))}

    def judge(self, evidence: Evidence) -> Judgement:
        share = evidence.metrics["amplification_modes"]
        if not np.all((share > 0) & (share <= 1)):
            return Verdict.ERROR, "no Fourier mode was followed on at least one level"
        verdict, reason = _largest(evidence.metrics[self.metric], self.bound, "deviation from G^n")
        return verdict, f"{reason}, over {share.min():.0%} of the modes"


def _order(series: Convergence, low: float, high: float) -> Judgement:
    """Judge an order; the fit and the finest step of refinement must agree, or nothing is concluded.

    PASS when the interval lies in the band, the finest step strays from it by no more than `STEP_SLACK`, and the order is not
    falling out of it unchecked. FAIL when the error stops, grows or its interval lies wholly outside, and the finest step
    lies outside on the same side and is not on its way in: levels that are not asymptotic yet accuse nobody. No band reaches
    down to what does not converge, nor beyond `PLAUSIBLE`.
    """
    kind, fit, used = series.classification, series.fit, int(series.kept.sum())
    if kind is Classification.NON_FINITE:
        return Verdict.ERROR, "the error is not finite on at least one level"
    if used < 3 or fit is None:
        return Verdict.INCONCLUSIVE, f"{used} of {len(series.h)} levels can be used ({kind}); an order needs three"
    high = min(high, PLAUSIBLE)
    band = f"[{low:g}, {high:g}]"
    measured = f"order {fit.order:.3f}, interval [{fit.low:.3f}, {fit.high:.3f}] from {used} levels ({kind})"
    if series.dropped:
        measured += f", without {'; '.join(series.dropped)}"
    change, lasts = series.trend()
    step, ahead = series.finest_step(low, high), series.finest_step(low, high, change)
    too_slow, too_fast = max(step, ahead) < 0, min(step, ahead) > 0
    if series.floor is not None:
        reason = f"the error stops at a floor of {series.floor.floor:.2e} of the solution: {measured}"
        return Verdict.FAIL if too_slow else Verdict.INCONCLUSIVE, reason
    if kind in (Classification.STAGNANT, Classification.DIVERGENT):
        return Verdict.FAIL if too_slow else Verdict.INCONCLUSIVE, f"the error does not converge: {measured}"
    if fit.high < low or fit.low > high:
        if too_slow if fit.high < low else too_fast:
            return Verdict.FAIL, f"{measured} lies outside {band}"
        return Verdict.INCONCLUSIVE, f"{measured} lies outside {band}, but the finest levels approach it: add a finer level"
    if not (low <= fit.low and fit.high <= high):
        return Verdict.INCONCLUSIVE, f"{measured} straddles an edge of {band}"
    if series.plunges(high):
        return Verdict.INCONCLUSIVE, f"{measured} lies in {band}, but no such order takes the error to round-off in one step"
    if not abs(step) <= STEP_SLACK or (lasts and ahead < -STEP_SLACK):
        return Verdict.INCONCLUSIVE, f"{measured} lies in {band}, but the finest levels leave it: add a finer level"
    return Verdict.PASS, measured


def _are_sizes(values: Array) -> bool:
    """Whether there are values, all finite and none negative."""
    return bool(len(values) and np.all(np.isfinite(values) & (np.asarray(values) >= 0)))


def _relative(metric: str, defect: Array, scale: float) -> Mapping[str, float]:
    """Largest defect over its scale; nothing is measured on one sample, or on histories that are zero throughout."""
    if len(defect) < 2 or scale == 0:
        return {}
    return {metric: float(np.max(np.abs(defect)) / scale) if np.isfinite(scale) else np.nan}


def _largest(values: Array, bound: float, what: str) -> Judgement:
    if not _are_sizes(values):
        return Verdict.ERROR, f"the {what} is not finite, or negative, on at least one level"
    verdict = Verdict.PASS if values.max() <= bound else Verdict.FAIL
    return verdict, f"largest {what} {values.max():.2e}, bound {bound:g}"


CRITERIA: Mapping[str, type[Any]] = {
    kind.__name__: kind for kind in (Order, Stall, Exact, Published, Balance, EnergyDrift, Amplification)
}
"""Criteria by the name under which files store them."""


@dataclass(frozen=True)
class Finding:
    """One verdict with everything that a reader needs to act on it.

    Parameters
    ----------
    study, case, solver, refinement : str
        What was judged.
    gate : str
        "verification" or "regression".
    criterion : str
        Title of the criterion.
    verdict : Verdict
    reason : str
        What was measured.
    source : str
        Where the expectation comes from.
    """

    study: str
    case: str
    solver: str
    refinement: str
    gate: str
    criterion: str
    verdict: Verdict
    reason: str
    source: str

    def __str__(self) -> str:
        return f"{self.verdict} {self.study}/{self.case}/{self.solver} ({self.refinement}): {self.criterion}: {self.reason}"


def judge(criterion: Criterion, evidence: Evidence) -> Judgement:
    """Judge one criterion; a run that did not complete is an ERROR with its outcome, before any number is looked at."""
    failed = [(h, outcome) for h, outcome in zip(evidence.h, evidence.outcomes, strict=True) if outcome != "completed"]
    if failed:
        return Verdict.ERROR, "; ".join(f"h={h:g}: {outcome}" for h, outcome in failed)
    if not evidence.outcomes:
        return Verdict.ERROR, "no level was run"
    try:
        return criterion.judge(evidence)
    except KeyError as missing:
        return (
            Verdict.ERROR,
            f"{missing} was not measured on this series: the solver does not return it, or the results are old",
        )


def exit_status(verdicts: Sequence[Verdict], *, strict: bool = False) -> int:
    """Exit status of a gate: 0 pass, 1 a gate failed, 3 a run erred, 4 inconclusive under `strict`."""
    verdict = worst(verdicts)
    if verdict is Verdict.INCONCLUSIVE:
        return 4 if strict else 0
    return {Verdict.PASS: 0, Verdict.FAIL: 1, Verdict.ERROR: 3}[verdict]
