"""Criterion on the consistency of a solution: its histories must equal sums over its own fields."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.bounds import judge_largest, relative_defect
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.errors import UsageError
from mpmverify.problem import Array, LinearElastic, Problem, Transport, components
from mpmverify.problem.quantities import multiplicity
from mpmverify.solution import Solution

NEEDS: Mapping[str, tuple[str, ...]] = {
    "mass": (),
    "momentum": ("velocity",),
    "kinetic_energy": ("velocity",),
    "strain_energy": ("stress",),
}
"""Fields over which each history of a body is summed."""
OBSTACLES: Mapping[str, str] = {
    "history": "the solver does not return this history",
    "velocity": "the solver does not return the velocity",
    "stress": "the solver does not return the stress",
    "u": "the solver does not return u",
    "law": "it cannot be computed from the fields of this material: remove it from the stocks",
    "instants": "an output time is not among the times of the histories",
    "motion": "history and fields are zero throughout",
}
"""Why a history cannot be compared with the fields, by the last part of the name of the metric that records it."""


@dataclass(frozen=True)
class FieldSums:
    """At the output times, the histories equal sums over the fields of the same solution, to round-off.

    This detects invented histories, which `Balance` cannot: a momentum and an impulse that are both zero balance.

    Parameters
    ----------
    stocks : tuple of str
        Histories to compare: of "mass", "momentum", "kinetic_energy" and "strain_energy".
    source : str
    bound : float
        Largest defect, relative to the larger of the sum of the magnitudes over the fields and the magnitude of the history.

    Raises
    ------
    UsageError
        If no history is given, or an unknown one.

    Notes
    -----
    A sample point has the constant mass m_p = rho0 V_p. Its reference volume V_p is its first weight where the weights stay as they
    are; weights w_p(t) that change are current volumes, and V_p = w_p(0)/J_p(0) with the given initial deformation.
    Mass is sum m_p, momentum sum m_p v_p in each direction, kinetic energy sum m_p |v_p|^2/2, and strain energy of the linear elastic
    law in d dimensions sum w_p (sigma_p : sigma_p - lambda/(d lambda + 2 mu) (tr sigma_p)^2)/(4 mu), where two dimensions are those of
    plane strain. In one that is w_p sigma_p^2/(2 (lambda + 2 mu)). The strain energy of other laws needs the deformation gradient,
    which is not among the fields. The mass of a transported scalar is sum w_p u_p.

    Which sums hold depends on the quadrature of the scheme. Declare only those that hold exactly, because a tolerance as large as the
    difference of two quadratures would hide faults of that size:

    - Particles carry mass, velocity, stress and volume: all four hold.
    - Finite elements sampled at their quadrature points: mass, momentum (row-sum lumping does not change it) and strain energy hold.
      Kinetic energy holds with a consistent mass matrix only; with a lumped one, v^T M v/2 is another quadrature.
    - Two-step Taylor-Galerkin sums over nodes by the trapezoidal rule and is sampled at element midpoints. Both rules are exact for
      linear functions, so mass and momentum hold. For the squares in the energies they differ by O(h^2).
    """

    stocks: tuple[str, ...]
    source: str
    bound: float = 1e-12

    def __post_init__(self) -> None:
        if not self.stocks or not set(self.stocks) <= NEEDS.keys():
            raise UsageError(f"{self.stocks!r} cannot be compared with sums of fields: choose from {', '.join(NEEDS)}")

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
    """Relative defect of one history, or a metric that records why it cannot be compared."""
    if obstacle := _obstacle(stock, solution, problem):
        return {_lacks(stock, obstacle): 1.0}
    terms = _terms(stock, solution, problem)
    history = np.stack([solution.histories[name][_rows(solution)] for name in components(stock, problem.dimension)], axis=1)
    scale = max(np.max(np.sum(np.abs(terms), axis=1)), np.max(np.abs(history)))
    if len(history) < 2 or scale == 0:
        return {_lacks(stock, "motion"): 1.0}
    return relative_defect(_defect(stock), np.sum(terms, axis=1) - history, scale)


def _obstacle(stock: str, solution: Solution, problem: Problem) -> str:
    transported, material = isinstance(problem.material, Transport), problem.material
    if not set(components(stock, problem.dimension)) <= solution.histories.keys():
        return "history"
    if (transported and stock != "mass") or (stock == "strain_energy" and type(material) is not LinearElastic):
        return "law"
    for quantity in ("u",) if transported else NEEDS[stock]:
        if quantity not in solution.fields:
            return quantity
    instants = solution.histories["time"][_rows(solution)]
    return "" if np.all(np.abs(instants - solution.time) <= 1e-9 * problem.end_time) else "instants"


def _rows(solution: Solution) -> np.ndarray:
    """Index of the history time nearest to each output time (T,)."""
    instants = solution.histories["time"]
    return np.searchsorted((instants[1:] + instants[:-1]) / 2, solution.time)


def _terms(stock: str, solution: Solution, problem: Problem) -> Array:
    """Contribution of each sample point to the C components of a history at the output times (T, P, C)."""
    weight, fields, material = solution.weight[:, :, None], solution.fields, problem.material
    if not isinstance(material, LinearElastic):
        return np.asarray(weight * fields["u"])
    mass = np.broadcast_to((material.density * _reference_volume(solution, problem))[:, None], weight.shape)
    if stock == "mass":
        return mass
    if stock == "strain_energy":
        return weight * _energy(fields["stress"], material, problem.dimension)
    velocity = fields["velocity"]
    return np.asarray(mass * velocity if stock == "momentum" else mass * np.sum(velocity**2, axis=2, keepdims=True) / 2)


def _reference_volume(solution: Solution, problem: Problem) -> Array:
    """Reference volume of each sample point (P,): its first weight, less the initial volume change where weights are current volumes."""
    first = solution.weight[0]
    if "displacement_gradient" not in problem.initial or np.all(solution.weight == first):
        return first
    gradient = problem.initial_field("displacement_gradient", solution.reference)
    F = np.eye(problem.dimension) + gradient.reshape(-1, problem.dimension, problem.dimension)
    return np.asarray(first / np.linalg.det(F))


def _energy(stress: Array, material: LinearElastic, dimension: int) -> Array:
    """Strain energy of the linear elastic law, of plane strain in two dimensions, per volume at each point (T, P, 1) [J/m^3]."""
    lame, shear = material.lame_lambda, material.shear_modulus
    trace = np.sum(stress[:, :, :dimension], axis=2)
    squares = np.sum(multiplicity("stress", dimension) * stress**2, axis=2)
    return np.asarray((squares - lame / (dimension * lame + 2 * shear) * trace**2) / (4 * shear))[:, :, None]
