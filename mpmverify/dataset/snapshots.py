"""Fields and histories of one run of each series, for the report, as contiguous ragged arrays.

Fields are in single precision: nothing is judged by them. A field is stored as the exact one and its error, so that a small error
keeps its digits; their sum is the numerical field, which is stored itself only where no exact one is known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mpmverify.dataset.tree import Group, Variable, text, variable
from mpmverify.problem import Array
from mpmverify.problem.quantities import UNITS, components, history_units

DIMENSIONS = {1: "", 2: "_2d", 3: "_3d"}
"""Suffix of the groups by dimension of the runs, whose components and units differ."""


@dataclass(frozen=True)
class Snapshots:
    """Fields and histories of one run, with T output times, P points and N samples of the histories.

    Parameters
    ----------
    case, refinement : str
        Series of the run.
    h : float
        Cell size [m].
    time : Array
        Output times (T,) [s].
    reference : Array
        Reference positions of the sample points (P, dim) [m].
    fields, exact : mapping of str to Array
        Numerical and exact fields (T, P, components) by quantity.
    histories : mapping of str to Array
        Histories (N,) by name.
    """

    case: str
    refinement: str
    h: float
    time: Array
    reference: Array
    fields: Mapping[str, Array]
    exact: Mapping[str, Array]
    histories: Mapping[str, Array]


def snapshot_groups(shots: Sequence[Snapshots]) -> dict[str, Group]:
    """Return the groups of a solver's snapshots and histories by name: "snapshots", "histories_2d" and so on."""
    groups = {}
    for dimension, suffix in DIMENSIONS.items():
        if selected := [shot for shot in shots if shot.reference.shape[1] == dimension]:
            groups[f"snapshots{suffix}"] = _profiles(selected, dimension)
            groups[f"histories{suffix}"] = _histories(selected, dimension)
    return groups


def _profiles(shots: Sequence[Snapshots], dimension: int) -> Group:
    variables: dict[str, Variable] = {}

    def put(quantity: str, suffix: str, read: Any, long_name: str, attributes: Mapping[str, str]) -> None:
        names = components(quantity, dimension)
        absent = [np.full((*_samples(shot), len(names)), np.nan) for shot in shots]
        columns = [np.asarray(read(shot, blank)).reshape(-1, len(names)) for shot, blank in zip(shots, absent, strict=True)]
        for name, values in zip(names, np.concatenate(columns).T, strict=True):
            shown = name.replace(quantity, long_name).replace("_", " ")
            variables[name + suffix] = variable("obs", values, {**attributes, "long_name": shown})

    place = {"units": "m"}
    put("reference", "", lambda s, _: np.tile(s.reference, (len(s.time), 1)), "reference position", place)
    places = " ".join(("time", *components("reference", dimension)))
    for quantity in dict.fromkeys(quantity for shot in shots for quantity in shot.fields):
        attributes = {"units": UNITS[quantity], "coordinates": places}
        owners = [shot for shot in shots if quantity in shot.fields]
        if not all(quantity in shot.exact for shot in owners):
            put(quantity, "", lambda s, blank, q=quantity: _single(s.fields.get(q, blank)), quantity, attributes)
        if any(quantity in shot.exact for shot in owners):
            put(
                quantity, "_exact", lambda s, blank, q=quantity: _single(s.exact.get(q, blank)), f"exact {quantity}", attributes
            )
            put(quantity, "_error", lambda s, blank, q=quantity: _error(s, q, blank), f"error of {quantity}", attributes)
    rows = [(shot, t) for shot in shots for t in shot.time]
    return Group(
        variables,
        {
            "case": variable("output", text([shot.case for shot, _ in rows])),
            "refinement": variable("output", text([shot.refinement for shot, _ in rows])),
            "h": variable("output", [shot.h for shot, _ in rows], {"units": "m", "long_name": "cell size"}),
            "time": variable("output", [t for _, t in rows], {"units": "s", "long_name": "output time"}),
            "row_size": variable(
                "output",
                [len(shot.reference) for shot, _ in rows],
                {"units": "1", "long_name": "points of the profile", "sample_dimension": "obs"},
            ),
        },
    )


def _single(values: Array) -> Array:
    with np.errstate(over="ignore"):  # of an unstable run
        return np.asarray(values, dtype=np.float32)


def _error(shot: Snapshots, quantity: str, blank: Array) -> Array:
    return _single(shot.fields.get(quantity, blank) - shot.exact.get(quantity, blank))


def _samples(shot: Snapshots) -> tuple[int, int]:
    return len(shot.time), len(shot.reference)


def _histories(shots: Sequence[Snapshots], dimension: int) -> Group:
    names = list(dict.fromkeys(name for shot in shots for name in shot.histories))
    variables = {}
    units = history_units(dimension, transported=any("u" in shot.fields for shot in shots))
    for name in names:
        columns = [shot.histories.get(name, np.full(len(shot.histories["time"]), np.nan)) for shot in shots]
        attributes = {"units": units[name], "long_name": name.replace("_", " ")}
        variables[f"history_{name}"] = variable("obs", np.concatenate(columns), attributes)
    return Group(
        variables,
        # The dimension is not "series", the dimension of the fits: a series without a run to show has fits but no histories.
        {
            "case": variable("shown", text([shot.case for shot in shots])),
            "refinement": variable("shown", text([shot.refinement for shot in shots])),
            "row_size": variable(
                "shown",
                [len(shot.histories["time"]) for shot in shots],
                {"units": "1", "long_name": "samples of the history", "sample_dimension": "obs"},
            ),
        },
    )
