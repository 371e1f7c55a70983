"""Data of the page that compares two solvers: what the page needs of every series, as plain tables for its script."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mpmverify.judgement.findings import Finding

from .conservation import Balance, balances, place
from .cost import MEASURABLE, ROUND_OFF, modes_alone
from .dossiers import Dossier, Entry, mark_of
from .notation import NORM_NAMES, ladder
from .overview import mark
from .pairs import SAME_SIZE, Compared, measured
from .record import Array, Measure
from .scorecard import ORDER, STALL, accepted_orders, measured_order
from .solver_names import choices
from .strips import AXIS

DIGITS, FEW = 7, 3
"""Significant digits of the numbers that are computed with, and of those that are only shown."""


class Words:
    """Texts by number: a text that many entries share is stored once."""

    def __init__(self) -> None:
        self.numbers: dict[tuple[Any, ...], int] = {}

    def number(self, *text: Any) -> int:
        """Return the number of a text, which gets one if it has none."""
        return self.numbers.setdefault(text, len(self.numbers))

    def listed(self) -> list[list[Any]]:
        """Return the texts in the order of their numbers."""
        return [list(text) for text in self.numbers]


def compare_data(known: Sequence[Dossier], compared: Compared) -> dict[str, Any]:
    """Return the data of all solvers.

    Parameters
    ----------
    known : sequence of Dossier
    compared : mapping
        What `pairs.compared_measures` returns.

    Returns
    -------
    dict
        - `rules`: what the script must know to compute ratios as `pairs` does;
        - `solvers`: name, page, family, worst verdict, choices;
        - `cases`: study, its title, case;
        - `series`: solver and case by number, ladder, axis, sizes, costs, and errors, orders and bands by measure;
        - `judged`: solver and case by number, the link to the verdicts, their numbers by word, the known limits, and the balances, as
          [criterion, figure, mark] with numbers of `balances` and `marks`.
    """
    numbers = {dossier.solver: k for k, dossier in enumerate(known)}
    cases, marks, kept, limits = Words(), Words(), Words(), Words()
    series, judged = [], []
    for dossier in known:
        found = _balances(dossier)
        table: dict[int, list[Entry]] = {}
        for entry in dossier.entries:
            case = cases.number(entry.record.name, str(entry.record.attributes["title"]), entry.series.case)
            table.setdefault(case, []).append(entry)
            if shown := measured(entry, compared):
                series.append({"solver": numbers[dossier.solver], "case": case} | _series(entry, shown))
        for case, entries in table.items():
            findings = [mark_of(finding) for entry in entries for finding in entry.findings]
            counts = Counter(marks.number(shown.kind, shown.text) for shown in findings)
            known_limits = [
                limits.number(ladder(finding.refinement), finding.criterion)
                for entry in entries
                for finding in entry.findings
                if mark_of(finding).kind == "limit"
            ]
            figures = [
                [
                    kept.number(place(one.quantity), one.quantity, one.criterion, one.bound),
                    _plain([one.figure], FEW)[0],
                    marks.number(mark_of(one.finding).kind, mark_of(one.finding).text),
                ]
                for entry in entries
                for one in found.get(id(entry), ())
            ]
            judged.append([numbers[dossier.solver], case, entries[0].href, list(counts.items()), known_limits, figures])
    return {
        "rules": {"roundOff": ROUND_OFF, "measurable": MEASURABLE, "sameSize": SAME_SIZE, "axis": AXIS},
        "solvers": [_solver(dossier) for dossier in known],
        "cases": [{"study": study, "title": title, "case": case} for study, title, case in cases.numbers],
        "marks": marks.listed(),
        "balances": kept.listed(),
        "limits": limits.listed(),
        "series": series,
        "judged": judged,
    }


def _balances(dossier: Dossier) -> dict[int, list[Balance]]:
    table: dict[int, list[Balance]] = {}
    for balance in balances(dossier):
        table.setdefault(id(balance.entry), []).append(balance)
    return table


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
        "steps": [level.point_steps for level in series.levels],
        "measures": [_measure(entry, measure) for measure in measures],
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


def _plain(values: Sequence[float] | Array, digits: int = DIGITS) -> list[float | None]:
    """Return numbers with a few digits; None stands for one that is not finite."""
    return [float(f"{value:.{digits - 1}e}") if math.isfinite(value) else None for value in np.asarray(values, float).tolist()]
