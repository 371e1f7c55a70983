"""Findings in a study's file: one row each in the dataset of their solver; missing baseline entries as an attribute."""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from mpmverify.dataset.tree import text
from mpmverify.judgement.findings import Finding

LACKING = "lacking"
"""Attribute of a study's file: the finding on baseline entries that were not run, as JSON."""
COLUMNS = ("case", "refinement", "gate", "criterion", "verdict", "reason", "source", "limit")


def with_findings(dataset: xr.Dataset, findings: Sequence[Finding]) -> xr.Dataset:
    """Return the dataset of a solver with its findings added, one row for each criterion."""
    return dataset.assign(
        {f"verdict_{name}": ("finding", text([str(getattr(finding, name)) for finding in findings])) for name in COLUMNS}
    )


def read_findings(study: str, solver: str, dataset: xr.Dataset | netCDF4.Group) -> list[Finding]:
    """Return the findings of a solver."""
    columns = [np.asarray(dataset[f"verdict_{name}"][...]).tolist() for name in COLUMNS]
    where = {"study": study, "solver": solver}
    return [Finding.of(where | dict(zip(COLUMNS, row, strict=True))) for row in zip(*columns, strict=True)]


def lacking_attribute(finding: Finding | None) -> dict[str, str]:
    """Return the attribute that stores the finding on missing baseline entries; "" if none is missing."""
    return {LACKING: json.dumps(dataclasses.asdict(finding)) if finding else ""}


def read_lacking(attributes: Mapping[Any, Any]) -> Finding | None:
    """Return the finding on missing baseline entries from the attributes of a study's file; None if none is missing."""
    stored = attributes.get(LACKING)
    return Finding.of(json.loads(stored)) if stored else None
