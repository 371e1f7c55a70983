"""Judge planted faults: run the trials with a faulty solver and determine the fate of the fault."""

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
from mpmverify.dataset.runs import Run, read_run
from mpmverify.errors import UsageError
from mpmverify.execution.runner import Plan, run, tasks_of
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.kill_table import Fate
from mpmverify.selftest.faults import Edit, Fault
from mpmverify.selftest.planting import planted, replanted
from mpmverify.selftest.reach import Lines, reaches
from mpmverify.selftest.syntax import names
from mpmverify.solution import Solution, Status
from mpmverify.study import Study

ROUND_OFF = 1e-11
"""Results whose relative difference is at most this count as the same."""

CONTRACT = "contract of a solution"
"""Criterion reported for a fault that raises no exception but returns an invalid solution: such a run counts as crashed."""


@dataclass(frozen=True)
class FaultResult:
    """Result of judging one fault.

    Parameters
    ----------
    fate : Fate
    finding : Finding or None
        The finding that killed the fault, or the first finding on a survivor that is not a PASS.
    reason : str
        Why the faulty solver does not run.
    deviation : float
        Largest relative deviation of its results from the unmodified solver's, over the trials that did not kill it.
    trials : int
        Number of trials that were run.
    killed_by, passed : tuple of str
        Studies whose verification killed the fault, and studies that it ran without being killed.
    seconds : float
        Wall time, including compilation [s].
    """

    fate: Fate
    finding: Finding | None = None
    reason: str = ""
    deviation: float = 0.0
    trials: int = 0
    killed_by: tuple[str, ...] = ()
    passed: tuple[str, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class FaultJudge:
    """Judges the faults of one solver family.

    Parameters
    ----------
    sources : Path
        Folder of the solvers.
    trials : tuple of Study
        Each has one solver in one case.
    baseline : Baseline
        Baseline of the regression gate.
    original : Path
        Results folder with the runs of the unmodified solvers.
    scratch : Path
        Parent folder of the temporary folders.
    lines : tuple of Lines
        Lines that each trial runs; a fault is tried where it is reached alone.
    every_study : bool
        Whether a fault that one study killed runs the trials of the other studies, too.
    """

    sources: Path
    trials: tuple[Study, ...]
    baseline: Baseline
    original: Path
    scratch: Path
    lines: tuple[Lines, ...]
    every_study: bool = False

    def judge(self, fault: Fault) -> FaultResult:
        """Run the trials that reach the fault until one of them kills it, or until each study has killed it or passed."""
        began = time.perf_counter()
        if not any(reaches(lines, fault, self.sources) for lines in self.lines):
            return FaultResult(Fate.NOT_EXERCISED)
        with tempfile.TemporaryDirectory(dir=self.scratch) as folder:
            result = self._run_trials(fault, Path(folder))
            if result.fate is Fate.EQUIVALENT and not self._exercised(fault, Path(folder)):
                result = dataclasses.replace(result, fate=Fate.NOT_EXERCISED)
        return dataclasses.replace(result, seconds=time.perf_counter() - began)

    def _run_trials(self, fault: Fault, folder: Path) -> FaultResult:
        doubtful: Finding | None = None
        regression: Finding | None = None
        deviation, ran = 0.0, 0
        killed: dict[str, Finding] = {}
        refused: set[str] = set()
        reached = [trial for trial, lines in zip(self.trials, self.lines, strict=True) if reaches(lines, fault, self.sources)]
        with planted(fault, self.sources, folder) as package:
            for trial in reached:
                if trial.name in killed:
                    continue
                ran += 1
                results = Results(folder / f"trial-{ran}")
                try:
                    faulty = replanted(trial, package)
                except Exception as error:  # a faulty module may raise anything when imported
                    return FaultResult(Fate.BROKEN, reason=f"{type(error).__name__}: {error}", trials=ran)
                try:
                    findings = self._findings(faulty, results)
                except UsageError as error:
                    if killed:
                        refused.add(trial.name)
                        continue
                    return FaultResult(
                        Fate.BROKEN, reason=f"the solver refuses the problem: {error}", deviation=deviation, trials=ran
                    )
                if killer := _killer(findings, "verification"):
                    if f": {Status.CRASHED}" in killer.reason:
                        if not killed and _raises(faulty):
                            return FaultResult(Fate.BROKEN, killer, deviation=deviation, trials=ran)
                        killer = dataclasses.replace(killer, criterion=CONTRACT)
                    killed[trial.name] = killer
                    if not self.every_study:
                        break
                    continue
                regression = regression or _killer(findings, "regression")
                doubtful = doubtful or next((f for f in findings if f.verdict is not Verdict.PASS), None)
                deviation = max(deviation, *self._deviations(trial, faulty, results))
        fate, finding = (Fate.EQUIVALENT if deviation <= ROUND_OFF else Fate.SURVIVED), doubtful
        if killed:
            fate, finding = Fate.KILLED, next(iter(killed.values()))
        elif regression:
            fate, finding = Fate.REGRESSION, regression
        passed = tuple(dict.fromkeys(trial.name for trial in reached if trial.name not in killed.keys() | refused))
        if killed and not self.every_study:
            passed = ()  # the trials after the first kill were not run
        return FaultResult(fate, finding, "", deviation, ran, tuple(killed), passed)

    def _findings(self, study: Study, results: Results) -> list[Finding]:
        (judged,) = run([study], Plan(results, self.baseline, jobs=0))
        return [finding for finding in judged.findings if counts(finding)]

    def _deviations(self, trial: Study, faulty: Study, results: Results) -> Iterator[float]:
        """Yield the deviation of each run of a trial from the same run of the unmodified solver."""
        original = Results(self.original)
        for reference, task in zip(
            tasks_of(trial, Plan(original, self.baseline)), tasks_of(faulty, Plan(results, self.baseline)), strict=True
        ):
            mine, theirs = read_run(results.run(task.key), task.key), read_run(original.run(reference.key), reference.key)
            # The errors are those of all outputs; the solutions have only some of them.
            yield max(deviation(mine.solution, theirs.solution), change_of_errors(mine, theirs))

    def _exercised(self, fault: Fault, folder: Path) -> bool:
        """Whether a trial reaches the edited passage: with a tripwire there, which raises or spoils arrays, some result differs."""
        tripped = dataclasses.replace(fault, edits=(_tripwire(fault.edits[0], self.sources),))
        return dataclasses.replace(self, every_study=False)._run_trials(tripped, folder).fate is not Fate.EQUIVALENT


def _raises(trial: Study) -> bool:
    """Whether a solver raises on a trial; a run that counts as crashed without an exception returned an invalid solution."""
    for case, series in trial.series():
        for level in series.refinement.tier("quick"):
            try:
                series.solver.solve(case.problem.problem, level)
            except Exception:  # a faulty solver may raise anything
                return True
    return False


TRACING_DECORATORS = {"traced", "_pass", "contextmanager"}
"""Decorators of functions that Python calls while code is being compiled, not while the compiled code runs."""
SPOIL = "__import__('mpmverify.selftest.tripwire', fromlist=['spoil_arrays']).spoil_arrays(locals())"


def _tripwire(edit: Edit, sources: Path) -> Edit:
    """Insert a tripwire before the statement that an edit changes: an exception, or `spoil_arrays` in a traced function."""
    text = (sources / edit.file).read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    line = text.count("\n", 0, edit.begin(text)) + 1
    around = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.stmt) and node.lineno <= line <= (node.end_lineno or 0)
    ]
    decorators = [one for node in around if isinstance(node, ast.FunctionDef) for one in node.decorator_list]
    traced = any(names(one) & TRACING_DECORATORS for one in decorators)
    around = [node for node in around if not lines[node.lineno - 1].lstrip().startswith("elif")]
    first = max(around, key=lambda node: (node.lineno, node.col_offset)).lineno - 1
    indent = lines[first][: len(lines[first]) - len(lines[first].lstrip())]
    tripwire = SPOIL if traced else "raise ArithmeticError"
    return Edit(edit.file, text, "".join([*lines[:first], f"{indent}{tripwire}\n", *lines[first:]]))


def counts(finding: Finding) -> bool:
    """Whether a finding counts; an inconclusive regression finding does not, because the baseline has no entry for it."""
    return finding.gate == "verification" or finding.verdict is not Verdict.INCONCLUSIVE


def _killer(findings: Sequence[Finding], gate: str) -> Finding | None:
    """Return the first FAIL of a gate, or its first ERROR if there is no FAIL."""
    for verdict in (Verdict.FAIL, Verdict.ERROR):
        for finding in findings:
            if finding.gate == gate and finding.verdict is verdict:
                return finding
    return None


def change_of_errors(faulty: Run, original: Run) -> float:
    """Return the largest difference between error norms, relative to the sizes of the exact fields; infinite where one is not a number."""
    worst = 0.0
    for quantity in faulty.errors.keys() & original.errors.keys():
        (mine, _), (theirs, size) = faulty.errors[quantity], original.errors[quantity]
        if not np.array_equal(mine, theirs, equal_nan=True):
            change = np.abs(mine - theirs) / np.where(size > 0, size, 1.0)
            worst = max(worst, float(np.max(np.where(np.isnan(change), np.inf, change))))
    return worst


def deviation(faulty: Solution, original: Solution) -> float:
    """Return the largest relative deviation of any array of a solution; infinite if shapes, outcomes or time steps differ.

    Notes
    -----
    Each array is scaled by its largest magnitude, with two exceptions. The momenta of the particles may cancel in their sum, so
    momentum and impulse are scaled by at least sqrt(2 m E), where m is the largest mass and E the largest energy. Energies and
    external work are scaled by E. Two runs that both became unstable, at any step, have deviation 0: neither has a result.
    """
    if (faulty.outcome.status, faulty.dt) != (original.outcome.status, original.dt):
        return float("inf")
    if not faulty.outcome.completed:
        return 0.0
    arrays, references = faulty.arrays(), original.arrays()
    if {name: values.shape for name, values in arrays.items()} != {name: values.shape for name, values in references.items()}:
        return float("inf")
    sizes = {name: float(np.max(np.abs(values), initial=0.0)) for name, values in references.items()}
    energies = ("kinetic_energy", "strain_energy", "external_work")
    energy = max((sizes.get(f"history of {name}", 0.0) for name in energies), default=0.0)
    scales = {f"history of {name}": energy for name in energies}
    momentum = np.sqrt(2 * energy * sizes.get("history of mass", 0.0))
    scales |= {f"history of {name}": max(momentum, sizes.get(f"history of {name}", 0.0)) for name in ("momentum", "impulse")}
    worst = 0.0
    for name, values in arrays.items():
        difference = float(np.max(np.abs(values - references[name]), initial=0.0))
        scale = scales.get(name, sizes[name])
        if difference != 0:
            worst = max(worst, difference / scale if scale > 0 and np.isfinite(difference) else float("inf"))
    return worst
