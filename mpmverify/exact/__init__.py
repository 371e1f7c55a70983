"""Catalogue of verification problems: one module for each, with its closed forms as pure functions of (X, t).

Exact and manufactured solutions, dispersion relations and stability limits of schemes belong here, each with its source. Error norms
and criteria do not.
"""

from mpmverify.exact.solution import ExactSolution, VerificationProblem

__all__ = ["ExactSolution", "VerificationProblem"]
