"""Catalogue of verification problems: one module for each, with its closed forms as pure functions of (X, t).

What is known of schemes in closed form belongs here, too: amplification factors, dispersion relations, stability limits and orders on
rough data. Everything has its source. Error norms
and criteria do not.
"""

from mpmverify.exact.solution import ExactSolution, VerificationProblem

__all__ = ["ExactSolution", "VerificationProblem"]
