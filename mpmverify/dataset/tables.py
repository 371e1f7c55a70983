"""A results folder as flat tables: what two folders can be compared by, read from the files of its studies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from mpmverify.baseline import levels
from mpmverify.dataset.evidence import evidence, series_of
from mpmverify.dataset.study import read_study, solvers
from mpmverify.dataset.verdicts import damage, findings
from mpmverify.gate import Verdict, worst
from mpmverify.norms import NORMS

PROVENANCE = ("commit", "commit_state", "tier", "versions", "platform", "date_created")


class SeriesKey(NamedTuple):
    """One solver on one ladder."""

    study: str
    case: str
    solver: str
    refinement: str


class Run(NamedTuple):
    """How one level was solved: its outcome, its steps, particles or elements times steps, and seconds without compilation."""

    outcome: str
    steps: int
    point_steps: int
    seconds: float


class Order(NamedTuple):
    """Fitted order with its interval, and the levels that were there to be fitted."""

    order: float
    low: float
    high: float
    levels: frozenset[str]


@dataclass(frozen=True)
class Tables:
    """What the studies of one results folder hold.

    Parameters
    ----------
    provenance : mapping
        `PROVENANCE` attributes by study.
    runs : mapping
        By (series, level); a level is "h=... nu_C=... ppc=...".
    errors : mapping
        (absolute error, exact norm), in the unit of the field, by (series, level, "quantity norm"). A run that did not complete has none.
    orders : mapping
        By (series, "quantity norm"), where a line was fitted.
    verdicts : mapping
        By (series, "gate: criterion"): the worst where several criteria share their title.
    """

    provenance: Mapping[str, Mapping[str, str]]
    runs: Mapping[tuple[SeriesKey, str], Run]
    errors: Mapping[tuple[SeriesKey, str, str], tuple[float, float]]
    orders: Mapping[tuple[SeriesKey, str], Order]
    verdicts: Mapping[tuple[SeriesKey, str], Verdict]


def read_tables(paths: Sequence[Path]) -> Tables:
    """Read the files of some studies.

    Raises
    ------
    ResultsError
        If a file is missing, unreadable, foreign, of another schema or damaged.
    """
    tables = Tables({}, {}, {}, {}, {})
    for path in paths:
        tree = read_study(path)
        with damage(path):
            part = _tables(tree)
        tables = Tables(
            {**tables.provenance, **part.provenance},
            {**tables.runs, **part.runs},
            {**tables.errors, **part.errors},
            {**tables.orders, **part.orders},
            {**tables.verdicts, **part.verdicts},
        )
    return tables


def _tables(tree: xr.DataTree) -> Tables:
    """Tables of one study."""
    study = tree.attrs["id"]
    runs: dict[tuple[SeriesKey, str], Run] = {}
    errors: dict[tuple[SeriesKey, str, str], tuple[float, float]] = {}
    orders: dict[tuple[SeriesKey, str], Order] = {}
    for solver, dataset in solvers(tree):
        completed = dataset["outcome"].values == "completed"
        work = {name: dataset[name].values.tolist() for name in ("steps", "point_steps", "seconds")}
        fits = np.stack([dataset[name].values for name in ("order", "order_low", "order_high")], axis=-1)
        names = [f"{quantity} {norm}" for quantity in dataset["quantity"].values.tolist() for norm in NORMS]
        for row, ((case, refinement), indices) in enumerate(series_of(dataset).items()):
            series = SeriesKey(study, case, solver, refinement)
            ladder = set()
            # Apart: a run that did not complete has no norms, and what one level lacks is no evidence of its series.
            for some in (indices[completed[indices]], indices[~completed[indices]]):
                seen = evidence(dataset, some)
                for k, (index, (level, values)) in enumerate(zip(some, levels(seen), strict=True)):
                    ladder.add(level)
                    runs[series, level] = Run(seen.outcomes[k], *(column[index] for column in work.values()))
                    for name, error in values.items():
                        quantity, _, norm = name.rpartition(" ")
                        errors[series, level, name] = error, float(seen.reference[quantity][k, NORMS.index(norm)])
            for name, (order, low, high) in zip(names, fits[row].reshape(-1, 3).tolist(), strict=True):
                if np.isfinite(order):
                    orders[series, name] = Order(order, low, high, frozenset(ladder))
    verdicts: dict[tuple[SeriesKey, str], Verdict] = {}
    known = {series for series, _ in runs}
    for f in findings(tree):
        judged = SeriesKey(study, f.case, f.solver, f.refinement), f"{f.gate}: {f.criterion}"
        if judged[0] not in known:  # what was not run is lost, and no worse
            continue
        verdicts[judged] = worst((f.verdict, verdicts.get(judged, f.verdict)))
    return Tables({study: {name: str(tree.attrs[name]) for name in PROVENANCE}}, runs, errors, orders, verdicts)
