"""Read the fields of runs in two and three dimensions from a study file."""

import re
from collections.abc import Mapping

import numpy as np

from mpmverify.dataset.tree import Group

from .record import Array, Field


def read_fields(snapshots: Group) -> dict[tuple[str, str], Field]:
    """Read the fields of a group `snapshots_2d` or `snapshots_3d`.

    Parameters
    ----------
    snapshots : Group
        With contiguous ragged arrays: one row per output time, one variable per component.

    Returns
    -------
    dict of (str, str) to Field
        Fields by case and refinement.
    """
    column, units = snapshots.columns, snapshots.units
    sampled = [name for name, entry in snapshots.variables.items() if entry.dimensions == ("obs",)]
    axes = [name for name in sampled if name.startswith("reference_")]
    stored = [name for name in sampled if name not in axes]
    ends = np.cumsum(column["row_size"])
    table: dict[tuple[str, str], list[int]] = {}
    for row, identity in enumerate(zip(column["case"].tolist(), column["refinement"].tolist(), strict=True)):
        table.setdefault(identity, []).append(row)
    fields = {}
    for identity, rows in table.items():
        points = int(column["row_size"][rows[0]])
        begin = int(ends[rows[0]]) - points
        values = {name: column[name][begin : begin + points * len(rows)].reshape(len(rows), points) for name in stored}
        fields[identity] = _field(
            h=float(column["h"][rows[0]]),
            time=column["time"][rows].astype(float),
            reference=np.stack([column[name][begin : begin + points] for name in axes], axis=1).astype(float),
            values={name: part.astype(float) for name, part in values.items() if np.isfinite(part).any()},
            units=units,
        )
    return fields


def _field(h: float, time: Array, reference: Array, values: Mapping[str, Array], units: Mapping[str, str]) -> Field:
    """Sort the stored variables into numerical fields, exact fields and errors."""
    names = dict.fromkeys(re.sub("_(exact|error)$", "", name) for name in values)
    exact = {name: values[f"{name}_exact"] for name in names if f"{name}_exact" in values}
    nowhere = np.full((len(time), len(reference)), np.nan)
    error = {name: values.get(f"{name}_error", nowhere) for name in exact}
    with np.errstate(over="ignore", invalid="ignore"):  # of an unstable run
        sums = {name: exact[name] + error[name] for name in exact}
    return Field(
        h=h,
        time=time,
        reference=reference,
        numerical={name: values[name] if name in values else sums[name] for name in names},
        exact=exact,
        error=error,
        units={name: units.get(f"{name}_exact", units.get(name, "1")) for name in names},
    )
