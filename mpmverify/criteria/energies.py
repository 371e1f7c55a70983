"""Criteria on the energy balance: the order of its drift, conservation to round-off, and decay."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence import PLAUSIBLE, analyse, judge_order
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.bounds import finite_and_non_negative, judge_largest, relative_defect
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence, first_absent
from mpmverify.problem import Array, Fixed, LinearElastic, Periodic, Problem, Traction, Velocity
from mpmverify.problem.material import KelvinVoigt, Maxwell
from mpmverify.solution import Solution

DRIFT_ROUND_OFF = 1e-11
"""Relative energy drift at and below which the drift is round-off."""

DRIFT, RISE = "energy_drift", "energy_rise"
"""Names of the metrics."""
OF_POINTS = "kinetic_energy_of_points"
"""Name of the metric of kinetic energies that are made up."""
FAR = 0.25
"""Share of what is exchanged by which the kinetic energy of a scheme may differ from that of its sample points."""
SAME_TIME = 1e-9
"""Difference of two times that are the same, relative to the last one."""


def energy_balance(solution: Solution, setting: Setting) -> tuple[Array, float] | None:
    """Energy balance of a run: kinetic plus strain energy less external work.

    For a viscous material the dissipated energy is added. For an elastic one it is not, even if the solver returns such a history.
    Where no load does work, the energy must balance by itself, too: no loss may be called external work.

    Returns
    -------
    (Array, float) or None
        The balance after each of N steps, (N + 1, 1), or both balances of a body without loads, (N + 1, 2); and their scale, the largest
        kinetic plus strain energy. Both have the unit of the histories. None if a history is missing.
    """
    history, problem = solution.histories, setting.problem.problem
    if not {"kinetic_energy", "strain_energy", "external_work"} <= history.keys():
        return None
    energy = history["kinetic_energy"] + history["strain_energy"]
    totals = [energy - history["external_work"], *([] if _loaded(problem) else [energy])]
    total = np.stack(totals, axis=1)
    if isinstance(problem.material, KelvinVoigt | Maxwell) and "dissipated_energy" in history:
        total = total + history["dissipated_energy"][:, None]
    return total, float(np.max(np.abs(energy)))


def _loaded(problem: Problem) -> bool:
    """Whether a body force, a traction or a moving face can do work on the body."""
    idle = (Fixed(), Periodic(), Traction(), Velocity())
    return problem.body_force is not None or any(condition not in idle for condition in problem.boundary.values())


def energy_drift(solution: Solution, setting: Setting) -> Mapping[str, float]:
    """Largest drift of the energy balance, relative to the largest energy."""
    if (found := energy_balance(solution, setting)) is None:
        return {}
    total, scale = found
    return {**relative_defect(DRIFT, total - total[0], scale), **kinetic_apart(solution, setting)}


def kinetic_apart(solution: Solution, setting: Setting) -> Mapping[str, float]:
    """Largest difference of the kinetic energy from that of the sample points, as a share of what is exchanged; empty up to `FAR`.

    It is measured at the output times at which the histories have a value. What is exchanged is at most the largest kinetic energy of
    the points and the range of the strain energy. A solution without velocities is not looked at.
    """
    material, velocity = setting.problem.problem.material, solution.fields.get("velocity")
    history, end = solution.histories, float(solution.time[-1])
    if velocity is None or not {"kinetic_energy", "strain_energy"} <= history.keys() or not isinstance(material, LinearElastic):
        return {}
    row = np.searchsorted(history["time"], solution.time - SAME_TIME * end).clip(max=len(history["time"]) - 1)
    known = np.abs(history["time"][row] - solution.time) <= SAME_TIME * end
    sums = 0.5 * material.density * (np.sum(velocity**2, axis=2) @ solution.weight[0])
    scale = float(np.max(sums) + np.ptp(history["strain_energy"]))
    if scale == 0 or not known.any():
        return {}
    apart = float(np.max(np.abs(sums - history["kinetic_energy"][row])[known])) / scale if np.all(np.isfinite(sums)) else np.inf
    return {OF_POINTS: apart} if apart > FAR else {}


def _unbalanced(evidence: Evidence, metric: str) -> Judgement | None:
    """Judge energies that are zero throughout, or not those of the sample points; None of others."""
    if where := first_absent(metric, evidence):
        return Verdict.ERROR, f"no energy to balance: kinetic and strain energy are zero throughout at {where}"
    apart = evidence.metrics.get(OF_POINTS, np.full(len(evidence.h), np.nan))[evidence.h == evidence.h.min()]
    if not np.all(np.isnan(apart)):  # on coarse levels energies half a step apart may differ as much
        off = f"off by up to {np.nanmax(apart):.2g} of what is exchanged"
        return Verdict.FAIL, f"the kinetic energy is not the sum of mass x |velocity|^2 / 2 over the sample points: {off}"
    return None


@dataclass(frozen=True)
class EnergyDrift:
    """The relative drift of kinetic, strain and dissipated energy less external work converges to zero with dt.

    Parameters
    ----------
    low : float
        Lowest accepted order of the drift in dt; the drift may also be at round-off.
    source : str
    round_off : float
        Relative drift at and below which it is round-off.
    """

    low: float
    source: str
    round_off: float = DRIFT_ROUND_OFF

    @property
    def title(self) -> str:
        return f"energy drift vanishes at order {self.low:g} or more"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        return energy_drift(solution, setting)

    def judge(self, evidence: Evidence) -> Judgement:
        if (unbalanced := _unbalanced(evidence, DRIFT)) is not None:
            return unbalanced
        drift = evidence.metrics[DRIFT]
        if not finite_and_non_negative(drift):
            return Verdict.ERROR, "the energy drift is not finite, or negative, on at least one level"
        if np.all(drift <= self.round_off):
            return Verdict.PASS, f"largest relative drift {drift.max():.1e}: round-off"
        if len(np.unique(evidence.dt)) < len(drift):
            return Verdict.INCONCLUSIVE, f"drift up to {drift.max():.1e}; an order in dt needs another dt on every level"
        verdict, reason = judge_order(analyse(evidence.dt, drift, round_off=self.round_off, size="dt"), self.low, PLAUSIBLE)
        return verdict, f"drift {drift.min():.1e} at best, in dt: {reason}"


@dataclass(frozen=True)
class EnergyConserved:
    """Kinetic, strain and dissipated energy less external work is constant to round-off.

    Parameters
    ----------
    source : str
    bound : float
        Largest relative drift.
    """

    source: str
    bound: float = DRIFT_ROUND_OFF

    @property
    def title(self) -> str:
        return f"energy conserved to {self.bound:g}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        return energy_drift(solution, setting)

    def judge(self, evidence: Evidence) -> Judgement:
        if (unbalanced := _unbalanced(evidence, DRIFT)) is not None:
            return unbalanced
        return judge_largest(evidence.metrics[DRIFT], self.bound, "relative energy drift")


@dataclass(frozen=True)
class EnergyDecays:
    """Kinetic, strain and dissipated energy less external work never increases by more than round-off, as in a dissipative scheme.

    Parameters
    ----------
    source : str
    bound : float
        Largest increase over the smallest earlier value, relative to the largest energy.
    """

    source: str
    bound: float = DRIFT_ROUND_OFF

    @property
    def title(self) -> str:
        return f"energy never rises by more than {self.bound:g}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        if (found := energy_balance(solution, setting)) is None:
            return {}
        total, scale = found
        rise = relative_defect(RISE, total - np.minimum.accumulate(total, axis=0), scale)
        return {**rise, **kinetic_apart(solution, setting)}

    def judge(self, evidence: Evidence) -> Judgement:
        if (unbalanced := _unbalanced(evidence, RISE)) is not None:
            return unbalanced
        return judge_largest(evidence.metrics[RISE], self.bound, "relative rise of the energy")
