"""The regression gate: error magnitudes against a committed baseline, accepted by a command with a reason.

A loss by a constant factor leaves every order unchanged; this gate sees it.
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
from mpmverify.criteria.criterion import Criterion, has_baseline
from mpmverify.criteria.evidence import Evidence, SeriesId
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import ResultsError, UsageError
from mpmverify.judgement.findings import Finding

TITLE = "errors against the accepted baseline"
RELATIVE = 0.01
"""Change of an error norm that counts; compilers and libraries change the last digits only."""
NOISE = 1e-11
"""Errors relative to the exact norm below which a change is round-off."""


@dataclass(frozen=True)
class Baseline:
    """Accepted error norms.

    Parameters
    ----------
    path : Path
    entries : mapping
        study -> solver -> "case | refinement" -> level -> "quantity norm" -> absolute error.
    accepted : list of mapping
        Who accepted what, when and why; the newest last.
    """

    path: Path
    entries: dict[str, Any] = field(default_factory=dict)
    accepted: list[dict[str, str]] = field(default_factory=list)

    @property
    def source(self) -> str:
        if not self.accepted:
            return "no baseline"
        last = self.accepted[-1]
        return f"baseline accepted on {last['date']}: {last['reason']}"

    def judge(self, study: str, solver: str, case: str, refinement: str, evidence: Evidence) -> Judgement:
        """Compare the errors of one series with the accepted ones: worse fails, better asks to be accepted."""
        if evidence.incomplete:
            return Verdict.ERROR, evidence.incomplete
        accepted = self.entries.get(study, {}).get(solver, {}).get(f"{case} | {refinement}", {})
        worse: list[tuple[float, str]] = []
        better: list[tuple[float, str]] = []
        missing: list[str] = []
        compared = 0
        for k, (level, values) in enumerate(identified(evidence)):
            known = accepted.get(level, {})
            missing.extend(f"{name} at {level}" for name in sorted(values.keys() ^ known.keys()))
            for name, now in values.items():
                quantity, _, norm = name.rpartition(" ")
                size = evidence.reference[quantity][k, NORMS.index(norm)]
                then = known.get(name, 0.0)
                if not np.all(np.isfinite([now, then, size])):
                    return Verdict.ERROR, f"{name} at {level}, its baseline or its exact norm is not finite"
                if name not in known:
                    continue
                compared += 1
                if rose(then, now, size):
                    worse.append((now / max(then, noise(size)), f"{name} at {level} rose from {then:.3e} to {now:.3e}"))
                elif rose(now, then, size):
                    better.append((now / then, f"{name} at {level} fell from {then:.3e} to {now:.3e}"))
        if worse:
            return Verdict.FAIL, f"{max(worse)[1]} ({len(worse)} of {compared} errors are worse)"
        if better:
            return (
                Verdict.INCONCLUSIVE,
                f"{min(better)[1]} ({len(better)} of {compared} are better): find out why, then accept the baseline",
            )
        if missing:
            return Verdict.INCONCLUSIVE, f"not in the baseline: {missing[0]} ({len(missing)} in all): accept the baseline"
        if not compared:
            return Verdict.INCONCLUSIVE, "no error was measured that a baseline could hold"
        return Verdict.PASS, f"{compared} errors within {RELATIVE:.0%} of the baseline"

    def lacking(self, study: str, series: Collection[tuple[str, str, str]], restricted_to: str = "") -> Finding | None:
        """Say which series the baseline holds of a study whose results lack them, for a part passes for no whole.

        Parameters
        ----------
        study : str
        series : collection of (case, solver, refinement)
            What was run of it.
        restricted_to : str
            What the run was restricted to, "" where it was not.

        Returns
        -------
        Finding or None
            INCONCLUSIVE of the first of them by name; None where none is lacking.
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

    def take_over(
        self, study: str, declared: Mapping[SeriesId, Sequence[Criterion]], evidence: Mapping[SeriesId, Evidence]
    ) -> int:
        """Take over the errors of every series that is compared with a baseline, and return how many there are.

        Raises
        ------
        UsageError
            If a run among them did not complete.
        """
        count = 0
        for series, seen in evidence.items():
            if not has_baseline(declared.get(series, ())):
                continue
            if set(seen.outcomes) != {"completed"} or not all(np.isfinite(table).all() for table in seen.error.values()):
                where = f"{study}/{series.case}/{series.solver} ({series.refinement})"
                raise UsageError(f"{where} did not complete on every level: a baseline takes finished runs alone")
            self.updated(study, series.solver, series.case, series.refinement, seen)
            count += 1
        return count

    def log(self, provenance: Mapping[str, Any], reason: str) -> None:
        """Say when, of which commit and why errors were accepted."""
        commit = f"{provenance['commit']} ({provenance['commit_state']})"
        self.accepted.append({"date": provenance["date_created"], "commit": commit, "reason": reason})

    def updated(self, study: str, solver: str, case: str, refinement: str, evidence: Evidence) -> None:
        """Take over the errors of one series."""
        series = self.entries.setdefault(study, {}).setdefault(solver, {}).setdefault(f"{case} | {refinement}", {})
        series |= dict(identified(evidence))

    def write(self) -> None:
        """Write the baseline, sorted, so that a change reads well in version control; no folder is made for it.

        Raises
        ------
        ResultsError
            If it cannot be written: the former baseline stays.
        """
        remedy = "choose another with --baseline"
        if not self.path.parent.is_dir():
            raise ResultsError(f"cannot write '{self.path}' (there is no such folder): {remedy}")
        body = {"accepted": self.accepted, "errors": self.entries}
        text = json.dumps(body, indent=1, sort_keys=True) + "\n"
        write_atomic(self.path, lambda temporary: temporary.write_text(text, encoding="utf-8"), remedy)


def noise(size: float) -> float:
    """Error norm that is round-off beside an exact norm `size`, and beside one where that is zero."""
    return NOISE * (size or 1.0)


def rose(then: float, now: float, size: float) -> bool:
    """Whether an error norm grew by what counts, beyond the round-off of an exact norm `size`; NaN never does."""
    return now > then * (1 + RELATIVE) + noise(size)


def identified(evidence: Evidence) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Identity of each level, and its absolute error norms to seven digits by quantity and norm."""
    for k, (h, courant, ppc) in enumerate(zip(evidence.h, evidence.courant, evidence.ppc, strict=True)):
        values = {
            f"{quantity} {norm}": float(f"{table[k, n]:.6e}")
            for quantity, table in evidence.error.items()
            for n, norm in enumerate(NORMS)
        }
        moved = "" if evidence.jitter is None or not evidence.jitter[k] else f" jitter={evidence.jitter[k]:.9g}"
        seeded = f" seed={evidence.seed[k]}" if moved and evidence.seed is not None else ""
        yield f"h={h:.9g} nu_C={courant:.9g} ppc={ppc}{moved}{seeded}", values


def read_baseline(path: Path) -> Baseline:
    """Read a baseline; a missing file is an empty one.

    Raises
    ------
    ResultsError
        If the file is damaged or foreign.
    """
    try:
        body = json.loads(path.read_text(encoding="utf-8"))
        if not (_holds_errors(body["errors"]) and all({"date", "reason"} <= entry.keys() for entry in body["accepted"])):
            raise ValueError("an error is no finite number, or an entry stands where none belongs")
        return Baseline(path, body["errors"], list(body["accepted"]))
    except FileNotFoundError:
        return Baseline(path)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise ResultsError(f"'{path}' is not an mpmverify baseline: restore it, or choose another with --baseline") from error


def _holds_errors(table: Any, depth: int = 5) -> bool:
    """Whether nested mappings end, after study, solver, series, level and norm, in finite errors that are not negative."""
    if depth == 0:
        return isinstance(table, int | float) and math.isfinite(table) and table >= 0
    return isinstance(table, dict) and all(_holds_errors(value, depth - 1) for value in table.values())
