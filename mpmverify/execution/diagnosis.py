"""Diagnosis of a solver from its levels on studies, if the table of signatures is of the same problems."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

from mpmverify.criteria.evidence import Level
from mpmverify.errors import ResultsError
from mpmverify.exact import VerificationProblem
from mpmverify.execution.keys import canonical
from mpmverify.judgement.diagnosis import diagnosis, measured, read_signatures, signature
from mpmverify.study import Study

DIGITS = 9
"""Significant digits of the numbers of a problem: processors and libraries differ in the last ones."""


def diagnose(studies: Sequence[Study], levels: Mapping[str, Sequence[Level]], solver: str) -> str:
    """Say which planted faults leave errors like those of a solver; "" if none is similar enough.

    Parameters
    ----------
    studies : sequence of Study
        With the cases that were run.
    levels : mapping of str to sequence of Level
        Levels by the name of their study.
    solver : str
        Name of the solver.

    Returns
    -------
    str
        A sentence, or why there is none: the table of signatures is of other problems of the same names.
    """
    try:
        known = read_signatures().problems
    except ResultsError as error:
        return f"no cause is known: {error}"
    found: dict[str, float] = {}
    for study in studies:
        name = study.name.removesuffix(f"-with-{solver}")
        for case in study.cases:
            place = f"{name} | {case.name}"
            if place in known and known[place] != problem_digest(case.problem):
                return (
                    f"no cause is known: the table of signatures is of another problem than {name}, {case.name}: "
                    "make it with `mpmverify selftest --signatures FILE`"
                )
        found |= signature(name, map(measured, (level for level in levels[study.name] if level.solver == solver)))
    return diagnosis(found)


def problem_digest(problem: VerificationProblem) -> str:
    """Digest of the values of a problem and of its exact fields, whatever code they stand for; numbers count to `DIGITS`."""
    body = json.dumps(_rounded(canonical([problem.problem, problem.exact.fields], set())), sort_keys=True)
    return hashlib.sha256(body.encode()).hexdigest()[:16]


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, dict):
        return {name: _rounded(entry) for name, entry in value.items()}
    return [_rounded(entry) for entry in value] if isinstance(value, list) else value
