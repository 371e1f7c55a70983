"""What was judged of the conservation of mass, momentum, angular momentum and energy by a solver."""

import math
from collections.abc import Mapping
from dataclasses import replace
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


def conservation(dossier: Dossier) -> tuple[ConservationRow, ...]:
    """Return one row for each criterion of conservation, over all series on which it was judged."""
    table: dict[tuple[str, str], list[tuple[Entry, Finding, Mapping[str, Any]]]] = {}
    for entry in dossier.entries:
        for title, criterion in entry.series.criteria.items():
            finding, quantity = entry.judged(title), _quantity(criterion)
            if quantity and finding:
                table.setdefault((quantity, title), []).append((entry, finding, criterion))
    rows = [_row(quantity, title, members) for (quantity, title), members in table.items()]
    return tuple(
        sorted(rows, key=lambda row: QUANTITIES.index(row.quantity) if row.quantity in QUANTITIES else len(QUANTITIES))
    )


def _quantity(criterion: Mapping[str, Any]) -> str:
    kind = str(criterion["type"])
    if kind in ("Balance", "ExactTotal"):
        return str(criterion["stock"]).replace("_", " ")
    return QUANTITIES[-1] if kind == "FieldSums" else METRICS.get(kind, ("", ""))[0]


def _row(quantity: str, title: str, members: list[tuple[Entry, Finding, Mapping[str, Any]]]) -> ConservationRow:
    findings = [finding for _, finding, _ in members]
    verdict = worst(finding.verdict for finding in findings)
    figures = [(_figure(entry.series, criterion), entry) for entry, finding, criterion in members if finding.verdict is verdict]
    figure, entry = max(figures, key=lambda pair: pair[0] if math.isfinite(pair[0]) else -math.inf)
    count = sum(finding.verdict is verdict for finding in findings)
    criterion = members[0][2]
    return ConservationRow(
        quantity=quantity,
        criterion=typeset_numbers(title).replace("_", " "),
        mark=replace(mark_of(next(f for f in findings if f.verdict is verdict)), note=f"{count} of {len(findings)}"),
        measured=number(figure),
        bound=f"order {criterion['low']:g} in dt" if criterion["type"] == "EnergyDrift" else number(float(criterion["bound"])),
        where=Link(f"{entry.record.name}, {entry.series.case}", entry.href),
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
