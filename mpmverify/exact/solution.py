"""Exact solutions, and verification problems: an initial-boundary-value problem together with its exact solution."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from mpmverify.problem import Array, Problem

ExactField = Callable[[Array, Array], Array]
"""Closed form: reference positions (P, dim) [m], times (T,) [s] -> values (T, P, components)."""
Total = Callable[[Array], Array]
"""Closed form of a sum over the whole body: times (T,) [s] -> values (T, components)."""


@dataclass(frozen=True)
class ExactSolution:
    """Closed-form fields of (X, t), with their regularity and source.

    Parameters
    ----------
    fields : mapping of str to ExactField
        Closed form by quantity, as a function of the reference position X (at small strain X = x).
    citation : str
        Source of the formulas.
    derivatives : float
        Regularity: the number s of derivatives in L1 that every field has; 1 for a jump, 2 for a kink, infinite for smooth fields.
    totals : mapping of str to Total
        Closed form of histories that are known, such as "momentum" and "angular_momentum", see `Solution`.
    """

    fields: Mapping[str, ExactField]
    citation: str
    derivatives: float = math.inf
    totals: Mapping[str, Total] = field(default_factory=dict)


@dataclass(frozen=True)
class VerificationProblem:
    """A problem, its exact solution and the errors that it exposes.

    Parameters
    ----------
    problem : Problem
    exact : ExactSolution
    exposes : str
        The errors of a solver that this problem exposes, as one sentence.
    equations : tuple of str
        Governing equations, initial and boundary conditions and the closed form, each as LaTeX.
    """

    problem: Problem
    exact: ExactSolution
    exposes: str
    equations: tuple[str, ...]
