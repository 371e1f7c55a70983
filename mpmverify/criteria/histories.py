"""Criteria on histories: what is conserved, and how fast a drift of energy vanishes."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence import PLAUSIBLE, analyse, judge_order
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.judging import are_sizes, judge_largest, relative_defect
from mpmverify.problem import Array, LinearElastic, components
from mpmverify.problem.material import KelvinVoigt, Maxwell
from mpmverify.solution import Solution


@dataclass(frozen=True)
class Balance:
    """A history equals its source term to round-off: mass is constant, momentum changes by the impulse.

    The mass of a body is that of its reference density; other stocks are what they are at first. A vector balances in every
    component.

    Parameters
    ----------
    stock : str
        History, such as "momentum", whatever the number of its components.
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

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        problem = setting.problem.problem
        stocks = components(self.stock, problem.dimension)
        changes = components(self.source_term, problem.dimension) if self.source_term else ()
        if not {*stocks, *changes} <= solution.histories.keys():
            return {}
        stock = np.array([solution.histories[name] for name in stocks]).T
        change = np.array([solution.histories[name] for name in changes]).T if changes else np.zeros_like(stock)
        body = problem.material if self.stock == "mass" else None
        start = body.density * problem.measure if isinstance(body, LinearElastic) else stock[0]
        defect = stock - start - (change - change[0])
        scales = [np.max(np.abs(stock)), np.max(np.abs(change))]
        if self.stock == "momentum" and {"mass", "kinetic_energy"} <= solution.histories.keys():
            # The terms that cancel set the scale of round-off: a momentum of zero is a difference of large ones.
            mass, kinetic = (np.abs(solution.histories[name]) for name in ("mass", "kinetic_energy"))
            scales.append(np.sqrt(2 * np.max(mass * kinetic)))
        return relative_defect(self._metric, defect, np.max(scales))

    def judge(self, evidence: Evidence) -> Judgement:
        return judge_largest(evidence.metrics[self._metric], self.bound, "relative defect")


DRIFT_ROUND_OFF = 1e-11
"""Relative energy drift at and below which nothing drifts."""


DRIFT, RISE = "energy_drift", "energy_rise"


def surplus(solution: Solution, setting: Setting) -> tuple[Array, float] | None:
    """Kinetic and strain energy less external work (N + 1,), and the largest energy [J/m^2]; None where a history is absent.

    With the heat of a viscous law, of which an elastic body makes none, whatever its solver says.
    """
    history = solution.histories
    if not {"kinetic_energy", "strain_energy", "external_work"} <= history.keys():
        return None
    energy = history["kinetic_energy"] + history["strain_energy"]
    total = energy - history["external_work"]
    if isinstance(setting.problem.problem.material, KelvinVoigt | Maxwell) and "dissipated_energy" in history:
        total = total + history["dissipated_energy"]
    return total, float(np.max(np.abs(energy)))


def energy_drift(solution: Solution, setting: Setting) -> Mapping[str, float]:
    """Largest drift of kinetic, strain and dissipated energy less external work, relative to the largest energy."""
    if (found := surplus(solution, setting)) is None:
        return {}
    total, scale = found
    return relative_defect(DRIFT, total - total[0], scale)


@dataclass(frozen=True)
class EnergyDrift:
    """Kinetic, strain and dissipated energy less external work stays: its largest relative drift converges at an order in dt.

    Parameters
    ----------
    low : float
        Least order of the drift in dt; the drift may also be at round-off.
    source : str
    """

    low: float
    source: str

    @property
    def title(self) -> str:
        return f"energy drift vanishes at order {self.low:g} or more"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        return energy_drift(solution, setting)

    def judge(self, evidence: Evidence) -> Judgement:
        drift = evidence.metrics[DRIFT]
        if not are_sizes(drift):
            return Verdict.ERROR, "the energy drift is not finite, or negative, on at least one level"
        if np.all(drift <= DRIFT_ROUND_OFF):
            return Verdict.PASS, f"largest relative drift {drift.max():.1e}: round-off"
        if len(np.unique(evidence.dt)) < len(drift):
            return Verdict.INCONCLUSIVE, f"drift up to {drift.max():.1e}; an order in dt needs another dt on every level"
        verdict, reason = judge_order(analyse(evidence.dt, drift, round_off=DRIFT_ROUND_OFF), self.low, PLAUSIBLE)
        return verdict, f"drift {drift.min():.1e} at best, in dt: {reason}"


@dataclass(frozen=True)
class EnergyConserved:
    """Kinetic, strain and dissipated energy less external work stays, to round-off.

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
        return judge_largest(evidence.metrics[DRIFT], self.bound, "relative energy drift")


@dataclass(frozen=True)
class EnergyDecays:
    """Kinetic plus strain energy less external work never rises, to round-off: a dissipative scheme gives nothing back.

    Parameters
    ----------
    source : str
    bound : float
        Largest rise over the least value before, relative to the largest energy.
    """

    source: str
    bound: float = DRIFT_ROUND_OFF

    @property
    def title(self) -> str:
        return f"energy never rises by more than {self.bound:g}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        if (found := surplus(solution, setting)) is None:
            return {}
        total, scale = found
        return relative_defect(RISE, total - np.minimum.accumulate(total), scale)

    def judge(self, evidence: Evidence) -> Judgement:
        return judge_largest(evidence.metrics[RISE], self.bound, "relative rise of the energy")
