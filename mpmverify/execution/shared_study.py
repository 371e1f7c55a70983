"""A study that tests share: solved once a session, when the first of its criteria is tested, by one of the processes."""

import contextlib
import dataclasses
import json
import sqlite3
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mpmverify.atomic import write_atomic
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria.evidence import SeriesId
from mpmverify.errors import MpmverifyError, UsageError
from mpmverify.execution.runner import Plan, run
from mpmverify.judgement.baseline import TITLE
from mpmverify.judgement.findings import Finding
from mpmverify.study import Study

CriterionId = tuple[str, str, str, str]
"""(case, solver, refinement, title)."""


@dataclass
class SharedStudy:
    """A study whose criteria are tested one by one.

    Parameters
    ----------
    study : Study
    plan : callable
        Returns the plan; called when the study is solved.
    wanted : callable
        Returns the series that the session has selected; only these are solved.
    gated : bool
        Whether the plan's baseline holds the study.
    shared : str
        Folder that the processes of a session share, "" when there is one process. The first process that needs a finding solves
        the study; the others wait.
    """

    study: Study
    plan: Callable[[], Plan]
    wanted: Callable[[], set[SeriesId]]
    gated: bool
    shared: str = ""
    _solved: dict[CriterionId, list[Finding]] | MpmverifyError | None = field(default=None, init=False)

    def declared(self) -> dict[str, dict[str, dict[str, list[str]]]]:
        """Titles of the criteria by case, solver and refinement."""
        tree: dict[str, dict[str, dict[str, list[str]]]] = {}
        for case, series in self.study.series():
            titles = [criterion.title for criterion in series.criteria]
            if self.gated:
                titles.append(TITLE)
            refinements = tree.setdefault(case.name, {}).setdefault(series.solver.name, {})
            refinements[series.refinement.label] = list(dict.fromkeys(titles))
        return tree

    def finding(self, criterion: CriterionId) -> Finding:
        """Worst finding with a title; the study is solved first if it is not solved yet.

        Raises
        ------
        MpmverifyError
            If the study cannot be solved, or the criterion was not judged.
        """
        if self._solved is None:
            try:
                self._solved = {}
                for finding in self._findings():
                    identity = finding.case, finding.solver, finding.refinement, finding.criterion
                    self._solved.setdefault(identity, []).append(finding)
            except MpmverifyError as error:
                self._solved = error
        if isinstance(self._solved, MpmverifyError):
            raise self._solved
        if criterion not in self._solved:
            raise UsageError(f"{' / '.join((self.study.name, *criterion))} was not judged")
        return max(self._solved[criterion], key=lambda finding: list(Verdict).index(finding.verdict))

    def _findings(self) -> Sequence[Finding]:
        if not self.shared:
            return self._run()
        with _locked(Path(self.shared, f"{self.study.name}.lock")):
            path = Path(self.shared, f"{self.study.name}.json")
            if not path.exists():
                text = json.dumps([dataclasses.asdict(finding) for finding in self._run()])
                write_atomic(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
            stored = json.loads(path.read_text(encoding="utf-8"))
        return [Finding.of(entry) for entry in stored]

    def _run(self) -> Sequence[Finding]:
        wanted = self.wanted()
        cases = []
        for case in self.study.cases:
            chosen = [s for s in case.series if (case.name, s.solver.name, s.refinement.label) in wanted]
            if chosen:
                cases.append(dataclasses.replace(case, series=tuple(chosen)))
        # Verdicts do not depend on the warning filters of the project under test.
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            (judged,) = run([dataclasses.replace(self.study, cases=tuple(cases))], self.plan())
        return judged.findings


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock between processes: that of a database file, which every platform releases when a process dies."""
    with contextlib.closing(sqlite3.connect(path, timeout=1e6, isolation_level=None)) as database:
        database.execute("BEGIN EXCLUSIVE")
        yield
