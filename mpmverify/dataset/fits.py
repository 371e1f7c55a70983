"""Fits in the dataset of a solver by series, quantity and norm, and observed orders by level."""

from collections.abc import Sequence

import numpy as np

from mpmverify.criteria.evidence import Level, SeriesId
from mpmverify.criteria.norms import NORMS
from mpmverify.dataset.tree import Group, text, variable
from mpmverify.judgement.judging import Judged


def fit_table(levels: Sequence[Level], judged: Judged) -> Group:
    """Return the fits of each series of a solver, and the observed orders between its levels, by the quantities of the levels."""
    rows: dict[SeriesId, list[int]] = {}
    for index, level in enumerate(levels):
        rows.setdefault(level.series, []).append(index)
    quantities = list(dict.fromkeys(quantity for level in levels for quantity in level.errors))
    shape = (len(rows), len(quantities), len(NORMS))
    numbers = {name: np.full(shape, np.nan) for name in ("order", "order_low", "order_high", "floor")}
    words = {name: np.full(shape, "", dtype=object) for name in ("classification", "dropped")}
    pairwise = np.full((len(levels), *shape[1:]), np.nan)
    kept = np.zeros(pairwise.shape, dtype=np.int8)
    for row, (identity, indices) in enumerate(rows.items()):
        seen = judged.evidence[identity]
        for (quantity, norm), series in judged.fits[identity].items():
            k, n = quantities.index(quantity), NORMS.index(norm)
            words["classification"][row, k, n] = series.classification.value
            words["dropped"][row, k, n] = "; ".join(series.dropped)
            coarse_first = np.array(indices)[np.argsort(-seen.sizes[seen.axis.size])]
            pairwise[coarse_first[1:], k, n] = series.pairwise
            kept[coarse_first, k, n] = series.kept
            if series.fit:
                numbers["order"][row, k, n] = series.fit.order
                numbers["order_low"][row, k, n] = series.fit.low
                numbers["order_high"][row, k, n] = series.fit.high
            if series.floor:
                numbers["floor"][row, k, n] = series.floor.floor
    axes = [judged.evidence[identity].axis.size for identity in rows]
    dims = ("series", "quantity", "norm")
    meaning = {
        "order": "fitted order in the size that the series refines",
        "order_low": "lower end of its 95 % interval",
        "order_high": "upper end of its 95 % interval",
        "floor": "relative error floor E0 where one shows",
    }
    return Group(
        {name: variable(dims, values, {"units": "1", "long_name": meaning[name]}) for name, values in numbers.items()}
        | {name: variable(dims, values.astype(str)) for name, values in words.items()}
        | {
            "order_pairwise": variable(
                ("level", "quantity", "norm"),
                pairwise,
                {"units": "1", "long_name": "observed order from the coarser level"},
            ),
            "kept": variable(
                ("level", "quantity", "norm"), kept, {"units": "1", "long_name": "1 where the level is in the fit"}
            ),
        },
        {
            "series_case": variable("series", text([identity.case for identity in rows])),
            "series_refinement": variable("series", text([identity.refinement for identity in rows])),
            "series_axis": variable("series", text(axes), {"long_name": "size that the series refines; empty for a design"}),
        },
    )


def read_orders(group: Group, levels: Sequence[Level]) -> dict[tuple[SeriesId, str], tuple[float, float, float]]:
    """Return (order, low, high) of each fit by (series, "quantity norm"); series without a fit are omitted."""
    series = list(dict.fromkeys(level.series for level in levels))
    column = group.columns
    fits = np.stack([column[name] for name in ("order", "order_low", "order_high")], axis=-1)
    names = [f"{quantity} {norm}" for quantity in column["quantity"].tolist() for norm in NORMS]
    return {
        (identity, name): (order, low, high)
        for identity, table in zip(series, fits, strict=True)
        for name, (order, low, high) in zip(names, table.reshape(-1, 3).tolist(), strict=True)
        if np.isfinite(order)
    }
