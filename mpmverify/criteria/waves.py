"""Criteria on waves: dispersion of a mode, phase error and decay of a pulse, position of a front."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpmverify.convergence import analyse, judge_order
from mpmverify.criteria.judging import judge_largest
from mpmverify.errors import UsageError
from mpmverify.exact.dispersion import RELATIONS
from mpmverify.gate import Evidence, Judgement, Setting, Verdict, worst
from mpmverify.problem import Array, Problem
from mpmverify.solution import Solution
from mpmverify.waves import amplitude, delay_and_gain, front, jump, modal_history, step_factor

ClosedForm = Callable[[Array, float], Array]
"""Exact values (n,) at positions (n,) [m] and a time [s]."""
REACH, DIFFERENCE = 0.25, 1e-4
"""Largest phase error that is looked for, and the step of its difference quotients, in final times."""


@dataclass(frozen=True)
class Dispersion:
    """A mode turns, and decays, by the scheme's own dispersion relation: omega(k h), not only its order, is right.

    Every step must be returned, and the mode must be alone at its wave number.

    Parameters
    ----------
    relation : str
        Name in `mpmverify.exact.dispersion.RELATIONS`.
    quantity : str
    wavenumber : float
        k [rad/m].
    bound : float
        Largest deviation of the complex frequency -i log(z)/dt of a step, relative to the theoretical one.
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
        if self.relation not in RELATIONS:
            raise UsageError(f"the dispersion relation {self.relation!r} is unknown: choose from {', '.join(RELATIONS)}")

    @property
    def title(self) -> str:
        return f"dispersion of {self.quantity} by {self.relation} to {self.bound:g}"

    @property
    def metrics(self) -> tuple[str, str, str, str]:
        """Deviation, phase angle k h [rad], and frequency over c k: measured and theoretical."""
        names = ("dispersion_defect", "phase_angle", "relative_frequency", "theoretical_frequency")
        return tuple(f"{name}_{self.quantity}" for name in names)  # type: ignore[return-value]

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
        defect = abs(np.log(found) - np.log(theory)) / abs(np.log(theory))
        table = (defect, k * h, np.angle(found) / exact, np.angle(theory) / exact)
        return {name: float(value) for name, value in zip(self.metrics, table, strict=True)}

    def judge(self, evidence: Evidence) -> Judgement:
        defect, angle = (evidence.metrics[name] for name in self.metrics[:2])
        if not np.all((angle > 0) & (angle < np.pi)):
            return Verdict.ERROR, "a mode is not resolved: k h must lie between 0 and pi"
        verdict, reason = judge_largest(defect, self.bound, "deviation of the frequency")
        return verdict, f"{reason}, for k h from {angle.min():.3g} to {angle.max():.3g}"


@dataclass(frozen=True)
class Leading:
    """An error of known leading term: it falls as C h^p, and at the finest level it has the size and the sign of that term.

    Parameters
    ----------
    quantity : str
    order : float
        p.
    slack : float
        Of the order, either way.
    source : str
    leading : float, optional
        C, in 1/m^p; None when the order alone is known.
    tolerance : float
        Of error/(C h^p) - 1 at the finest level.
    """

    quantity: str
    order: float
    slack: float
    source: str
    leading: float | None = None
    tolerance: float = 0.02
    what: ClassVar[str]

    @property
    def title(self) -> str:
        known = "" if self.leading is None else f", leading term {self.leading:.4g}"
        return f"{self.what} of {self.quantity} of order {self.order:.3g}{known}"

    @property
    def metric(self) -> str:
        return f"{self.what.replace(' ', '_')}_{self.quantity}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        exact = setting.problem.exact.fields
        if self.quantity not in solution.fields or self.quantity not in exact or setting.problem.problem.dimension != 1:
            return {}
        field = exact[self.quantity]
        return {
            self.metric: self.error(solution, setting.problem.problem, lambda x, t: field(x[:, None], np.array([t]))[0, :, 0])
        }

    def error(self, solution: Solution, problem: Problem, exact: ClosedForm) -> float:
        """Signed error of a solution; NaN where it has none, because something is not finite or there is no wave."""
        raise NotImplementedError

    def judge(self, evidence: Evidence) -> Judgement:
        error = evidence.metrics[self.metric]
        series = analyse(evidence.h, np.abs(error))
        verdict, reason = judge_order(series, self.order - self.slack, self.order + self.slack)
        if self.leading is None or verdict is Verdict.ERROR:
            return verdict, reason
        finest = np.argmin(evidence.h)
        share = error[finest] / (self.leading * evidence.h[finest] ** self.order)
        kept = abs(share - 1) <= self.tolerance
        return worst([verdict, Verdict.PASS if kept else Verdict.FAIL]), f"{share:.4f} of the leading term, {reason}"


@dataclass(frozen=True)
class PhaseError(Leading):
    """The wave at the final time is late, in parts of that time, by an error of known leading term; early is negative."""

    what = "phase error"

    def error(self, solution: Solution, problem: Problem, exact: ClosedForm) -> float:
        x, end = solution.reference[:, 0], float(solution.time[-1])
        values, weight = solution.fields[self.quantity][-1, :, 0], solution.weight[-1]
        delay, _ = delay_and_gain(values, weight, lambda late: exact(x, end - late), REACH * end, DIFFERENCE * end)
        return delay / end


@dataclass(frozen=True)
class AmplitudeDecay(Leading):
    """The wave loses a part of its root mean square from the first to the last output; growth is negative.

    Both are taken relative to the exact solution at the same points, and the first as what the samples show of the wave.
    """

    what = "amplitude decay"

    def error(self, solution: Solution, problem: Problem, exact: ClosedForm) -> float:
        x, sizes = solution.reference[:, 0], []
        for output in (0, -1):
            weight, known = solution.weight[output], exact(x, float(solution.time[output]))
            sizes.append((amplitude(solution.fields[self.quantity][output, :, 0], weight), amplitude(known, weight)))
        (first, first_exact), (last, last_exact) = sizes
        if not min(first, last, first_exact, last_exact) > 0:
            return math.nan
        return 1 - (last / last_exact) / (first / first_exact)


@dataclass(frozen=True)
class FrontPosition(Leading):
    """The only front of the final time lags behind the exact one, in parts of the body's length; ahead is negative."""

    what = "front lag"

    def error(self, solution: Solution, problem: Problem, exact: ClosedForm) -> float:
        x, end = solution.reference[:, 0], float(solution.time[-1])
        place, level = jump(lambda x: exact(x, end), x)
        before, _ = jump(lambda x: exact(x, (1 - DIFFERENCE) * end), x)
        found = front(x, solution.fields[self.quantity][-1, :, 0], level)
        return math.copysign(1.0, place - before) * (place - found) / problem.lengths[0] if place != before else math.nan
