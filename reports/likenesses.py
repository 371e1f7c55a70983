"""What errors like those of a solver of one's own come from, on its page."""

import json
from collections.abc import Iterator

import numpy as np

from mpmverify.convergence.verdict import Verdict
from mpmverify.errors import ResultsError
from mpmverify.judgement.diagnosis import Measured, diagnosis, read_signatures, signature

from .dossiers import Dossier, Entry
from .record import Record


def likely_causes(dossier: Dossier) -> str:
    """Return the sentence of the diagnosis of a solver of one's own; "" if no criterion on it failed, or nothing is similar enough."""
    found: dict[str, float] = {}
    failed = False
    try:
        known = read_signatures().problems
    except ResultsError:  # the run that failed has said so
        return ""
    for entry in dossier.entries:
        own, case = f"-with-{entry.series.solver}", entry.series.case
        study = entry.record.name.removesuffix(own)
        place = f"{study} | {case}"
        if study != entry.record.name and place in known and _problems(entry.record).get(case) == known[place]:
            failed = failed or any(finding.verdict is Verdict.FAIL for finding in entry.findings)
            found |= signature(study, _measured(entry))
    said = diagnosis(found) if failed else ""
    return f"{said[:1].upper()}{said[1:]}." if said else ""


def _problems(record: Record) -> dict[str, str]:
    """Digest of the problem of each case; none of a file that does not say, or is damaged there."""
    try:
        found = json.loads(record.attributes.get("problems", ""))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


def _measured(entry: Entry) -> Iterator[Measured]:
    series = entry.series
    for k, level in enumerate(series.levels):
        errors = {measure: float(estimate.error[k]) for measure, estimate in series.estimates.items()}
        metrics = {name: float(values[k]) for name, values in series.metrics.items()}
        yield Measured(
            *(series.case, level.h, level.courant, level.ppc, level.outcome == "completed"),
            {measure: error for measure, error in errors.items() if not np.isnan(error)},
            {name: value for name, value in metrics.items() if not np.isnan(value)},
        )
