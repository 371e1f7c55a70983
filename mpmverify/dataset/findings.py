"""Findings in a study's file: one row each in the dataset of their solver; missing baseline entries as an attribute."""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mpmverify.dataset.tree import Group, text, variable
from mpmverify.judgement.findings import Finding

LACKING = "lacking"
"""Attribute of a study's file: the finding on baseline entries that were not run, as JSON."""
COLUMNS = ("case", "refinement", "gate", "criterion", "verdict", "reason", "source", "limit")


def finding_table(findings: Sequence[Finding]) -> Group:
    """Return the findings of a solver, one row for each criterion."""
    return Group(
        {f"verdict_{name}": variable("finding", text([getattr(finding, name) for finding in findings])) for name in COLUMNS}
    )


def read_findings(study: str, solver: str, column: Mapping[str, Any]) -> list[Finding]:
    """Return the findings of a solver from the columns of its group, or the variables of an open file."""
    columns = [np.asarray(column[f"verdict_{name}"][...]).tolist() for name in COLUMNS]
    where = {"study": study, "solver": solver}
    return [Finding.of(where | dict(zip(COLUMNS, row, strict=True))) for row in zip(*columns, strict=True)]


def lacking_attribute(finding: Finding | None) -> dict[str, str]:
    """Return the attribute that stores the finding on missing baseline entries; "" if none is missing."""
    return {LACKING: json.dumps(dataclasses.asdict(finding)) if finding else ""}


def read_lacking(attributes: Mapping[Any, Any]) -> Finding | None:
    """Return the finding on missing baseline entries from the attributes of a study's file; None if none is missing."""
    stored = attributes.get(LACKING)
    return Finding.of(json.loads(stored)) if stored else None
