"""Criteria on histories: conservation of mass and momentum, and their closed forms."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.bounds import judge_largest, relative_defect
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence, first_absent
from mpmverify.errors import UsageError
from mpmverify.problem import Array, LinearElastic, components
from mpmverify.solution import Solution

OF_POINTS = "momentum_of_points"
"""Name of the metric."""
FAR = 0.25
"""Share of what moves by which the momentum of a scheme may differ from that of its sample points. A history of zeros balances."""


@dataclass(frozen=True)
class Balance:
    """A conserved quantity changes by its source term alone, to round-off: mass is constant, momentum changes by the impulse.

    The mass of a body is compared with the integral of its reference density; every other quantity with its initial value. A vector
    must balance in every component.

    Parameters
    ----------
    stock : str
        History of the conserved quantity, such as "momentum", without a component suffix.
    source_term : str
        History that accounts for its change, such as "impulse"; "" if it must stay constant.
    source : str
    bound : float
        Largest defect relative to the largest magnitude in the two histories. For momentum, the sum of the magnitudes of the momenta
        at the sample points also counts: round-off scales with them, even if they cancel.
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
            else f"{self.stock} conserved" + f" to {self.bound:g}" * (self.bound > Balance.bound)
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
        scale = max(np.max(np.abs(stock)), np.max(np.abs(change)))
        if self.stock != "momentum" or not isinstance(problem.material, LinearElastic):
            return relative_defect(self._metric, defect, scale)
        moved, density = moved_momentum(solution, problem.material.density), problem.material.density
        found = relative_defect(self._metric, defect, max(scale, moved))
        apart = _apart(solution, stock, density, moved)
        return {**found, OF_POINTS: apart} if apart > FAR else found

    def judge(self, evidence: Evidence) -> Judgement:
        if where := first_absent(self._metric, evidence):
            return Verdict.ERROR, f"nothing to balance: {self.stock} and all that moves are zero throughout at {where}"
        if self.stock == "momentum" and OF_POINTS in evidence.metrics:
            off = f"off by up to {np.nanmax(evidence.metrics[OF_POINTS]):.2g} of what moves"
            return Verdict.FAIL, f"the momentum is not the sum of density x volume x velocity over the sample points: {off}"
        return judge_largest(evidence.metrics[self._metric], self.bound, "relative defect")


def _apart(solution: Solution, stock: Array, density: float, moved: float) -> float:
    """Largest difference of a momentum from that of the sample points at the output times, as a share of what moves."""
    velocity = solution.fields.get("velocity")
    if velocity is None or moved == 0:
        return 0.0
    sums = np.einsum("p,tpi->ti", density * solution.weight[0], velocity)
    stored = np.stack([np.interp(solution.time, solution.histories["time"], p) for p in stock.T], axis=1)
    return float(np.max(np.abs(sums - stored))) / moved


@dataclass(frozen=True)
class ExactTotal:
    """A history agrees with its closed form after every step, to round-off: the momentum of a loaded body, for example.

    `Balance` compares a momentum with the impulse of the same solver, which a load of the wrong size or direction changes alike.

    Parameters
    ----------
    stock : str
        History, such as "momentum", without a component suffix; a vector must agree in every component.
    source : str
    bound : float
        Largest deviation relative to the largest magnitude of a component of the closed form.
    """

    stock: str
    source: str
    bound: float = 1e-12

    @property
    def title(self) -> str:
        return f"{self.stock} exact to {self.bound:g}"

    @property
    def _metric(self) -> str:
        return f"{self.stock}_error"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        """Return the largest relative deviation.

        Raises
        ------
        UsageError
            If the exact solution has no such total, or it is zero throughout.
        """
        problem, names = setting.problem.problem, components(self.stock, setting.problem.problem.dimension)
        if not set(names) <= solution.histories.keys():
            return {}
        known = setting.problem.exact.totals.get(self.stock)
        exact = np.zeros(0) if known is None else known(solution.histories["time"])
        if not np.any(exact):
            raise UsageError(f"the exact {self.stock} of {problem.name!r} is unknown or zero throughout: judge it by Balance")
        defect = np.array([solution.histories[name] for name in names]).T - exact
        return relative_defect(self._metric, defect, float(np.max(np.abs(exact))))

    def judge(self, evidence: Evidence) -> Judgement:
        return judge_largest(evidence.metrics[self._metric], self.bound, f"relative error of the {self.stock}")


def moved_momentum(solution: Solution, density: float) -> float:
    """Largest sum over the sample points of |m_p v_p| at an output time, in the unit of the momentum.

    Every solution has what this needs: m_p is the reference density times the first weight, and v_p the field "velocity" or else the
    change of the position from one output time to the next.
    """
    velocity = solution.fields.get("velocity")
    if velocity is None:
        velocity = np.diff(solution.position, axis=0) / np.diff(solution.time)[:, None, None]
    return float(density * np.max(np.linalg.norm(velocity, axis=2) @ solution.weight[0], initial=0.0))
