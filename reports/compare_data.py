"""Data of the page that compares two solvers: what the page needs of every series, as plain tables for its script."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mpmverify.judgement.findings import Finding

from .conservation import balances, place
from .cost import MEASURABLE, ROUND_OFF, modes_alone
from .dossiers import Dossier, Entry, mark_of
from .notation import NORM_NAMES, ladder
from .overview import mark
from .pairs import SAME_SIZE, compared_measures
from .record import Array, Measure
from .scorecard import ORDER, STALL, accepted_orders, measured_order
from .solver_names import choices
from .strips import AXIS

DIGITS = 7
"""Significant digits of the numbers."""


def compare_data(known: Sequence[Dossier]) -> dict[str, Any]:
    """Return the data of all solvers.

    Parameters
    ----------
    known : sequence of Dossier

    Returns
    -------
    dict
        - `rules`: what the script must know to compute ratios as `pairs` does;
        - `solvers`: name, page, family, worst verdict, choices;
        - `cases`: study, its title, case;
        - `series`: solver and case by number, ladder, axis, sizes, costs, and errors, orders and bands by measure;
        - `judged`: verdicts of a solver on a case, with the link to them, its known limits, and its balances.
    """
    numbers = {dossier.solver: k for k, dossier in enumerate(known)}
    cases: dict[tuple[str, str], int] = {}
    titles: dict[str, str] = {}
    measures: dict[tuple[str, str], tuple[Measure, ...]] = {}
    series, judged = [], []
    for dossier in known:
        table: dict[int, list[Entry]] = {}
        for entry in dossier.entries:
            where = entry.record.name, entry.series.case
            if where not in cases:
                cases[where], measures[where] = len(cases), compared_measures(entry.record, entry.series.case)
                titles[entry.record.name] = str(entry.record.attributes["title"])
            table.setdefault(cases[where], []).append(entry)
            found = _series(entry, measures[where])
            if found["measures"]:
                series.append({"solver": numbers[dossier.solver], "case": cases[where]} | found)
        judged += [
            {"solver": numbers[dossier.solver], "case": case} | _judged(dossier, members) for case, members in table.items()
        ]
    return {
        "rules": {"roundOff": ROUND_OFF, "measurable": MEASURABLE, "sameSize": SAME_SIZE, "axis": AXIS},
        "solvers": [_solver(dossier) for dossier in known],
        "cases": [{"study": study, "title": titles[study], "case": case} for study, case in cases],
        "series": series,
        "judged": judged,
    }


def _solver(dossier: Dossier) -> dict[str, Any]:
    worst = mark(dossier.findings)
    facts = {fact.name: fact.value for fact in choices(dossier.schemes[0])}
    return {
        "name": dossier.solver,
        "page": dossier.file,
        "family": dossier.family,
        "mark": [worst.kind, worst.text],
        "choices": facts,
    }


def _series(entry: Entry, measures: Sequence[Measure]) -> dict[str, Any]:
    series = entry.series
    return {
        "ladder": ladder(series.refinement),
        "axis": series.axis,
        "tells": bool(series.axis) and not modes_alone(series),
        "sizes": _plain(series.sizes),
        "seconds": _plain([level.seconds for level in series.levels]),
        "steps": _plain([level.point_steps for level in series.levels]),
        "measures": [_measure(entry, measure) for measure in measures if measure in series.estimates],
    }


def _measure(entry: Entry, measure: Measure) -> dict[str, Any]:
    series, (quantity, norm) = entry.series, measure
    found: dict[str, Any] = {
        "quantity": quantity.replace("_", " "),
        "norm": NORM_NAMES.get(norm, norm),
        "errors": _plain(series.estimates[measure].error),
    }
    criterion, finding = _judgement(entry, measure)
    if criterion is None or finding is None:
        estimate = series.estimates[measure]
        return found | {"order": _plain([estimate.order, estimate.low, estimate.high])}
    order, ends = measured_order(entry, criterion)
    band, words = accepted_orders(criterion)
    shown = mark_of(finding)
    formal = series.formal.get(quantity) if series.axis == "h" else None
    return found | {
        "order": _plain([order, *ends]),
        "band": _plain(band),
        "accepted": words,
        "formal": formal,
        "mark": [shown.kind, shown.text],
    }


def _judgement(entry: Entry, measure: Measure) -> tuple[Mapping[str, Any] | None, Finding | None]:
    """Return the first criterion on the order in a measure, with its finding."""
    for title, criterion in entry.series.criteria.items():
        if criterion["type"] in (ORDER, STALL) and (criterion["quantity"], criterion["norm"]) == measure:
            return criterion, entry.judged(title)
    return None, None


def _judged(dossier: Dossier, entries: Sequence[Entry]) -> dict[str, Any]:
    findings = [finding for entry in entries for finding in entry.findings]
    here = {id(entry) for entry in entries}
    kept = [balance for balance in balances(dossier) if id(balance.entry) in here]
    limits = [
        {"ladder": ladder(finding.refinement), "criterion": finding.criterion}
        for finding in findings
        if mark_of(finding).kind == "limit"
    ]
    return {
        "href": entries[0].href,
        "verdicts": Counter(mark_of(finding).text for finding in findings),
        "limits": limits,
        "balances": [
            {
                "place": place(balance.quantity),
                "quantity": balance.quantity,
                "criterion": balance.criterion,
                "figure": _plain([balance.figure])[0],
                "bound": balance.bound,
                "mark": [mark_of(balance.finding).kind, mark_of(balance.finding).text],
            }
            for balance in kept
        ],
    }


def _plain(values: Sequence[float] | Array) -> list[float | None]:
    """Return numbers with a few digits; None stands for one that is not finite."""
    return [float(f"{value:.{DIGITS - 1}e}") if math.isfinite(value) else None for value in np.asarray(values, float).tolist()]
