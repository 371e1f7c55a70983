"""What became of a planted fault: the trials that it was put to, and how they ended."""

import ast
import dataclasses
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpmverify.convergence.verdict import Verdict
from mpmverify.dataset.files import Results
from mpmverify.dataset.runs import read_run
from mpmverify.errors import UsageError
from mpmverify.execution.runner import Plan, run, tasks_of
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.kill_table import Fate
from mpmverify.selftest.faults import Edit, Fault
from mpmverify.selftest.planting import planted, replanted
from mpmverify.selftest.syntax import names
from mpmverify.solution import Solution, Status
from mpmverify.study import Study

ROUND_OFF = 1e-11
"""Results that differ by no more, relative to their size, are the same."""

CONTRACT = "contract of a solution"
"""What kills a fault that counts as crashed and raises nothing: it returned what no solver may."""


@dataclass(frozen=True)
class Fortune:
    """What became of one fault.

    Parameters
    ----------
    fate : Fate
    finding : Finding or None
        What killed it; the worst that was said of a survivor.
    reason : str
        Why it does not run.
    deviation : float
        Largest relative deviation of its results from the original's on the trials that it lived to see.
    trials : int
        How many those were.
    seconds : float
        Compilation included.
    """

    fate: Fate
    finding: Finding | None = None
    reason: str = ""
    deviation: float = 0.0
    trials: int = 0
    seconds: float = 0.0


@dataclass(frozen=True)
class Court:
    """Everything that a fault is judged by.

    Parameters
    ----------
    sources : Path
        Folder of the solvers.
    trials : tuple of Study
        Each with one solver in one case.
    baseline : Baseline
        Of the regression gate.
    original : Path
        Results folder with the runs of the original solvers.
    scratch : Path
        Where temporary folders go.
    """

    sources: Path
    trials: tuple[Study, ...]
    baseline: Baseline
    original: Path
    scratch: Path

    def judge(self, fault: Fault) -> Fortune:
        """Put a fault to the trials until one of them kills it."""
        began = time.perf_counter()
        with tempfile.TemporaryDirectory(dir=self.scratch) as folder:
            fortune = self._tried(fault, Path(folder))
            if fortune.fate is Fate.EQUIVALENT and not self._exercised(fault, Path(folder)):
                fortune = dataclasses.replace(fortune, fate=Fate.NOT_EXERCISED)
        return dataclasses.replace(fortune, seconds=time.perf_counter() - began)

    def _tried(self, fault: Fault, folder: Path) -> Fortune:
        worst: Finding | None = None
        regression: Finding | None = None
        deviation = 0.0
        with planted(fault, self.sources, folder) as package:
            for k, trial in enumerate(self.trials, start=1):
                results = Results(folder / f"trial-{k}")
                try:
                    faulty = replanted(trial, package)
                except Exception as error:  # what a fault does when it is imported is its own affair
                    return Fortune(Fate.BROKEN, reason=f"{type(error).__name__}: {error}", trials=k)
                try:
                    findings = self._findings(faulty, results)
                except UsageError as error:
                    return Fortune(Fate.BROKEN, reason=f"it refuses the problem: {error}", deviation=deviation, trials=k)
                if killer := _killer(findings, "verification"):
                    fate = Fate.KILLED
                    if f": {Status.CRASHED}" in killer.reason and _raises(faulty):
                        fate = Fate.BROKEN
                    elif f": {Status.CRASHED}" in killer.reason:
                        killer = dataclasses.replace(killer, criterion=CONTRACT)
                    return Fortune(fate, killer, deviation=deviation, trials=k)
                regression = regression or _killer(findings, "regression")
                worst = worst or next((f for f in findings if f.verdict is not Verdict.PASS), None)
                deviation = max(deviation, *self._deviations(trial, faulty, results))
        if regression:
            return Fortune(Fate.REGRESSION, regression, deviation=deviation, trials=len(self.trials))
        fate = Fate.EQUIVALENT if deviation <= ROUND_OFF else Fate.SURVIVED
        return Fortune(fate, worst, deviation=deviation, trials=len(self.trials))

    def _findings(self, study: Study, results: Results) -> list[Finding]:
        (judged,) = run([study], Plan(results, self.baseline, jobs=0))
        return [finding for finding in judged.findings if counts(finding)]

    def _deviations(self, trial: Study, faulty: Study, results: Results) -> Iterator[float]:
        """Deviation of each run of a trial from the original's."""
        original = Results(self.original)
        for one, two in zip(
            tasks_of(trial, Plan(original, self.baseline)), tasks_of(faulty, Plan(results, self.baseline)), strict=True
        ):
            yield deviation(read_run(results.run(two.key), two.key), read_run(original.run(one.key), one.key))

    def _exercised(self, fault: Fault, folder: Path) -> bool:
        """Whether a trial comes to the passage: with an exception in its place, or what spoils results, one of them differs."""
        tripped = dataclasses.replace(fault, edits=(_trip(fault.edits[0], self.sources),))
        return self._tried(tripped, folder).fate is not Fate.EQUIVALENT


def _raises(trial: Study) -> bool:
    """Whether a solver raises on a trial: one that does not, and counts as crashed, has returned what no solver may."""
    for case, series in trial.series():
        for level in series.refinement.tier("quick"):
            try:
                series.solver.solve(case.problem.problem, level)
            except Exception:  # what a fault raises is its own affair
                return True
    return False


TRACED = {"traced", "_pass", "contextmanager"}
"""Decorators of functions that Python runs when code is compiled, and not when that runs."""
TRIP = "__import__('mpmverify.selftest.trip', fromlist=['trip']).trip(locals())"


def _trip(edit: Edit, sources: Path) -> Edit:
    """Exception in front of the statement that an edit changes, or in a function that writes compiled code a `trip` in it."""
    text = (sources / edit.file).read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    line = text.count("\n", 0, edit.begin(text)) + 1
    around = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0)
    ]
    decorators = [one for node in around if isinstance(node, ast.FunctionDef) for one in node.decorator_list]
    writes = any(names(one) & TRACED for one in decorators)
    around = [node for node in around if not lines[node.lineno - 1].lstrip().startswith("elif")]
    first = max(around, key=lambda node: (node.lineno, node.col_offset)).lineno - 1
    indent = lines[first][: len(lines[first]) - len(lines[first].lstrip())]
    trip = TRIP if writes else "raise ArithmeticError"
    return Edit(edit.file, text, "".join([*lines[:first], f"{indent}{trip}\n", *lines[first:]]))


def counts(finding: Finding) -> bool:
    """Whether a finding says anything: the regression gate does not where the baseline has nothing to compare with."""
    return finding.gate == "verification" or finding.verdict is not Verdict.INCONCLUSIVE


def _killer(findings: Sequence[Finding], gate: str) -> Finding | None:
    """First FAIL of a gate, or else its first ERROR."""
    for verdict in (Verdict.FAIL, Verdict.ERROR):
        for finding in findings:
            if finding.gate == gate and finding.verdict is verdict:
                return finding
    return None


def deviation(mine: Solution, theirs: Solution) -> float:
    """Largest deviation of any array of a solution, relative to its size; infinite where shapes or outcomes differ.

    Two runs that are unstable alike, at whatever step, do not differ: what they return is no result.
    Momentum and impulse are compared with the size of the particles' momenta, which cancel in their sum; the energies and the
    work with the largest of them.
    """
    if (mine.outcome.status, mine.dt) != (theirs.outcome.status, theirs.dt):
        return float("inf")
    if not mine.outcome.completed:
        return 0.0
    one, two = mine.arrays(), theirs.arrays()
    if {name: values.shape for name, values in one.items()} != {name: values.shape for name, values in two.items()}:
        return float("inf")
    sizes = {name: float(np.max(np.abs(values), initial=0.0)) for name, values in two.items()}
    energies = ("kinetic_energy", "strain_energy", "external_work")
    energy = max((sizes.get(f"history of {name}", 0.0) for name in energies), default=0.0)
    scales = {f"history of {name}": energy for name in energies}
    momentum = np.sqrt(2 * energy * sizes.get("history of mass", 0.0))
    scales |= {f"history of {name}": max(momentum, sizes.get(f"history of {name}", 0.0)) for name in ("momentum", "impulse")}
    worst = 0.0
    for name, values in one.items():
        difference = float(np.max(np.abs(values - two[name]), initial=0.0))
        scale = scales.get(name, sizes[name])
        if difference != 0:
            worst = max(worst, difference / scale if scale > 0 and np.isfinite(difference) else float("inf"))
    return worst
