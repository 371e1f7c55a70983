"""Stability limits and frequencies of a solver beside their theory."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mpmverify.judgement.findings import Finding

from .dossiers import Dossier, Entry, mark_of
from .notation import DASH, count, ladder, number
from .parts import Link
from .solver_parts import TheoryRow


def against_theory(dossier: Dossier) -> tuple[TheoryRow, ...]:
    """Return what was measured of limits of stability, of runs beyond them, and of frequencies."""
    rows: list[TheoryRow] = []
    for kind, read in READERS.items():
        for entry in dossier.entries:
            for title, criterion in entry.series.criteria.items():
                finding = entry.judged(title)
                if criterion["type"] == kind and finding:
                    rows += read(entry, finding, criterion)
    return tuple(rows)


def _limits(entry: Entry, finding: Finding, _: Mapping[str, Any]) -> Iterator[TheoryRow]:
    metrics = entry.series.metrics
    if "stability_limit" not in metrics:
        yield _failed(entry, finding, "largest stable Courant number")
        return
    pairs = zip(entry.series.levels, metrics["stability_limit"], metrics["theoretical_stability_limit"], strict=True)
    for level, measured, theory in sorted(pairs, key=lambda pair: pair[0].ppc):
        yield TheoryRow(
            mark=mark_of(finding),
            what="largest stable Courant number",
            where=_where(entry),
            at=f"{count(level.ppc)} particle{'s' * (level.ppc != 1)} per cell",
            measured=f"{measured:.4f}",
            theory=f"{theory:.4f}",
            deviation=number(float(abs(measured / theory - 1)), 2),
        )


def _beyond(entry: Entry, finding: Finding, criterion: Mapping[str, Any]) -> Iterator[TheoryRow]:
    ended = list(dict.fromkeys(level.outcome.partition(";")[0] for level in entry.series.levels))
    yield TheoryRow(
        mark=mark_of(finding),
        what="runs above the limit",
        where=_where(entry),
        at=f"Courant ≥ {min(level.courant for level in entry.series.levels):.4g}",
        measured=", ".join(ended),
        theory=f"unstable above {criterion['limit']:.4g}",
        deviation=DASH,
    )


def _frequencies(entry: Entry, finding: Finding, criterion: Mapping[str, Any]) -> Iterator[TheoryRow]:
    quantity, metrics = criterion["quantity"], entry.series.metrics
    names = ("dispersion_defect", "phase_angle", "relative_frequency", "theoretical_frequency")
    columns = [metrics.get(f"{name}_{quantity}") for name in names]
    defect, angle, measured, theory = columns
    if defect is None or angle is None or measured is None or theory is None or not np.isfinite(defect).any():
        yield _failed(entry, finding, f"frequency of the {quantity}")
        return
    k = int(np.nanargmax(defect))
    yield TheoryRow(
        mark=mark_of(finding),
        what=f"frequency of the {quantity}, ω/(ck)",
        where=_where(entry),
        at=f"kh = {angle[k]:.3g}, {ladder(entry.series.refinement)}",
        measured=f"{measured[k]:.6f}",
        theory=f"{theory[k]:.6f}",
        deviation=number(float(defect[k]), 2),
    )


READERS = {"StabilityLimit": _limits, "Unstable": _beyond, "Dispersion": _frequencies}
"""Criteria that compare with a theory of the scheme, each with what reads its rows."""


def _failed(entry: Entry, finding: Finding, what: str) -> TheoryRow:
    return TheoryRow(mark_of(finding), what, _where(entry), DASH, DASH, DASH, DASH)


def _where(entry: Entry) -> Link:
    return Link(f"{entry.record.name}, {entry.series.case}", entry.href)
