"""The sources of error that criteria tell apart, in the dataset of a solver: one row a criterion."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from mpmverify.axis import UNITS
from mpmverify.criteria import Separated
from mpmverify.dataset.study import text
from mpmverify.gate import Criterion, Evidence
from mpmverify.separation import REST, Source

NAMES = (*UNITS, REST)
MEANING = {
    "amplitude": "relative error per unit of the size, in SI units, to the power of the exponent; 0 where the source is not seen",
    "exponent": "power of the size that the source falls with",
    "low": "lower end of its 99 % interval",
    "high": "upper end of its 99 % interval",
    "share": "largest part of the source in the sum of all, on any run; 0 where it is not seen",
}


def with_sources(
    dataset: xr.Dataset,
    declared: Sequence[tuple[str, str, Criterion]],
    seen: Mapping[tuple[str, str], Evidence],
) -> xr.Dataset:
    """Add the sources of the errors that are to be separated, if any, to a solver's dataset; sources out of question are NaN."""
    rows = [(case, refinement, entry) for case, refinement, entry in declared if isinstance(entry, Separated)]
    rows = [row for row in rows if row[:2] in seen and row[2].quantity in seen[row[:2]].error]
    dataset = dataset.drop_dims(("separation", "source", "beside"), errors="ignore")
    if not rows:
        return dataset
    found = [entry.separation(seen[case, refinement]) for case, refinement, entry in rows]
    table = {name: np.full((len(rows), len(NAMES)), np.nan) for name in MEANING}
    cosine = np.full((len(rows), len(NAMES), len(NAMES)), np.nan)
    for k, separation in enumerate(found):
        for source in separation.sources:
            for name in MEANING:
                table[name][k, NAMES.index(source.size)] = getattr(source, name)
        for (one, other), value in separation.cosine.items():
            i, j = NAMES.index(one), NAMES.index(other)
            cosine[k, i, j] = cosine[k, j, i] = value
    texts = {
        "case": [case for case, _, _ in rows],
        "refinement": [refinement for _, refinement, _ in rows],
        "quantity": [entry.quantity for _, _, entry in rows],
        "norm": [entry.norm for _, _, entry in rows],
        "obstacle": [separation.obstacle for separation in found],
    }
    residual = np.array([separation.residual for separation in found])
    return dataset.assign(
        {f"separation_{name}": ("separation", text(values)) for name, values in texts.items()}
        | {"separation_residual": ("separation", residual, {"units": "1", "long_name": "root mean square of log(error/fit)"})}
        | {
            f"source_{name}": (("separation", "source"), table[name], {"units": "1", "long_name": meaning})
            for name, meaning in MEANING.items()
        }
        | {
            "source_cosine": (
                ("separation", "source", "beside"),
                cosine,
                {"units": "1", "long_name": "cosine between the error fields of two sources"},
            )
        }
    ).assign_coords(source=("source", text(NAMES)), beside=("beside", text(NAMES)))


def source_of(row: dict[str, float], size: str) -> Source | None:
    """Source from its row by name of `MEANING`; None when it is out of question."""
    return None if np.isnan(row["share"]) else Source(size, **row)
