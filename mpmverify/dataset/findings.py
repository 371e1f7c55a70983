"""Findings in a study's file: those of its series by solver, and the one on what is lacking as an attribute."""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from mpmverify.dataset.tree import text
from mpmverify.judgement.findings import Finding

LACKING = "lacking"
"""Attribute of a study: the finding on what it lacks of the baseline, as JSON."""
COLUMNS = ("case", "refinement", "gate", "criterion", "verdict", "reason", "source")


def with_findings(dataset: xr.Dataset, findings: Sequence[Finding]) -> xr.Dataset:
    """Add the findings of a solver to its dataset, one row a criterion."""
    return dataset.assign(
        {f"verdict_{name}": ("finding", text([str(getattr(finding, name)) for finding in findings])) for name in COLUMNS}
    )


def read_findings(study: str, solver: str, dataset: xr.Dataset) -> list[Finding]:
    """Findings of a solver's dataset."""
    columns = [dataset[f"verdict_{name}"].values.tolist() for name in COLUMNS]
    where = {"study": study, "solver": solver}
    return [Finding.of(where | dict(zip(COLUMNS, row, strict=True))) for row in zip(*columns, strict=True)]


def lacking_attribute(finding: Finding | None) -> dict[str, str]:
    """Attribute that stores the finding on what a study lacks; empty where it lacks nothing."""
    return {LACKING: json.dumps(dataclasses.asdict(finding)) if finding else ""}


def read_lacking(attributes: Mapping[Any, Any]) -> Finding | None:
    """Finding on what a study lacks, by the attributes of its file; None where it lacks nothing."""
    stored = attributes.get(LACKING)
    return Finding.of(json.loads(stored)) if stored else None
