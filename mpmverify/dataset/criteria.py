"""Criteria in the dataset of a solver: a file can be judged alone."""

import dataclasses
import json
from collections.abc import Sequence
from typing import Any

import xarray as xr

from mpmverify.criteria import CRITERIA
from mpmverify.dataset.study import text
from mpmverify.errors import UsageError
from mpmverify.gate import Criterion


def with_criteria(dataset: xr.Dataset, declared: Sequence[tuple[str, str, Criterion]]) -> xr.Dataset:
    """Add the declared criteria (case, refinement, criterion) of a solver to its dataset, so that a file can be judged alone."""
    rows = [
        # A criterion is a frozen dataclass, which its protocol cannot say.
        (case, refinement, json.dumps({"type": type(criterion).__name__} | dataclasses.asdict(criterion)))  # type: ignore[call-overload]
        for case, refinement, criterion in declared
    ]
    names = ("criterion_case", "criterion_refinement", "criterion_json")
    return dataset.assign({name: ("criterion", text([row[k] for row in rows])) for k, name in enumerate(names)})


def criteria(dataset: xr.Dataset) -> list[tuple[str, str, Criterion]]:
    """Declared criteria of a solver's dataset."""
    names = ("criterion_case", "criterion_refinement", "criterion_json")
    table = []
    for case, refinement, stored in zip(*(dataset[name].values.tolist() for name in names), strict=True):
        values = json.loads(stored)
        kind = values.pop("type")
        if kind not in CRITERIA:
            raise UsageError(f"the criterion {kind!r} of {case!r} is unknown: choose from {', '.join(CRITERIA)}")
        table.append((case, refinement, CRITERIA[kind](**{name: _frozen(value) for name, value in values.items()})))
    return table


def _frozen(value: Any) -> Any:
    """JSON knows no tuples."""
    return tuple(_frozen(entry) for entry in value) if isinstance(value, list) else value
