"""What was judged of the conservation of mass, momentum, angular momentum and energy by a solver."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mpmverify.convergence.verdict import worst
from mpmverify.judgement.findings import Finding

from .dossiers import Dossier, Entry, mark_of
from .notation import number, typeset_numbers
from .parts import Link
from .record import Series
from .solver_parts import ConservationRow

QUANTITIES = ("mass", "momentum", "angular momentum", "energy", "sums over the points")
"""Order of the rows."""
METRICS: Mapping[str, tuple[str, str]] = {
    "EnergyDrift": ("energy", "energy_drift"),
    "EnergyConserved": ("energy", "energy_drift"),
    "EnergyDecays": ("energy", "energy_rise"),
}
"""Quantity and metric of the criteria on the energy."""


@dataclass(frozen=True)
class Balance:
    """A criterion of conservation as it was judged on one series: the largest measured figure, and the bound as text."""

    quantity: str
    criterion: str
    entry: Entry
    finding: Finding
    figure: float
    bound: str


def conservation(dossier: Dossier) -> tuple[ConservationRow, ...]:
    """Return one row for each criterion of conservation, over all series on which it was judged."""
    table: dict[tuple[str, str], list[Balance]] = {}
    for balance in balances(dossier):
        table.setdefault((balance.quantity, balance.criterion), []).append(balance)
    return tuple(sorted(map(_row, table.values()), key=lambda row: place(row.quantity)))


def balances(dossier: Dossier) -> Iterator[Balance]:
    """Yield what was judged of conservation on every series."""
    for entry in dossier.entries:
        for title, criterion in entry.series.criteria.items():
            finding, quantity = entry.judged(title), _quantity(criterion)
            if quantity and finding:
                drift = criterion["type"] == "EnergyDrift"
                bound = f"order {criterion['low']:g} in dt" if drift else number(float(criterion["bound"]))
                shown = typeset_numbers(title).replace("_", " ")
                yield Balance(quantity, shown, entry, finding, _figure(entry.series, criterion), bound)


def place(quantity: str) -> int:
    """Return the place of a conserved quantity in the order of the rows."""
    return QUANTITIES.index(quantity) if quantity in QUANTITIES else len(QUANTITIES)


def _quantity(criterion: Mapping[str, Any]) -> str:
    kind = str(criterion["type"])
    if kind in ("Balance", "ExactTotal"):
        return str(criterion["stock"]).replace("_", " ")
    return QUANTITIES[-1] if kind == "FieldSums" else METRICS.get(kind, ("", ""))[0]


def _row(members: list[Balance]) -> ConservationRow:
    verdict = worst(member.finding.verdict for member in members)
    having = [member for member in members if member.finding.verdict is verdict]
    shown = max(having, key=lambda member: member.figure if math.isfinite(member.figure) else -math.inf)
    return ConservationRow(
        quantity=shown.quantity,
        criterion=shown.criterion,
        mark=replace(mark_of(having[0].finding), note=f"{len(having)} of {len(members)}"),
        measured=number(shown.figure),
        bound=members[0].bound,
        where=Link(f"{shown.entry.record.name}, {shown.entry.series.case}", shown.entry.href),
    )


def _figure(series: Series, criterion: Mapping[str, Any]) -> float:
    """Return the largest figure of a series; of a drift that must vanish with dt, that of the finest level."""
    kind = str(criterion["type"])
    if kind == "FieldSums":
        names = [f"{stock}_sum_defect" for stock in criterion["stocks"]]
    else:
        end = "error" if kind == "ExactTotal" else "defect"
        names = [METRICS[kind][1] if kind in METRICS else f"{criterion['stock']}_{end}"]
    values = [series.metrics[name] for name in names if name in series.metrics]
    if kind == "EnergyDrift":
        values = [column[-1:] for column in values]
    known = np.concatenate(values) if values else np.zeros(0)
    known = known[np.isfinite(known)]
    return float(known.max()) if len(known) else math.nan
