"""Stored studies judged anew, and their errors accepted: nothing is run."""

from collections.abc import Sequence
from pathlib import Path

from mpmverify.criteria.evidence import evidence_by_series
from mpmverify.dataset.study import StoredStudy, parsing, read_study
from mpmverify.errors import ResultsError
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.judging import Judged, judge


def gate(path: Path, baseline: Baseline) -> tuple[Finding, ...]:
    """Read the file of a study and judge it.

    Parameters
    ----------
    path : Path
    baseline : Baseline
        Of the regression gate.

    Raises
    ------
    ResultsError
        If the file cannot be read, is damaged, or holds nothing that could be judged.
    """
    found = judged(read_study(path), baseline).findings
    if not found:
        raise ResultsError(f"'{path}' holds nothing to judge: delete it and run `mpmverify run` again")
    return found


def judged(stored: StoredStudy, baseline: Baseline) -> Judged:
    """Judge a stored study."""
    evidence = evidence_by_series(stored.levels)
    return judge(stored.name, stored.declared, evidence, baseline, str(stored.attributes.get("restricted_to", "")))


def accept(baseline: Baseline, paths: Sequence[Path], reason: str) -> int:
    """Take the errors of the files of some studies over into a baseline, and return how many series that were.

    Parameters
    ----------
    baseline : Baseline
        Changed in memory alone.
    paths : sequence of Path
        Files of studies.
    reason : str
        Why the errors may change.

    Raises
    ------
    ResultsError
        If a file cannot be read, or is damaged.
    UsageError
        If a run among them did not complete. Nothing may be written then.
    """
    count = 0
    studies = [read_study(path) for path in paths]
    for stored in studies:
        evidence = evidence_by_series(stored.levels)
        count += baseline.accept_study(stored.name, stored.declared, evidence)
    with parsing(paths[0]):
        baseline.log(studies[0].attributes, reason)
    return count
