"""Criteria on waves: dispersion of a mode, phase error and amplitude decay of a pulse, position of a front."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpmverify.convergence import ROUND_OFF, analyse, judge_order
from mpmverify.convergence.verdict import Judgement, Verdict, worst
from mpmverify.criteria.bounds import judge_largest
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence, absent, first_absent
from mpmverify.criteria.measurements import amplitude, delay_and_gain, modal_history, step_factor
from mpmverify.errors import UsageError
from mpmverify.exact.dispersion import RELATIONS, front_lag, leading_errors
from mpmverify.exact.waves import front, jump
from mpmverify.problem import Array
from mpmverify.solution import Solution

ClosedForm = Callable[[Array, float], Array]
"""Exact values (n,) at positions (n,) [m] and a time [s]."""
REACH, DIFFERENCE = 0.25, 1e-4
"""Largest phase error that is searched, and the step of the difference quotients; both are fractions of the final time."""


def check_relation(relation: str) -> None:
    """Raise a `UsageError` if there is no dispersion relation of this name."""
    if relation not in RELATIONS:
        raise UsageError(f"the dispersion relation {relation!r} is unknown: choose from {', '.join(RELATIONS)}")


@dataclass(frozen=True)
class Dispersion:
    """A mode oscillates and decays according to the dispersion relation of the scheme.

    This verifies the value of omega(k h), not only its order. The solution must contain every time step, and no other mode with the
    same wave number.

    Parameters
    ----------
    relation : str
        Name in `mpmverify.exact.dispersion.RELATIONS`.
    quantity : str
    wavenumber : float
        k [rad/m].
    bound : float
        Largest deviation of the complex frequency -i log(z)/dt, relative to the theoretical one; z is the factor of one time step.
    source : str

    Raises
    ------
    UsageError
        If the relation is unknown.
    """

    relation: str
    quantity: str
    wavenumber: float
    bound: float
    source: str

    def __post_init__(self) -> None:
        check_relation(self.relation)

    @property
    def title(self) -> str:
        return f"dispersion of {self.quantity} by {self.relation} to {self.bound:g}"

    @property
    def metrics(self) -> tuple[str, str, str, str]:
        """Names of the deviation, the phase angle k h [rad], and the measured and the theoretical frequency over c k."""
        of = self.quantity
        return f"dispersion_defect_{of}", f"phase_angle_{of}", f"relative_frequency_{of}", f"theoretical_frequency_{of}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        problem, time = setting.problem.problem, solution.time
        every = len(time) > 1 and np.allclose(np.diff(time), solution.dt, rtol=1e-9, atol=0)
        if self.quantity not in solution.fields or problem.dimension != 1 or not every:
            return {}
        c, h, k = problem.material.wave_speed, setting.discretisation.h, self.wavenumber
        exact = k * c * solution.dt
        (theory,) = RELATIONS[self.relation](np.array([k * h]), c * solution.dt / h, setting.discretisation.ppc)
        values, weight = solution.fields[self.quantity][:, :, 0], solution.weight[0]
        found = step_factor(modal_history(values, solution.reference[:, 0], weight, k))
        if np.isnan(found) and np.all(np.isfinite(values)):
            return {absent(self.metrics[0]): 1.0}
        defect = abs(np.log(found) - np.log(theory)) / abs(np.log(theory))
        table = (defect, k * h, np.angle(found) / exact, np.angle(theory) / exact)
        return {name: float(value) for name, value in zip(self.metrics, table, strict=True)}

    def judge(self, evidence: Evidence) -> Judgement:
        if where := first_absent(self.metrics[0], evidence):
            return Verdict.FAIL, f"the mode of {self.quantity} does not oscillate at {where}"
        defect, angle = (evidence.metrics[name] for name in self.metrics[:2])
        if not np.all((angle > 0) & (angle < np.pi)):
            return Verdict.ERROR, "a mode is not resolved: k h must lie between 0 and pi"
        verdict, reason = judge_largest(defect, self.bound, "deviation of the frequency")
        return verdict, f"{reason}, for k h from {angle.min():.3g} to {angle.max():.3g}"


def closed_form(quantity: str, solution: Solution, setting: Setting) -> ClosedForm | None:
    """Exact field of a quantity on a bar; None unless the problem is 1D and both the exact solution and the solution have it."""
    field = setting.problem.exact.fields.get(quantity)
    if field is None or quantity not in solution.fields or setting.problem.problem.dimension != 1:
        return None
    return lambda x, t: field(x[:, None], np.array([t]))[0, :, 0]


@dataclass(frozen=True)
class LeadingTerm:
    """A signed error of the wave at the final time converges to the leading error term of the dispersion relation.

    This verifies the size and the sign of the error, not only its order.

    Parameters
    ----------
    quantity : str
    order : float
        Expected order of the error.
    slack : float
        Half-width of the accepted band of orders.
    source : str
    relation : str
        Name in `mpmverify.exact.dispersion.RELATIONS`.
    factor : float
        Factor of the leading term, factor * coefficient * h^order [1/m^order]; the relation gives the coefficient [1].
    tolerance : float
        Accepted deviation of the error from the leading term at the finest level, relative to the term.

    Raises
    ------
    UsageError
        If the relation is unknown.
    """

    quantity: str
    order: float
    slack: float
    source: str
    relation: str
    factor: float
    tolerance: float = 0.02
    what: ClassVar[str]

    def __post_init__(self) -> None:
        check_relation(self.relation)

    @property
    def title(self) -> str:
        return f"{self.what} of {self.quantity} of order {self.order:g} by {self.relation}"

    @property
    def metric(self) -> str:
        return f"{self.what.replace(' ', '_')}_{self.quantity}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        exact = closed_form(self.quantity, solution, setting)
        if exact is None:
            return {}
        error = self.error(solution, exact)
        if math.isnan(error) and np.all(np.isfinite(solution.fields[self.quantity])):
            return {absent(self.metric): 1.0}
        return {self.metric: error}

    def error(self, solution: Solution, exact: ClosedForm) -> float:
        """Return the signed error of a solution; NaN if a value is not finite or there is no wave."""
        raise NotImplementedError

    @staticmethod
    def coefficient(lag: float, loss: float) -> float:
        """Select one of the two leading error coefficients of a relation: that of the phase lag or that of the amplitude loss."""
        raise NotImplementedError

    def judge(self, evidence: Evidence) -> Judgement:
        if where := first_absent(self.metric, evidence):
            return Verdict.FAIL, f"no wave of {self.quantity} is found at {where}"
        error = evidence.metrics[self.metric]
        verdict, reason = judge_order(analyse(evidence.h, np.abs(error)), self.order - self.slack, self.order + self.slack)
        finest = np.argmin(evidence.h)
        leading = leading_errors(self.relation, float(evidence.courant[finest]), int(evidence.ppc[finest]))
        term = self.factor * self.coefficient(*leading) * evidence.h[finest] ** self.order
        if verdict is Verdict.ERROR:
            return verdict, reason
        if abs(term) <= ROUND_OFF:
            if np.all(np.abs(error) <= ROUND_OFF):
                return Verdict.PASS, "at round-off on every level: the relation has no such error"
            return worst([verdict, Verdict.INCONCLUSIVE]), f"{reason}; the relation has no leading term to compare it with"
        share = error[finest] / term
        kept = Verdict.PASS if abs(share - 1) <= self.tolerance else Verdict.FAIL
        return worst([verdict, kept]), f"{share:.4f} of the leading term at h={evidence.h[finest]:g}, {reason}"


@dataclass(frozen=True)
class PhaseError(LeadingTerm):
    """Delay of the wave at the final time, as a fraction of that time; negative if the wave is early."""

    what = "phase error"

    @staticmethod
    def coefficient(lag: float, loss: float) -> float:
        return lag

    def error(self, solution: Solution, exact: ClosedForm) -> float:
        x, end = solution.reference[:, 0], float(solution.time[-1])
        values, weight = solution.fields[self.quantity][-1, :, 0], solution.weight[-1]
        delay, _ = delay_and_gain(values, weight, lambda late: exact(x, end - late), REACH * end, DIFFERENCE * end)
        return delay / end


@dataclass(frozen=True)
class AmplitudeDecay(LeadingTerm):
    """Relative loss of the root mean square of the wave from the first to the last output; negative if it grows.

    Both root mean squares are taken relative to that of the exact solution at the same points. The first output accounts for any
    smoothing by the sampling.
    """

    what = "amplitude decay"

    @staticmethod
    def coefficient(lag: float, loss: float) -> float:
        return loss

    def error(self, solution: Solution, exact: ClosedForm) -> float:
        x, sizes = solution.reference[:, 0], []
        for output in (0, -1):
            weight, known = solution.weight[output], exact(x, float(solution.time[output]))
            sizes.append((amplitude(solution.fields[self.quantity][output, :, 0], weight), amplitude(known, weight)))
        (first, first_exact), (last, last_exact) = sizes
        if not min(first, last, first_exact, last_exact) > 0:
            return math.nan
        return 1 - (last / last_exact) / (first / first_exact)


@dataclass(frozen=True)
class FrontPosition:
    """At the final time, the lag of the single front behind the exact one agrees with the dispersion relation of the scheme.

    Parameters
    ----------
    quantity : str
    relation : str
        Name in `mpmverify.exact.dispersion.RELATIONS`.
    cells : float
        Largest deviation of the lag [cells].
    source : str

    Raises
    ------
    UsageError
        If the relation is unknown.
    """

    quantity: str
    relation: str
    cells: float
    source: str

    def __post_init__(self) -> None:
        check_relation(self.relation)

    @property
    def title(self) -> str:
        return f"front of {self.quantity} to {self.cells:g} cells where {self.relation} has it"

    @property
    def metrics(self) -> tuple[str, str]:
        """Names of the measured and the theoretical lag [cells]; a lag is negative if the front is ahead."""
        return f"front_lag_{self.quantity}", f"theoretical_front_lag_{self.quantity}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        exact, at = closed_form(self.quantity, solution, setting), setting.discretisation
        if exact is None:
            return {}
        x, end = solution.reference[:, 0], float(solution.time[-1])
        place, level = jump(lambda x: exact(x, end), x)
        before, _ = jump(lambda x: exact(x, (1 - DIFFERENCE) * end), x)
        found = front(x, solution.fields[self.quantity][-1, :, 0], level)
        lag = math.copysign(1.0, place - before) * (place - found) / at.h if place != before else math.nan
        courant = setting.problem.problem.material.wave_speed * solution.dt / at.h
        theory = front_lag(self.relation, courant, round(end / solution.dt), at.ppc)
        if math.isnan(lag) and np.all(np.isfinite(solution.fields[self.quantity])):
            return {absent(self.metrics[0]): 1.0}
        return dict(zip(self.metrics, (lag, theory), strict=True))

    def judge(self, evidence: Evidence) -> Judgement:
        if where := first_absent(self.metrics[0], evidence):
            return Verdict.FAIL, f"no front of {self.quantity} is found at {where}"
        lag, theory = (evidence.metrics[name] for name in self.metrics)
        finest = np.argmin(evidence.h)
        verdict, reason = judge_largest(np.abs(lag - theory), self.cells, "deviation in cells")
        return verdict, f"{reason}; it lags by {lag[finest]:.3f} cells at h={evidence.h[finest]:g}"
