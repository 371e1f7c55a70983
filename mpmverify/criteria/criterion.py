"""Protocol of a criterion: it measures quantities on each solution and judges the evidence of a series."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from numbers import Real
from typing import Any, ClassVar, Protocol, get_type_hints

from mpmverify.convergence.verdict import Judgement
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.norms import NORMS
from mpmverify.exact import VerificationProblem
from mpmverify.problem import UNITS, Discretisation
from mpmverify.solution import Solution


@dataclass(frozen=True)
class Setting:
    """Problem, with its exact solution, and discretisation of a run."""

    problem: VerificationProblem
    discretisation: Discretisation


class Criterion(Protocol):
    """A requirement on a series of runs."""

    @property
    def source(self) -> str:
        """Source of the expectation, such as a citation."""

    @property
    def title(self) -> str:
        """Short description of what is judged."""

    def measure(self, solution: Solution, setting: Setting) -> Mapping[str, float]:
        """Return the numbers that the judgement needs from a solution, in addition to its error norms, by name."""

    def judge(self, evidence: Evidence) -> Judgement:
        """Return the verdict on the runs of a series, with the reason in one sentence."""


JUDGED = frozenset({"source", "low", "high", "bound", "limit", "cells", "slack", "tolerance", "round_off"})
"""Fields of criteria that `judge` reads and `measure` does not: a measured run can be judged by others."""


def measurement(criterion: Criterion) -> dict[str, Any]:
    """Return what the numbers that a criterion measures depend on: its fields by name, except those that are only `JUDGED`."""
    # Every criterion is a dataclass; a protocol cannot express that.
    named = (entry.name for entry in fields(criterion))  # type: ignore[arg-type]
    return {name: getattr(criterion, name) for name in named if name not in JUDGED}


def misdeclared(criterion: Any) -> str:
    """Say which field of a criterion has a value that it cannot have; "" when none has."""
    if not is_dataclass(criterion) or isinstance(criterion, type):
        return f"{criterion!r} is no criterion: see mpmverify.criteria"
    kinds = get_type_hints(type(criterion))
    for entry in fields(criterion):
        name, value, kind = entry.name, getattr(criterion, entry.name), kinds[entry.name]
        where = f"{name} of the criterion {type(criterion).__name__} is {value!r}"
        if kind is float and (not isinstance(value, Real) or isinstance(value, bool) or math.isnan(value)):
            return f"{where}, and must be a number"
        if kind is str and not isinstance(value, str):
            return f"{where}, and must be a text"
        if name == "quantity" and value not in UNITS:
            return f"{where}: choose from {', '.join(UNITS)}"
        if name == "norm" and value not in NORMS:
            return f"{where}: choose from {', '.join(NORMS)}"
    return ""


class OnOutcomes:
    """Base class of criteria on the outcomes of runs: judged even when runs did not complete."""


class OnLimits:
    """Base class of criteria that expect a known limit of the scheme, a stall or an instability.

    Their PASS says that the scheme has this limit, and reads as such. They say what of a run is compared with the baseline, because the
    errors beyond a limit are not as reproducible as others.
    """

    marker: ClassVar[str] = "known limit"

    @property
    def change(self) -> float:
        """Relative change of the compared values up to which a run counts as unchanged."""
        raise NotImplementedError

    def compared(self, evidence: Evidence, level: int) -> Mapping[str, tuple[float, float]]:
        """Return the values of one level that are compared with the baseline, each with the size to which round-off is relative."""
        return errors_of_level(evidence, level)


def errors_of_level(evidence: Evidence, level: int) -> dict[str, tuple[float, float]]:
    """Return the error norms of one level by "quantity norm", each with the size of the exact field."""
    return {
        f"{quantity} {norm}": (float(table[level, n]), float(evidence.reference[quantity][level, n]))
        for quantity, table in evidence.error.items()
        for n, norm in enumerate(NORMS)
    }
