"""The catalogue: one module for each verification problem, with its closed forms as pure functions of (X, t).

Here belong exact and manufactured solutions, dispersion relations and stability limits of schemes, each with its source. Error
norms and criteria do not: a closed form does not know what is demanded of a solver.
"""

from mpmverify.exact.solution import ExactSolution, VerificationProblem

__all__ = ["ExactSolution", "VerificationProblem"]
