"""Criterion on a solution's agreement with itself: its histories are sums over its own fields."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.judging import judge_largest, relative_defect
from mpmverify.errors import UsageError
from mpmverify.problem import Array, LinearElastic, Problem, Transport
from mpmverify.solution import Solution

NEEDS: Mapping[str, tuple[str, ...]] = {
    "mass": (),
    "momentum": ("velocity",),
    "kinetic_energy": ("velocity",),
    "strain_energy": ("stress",),
}
"""Fields of a body that each stock is a sum over."""
OBSTACLES: Mapping[str, str] = {
    "history": "the solver does not return this history",
    "velocity": "the solver does not return the velocity",
    "stress": "the solver does not return the stress",
    "u": "the solver does not return u",
    "law": "the fields of this material do not tell it: take it out of the stocks",
    "instants": "an output time is not among the times of the histories",
    "motion": "history and fields are zero throughout",
}
"""Why a stock cannot be compared with the fields, by the end of the name of the metric that says so."""


@dataclass(frozen=True)
class FieldSums:
    """The histories are sums over the solution's own fields at the output times, to round-off.

    What balances may be made up all the same, as a momentum and an impulse of zero are: this criterion sees it.

    Parameters
    ----------
    stocks : tuple of str
        The histories that are summed as the fields are sampled, of "mass", "momentum", "kinetic_energy", "strain_energy".
    source : str
    bound : float
        Largest defect relative to the largest sum of magnitudes, of the fields or of the history.

    Raises
    ------
    UsageError
        If no stock is named, or an unknown one.

    Notes
    -----
    A sample point keeps its mass m_p = rho0 w_p(0), since the first weights are reference volumes; its stress acts on w_p(t). So
    mass is sum m_p, momentum sum m_p v_p, kinetic energy sum m_p v_p^2/2, and strain energy of the linear elastic law
    sum w_p sigma_p^2/(2 (lambda + 2 mu)); that of a neo-Hookean body takes its deformation gradient, which is no field. The
    mass of a transported scalar is sum w_p u_p.

    Which of these a scheme obeys is a matter of its quadrature; what it does not obey is not to be declared, for a tolerance as
    large as the difference of two quadratures would hide faults as large:

    - particles carry mass, velocity, stress and volume themselves: all four;
    - finite elements that are sampled where they integrate: mass, momentum, which lumping by row sums does not change, and
      strain energy; kinetic energy with a consistent mass alone, since v^T M v/2 of a lumped one is another quadrature;
    - two-step Taylor-Galerkin sums over nodes by the trapezoidal rule and is sampled in the middle of its elements: both are exact
      of a linear function, thus mass and momentum, and differ by O(h^2) of its square, the energies.
    """

    stocks: tuple[str, ...]
    source: str
    bound: float = 1e-12

    def __post_init__(self) -> None:
        if not self.stocks or not set(self.stocks) <= NEEDS.keys():
            raise UsageError(f"sums of fields are taken of {', '.join(NEEDS)}, not of {self.stocks!r}")

    @property
    def title(self) -> str:
        return f"{', '.join(self.stocks)} summed from the fields to {self.bound:g}"

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        table: dict[str, float] = {}
        for stock in self.stocks:
            table |= _compared(stock, solution, setting.problem.problem)
        return table

    def judge(self, evidence: Evidence) -> Judgement:
        for stock in self.stocks:
            for what, why in OBSTACLES.items():
                if _lacks(stock, what) in evidence.metrics:
                    return Verdict.ERROR, f"{stock} cannot be compared with the fields: {why}"
        defects = {stock: evidence.metrics[_defect(stock)] for stock in self.stocks}
        verdict, reason = judge_largest(np.concatenate(list(defects.values())), self.bound, "relative defect")
        return verdict, f"{reason}, of {max(defects, key=lambda stock: float(np.max(defects[stock])))}"


def _defect(stock: str) -> str:
    return f"{stock}_sum_defect"


def _lacks(stock: str, what: str) -> str:
    return f"{stock}_sum_lacks_{what}"


def _compared(stock: str, solution: Solution, problem: Problem) -> Mapping[str, float]:
    """Defect of one stock, or the obstacle to measuring it."""
    if obstacle := _obstacle(stock, solution, problem):
        return {_lacks(stock, obstacle): 1.0}
    terms, history = _terms(stock, solution, problem), solution.histories[stock][_rows(solution)]
    scale = max(np.max(np.sum(np.abs(terms), axis=1)), np.max(np.abs(history)))
    return relative_defect(_defect(stock), np.sum(terms, axis=1) - history, scale) or {_lacks(stock, "motion"): 1.0}


def _obstacle(stock: str, solution: Solution, problem: Problem) -> str:
    transported, material = isinstance(problem.material, Transport), problem.material
    if stock not in solution.histories:
        return "history"
    if (transported and stock != "mass") or (stock == "strain_energy" and type(material) is not LinearElastic):
        return "law"
    for quantity in ("u",) if transported else NEEDS[stock]:
        if quantity not in solution.fields:
            return quantity
    instants = solution.histories["time"][_rows(solution)]
    return "" if np.all(np.abs(instants - solution.time) <= 1e-9 * problem.end_time) else "instants"


def _rows(solution: Solution) -> np.ndarray:
    """Place of the nearest time of the histories to each output time (T,)."""
    instants = solution.histories["time"]
    return np.searchsorted((instants[1:] + instants[:-1]) / 2, solution.time)


def _terms(stock: str, solution: Solution, problem: Problem) -> Array:
    """What the sample points add to a stock at the output times (T, P)."""
    weight, fields, material = solution.weight, solution.fields, problem.material
    if not isinstance(material, LinearElastic):
        return np.asarray(weight * fields["u"][:, :, 0])
    mass = np.broadcast_to(material.density * weight[0], weight.shape)
    if stock == "mass":
        return mass
    if stock == "strain_energy":
        modulus = material.lame_lambda + 2 * material.shear_modulus
        return np.asarray(weight * fields["stress"][:, :, 0] ** 2 / (2 * modulus))
    velocity = fields["velocity"][:, :, 0]
    return np.asarray(mass * velocity if stock == "momentum" else mass * velocity**2 / 2)
