"""The self-test from the faults to the kill table; what is already known of a fault is not found out again."""

import json
import tempfile
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
from mpmverify.execution.workers import environment
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.kill_table import Fate, PlantedFault, Rates, SelfTest, UnmodifiedRun
from mpmverify.selftest.faults import Fault, passage
from mpmverify.selftest.named import NAMED
from mpmverify.selftest.processes import each_alone
from mpmverify.selftest.rules import faults, sampled
from mpmverify.selftest.survivors import EXPLAINED
from mpmverify.selftest.trials import TRIALS, merged
from mpmverify.selftest.unmodified import settings, unmodified
from mpmverify.selftest.verdict import Court, Fortune
from mpmverify.study import Study

EACH = 4
"""Faults of every rule and family in the full tier."""
RUNS = {"quick": 4, "full": 50}
"""Runs of the unmodified solvers."""
CODE = ("mpmverify.execution.evaluation", "mpmverify.judgement.judging", "mpmverify.selftest.verdict")
"""Modules that judge a fault."""
SERIES = {"quick": 13_500, "full": 270_000}
"""Random series that the judge is asked about."""
SEED = 11
COMPILATION = {"NUMBA_OPT": "1"}
"""Most of the time compiles what runs for a moment: less optimisation takes a quarter off."""

Progress = Callable[[str, int, int], None]
Row = TypeVar("Row", PlantedFault, UnmodifiedRun)


@dataclass(frozen=True)
class Session:
    """Everything that one self-test does.

    Parameters
    ----------
    results : Results
    get : callable
        Gives a study by its name.
    sources : Path
        Folder of the solvers.
    baseline : Baseline
    tier : str
        "quick" plants the named faults, "full" the sample of those by rule beside them.
    jobs : int
        Faults at a time.
    timeout : float
        Limit for one fault on all trials [s of processor time].
    """

    results: Results
    get: Callable[[str], Study]
    sources: Path
    baseline: Baseline
    tier: str = "quick"
    jobs: int = 1
    timeout: float = 120.0

    def run(self, progress: Progress = lambda *_: None) -> SelfTest:
        """Run the unmodified solvers, and the faults and random series when those pass.

        Raises
        ------
        UsageError, ResultsError
            If a fault or a trial was declared for other sources, or a file cannot be read or written.
        """
        trials = {family: tuple(trial.of(self.get) for trial in declared) for family, declared in TRIALS.items()}
        found = {family: faults(self.sources, family, plain=_plain(trials[family])) for family in TRIALS}
        planted = list(NAMED)
        if self.tier == "full":
            planted += [fault for family in TRIALS for fault in sampled(found[family], EACH)]
        keys = {fault.id: self._key(fault, trials[fault.family]) for fault in planted}
        studies = merged(study for declared in trials.values() for study in declared)
        runs = self._unmodified(studies, progress)
        first, sites = next(runs), sum(map(len, found.values()))
        if first.verdict != Verdict.PASS:  # no verdict on a fault would mean anything
            return SelfTest(self.tier, sites, (), (first,))
        # Half of the unmodified runs leave a processor idle.
        with ProcessPoolExecutor(1, get_context("spawn")) as beside:
            rates = self._rates(beside)
            unmodified_runs = (first, *runs)
            answered = rates()
        progress("verdicts on random series", 1, 1)
        for _ in run(studies, Plan(self._original, self.baseline, jobs=self.jobs)):
            pass  # what the faulty solvers are compared with
        rows = {fault.id: row for fault, row in self._planted(planted, keys, trials, progress)}
        return SelfTest(self.tier, sites, tuple(rows[fault.id] for fault in planted), unmodified_runs, answered)

    def _rates(self, beside: ProcessPoolExecutor) -> Callable[[], Rates]:
        """Ask another process how often the judge is right about random series of known truth; what is returned waits for it."""
        count = SERIES[self.tier]
        path = self._path(digest(count, SEED, code=("mpmverify.convergence.synthetic",)))
        try:
            stored = json.loads(path.read_text(encoding="utf-8"))
            known = Rates(**{name: tuple(Rate(**row) for row in rows) for name, rows in stored.items()})
        except (OSError, ValueError, TypeError, AttributeError):
            measures = ((measure, count), (measure_designs, count // 90), (measure_limits, count // 4))
            asked = [beside.submit(by, number, SEED) for by, number in measures]

            def answered() -> Rates:
                rates = Rates(*(tuple(future.result()) for future in asked))
                _store(path, rates)
                return rates

            return answered
        return lambda: known

    def _unmodified(self, studies: list[Study], progress: Progress) -> Iterator[UnmodifiedRun]:
        """Every setting once."""
        chosen = settings(RUNS[self.tier])
        for done, setting in enumerate(chosen, start=1):
            key = digest(
                studies, asdict(setting), file_digest(self.baseline.path), code=(*CODE, "mpmverify.selftest.unmodified")
            )
            row = _stored(self._path(key), UnmodifiedRun)
            if row is None:
                row = unmodified(studies, setting, self.baseline)
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
        # What a process that is ended at its limit leaves behind goes with the folder of them all.
        with environment(COMPILATION), tempfile.TemporaryDirectory(prefix="mpmverify-") as scratch:
            courts = {
                family: Court(self.sources, studies, self.baseline, self._original.path, Path(scratch))
                for family, studies in trials.items()
            }
            tasks = [(courts[fault.family], fault) for fault in waiting]
            for (_, fault), fortune in each_alone(_judge, tasks, self.jobs, self.timeout, _failed, imports):
                row = self._row(fault, fortune)
                if fortune.fate is not Fate.UNDECIDED:  # a busy machine is no verdict on a fault: it is tried again
                    _store(self._path(keys[fault.id]), row)
                done += 1
                progress("planted faults", done, len(planted))
                yield fault, row

    def _key(self, fault: Fault, trials: tuple[Study, ...]) -> str:
        """Content key: the patch, the trials and the original that they run, the baseline and the code that judges."""
        patch = sorted(fault.planted(self.sources).items())
        return digest(
            fault.id, fault.name, patch, trials, file_digest(self.baseline.path), EXPLAINED.get(fault.id, ""), code=CODE
        )

    def _row(self, fault: Fault, fortune: Fortune) -> PlantedFault:
        at, finding = passage(fault, self.sources), fortune.finding
        names = ("study", "case", "solver", "gate", "verdict", "criterion", "reason")
        said = {name: str(getattr(finding, name)) for name in names} if finding else {"reason": fortune.reason}
        return PlantedFault(
            id=fault.id,
            family=fault.family,
            rule=fault.rule,
            name=fault.name,
            file=at.file,
            line=at.line,
            before=at.before,
            after=at.after,
            fate=fortune.fate,
            deviation=fortune.deviation,
            trials=fortune.trials,
            seconds=fortune.seconds,
            explanation=EXPLAINED.get(fault.id, ""),
            **said,
        )

    @property
    def _original(self) -> Results:
        return Results(self.results.selftest.parent / "original")

    def _path(self, key: str) -> Path:
        return self.results.selftest.parent / "known" / f"{key}.json"


def _plain(trials: Sequence[Study]) -> bool:
    """Whether no trial has more than one dimension."""
    return all(case.problem.problem.dimension == 1 for study in trials for case, _ in study.series())


def _judge(task: tuple[Court, Fault]) -> Fortune:
    court, fault = task
    return court.judge(fault)


def _failed(reason: str, *, undecided: bool) -> Fortune:
    return Fortune(Fate.UNDECIDED if undecided else Fate.BROKEN, reason=reason)


def _store(path: Path, row: PlantedFault | UnmodifiedRun | Rates) -> None:
    write_atomic(path, lambda temporary: temporary.write_text(json.dumps(asdict(row)), encoding="utf-8"))


def _stored(path: Path, kind: type[Row]) -> Row | None:
    """Row that is known; None when there is none, or none that can be read."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        return kind(**(stored | ({"fate": Fate(stored["fate"])} if "fate" in stored else {})))
    except (OSError, ValueError, TypeError):
        return None
