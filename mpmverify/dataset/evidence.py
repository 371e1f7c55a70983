"""Evidence in the dataset of a solver: the numbers of each series, as the judge takes them."""

import numpy as np
import xarray as xr

from mpmverify.criteria.metrics import Metrics
from mpmverify.gate import Evidence
from mpmverify.norms import NORMS
from mpmverify.problem import Array


def series_of(dataset: xr.Dataset) -> dict[tuple[str, str], np.ndarray]:
    """Level indices of each (case, refinement) of a solver."""
    table: dict[tuple[str, str], list[int]] = {}
    for index, identity in enumerate(zip(dataset["case"].values.tolist(), dataset["refinement"].values.tolist(), strict=True)):
        table.setdefault(identity, []).append(index)
    return {identity: np.array(indices) for identity, indices in table.items()}


def evidence(dataset: xr.Dataset, levels: np.ndarray) -> Evidence:
    """Evidence of one series of a solver's dataset; quantities and metrics that were not measured on it are absent.

    Raises
    ------
    LookupError, ValueError
        If the dataset lacks a column, or one does not hold what a judge may take for granted.
    """
    part = dataset.isel(level=levels)

    def numbers(name: str, *shape: int) -> Array:
        values: Array = part[name].values
        if values.dtype.kind not in "fiu" or values.shape != (len(levels), *shape):
            raise ValueError(f"{name} is of type {values.dtype} and shape {values.shape}")
        return values

    sizes = {name: numbers(name) for name in ("h", "dt", "courant", "ppc")}
    # The time step of a run that never began is not known.
    if not all(
        np.all((values > 0) & (values < np.inf) | (np.isnan(values) & (name == "dt"))) for name, values in sizes.items()
    ):
        raise ValueError("a level has no size")
    size = {quantity: numbers(f"exact_norm_{quantity}", len(NORMS)) for quantity in part["quantity"].values.tolist()}
    size = {quantity: values for quantity, values in size.items() if np.isfinite(values).all()}
    names = part["metric_name"].values.tolist()
    metric = numbers("metric", len(names))
    return Evidence(
        **sizes,
        jitter=numbers("jitter"),
        seed=numbers("seed"),
        outcomes=tuple(part["outcome"].values.tolist()),
        error={quantity: numbers(f"error_absolute_{quantity}", len(NORMS)) for quantity in size},
        reference=size,
        metrics=Metrics({str(name): metric[:, k] for k, name in enumerate(names) if not np.isnan(metric[:, k]).all()}),
    )
