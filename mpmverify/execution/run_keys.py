"""Content keys of runs: what is solved and measured, and the code of both."""

import json
from collections.abc import Sequence

from mpmverify.criteria.criterion import Criterion, measurement
from mpmverify.criteria.errors import ErrorCriterion
from mpmverify.dataset.files import SCHEMA
from mpmverify.exact import VerificationProblem
from mpmverify.execution.keys import canonical, digest, reduced
from mpmverify.problem import Discretisation
from mpmverify.solution import Solver

EVALUATION = "mpmverify.execution.evaluation"
"""Module that measures a run."""


def run_keys(
    problem: VerificationProblem, solver: Solver, discretisations: Sequence[Discretisation], criteria: Sequence[Criterion] = ()
) -> list[str]:
    """Content key of each of some runs: what is solved and what is measured, the code of both and the numerical libraries.

    Parameters
    ----------
    problem : VerificationProblem
        Its texts are not in the keys.
    solver : Solver
    discretisations : sequence of Discretisation
        Of the runs.
    criteria : sequence of Criterion
        What they measure is in the keys. What they accept is not: a stored run can be judged anew.

    Raises
    ------
    UsageError
        If one of them is not a value; see `digest`.
    """
    code = {EVALUATION}
    measured = set()
    for criterion in criteria:
        if not isinstance(criterion, ErrorCriterion):
            code.add(type(criterion).__module__)
            measured.add(json.dumps([type(criterion).__qualname__, canonical(measurement(criterion), code)]))
    fixed = [reduced(part) for part in (problem.problem, problem.exact, solver)]
    return [digest(SCHEMA, *fixed, level, sorted(measured), code=code) for level in discretisations]
