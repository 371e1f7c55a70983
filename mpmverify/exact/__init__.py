"""Catalogue of closed forms: each a pure function of (X, t) beside the problem that it solves."""

from mpmverify.exact.solution import ExactSolution, VerificationProblem

__all__ = ["ExactSolution", "VerificationProblem"]
