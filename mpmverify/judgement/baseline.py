"""The regression gate: compares error norms with a baseline file, whose values were accepted by a command with a reason.

An error that grows by a constant factor on all levels leaves the order unchanged; this gate detects it.
"""

import json
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mpmverify.atomic import write_atomic
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.criterion import Criterion, OnLimits, OnOutcomes, errors_of_level
from mpmverify.criteria.evidence import Evidence, SeriesId
from mpmverify.errors import ResultsError, UsageError
from mpmverify.judgement.findings import Finding

TITLE = "errors against the accepted baseline"
RELATIVE = 0.01
"""Relative change of an error norm up to which it counts as unchanged; compilers and libraries change the last digits only."""
NOISE = 1e-11
"""Change of an error norm, relative to the exact norm, up to which it is round-off."""


@dataclass(frozen=True)
class Baseline:
    """Accepted error norms of a file.

    Parameters
    ----------
    path : Path
    entries : mapping
        study -> solver -> "case | refinement" -> level -> name of a value -> value: "quantity norm" and the absolute error, in the unit of
        the quantity, or what a criterion on a limit compares.
    accepted : list of mapping
        Date, commit and reason of each acceptance; the newest last.
    only : frozenset of str, optional
        Names of the studies that it gates; by default all.
    """

    path: Path
    entries: dict[str, Any] = field(default_factory=dict)
    accepted: list[dict[str, str]] = field(default_factory=list)
    only: frozenset[str] | None = None

    def gates(self, study: str) -> bool:
        """Whether it gates a study."""
        return self.only is None or study in self.only

    @property
    def source(self) -> str:
        """Date and reason of the last acceptance."""
        if not self.accepted:
            return "no baseline"
        last = self.accepted[-1]
        return f"baseline accepted on {last['date']}: {last['reason']}"

    def judge(
        self, study: str, solver: str, case: str, refinement: str, evidence: Evidence, criteria: Sequence[Criterion] = ()
    ) -> Judgement:
        """Compare the error norms of one series with the accepted ones.

        Parameters
        ----------
        study, solver, case, refinement : str
        evidence : Evidence
        criteria : sequence of Criterion
            Of the series: one on a limit of the scheme says what is compared, and which change counts as none.

        Returns
        -------
        (Verdict, str)
            FAIL if an error has changed, for the worse or for the better, else INCONCLUSIVE if only one side has one, else PASS; ERROR
            if a run did not complete or a value is not finite. With the reason.
        """
        if evidence.incomplete and not _expected(criteria):
            return Verdict.ERROR, evidence.incomplete
        accepted = self.entries.get(study, {}).get(solver, {}).get(f"{case} | {refinement}", {})
        worse: list[tuple[float, str]] = []
        better: list[tuple[float, str]] = []
        missing: list[str] = []
        compared = 0
        change = _change(criteria)
        for level, values in values_by_level(evidence, criteria):
            known = accepted.get(level, {})
            missing.extend(f"{name} at {level}" for name in sorted(values.keys() ^ known.keys()))
            for name, (now, size) in values.items():
                then = known.get(name, 0.0)
                if not np.all(np.isfinite([now, then, size])):
                    return Verdict.ERROR, f"{name} at {level}, its baseline or its exact norm is not finite"
                if name not in known:
                    continue
                compared += 1
                if rose(then, now, size, change):
                    worse.append((now / max(then, noise(size)), f"{name} at {level} rose from {then:.3e} to {now:.3e}"))
                elif rose(now, then, size, change):
                    better.append((now / then, f"{name} at {level} fell from {then:.3e} to {now:.3e}"))
        if worse:
            return Verdict.FAIL, f"{max(worse)[1]} ({len(worse)} of {compared} values rose)"
        if better:
            return (
                Verdict.FAIL,
                f"{min(better)[1]} ({len(better)} of {compared} values fell): find out why, then accept the baseline",
            )
        if missing:
            return Verdict.INCONCLUSIVE, f"not in the baseline: {missing[0]} ({len(missing)} in all): accept the baseline"
        if not compared:
            return Verdict.INCONCLUSIVE, "nothing was measured that a baseline could hold"
        return Verdict.PASS, f"{compared} values within {change:.2g} of the baseline"

    def missing_series(self, study: str, series: Collection[tuple[str, str, str]], restricted_to: str = "") -> Finding | None:
        """Check that the results of a study contain every series of the baseline, so that no study passes by leaving series out.

        Parameters
        ----------
        study : str
        series : collection of (case, solver, refinement)
            Series that were run.
        restricted_to : str
            Part of the study to which the run was restricted; "" for the whole study.

        Returns
        -------
        Finding or None
            INCONCLUSIVE, on the first missing series by solver, case and refinement; None if no series is missing.
        """
        run = {(solver, f"{case} | {refinement}") for case, solver, refinement in series}
        known = [(solver, name) for solver, entry in self.entries.get(study, {}).items() for name in entry]
        absent = sorted(set(known) - run)
        if not absent:
            return None
        solver, name = absent[0]
        case, _, refinement = name.partition(" | ")
        why = f"the run was restricted to {restricted_to}: " if restricted_to else ""
        remedy = "run the whole study" + ("" if restricted_to else ", or take out of the baseline what is gone for good")
        reason = f"in the baseline, but not in the results ({len(absent)} of {len(known)} series in all): {why}{remedy}"
        return Finding(study, case, solver, refinement, "regression", TITLE, Verdict.INCONCLUSIVE, reason, self.source)

    def accept_study(
        self, study: str, declared: Mapping[SeriesId, Sequence[Criterion]], evidence: Mapping[SeriesId, Evidence]
    ) -> int:
        """Store the error norms of every series of a study, or what its criterion on a limit compares.

        Parameters
        ----------
        study : str
        declared : mapping of SeriesId to sequence of Criterion
            Criteria of each series.
        evidence : mapping of SeriesId to Evidence

        Returns
        -------
        int
            Number of stored series.

        Raises
        ------
        UsageError
            If a run did not complete and no criterion expects that, or an error norm is not finite.
        """
        for series, seen in evidence.items():
            criteria = declared.get(series, ())
            incomplete = set(seen.outcomes) != {"completed"} and not _expected(criteria)
            if incomplete or not all(np.isfinite(table).all() for table in seen.error.values()):
                where = f"{study}/{series.case}/{series.solver} ({series.refinement})"
                raise UsageError(f"{where} did not complete on every level: a baseline accepts completed runs only")
            self.accept_series(study, series.solver, series.case, series.refinement, seen, criteria)
        return len(evidence)

    def log(self, provenance: Mapping[str, Any], reason: str) -> None:
        """Record the date, the commit and the reason of an acceptance."""
        commit = f"{provenance['commit']} ({provenance['commit_state']})"
        self.accepted.append({"date": provenance["date_created"], "commit": commit, "reason": reason})

    def accept_series(
        self, study: str, solver: str, case: str, refinement: str, evidence: Evidence, criteria: Sequence[Criterion] = ()
    ) -> None:
        """Store what is compared of one series; other levels of the series are kept."""
        series = self.entries.setdefault(study, {}).setdefault(solver, {}).setdefault(f"{case} | {refinement}", {})
        for level, values in values_by_level(evidence, criteria):
            series[level] = {name: value for name, (value, _) in values.items()}

    def write(self) -> None:
        """Write the baseline file, sorted, so that changes are readable in version control.

        Raises
        ------
        ResultsError
            If the folder does not exist or the file cannot be written; an existing file is then unchanged.
        """
        remedy = "choose another with --baseline"
        if not self.path.parent.is_dir():
            raise ResultsError(f"cannot write '{self.path}' (there is no such folder): {remedy}")
        body = {"accepted": self.accepted, "errors": self.entries}
        text = json.dumps(body, indent=1, sort_keys=True) + "\n"
        write_atomic(self.path, lambda temporary: temporary.write_text(text, encoding="utf-8"), remedy)


def noise(size: float) -> float:
    """Largest error norm that is round-off for an exact norm `size`; a size of zero counts as one."""
    return NOISE * (size or 1.0)


def rose(then: float, now: float, size: float, change: float = RELATIVE) -> bool:
    """Whether a value grew by more than a relative `change` and the round-off of an exact norm `size`; False for NaN."""
    return now > then * (1 + change) + noise(size)


def _change(criteria: Sequence[Criterion]) -> float:
    """Relative change that counts as none: the largest that a criterion on a limit of the scheme states, else `RELATIVE`."""
    return max((criterion.change for criterion in criteria if isinstance(criterion, OnLimits)), default=RELATIVE)


def _expected(criteria: Sequence[Criterion]) -> bool:
    """Whether a criterion expects that runs do not complete."""
    return any(isinstance(criterion, OnOutcomes) for criterion in criteria)


def values_by_level(
    evidence: Evidence, criteria: Sequence[Criterion] = ()
) -> Iterator[tuple[str, Mapping[str, tuple[float, float]]]]:
    """Yield the name of each level and its values, rounded to seven digits and each with its size, by name."""
    compared = next((criterion.compared for criterion in criteria if isinstance(criterion, OnLimits)), errors_of_level)
    for k, (h, courant, ppc) in enumerate(zip(evidence.h, evidence.courant, evidence.ppc, strict=True)):
        values = {name: (float(f"{value:.6e}"), size) for name, (value, size) in compared(evidence, k).items()}
        moved = "" if evidence.jitter is None or not evidence.jitter[k] else f" jitter={evidence.jitter[k]:.9g}"
        seeded = f" seed={evidence.seed[k]}" if moved and evidence.seed is not None else ""
        yield f"h={h:.9g} nu_C={courant:.9g} ppc={ppc}{moved}{seeded}", values


def read_baseline(path: Path, only: Collection[str] | None = None) -> Baseline:
    """Read a baseline file; the baseline is empty if the file does not exist.

    Parameters
    ----------
    path : Path
    only : collection of str, optional
        Names of the studies that it gates; by default all.

    Raises
    ------
    ResultsError
        If the file cannot be read or is not a baseline.
    """
    gated = None if only is None else frozenset(only)
    try:
        body = json.loads(path.read_text(encoding="utf-8"))
        if not (_holds_errors(body["errors"]) and all({"date", "reason"} <= entry.keys() for entry in body["accepted"])):
            raise ValueError("an error is not a finite number, or the nesting is wrong")
        return Baseline(path, body["errors"], list(body["accepted"]), gated)
    except FileNotFoundError:
        return Baseline(path, only=gated)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise ResultsError(f"'{path}' is not an mpmverify baseline: restore it, or choose another with --baseline") from error


def _holds_errors(table: Any, depth: int = 5) -> bool:
    """Whether a table is nested by study, solver, series, level and norm, and every error is finite and not negative."""
    if depth == 0:
        return isinstance(table, int | float) and math.isfinite(table) and table >= 0
    return isinstance(table, dict) and all(_holds_errors(value, depth - 1) for value in table.values())
