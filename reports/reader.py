"""Read study files into records."""

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from mpmverify.convergence.sources import Separation
from mpmverify.dataset.criteria import stored_criterion
from mpmverify.dataset.findings import read_lacking
from mpmverify.dataset.history import read_history
from mpmverify.dataset.sources import MEANING, source_of
from mpmverify.dataset.study import parsing, read_study_groups, solvers
from mpmverify.dataset.tree import Group
from mpmverify.errors import UsageError
from mpmverify.judgement.findings import Finding

from .field_reader import read_fields
from .record import Array, Case, Estimate, Level, Measure, Profile, Record, Series


def read(path: Path) -> Record:
    """Read a study file; the record has the name of the file, so that a renamed copy gets a page of its own.

    Raises
    ------
    ResultsError
        If the file is unreadable, foreign or damaged.
    """
    groups = read_study_groups(path, renamed=True)
    with parsing(path):
        return record_of(path.stem, groups)


def record_of(name: str, groups: Mapping[str, Group]) -> Record:
    """Return the record of a study from the groups of its file, read or to be written."""
    root = groups["/"]
    missing = read_lacking(root.attributes)
    return Record(
        name,
        root.attributes,
        tuple(_cases(root.columns)),
        {solver: str(group.attributes["scheme"]) for solver, group in solvers(groups)},
        tuple(entry for solver, group in solvers(groups) for entry in _series(name, solver, group, _within(groups, solver))),
        (dataclasses.replace(missing, study=name),) if missing else (),
        read_history(name, root.attributes, root.columns),
    )


def _within(groups: Mapping[str, Group], solver: str) -> dict[str, Group]:
    """Return the groups of a solver's snapshots and histories by name."""
    place = f"/{solver}/"
    return {name.removeprefix(place): group for name, group in groups.items() if name.startswith(place)}


def _cases(column: Mapping[str, np.ndarray]) -> Iterator[Case]:
    names = ("study_case", "exposes", "citation", "equations", "setup", "shown")
    for name, exposes, citation, equations, setup, shown in zip(*(column[n].tolist() for n in names), strict=True):
        table = tuple((str(k), str(v)) for k, v in json.loads(setup).items())
        yield Case(name, exposes, citation, tuple(json.loads(equations)), table, shown)


def _series(study: str, solver: str, group: Group, within: Mapping[str, Group]) -> Iterator[Series]:
    column = group.columns
    units, declared, judged = group.units, _criteria(column), _judged(column, study, solver)
    profiles = _profiles(within["snapshots"]) if "snapshots" in within else {}
    spatial = [part for name, part in within.items() if name.startswith("snapshots_")]
    fields = {identity: entry for part in spatial for identity, entry in read_fields(part).items()}
    kept = [part for name, part in within.items() if name.startswith("histories")]
    histories = {identity: table for part in kept for identity, table in _histories(part).items()}
    members: dict[tuple[str, str], list[int]] = {}
    for index, identity in enumerate(zip(column["case"].tolist(), column["refinement"].tolist(), strict=True)):
        members.setdefault(identity, []).append(index)
    fits = list(zip(column["series_case"].tolist(), column["series_refinement"].tolist(), strict=True))
    axes = column["series_axis"].tolist()
    separated = _separations(column)
    for identity, unsorted in members.items():
        indices = np.array(unsorted)[np.lexsort([column["ppc"][unsorted], -column["dt"][unsorted], -column["h"][unsorted]])]
        names = [f.name for f in dataclasses.fields(Level)]
        levels = tuple(Level(*entry) for entry in zip(*(column[name][indices].tolist() for name in names), strict=True))
        history, history_units = histories.get(identity, ({}, {}))
        yield Series(
            case=identity[0],
            solver=solver,
            family=str(group.attributes["scheme"]).partition("(")[0],
            refinement=identity[1],
            axis=axes[fits.index(identity)],
            formal=json.loads(group.attributes["orders"]),
            levels=levels,
            estimates=_estimates(column, units, fits.index(identity), indices),
            criteria=declared.get(identity, {}),
            findings=tuple(judged.get(identity, ())),
            metrics=_metrics(column, indices),
            separations=separated.get(identity, {}),
            profile=profiles.get(identity),
            spatial=fields.get(identity),
            histories=history,
            history_units=history_units,
        )


def _judged(column: Mapping[str, np.ndarray], study: str, solver: str) -> dict[tuple[str, str], list[Finding]]:
    """Return the findings by series."""
    table: dict[tuple[str, str], list[Finding]] = {}
    fields = {name.removeprefix("verdict_"): values.tolist() for name, values in column.items() if name.startswith("verdict_")}
    for row in zip(*fields.values(), strict=True):
        finding = Finding.of({"study": study, "solver": solver} | dict(zip(fields, row, strict=True)))
        table.setdefault((finding.case, finding.refinement), []).append(finding)
    return table


def _estimates(
    column: Mapping[str, np.ndarray], units: Mapping[str, str], row: int, indices: np.ndarray
) -> dict[Measure, Estimate]:
    table = {}
    for k, quantity in enumerate(column["quantity"].tolist()):
        for n, norm in enumerate(column["norm"].tolist()):
            error = column["error"][indices, k, n]
            if not np.isfinite(error).any():
                continue
            sentences = tuple(s for s in str(column["dropped"][row, k, n]).split("; ") if s)
            table[quantity, norm] = Estimate(
                error=error,
                absolute=column[f"error_absolute_{quantity}"][indices, n],
                units=units[f"error_absolute_{quantity}"],
                pairwise=column["order_pairwise"][indices, k, n],
                kept=tuple((column["kept"][indices, k, n] == 1).tolist()),
                dropped=sentences,
                order=float(column["order"][row, k, n]),
                low=float(column["order_low"][row, k, n]),
                high=float(column["order_high"][row, k, n]),
                floor=float(column["floor"][row, k, n]),
                classification=str(column["classification"][row, k, n]),
            )
    return table


def _metrics(column: Mapping[str, np.ndarray], indices: np.ndarray) -> dict[str, Array]:
    """Return the quantities that criteria measured on a series, by name."""
    table = {name: column["metric"][indices, k] for k, name in enumerate(column["metric_name"].tolist())}
    return {name: values for name, values in table.items() if np.isfinite(values).any()}


def _criteria(column: Mapping[str, np.ndarray]) -> dict[tuple[str, str], dict[str, Mapping[str, Any]]]:
    """Return the fields of the declared criteria by series and title; one that is unknown here is left out."""
    table: dict[tuple[str, str], dict[str, Mapping[str, Any]]] = {}
    rows = (column[f"criterion_{name}"].tolist() for name in ("case", "refinement", "json"))
    for case, refinement, stored in zip(*rows, strict=True):
        with suppress(UsageError):
            title = stored_criterion(stored, f"case {case!r}").title
            table.setdefault((case, refinement), {})[title] = json.loads(stored)
    return table


def _separations(column: Mapping[str, np.ndarray]) -> dict[tuple[str, str], dict[Measure, Separation]]:
    """Return the separated sources of error by series and measure."""
    table: dict[tuple[str, str], dict[Measure, Separation]] = {}
    names = ("case", "refinement", "quantity", "norm", "obstacle", "residual")
    sizes = column["source"].tolist() if "source" in column else []
    for k, row in enumerate(zip(*(column[f"separation_{name}"].tolist() for name in names if sizes), strict=True)):
        case, refinement, quantity, norm, obstacle, residual = row
        found = [
            source_of({name: float(column[f"source_{name}"][k, j]) for name in MEANING}, size) for j, size in enumerate(sizes)
        ]
        cosine = {
            (sizes[i], sizes[j]): float(value)
            for (i, j), value in np.ndenumerate(column["source_cosine"][k])
            if i < j and np.isfinite(value)
        }
        separation = Separation(tuple(source for source in found if source), cosine, residual, obstacle)
        table.setdefault((case, refinement), {})[quantity, norm] = separation
    return table


def _profiles(snapshots: Group) -> dict[tuple[str, str], Profile]:
    column, units = snapshots.columns, snapshots.units
    kinds = [name for name, entry in snapshots.variables.items() if entry.dimensions == ("obs",) and name != "reference"]
    units = {name.removesuffix("_exact"): unit for name, unit in units.items()}
    ends = np.cumsum(column["row_size"])
    table: dict[tuple[str, str], list[int]] = {}
    for row, identity in enumerate(zip(column["case"].tolist(), column["refinement"].tolist(), strict=True)):
        table.setdefault(identity, []).append(row)
    profiles = {}
    for identity, rows in table.items():
        points = int(column["row_size"][rows[0]])
        begin = int(ends[rows[0]]) - points
        part = slice(begin, begin + points * len(rows))
        reference = column["reference"][begin : begin + points]
        ascending = np.argsort(reference, kind="stable")

        def grid(
            name: str, part: slice = part, shape: tuple[int, int] = (len(rows), points), by: np.ndarray = ascending
        ) -> Array:
            values: Array = column[name][part].reshape(shape)[:, by].astype(float) if name in column else np.full(shape, np.nan)
            return values

        exact = {name: grid(f"{name}_exact") for name in dict.fromkeys(re.sub("_(exact|error)$", "", kind) for kind in kinds)}
        fields = {name: grid(name) if name in column else known + grid(f"{name}_error") for name, known in exact.items()}
        measured = [name for name, values in fields.items() if np.isfinite(values).any()]
        profiles[identity] = Profile(
            h=float(column["h"][rows[0]]),
            time=column["time"][rows],
            reference=reference[ascending],
            fields={name: fields[name] for name in measured},
            exact={name: exact[name] for name in measured},
            units={name: units[name] for name in measured},
        )
    return profiles


def _histories(samples: Group) -> dict[tuple[str, str], tuple[dict[str, Array], dict[str, str]]]:
    column = samples.columns
    units = {name.removeprefix("history_"): unit for name, unit in samples.units.items()}
    ends = np.cumsum(column["row_size"])
    table = {}
    for row, identity in enumerate(zip(column["case"].tolist(), column["refinement"].tolist(), strict=True)):
        part = slice(int(ends[row] - column["row_size"][row]), int(ends[row]))
        parts = {name.removeprefix("history_"): values[part] for name, values in column.items() if name.startswith("history_")}
        table[identity] = {name: values for name, values in parts.items() if np.isfinite(values).any()}, units
    return table
