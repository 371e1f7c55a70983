"""Separated sources of error in the dataset of a solver, one row for each criterion that separates them."""

import numpy as np

from mpmverify.convergence.axis import UNITS
from mpmverify.convergence.sources import REST, Source
from mpmverify.dataset.tree import Group, text, variable
from mpmverify.judgement.judging import Judged

NAMES = (*UNITS, REST)
MEANING = {
    "amplitude": "relative error per unit of the size, in SI units, to the power of the exponent; 0 where the source is not seen",
    "exponent": "power of the size that the source falls with",
    "low": "lower end of its 99 % interval",
    "high": "upper end of its 99 % interval",
    "share": "largest part of the source in the sum of all, on any run; 0 where it is not seen",
}


def source_table(solver: str, judged: Judged) -> Group:
    """Return the separated sources of error of a solver, empty if there are none; sources that a criterion does not model are NaN."""
    rows = [
        (series, criterion, separation)
        for series, separations in judged.separations.items()
        if series.solver == solver
        for criterion, separation in separations
    ]
    if not rows:
        return Group()
    found = [separation for _, _, separation in rows]
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
        "case": [series.case for series, _, _ in rows],
        "refinement": [series.refinement for series, _, _ in rows],
        "quantity": [criterion.quantity for _, criterion, _ in rows],
        "norm": [criterion.norm for _, criterion, _ in rows],
        "obstacle": [separation.obstacle for separation in found],
    }
    residual = np.array([separation.residual for separation in found])
    return Group(
        {f"separation_{name}": variable("separation", text(values)) for name, values in texts.items()}
        | {
            "separation_residual": variable(
                "separation", residual, {"units": "1", "long_name": "root mean square of log(error/fit)"}
            )
        }
        | {
            f"source_{name}": variable(("separation", "source"), table[name], {"units": "1", "long_name": meaning})
            for name, meaning in MEANING.items()
        }
        | {
            "source_cosine": variable(
                ("separation", "source", "beside"),
                cosine,
                {"units": "1", "long_name": "cosine between the error fields of two sources"},
            )
        },
        {"source": variable("source", text(NAMES)), "beside": variable("beside", text(NAMES))},
    )


def source_of(row: dict[str, float], size: str) -> Source | None:
    """Return the source of a row, by the names of `MEANING`; None if the criterion does not model it."""
    return None if np.isnan(row["share"]) else Source(size, **row)
