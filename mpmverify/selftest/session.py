"""Run the self-test, from the faults to the kill table; stored results are reused."""

import json
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from mpmverify.atomic import write_atomic
from mpmverify.convergence.synthetic import Rate, measure, measure_designs, measure_limits
from mpmverify.convergence.verdict import Verdict
from mpmverify.dataset.files import Results
from mpmverify.execution.keys import digest, file_digest
from mpmverify.execution.runner import Plan, run
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.kill_table import Fate, PlantedFault, Rates, SelfTest, UnmodifiedRun
from mpmverify.selftest.fault_judge import FaultJudge, FaultResult
from mpmverify.selftest.faults import Fault, passage
from mpmverify.selftest.named import NAMED
from mpmverify.selftest.processes import each_alone
from mpmverify.selftest.reach import Lines, lines_run
from mpmverify.selftest.rules import faults, sampled
from mpmverify.selftest.survivors import EXPLAINED
from mpmverify.selftest.trials import TRIALS, merged
from mpmverify.selftest.unmodified import settings, unmodified
from mpmverify.study import Study

FAULTS_PER_RULE = 4
"""Faults of each rule and family in the full tier."""
UNMODIFIED_RUNS = {"quick": 4, "full": 50}
"""Number of runs of the unmodified solvers."""
CODE = ("mpmverify.execution.evaluation", "mpmverify.judgement.judging", "mpmverify.selftest.fault_judge")
"""Modules that judge a fault: their source text is part of the content keys."""
RANDOM_SERIES = {"quick": 9_800, "full": 196_000}
"""Number of random error series whose verdicts are checked."""
SEED = 11

Progress = Callable[[str, int, int], None]
Row = TypeVar("Row", PlantedFault, UnmodifiedRun)


EVERY_STUDY = 10
"""Factor on the limit of processor time of a fault that runs every study."""
PATIENT = 600.0
"""Limit on the processor time of a trial of the unmodified solvers, which is traced line by line [s]."""


@dataclass(frozen=True)
class Session:
    """One self-test.

    Parameters
    ----------
    results : Results
    get : callable
        Returns a study by name.
    sources : Path
        Folder of the solvers.
    baseline : Baseline
    tier : str
        "quick" plants the named faults; "full" also plants a sample of the faults by rule.
    jobs : int
        Number of faults judged at the same time.
    every_study : bool
        Whether a fault that one study killed runs the trials of the other studies, too.
    timeout : float
        Limit on the processor time of one fault over the trials up to its first kill [s]; `EVERY_STUDY` times that over all studies.
    """

    results: Results
    get: Callable[[str], Study]
    sources: Path
    baseline: Baseline
    tier: str = "quick"
    jobs: int = 1
    every_study: bool = False
    timeout: float = 120.0

    def run(self, progress: Progress = lambda *_: None) -> SelfTest:
        """Run the unmodified solvers and, if they pass, judge the faults and the random series.

        Raises
        ------
        UsageError
            If a fault or a trial does not fit the sources.
        ResultsError
            If a file cannot be read or written.
        """
        trials = {family: tuple(trial.of(self.get) for trial in declared) for family, declared in TRIALS.items()}
        found = {family: faults(self.sources, family, one_dimensional=_one_dimensional(trials[family])) for family in TRIALS}
        planted = list(NAMED)
        if self.tier == "full":
            planted += [fault for family in TRIALS for fault in sampled(found[family], FAULTS_PER_RULE)]
        keys = {fault.id: self._key(fault, trials[fault.family]) for fault in planted}
        studies = merged(study for declared in trials.values() for study in declared)
        runs = self._unmodified(studies, progress)
        first, sites = next(runs), sum(map(len, found.values()))
        if first.verdict != Verdict.PASS:  # verdicts on faults would mean nothing
            return SelfTest(self.tier, sites, (), (first,))
        # The random series use the processors that half of the unmodified runs leave idle.
        with ProcessPoolExecutor(1, get_context("spawn")) as executor:
            rates = self._rates(executor)
            unmodified_runs = (first, *runs)
            known_rates = rates()
        progress("verdicts on random series", 1, 1)
        for _ in run(studies, Plan(self._original, self.baseline, jobs=self.jobs)):
            pass  # the results that those of the faulty solvers are compared with
        rows = {fault.id: row for fault, row in self._planted(planted, keys, trials, progress)}
        found_rows = tuple(rows[fault.id] for fault in planted)
        return SelfTest(self.tier, sites, found_rows, unmodified_runs, known_rates, self.every_study)

    def _rates(self, executor: ProcessPoolExecutor) -> Callable[[], Rates]:
        """Measure in another process how often the judge is right about random series; the returned function waits for the rates."""
        count = RANDOM_SERIES[self.tier]
        path = self._path(digest(count, SEED, code=("mpmverify.convergence.synthetic",)))
        try:
            stored = json.loads(path.read_text(encoding="utf-8"))
            known = Rates(**{name: tuple(Rate(**row) for row in rows) for name, rows in stored.items()})
        except (OSError, ValueError, TypeError, AttributeError):
            measures = ((measure, count), (measure_designs, count // 90), (measure_limits, count // 4))
            futures = [executor.submit(by, number, SEED) for by, number in measures]

            def measured() -> Rates:
                rates = Rates(*(tuple(future.result()) for future in futures))
                _store(path, rates)
                return rates

            return measured
        return lambda: known

    def _unmodified(self, studies: list[Study], progress: Progress) -> Iterator[UnmodifiedRun]:
        """Run the unmodified solvers once for each setting: those of all studies first, and of a third of them in most of many runs.

        A third stays for nine settings, so that it meets every number of processes with every number of threads.
        """
        chosen = settings(UNMODIFIED_RUNS[self.tier])
        for done, setting in enumerate(chosen, start=1):
            third = (done - 1) // 9 % 3
            some = studies if done <= UNMODIFIED_RUNS["quick"] else studies[third::3]
            key = digest(some, asdict(setting), file_digest(self.baseline.path), code=(*CODE, "mpmverify.selftest.unmodified"))
            row = _stored(self._path(key), UnmodifiedRun)
            if row is None:
                row = unmodified(some, setting, self.baseline)
                _store(self._path(key), row)
            progress("unmodified solvers", done, len(chosen))
            yield row

    def _planted(
        self, planted: Sequence[Fault], keys: dict[str, str], trials: dict[str, tuple[Study, ...]], progress: Progress
    ) -> Iterator[tuple[Fault, PlantedFault]]:
        done, waiting = 0, []
        for fault in planted:
            row = _stored(self._path(keys[fault.id]), PlantedFault)
            if row is None:
                waiting.append(fault)
            else:
                done += 1
                progress("planted faults", done, len(planted))
                yield fault, row
        modules = {type(s.solver).__module__ for studies in trials.values() for study in studies for _, s in study.series()}
        imports = sorted({*CODE, *modules})
        # This folder holds all temporary files, so that those of a killed process are removed, too.
        with tempfile.TemporaryDirectory(prefix="mpmverify-") as scratch:
            lines = self._lines({fault.family: trials[fault.family] for fault in waiting}, Path(scratch), imports)
            judges = {
                family: FaultJudge(
                    self.sources, trials[family], self.baseline, self._original.path, Path(scratch), found, self.every_study
                )
                for family, found in lines.items()
            }
            tasks = [(judges[fault.family], fault) for fault in waiting]
            timeout = self.timeout * (EVERY_STUDY if self.every_study else 1)
            for (_, fault), result in each_alone(_judge, tasks, self.jobs, timeout, _failed, imports):
                row = self._row(fault, result)
                if result.fate is not Fate.UNDECIDED:  # the machine was too busy: the next self-test tries again
                    _store(self._path(keys[fault.id]), row)
                done += 1
                progress("planted faults", done, len(planted))
                yield fault, row

    def _lines(
        self, trials: dict[str, tuple[Study, ...]], scratch: Path, imports: Sequence[str]
    ) -> dict[str, tuple[Lines, ...]]:
        """Find out which lines of the solvers each trial runs."""
        tasks = [(family, k, study, self.sources, scratch) for family, of in trials.items() for k, study in enumerate(of)]
        found = {
            (family, k): lines
            for (family, k, *_), lines in each_alone(_lines_run, tasks, self.jobs, PATIENT, _without_lines, imports)
        }
        return {family: tuple(found[family, k] for k in range(len(of))) for family, of in trials.items()}

    def _key(self, fault: Fault, trials: tuple[Study, ...]) -> str:
        """Return the content key: the patch, the trials with their unmodified solvers, the baseline and the judging code."""
        patch = sorted(fault.planted(self.sources).items())
        known = file_digest(self.baseline.path), EXPLAINED.get(fault.id, ""), self.every_study
        return digest(fault.id, fault.name, patch, trials, *known, code=CODE)

    def _row(self, fault: Fault, result: FaultResult) -> PlantedFault:
        at, finding = passage(fault, self.sources), result.finding
        names = ("study", "case", "solver", "gate", "verdict", "criterion", "reason")
        judgement = {name: str(getattr(finding, name)) for name in names} if finding else {"reason": result.reason}
        return PlantedFault(
            id=fault.id,
            family=fault.family,
            rule=fault.rule,
            name=fault.name,
            file=at.file,
            line=at.line,
            before=at.before,
            after=at.after,
            fate=result.fate,
            deviation=result.deviation,
            trials=result.trials,
            killed_by=",".join(result.killed_by),
            passed=",".join(result.passed),
            seconds=result.seconds,
            explanation=EXPLAINED.get(fault.id, ""),
            **judgement,
        )

    @property
    def _original(self) -> Results:
        return Results(self.results.selftest.parent / "original")

    def _path(self, key: str) -> Path:
        return self.results.selftest.parent / "known" / f"{key}.json"


def _one_dimensional(trials: Sequence[Study]) -> bool:
    """Whether all trials are one-dimensional."""
    return all(case.problem.problem.dimension == 1 for study in trials for case, _ in study.series())


def _judge(task: tuple[FaultJudge, Fault]) -> FaultResult:
    judge, fault = task
    try:
        return judge.judge(fault)
    except Exception:
        traceback.print_exc()  # here, where the place is known: the error reaches the caller as text
        raise


def _lines_run(task: tuple[str, int, Study, Path, Path]) -> Lines:
    _, _, trial, sources, scratch = task
    return lines_run(trial, sources, scratch)


def _without_lines(reason: str, *, undecided: bool) -> Lines:
    raise RuntimeError(f"a trial of the unmodified solvers does not run: {reason}")


def _failed(reason: str, *, undecided: bool) -> FaultResult:
    return FaultResult(Fate.UNDECIDED if undecided else Fate.BROKEN, reason=reason)


def _store(path: Path, row: PlantedFault | UnmodifiedRun | Rates) -> None:
    write_atomic(path, lambda temporary: temporary.write_text(json.dumps(asdict(row)), encoding="utf-8"))


def _stored(path: Path, kind: type[Row]) -> Row | None:
    """Return the stored row, or None if there is none that can be read."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        return kind(**(stored | ({"fate": Fate(stored["fate"])} if "fate" in stored else {})))
    except (OSError, ValueError, TypeError):
        return None
