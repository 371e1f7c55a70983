"""Verdicts of a study that changed since the run before, in its file: the file that is replaced is what they are compared with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from mpmverify.dataset.findings import read_findings
from mpmverify.dataset.tree import Group, text, variable
from mpmverify.judgement.change import Change, Direction, Kind
from mpmverify.judgement.comparison import verdict_changes
from mpmverify.judgement.findings import Finding

RUN, BEFORE = "run_started", "run_before_started"
"""Attributes of a study's file: start of the run that judged the study, and of the run before; the latter is "" if there was none."""
COLUMNS = ("direction", "case", "solver", "refinement", "name", "before", "after")


@dataclass(frozen=True)
class History:
    """Verdicts of a study that changed.

    Parameters
    ----------
    run, before : str
        Start of the run that judged the study, and of the run that had judged it before, by ISO 8601; "" if it is not known, or there
        was none.
    changes : tuple of Change
        The worst first.
    """

    run: str = ""
    before: str = ""
    changes: tuple[Change, ...] = ()


def history(path: Path, run: str, inputs: str, findings: Sequence[Finding], restricted_to: str = "") -> History:
    """Compare the findings of a study with those in the file that is about to be replaced.

    Parameters
    ----------
    path : Path
        File of the study; without a file, or if it cannot be read, there is nothing to compare with.
    run : str
        Start of this run.
    inputs : str
        Digest of everything that the file depends on; "" if the file must be written again at the next run.
    findings : sequence of Finding
        What this run found.
    restricted_to : str
        Part of the study that this run judged. If the file holds another part, only the criteria of both are compared.

    Notes
    -----
    A run that left no file is tried again by the next run, and a study is judged again if its stored verdicts are lost. If that changes
    no verdict, the study keeps the history that it has: there was nothing new to do, and what the run before has changed is still to be
    seen.
    """
    try:
        with netCDF4.Dataset(path) as file:
            kept = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            columns = {name: values[...] for name, values in file.variables.items()}
            found = [
                entry for solver, group in file.groups.items() for entry in read_findings(path.stem, solver, group.variables)
            ]
            changes = verdict_changes(found, findings)
            if not changes and kept["inputs"] in ("", inputs):
                return read_history(path.stem, kept, columns)
            before = kept.get(RUN) or kept["date_created"]
    except (OSError, RuntimeError, AttributeError, LookupError, TypeError, ValueError):
        return History(run)
    if kept.get("restricted_to", "") != restricted_to:
        changes = tuple(change for change in changes if change.kind is Kind.VERDICT)
    return History(run, before, changes)


def change_table(past: History) -> Group:
    """Return the part of a file's root that holds the history of a study, one row for each changed verdict."""
    return Group(
        {f"changed_{name}": variable("change", text([getattr(c, name) or "" for c in past.changes])) for name in COLUMNS},
        attributes={RUN: past.run, BEFORE: past.before},
    )


def read_history(study: str, attributes: Mapping[str, Any], column: Mapping[str, np.ndarray]) -> History:
    """Return the history of a study from the attributes and the columns of the root of its file; an empty one of an older file."""
    if RUN not in attributes:
        return History()
    rows = zip(*(column[f"changed_{name}"].tolist() for name in COLUMNS), strict=True)
    return History(attributes[RUN], attributes[BEFORE], tuple(_change(study, *row) for row in rows))


def _change(study: str, direction: str, case: str, solver: str, refinement: str, name: str, before: str, after: str) -> Change:
    kind = Kind.VERDICT if before and after else Kind.CRITERION
    where = (study, case, solver, refinement)
    return Change(Direction(direction), kind, *where, name=name, before=before or None, after=after or None)
