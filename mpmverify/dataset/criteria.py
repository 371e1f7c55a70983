"""Declared criteria in the dataset of a solver, so that a study's file can be judged without its declaration."""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mpmverify.criteria import CRITERIA
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import SeriesId
from mpmverify.dataset.tree import Group, text, variable
from mpmverify.errors import UsageError

COLUMNS = ("criterion_case", "criterion_refinement", "criterion_json")


def criterion_table(solver: str, declared: Mapping[SeriesId, Sequence[Criterion]]) -> Group:
    """Return the declared criteria of a solver, one row for each criterion."""
    rows = [
        # Every criterion is a dataclass; a protocol cannot express that.
        (series.case, series.refinement, json.dumps({"type": type(one).__name__} | dataclasses.asdict(one)))  # type: ignore[call-overload]
        for series, criteria in declared.items()
        if series.solver == solver
        for one in criteria
    ]
    return Group({name: variable("criterion", text([row[k] for row in rows])) for k, name in enumerate(COLUMNS)})


def read_criteria(solver: str, column: Mapping[str, np.ndarray]) -> dict[SeriesId, tuple[Criterion, ...]]:
    """Return the declared criteria of a solver by series, from the columns of its group.

    Raises
    ------
    UsageError
        If a criterion is unknown or rejects its stored values.
    LookupError, TypeError, ValueError
        If the stored criteria cannot be parsed.
    """
    table: dict[SeriesId, tuple[Criterion, ...]] = {}
    for case, refinement, stored in zip(*(column[name].tolist() for name in COLUMNS), strict=True):
        criterion = stored_criterion(stored, f"case {case!r}")
        series = SeriesId(case, solver, refinement)
        table[series] = (*table.get(series, ()), criterion)
    return table


def stored_criterion(stored: str, where: str) -> Criterion:
    """Return a criterion from its text in JSON; `where` names its place in an error.

    Raises
    ------
    UsageError
        If it is unknown, or rejects its stored values.
    """
    values = json.loads(stored)
    kind = values.pop("type")
    if kind not in CRITERIA:
        raise UsageError(f"the criterion {kind!r} of {where} is unknown: choose from {', '.join(CRITERIA)}")
    criterion: Criterion = CRITERIA[kind](**{name: _frozen(value) for name, value in values.items()})
    return criterion


def _frozen(value: Any) -> Any:
    """Return a JSON value with its lists turned back into tuples."""
    return tuple(_frozen(entry) for entry in value) if isinstance(value, list) else value
