"""One study as one DataTree: levels, errors, fits and verdicts by solver, with the profiles that the pages show.

Layout
------
/                    case metadata, provenance
/<solver>            error(level, quantity, norm), absolute errors and exact norms by quantity, fits by series, verdicts by criterion
/<solver>/snapshots  fields of one level of each series: contiguous ragged arrays, one row an output time, one variable a component
/<solver>/histories  energy, momentum, mass and impulse of the same runs: contiguous ragged arrays, one row a series

Runs in two and three dimensions have components and units of their own: theirs are `snapshots_2d`, `histories_3d` and so on.
"""

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mpmverify.atomic import write_atomic
from mpmverify.dataset import provenance
from mpmverify.dataset.files import check_ours
from mpmverify.dataset.level import Level, SeriesId, Snapshots
from mpmverify.dataset.statement import statement
from mpmverify.dataset.tree import write_tree
from mpmverify.errors import ResultsError
from mpmverify.norms import NORMS
from mpmverify.quantities import UNITS, components, history_units
from mpmverify.study import Study

DIMENSIONS = {1: "", 2: "_2d", 3: "_3d"}
"""Suffix of the groups that hold the runs in so many dimensions."""


def build(
    study: Study,
    tier: str,
    inputs: str,
    levels: Sequence[Level],
    snapshots: Mapping[SeriesId, Snapshots],
) -> xr.DataTree:
    """Make the tree of a study, without fits and verdicts."""
    groups = {"/": _root(study, tier, inputs, sorted({level.seed for level in levels if level.jitter}))}
    for _, series in study.series():
        name = series.solver.name
        if f"/{name}" in groups:
            continue
        mine = [level for level in levels if level.solver == name]
        groups[f"/{name}"] = _levels(mine).assign_attrs(
            solver=name, scheme=_describe(series.solver), orders=json.dumps(dict(series.solver.orders))
        )
        shown = [shot for (_, solver, _), shot in snapshots.items() if solver == name]
        for dimension, suffix in DIMENSIONS.items():
            if alike := [shot for shot in shown if shot.reference.shape[1] == dimension]:
                groups[f"/{name}/snapshots{suffix}"] = _profiles(alike, dimension)
                groups[f"/{name}/histories{suffix}"] = _histories(alike, dimension)
    return xr.DataTree.from_dict(groups)


def _describe(value: Any) -> str:
    choices = ", ".join(f"{f.name}={getattr(value, f.name)!r}" for f in dataclasses.fields(value))
    return f"{type(value).__name__}({choices})"


def text(values: Sequence[str]) -> np.ndarray:
    return np.array(list(values), dtype=object if len(values) else "U1")


def _root(study: Study, tier: str, inputs: str, seeds: Sequence[int]) -> xr.Dataset:
    def each(read: Any) -> tuple[str, np.ndarray]:
        return "study_case", text([read(case) for case in study.cases])

    return xr.Dataset(
        {
            "exposes": each(lambda case: case.problem.exposes),
            "citation": each(lambda case: case.problem.exact.citation),
            "equations": each(lambda case: json.dumps(case.problem.equations)),
            "setup": each(lambda case: json.dumps(statement(case.problem.problem), ensure_ascii=False)),
            "shown": each(lambda case: case.shown),
        },
        # Not "case", which the solvers' groups have by level: a group inherits the dimensions of its parent.
        coords={"study_case": each(lambda case: case.name)},
        attrs=provenance.attributes("study", study.title, study.summary)
        | {
            "id": study.name,
            "tier": tier,
            "restricted_to": study.restricted_to,
            "inputs": inputs,
            "seeds": ", ".join(map(str, seeds)) or "none: no run is random",
        },
    )


def _levels(levels: Sequence[Level]) -> xr.Dataset:
    quantities = list(dict.fromkeys(quantity for level in levels for quantity in level.errors))
    metrics = sorted({name for level in levels for name in level.metrics})
    absent = np.full(len(NORMS), np.nan)
    table = np.array([[level.errors.get(q, (absent, absent)) for q in quantities] for level in levels], dtype=float)
    table = table.reshape(len(levels), len(quantities), 2, len(NORMS))
    error, size = table[:, :, 0], table[:, :, 1]

    def each(read: Any, units: str | None = None, long_name: str = "") -> tuple[str, Any, dict[str, str]]:
        values = [read(level) for level in levels]
        if units is None:
            return "level", text(values), {"long_name": long_name}
        return "level", np.array(values), {"units": units, "long_name": long_name}

    return xr.Dataset(
        {
            "error": (
                ("level", "quantity", "norm"),
                error / np.where(size > 0, size, 1.0),
                {
                    "units": "1",
                    "long_name": "error relative to the exact norm",
                    "comment": "absolute where the exact norm is 0",
                },
            ),
            "metric": (
                ("level", "metric_name"),
                np.array([[level.metrics.get(name, np.nan) for name in metrics] for level in levels]).reshape(
                    len(levels), len(metrics)
                ),
                {"units": "1", "long_name": "what the criteria measured on the solutions"},
            ),
            "steps": each(lambda level: level.steps, "1", "time steps"),
            "point_steps": each(lambda level: level.point_steps, "1", "particles or elements times steps"),
            "seconds": each(lambda level: level.seconds, "s", "wall time without compilation"),
            "outcome": each(lambda level: level.outcome, None, "how the run ended"),
            "run": each(lambda level: level.key, None, "key of the run file"),
        }
        | {
            f"{name}_{quantity}": (
                ("level", "norm"),
                values[:, k],
                {"units": UNITS[quantity], "long_name": f"{of} {quantity}; L1 and L2 are means over the body"},
            )
            for k, quantity in enumerate(quantities)
            for name, values, of in (
                ("error_absolute", error, "norm of the error of"),
                ("exact_norm", size, "norm of the exact"),
            )
        },
        coords={
            "case": each(lambda level: level.case, None, "case"),
            "refinement": each(lambda level: level.refinement, None, "ladder"),
            "h": each(lambda level: level.h, "m", "cell size"),
            "dt": each(lambda level: level.dt, "s", "time step"),
            "courant": each(lambda level: level.courant, "1", "Courant number"),
            "ppc": each(lambda level: level.ppc, "1", "particles per cell"),
            "jitter": each(lambda level: level.jitter, "1", "largest displacement of a particle as a share of the spacing"),
            "seed": each(lambda level: level.seed, "1", "seed of the displacements"),
            "quantity": ("quantity", text(quantities)),
            "norm": ("norm", text(NORMS)),
            "metric_name": ("metric_name", text(metrics)),
        },
    )


def _profiles(shots: Sequence[Snapshots], dimension: int) -> xr.Dataset:
    variables: dict[str, Any] = {}

    def put(quantity: str, suffix: str, read: Any, long_name: str, attributes: Mapping[str, str]) -> None:
        names = components(quantity, dimension)
        absent = [np.full((*shot.position.shape[:2], len(names)), np.nan) for shot in shots]
        columns = [
            np.asarray(read(shot, blank), dtype=float).reshape(-1, len(names))
            for shot, blank in zip(shots, absent, strict=True)
        ]
        for name, values in zip(names, np.concatenate(columns).T, strict=True):
            shown = name.replace(quantity, long_name).replace("_", " ")
            variables[name + suffix] = ("obs", values, {**attributes, "long_name": shown})

    put("reference", "", lambda s, _: np.broadcast_to(s.reference, s.position.shape), "reference position", {"units": "m"})
    put("position", "", lambda s, _: s.position, "current position", {"units": "m"})
    places = " ".join(("time", *components("position", dimension)))
    for quantity in dict.fromkeys(quantity for shot in shots for quantity in shot.fields):
        attributes = {"units": UNITS[quantity], "coordinates": places}
        put(quantity, "", lambda s, blank, q=quantity: s.fields.get(q, blank), quantity, attributes)
        put(quantity, "_exact", lambda s, blank, q=quantity: s.exact.get(q, blank), f"exact {quantity}", attributes)
    rows = [(shot, t) for shot in shots for t in shot.time]
    return xr.Dataset(
        variables,
        coords={
            "case": ("output", text([shot.case for shot, _ in rows])),
            "refinement": ("output", text([shot.refinement for shot, _ in rows])),
            "h": ("output", np.array([shot.h for shot, _ in rows]), {"units": "m", "long_name": "cell size"}),
            "time": ("output", np.array([t for _, t in rows]), {"units": "s", "long_name": "output time"}),
            "row_size": (
                "output",
                np.array([len(shot.reference) for shot, _ in rows]),
                {"units": "1", "long_name": "points of the profile", "sample_dimension": "obs"},
            ),
        },
    )


def _histories(shots: Sequence[Snapshots], dimension: int) -> xr.Dataset:
    names = list(dict.fromkeys(name for shot in shots for name in shot.histories))
    variables = {}
    units = history_units(dimension, transported=any("u" in shot.fields for shot in shots))
    for name in names:
        columns = [shot.histories.get(name, np.full(len(shot.histories["time"]), np.nan)) for shot in shots]
        attributes = {"units": units[name], "long_name": name.replace("_", " ")}
        variables[f"history_{name}"] = ("obs", np.concatenate(columns), attributes)
    return xr.Dataset(
        variables,
        # Not "series", which a solver's fits are of: those of its series that left no run to show have no histories.
        coords={
            "case": ("shown", text([shot.case for shot in shots])),
            "refinement": ("shown", text([shot.refinement for shot in shots])),
            "row_size": (
                "shown",
                np.array([len(shot.histories["time"]) for shot in shots]),
                {"units": "1", "long_name": "samples of the history", "sample_dimension": "obs"},
            ),
        },
    )


# Reading back: the same numbers, for the judge and for the pages.


def solvers(tree: xr.DataTree) -> Iterator[tuple[str, xr.Dataset]]:
    for name, node in tree.children.items():
        yield name, node.to_dataset(inherit=False)


def write_study(path: Path, tree: xr.DataTree) -> None:
    """Write a tree whole; a foreign file at `path` is never overwritten."""
    if path.exists():
        check_ours(path, "study")
    write_atomic(path, lambda temporary: write_tree(temporary, tree))


def read_study(path: Path) -> xr.DataTree:
    """Read a tree into memory.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, foreign, damaged or that of another study than its name says.
    """
    study = check_ours(path, "study").get("id")
    if study != path.stem:
        raise ResultsError(f"'{path}' holds the study {study!r}: rename it to '{study}.nc', or move it away")
    try:
        with xr.open_datatree(path, engine="netcdf4") as tree:
            return tree.load()
    except (OSError, RuntimeError, ValueError) as error:
        raise ResultsError(f"'{path}' is damaged: delete it and run `mpmverify run` again") from error
