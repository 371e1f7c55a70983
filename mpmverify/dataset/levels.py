"""Levels in the dataset of a solver: sizes, errors, metrics and work, one row for each run."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mpmverify.criteria.evidence import Level
from mpmverify.criteria.norms import NORMS
from mpmverify.dataset.tree import Group, Variable, text, variable
from mpmverify.problem import Array
from mpmverify.problem.quantities import UNITS


def level_table(levels: Sequence[Level]) -> Group:
    """Return the group of the levels of one solver, in the order given."""
    quantities = list(dict.fromkeys(quantity for level in levels for quantity in level.errors))
    metrics = sorted({name for level in levels for name in level.metrics})
    absent = np.full(len(NORMS), np.nan)
    table = np.array([[level.errors.get(q, (absent, absent)) for q in quantities] for level in levels], dtype=float)
    table = table.reshape(len(levels), len(quantities), 2, len(NORMS))
    error, size = table[:, :, 0], table[:, :, 1]

    def each(read: Any, units: str | None = None, long_name: str = "") -> Variable:
        values = [read(level) for level in levels]
        if units is None:
            return variable("level", text(values), {"long_name": long_name})
        return variable("level", values, {"units": units, "long_name": long_name})

    return Group(
        {
            "error": variable(
                ("level", "quantity", "norm"),
                error / np.where(size > 0, size, 1.0),
                {
                    "units": "1",
                    "long_name": "error relative to the size of the exact field over the run",
                    "comment": "absolute where that size is 0",
                },
            ),
            "metric": variable(
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
            f"{name}_{quantity}": variable(
                ("level", "norm"),
                values[:, k],
                {"units": UNITS[quantity], "long_name": f"{of} {quantity}; L1 and L2 are means over the body"},
            )
            for k, quantity in enumerate(quantities)
            for name, values, of in (
                ("error_absolute", error, "norm of the error of"),
                ("exact_norm", size, "largest norm over the output times of the exact"),
            )
        },
        {
            "case": each(lambda level: level.case, None, "case"),
            "refinement": each(lambda level: level.refinement, None, "ladder"),
            "h": each(lambda level: level.h, "m", "cell size"),
            "dt": each(lambda level: level.dt, "s", "time step"),
            "courant": each(lambda level: level.courant, "1", "Courant number"),
            "ppc": each(lambda level: level.ppc, "1", "particles per cell"),
            "jitter": each(lambda level: level.jitter, "1", "largest displacement of a particle as a share of the spacing"),
            "seed": each(lambda level: level.seed, "1", "seed of the displacements"),
            "quantity": variable("quantity", text(quantities)),
            "norm": variable("norm", text(NORMS)),
            "metric_name": variable("metric_name", text(metrics)),
        },
    )


def read_levels(solver: str, group: Group) -> list[Level]:
    """Return the levels of a solver, each with the quantities and metrics that were measured on it.

    Raises
    ------
    LookupError, ValueError
        If a variable is missing, or has the wrong type, shape or range.
    """
    column = group.columns
    count = len(column["case"])

    def numbers(name: str, *shape: int) -> Array:
        values: Array = column[name]
        if values.dtype.kind not in "fiu" or values.shape != (count, *shape):
            raise ValueError(f"{name} is of type {values.dtype} and shape {values.shape}")
        return values

    sizes = {name: numbers(name) for name in ("h", "dt", "courant", "ppc")}
    # dt is NaN for a run that did not start.
    if not all(
        np.all((values > 0) & (values < np.inf) | (np.isnan(values) & (name == "dt"))) for name, values in sizes.items()
    ):
        raise ValueError("a size of a level is not positive and finite")
    quantities, metrics = (column[name].tolist() for name in ("quantity", "metric_name"))
    exact = {quantity: numbers(f"exact_norm_{quantity}", len(NORMS)) for quantity in quantities}
    error = {quantity: numbers(f"error_absolute_{quantity}", len(NORMS)) for quantity in quantities}
    metric = numbers("metric", len(metrics))
    columns = sizes | {name: numbers(name) for name in ("jitter", "seed", "steps", "point_steps", "seconds")}
    rows = {name: values.tolist() for name, values in columns.items()}
    rows |= {name: column[name].tolist() for name in ("case", "refinement", "outcome")} | {"key": column["run"].tolist()}

    def measured(k: int) -> Mapping[str, float]:
        return {str(name): value for name, value in zip(metrics, metric[k].tolist(), strict=True) if not np.isnan(value)}

    return [
        Level(
            solver=solver,
            errors={q: (error[q][k], exact[q][k]) for q in quantities if np.isfinite(exact[q][k]).all()},
            metrics=measured(k),
            **{name: values[k] for name, values in rows.items()},
        )
        for k in range(count)
    ]
