"""An exact solution, and the verification problem that pairs it with its initial-boundary-value problem."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mpmverify.problem import Array, Problem

ExactField = Callable[[Array, Array], Array]
"""Closed form: reference positions (P, dim) [m], times (T,) [s] -> values (T, P, components)."""


@dataclass(frozen=True)
class ExactSolution:
    """Closed-form fields of (X, t) with their source.

    Parameters
    ----------
    fields : mapping of str to ExactField
        Closed form by quantity, in the reference position X (at small strain X = x).
    citation : str
        Where the formula comes from.
    derivatives : float
        Regularity: the number s of derivatives that every field has in L1; 1 for a jump, 2 for a kink, infinite when smooth.
    """

    fields: Mapping[str, ExactField]
    citation: str
    derivatives: float = math.inf


@dataclass(frozen=True)
class VerificationProblem:
    """A problem, its exact solution and the error that it exposes.

    Parameters
    ----------
    problem : Problem
    exact : ExactSolution
    exposes : str
        What error this problem exposes, one sentence.
    equations : tuple of str
        Governing equations, initial and boundary conditions and the closed form, each as LaTeX.
    """

    problem: Problem
    exact: ExactSolution
    exposes: str
    equations: tuple[str, ...]
