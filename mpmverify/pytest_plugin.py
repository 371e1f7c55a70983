"""pytest plugin: it collects studies as tests, one test per criterion, and offers the fixture `verify` for your own solver.

Every pytest session imports this module. It therefore imports pytest and `mpmverify.errors` alone, until a study or the fixture is used.
"""

import argparse
import tempfile
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from mpmverify.errors import MpmverifyError, UsageError

if TYPE_CHECKING:
    from mpmverify.criteria.criterion import Criterion
    from mpmverify.criteria.evidence import SeriesId
    from mpmverify.execution.runner import Plan
    from mpmverify.execution.shared_study import CriterionId, SharedStudy
    from mpmverify.judgement.findings import Finding
    from mpmverify.solution import Solver
    from mpmverify.study import Refinement, Study

ROOT = "mpmverify"
"""First part of the node id of every criterion, and the name of its marker."""
SHARED = pytest.StashKey[tempfile.TemporaryDirectory[str]]()
"""Folder that the workers of pytest-xdist share."""


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup(ROOT, "verification studies")
    group.addoption("--mpmverify", action="store_true", help="Collect the shipped studies as tests, one test per criterion.")
    group.addoption(
        "--mpmverify-study",
        action="append",
        default=[],
        metavar="STUDY",
        help="Collect only this study: a shipped name, or FILE.py:NAME or MODULE:NAME for your own study; may be repeated.",
    )
    group.addoption("--mpmverify-out", metavar="DIR", help="Results folder; by default a folder in pytest's cache.")
    group.addoption("--mpmverify-tier", choices=["quick", "full"], default="quick", help="Number of levels.")
    group.addoption(
        "--mpmverify-jobs", type=_jobs, metavar="N", help="Number of worker processes; by default one per processor."
    )
    group.addoption(
        "--mpmverify-strict", action="store_true", help="Report an inconclusive verdict as failed instead of skipped."
    )
    group.addoption(
        "--mpmverify-baseline",
        metavar="FILE",
        help="Baseline of the regression gate; by default the shipped one, for shipped studies.",
    )
    group.addoption("--mpmverify-no-cache", action="store_true", help="Solve again what is already solved.")


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"the number of worker processes must be at least 1, not {text!r}")
    return int(text)


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", f"{ROOT}: a criterion of a study, collected by --mpmverify or --mpmverify-study.")
    # Checked here because pytest reports a UsageError at this point in one line, and later with a traceback.
    if _collects(config) and not (config.getoption("mpmverify_out") or config.pluginmanager.has_plugin("cacheprovider")):
        raise pytest.UsageError("pytest's cache is disabled: choose a results folder with --mpmverify-out")


def pytest_report_header(config: pytest.Config) -> str | None:
    if not _collects(config):
        return None
    return f"mpmverify: {config.getoption('mpmverify_tier')} tier, results in {_folder(config)}"


def _collects(config: pytest.Config) -> bool:
    return bool(config.getoption("mpmverify") or config.getoption("mpmverify_study"))


def _folder(config: pytest.Config) -> Path:
    """Results folder; the next session reuses the runs that it stores."""
    if chosen := config.getoption("mpmverify_out"):
        return Path(config.invocation_params.dir, chosen)
    return Path(config.cache.mkdir(ROOT))


# Collection, from the declarations alone: no run is solved. Node ids are mpmverify::study::case::solver::refinement::criterion.


@pytest.hookimpl(hookwrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, None]:
    """Add the studies to the items that the session collects from files."""
    outcome = yield
    if isinstance(collector, pytest.Session) and _collects(collector.config):
        report: pytest.CollectReport = outcome.get_result()
        if report.passed:
            report.result.append(Studies.from_parent(collector, name=ROOT, nodeid=ROOT))


class Studies(pytest.Collector):
    """All chosen studies."""

    def collect(self) -> Iterator["Branch"]:
        """Yield the studies.

        Raises
        ------
        CollectError
            If a study is unknown or has no criterion, or if two studies have the same name.
        """
        from mpmverify import studies
        from mpmverify.adapters.names import is_own, own_study
        from mpmverify.execution.shared_study import SharedStudy

        shared = getattr(self.config, "workerinput", {}).get("mpmverify_shared", "")
        known: dict[str, str] = {}
        try:
            for name in dict.fromkeys(self.config.getoption("mpmverify_study") or studies.NAMES):
                study = own_study(name) if is_own(name) else studies.get(name)
                if known.setdefault(study.name, name) != name:
                    raise UsageError(f"{known[study.name]!r} and {name!r} are both named {study.name!r}: rename one")
                gated = not is_own(name) or bool(self.config.getoption("mpmverify_baseline"))
                bench = SharedStudy(study, self._plan, partial(self._wanted, study.name), gated, shared)
                tree = bench.declared()
                if not any(titles for cases in tree.values() for ladders in cases.values() for titles in ladders.values()):
                    raise UsageError(f"the study {name!r} has no criterion: declare one for its series")
                yield Branch.from_parent(self, name=study.name, bench=bench, tree=tree)
        except MpmverifyError as error:
            raise self.CollectError(str(error)) from error

    def _wanted(self, study: str) -> "set[SeriesId]":
        from mpmverify.criteria.evidence import SeriesId

        items = (item for item in self.session.items if isinstance(item, CriterionItem))
        return {SeriesId(*item.identity[:3]) for item in items if item.bench.study.name == study}

    def _plan(self) -> "Plan":
        from mpmverify import studies
        from mpmverify.dataset.files import Results
        from mpmverify.execution.processes import processors
        from mpmverify.execution.runner import Plan
        from mpmverify.judgement.baseline import read_baseline

        option = self.config.getoption
        own = option("mpmverify_baseline")
        if own and not (path := Path(self.config.invocation_params.dir, own)).exists():
            raise UsageError(f"there is no baseline '{own}': make it with `mpmverify baseline accept`, or leave it out")
        return Plan(
            results=Results(_folder(self.config)),
            baseline=read_baseline(path) if own else read_baseline(studies.BASELINE, studies.NAMES),
            tier=option("mpmverify_tier"),
            jobs=option("mpmverify_jobs") or processors(),
            reuse=not option("mpmverify_no_cache"),
        )


class Branch(pytest.Collector):
    """Collector of a study, a case, a solver or a refinement.

    `tree` has the levels below it by name, and `above` the names of the levels above it, from the study on.
    """

    KINDS = ("Study", "Case", "Solver", "Refinement")

    def __init__(self, *, bench: "SharedStudy", tree: Any, above: tuple[str, ...] = (), **choices: Any) -> None:
        super().__init__(**choices)
        self.bench, self.tree, self.above = bench, tree, above

    def collect(self) -> "Iterator[Branch | CriterionItem]":
        for name in self.tree:
            here = (*self.above, name)
            if len(here) == len(self.KINDS):
                # Given as text: pytest then parses it as it parses the ids in its cache, even where a title ends in a bracket.
                nodeid = f"{self.nodeid}::{name}"
                yield CriterionItem.from_parent(self, name=name, nodeid=nodeid, bench=self.bench, identity=here)
            else:
                yield Branch.from_parent(self, name=name, bench=self.bench, tree=self.tree[name], above=here)

    def __repr__(self) -> str:
        return f"<{self.KINDS[len(self.above)]} {self.name}>"


class CriterionItem(pytest.Item):
    """One criterion of one series."""

    def __init__(self, *, bench: "SharedStudy", identity: "CriterionId", **choices: Any) -> None:
        super().__init__(**choices)
        self.bench, self.identity = bench, identity
        self.add_marker(ROOT)

    def setup(self) -> None:
        """Solve and judge the study; a verdict ERROR is reported as an error of the test's setup."""
        try:
            self.finding = self.bench.finding(self.identity)
            failure = _explained(self.finding) if self.finding.verdict == "ERROR" else ""
        except MpmverifyError as error:
            failure = str(error)
        if failure:  # outside of the handler: pytest would also show the exception that was being handled
            pytest.fail(failure, pytrace=False)

    def runtest(self) -> None:
        if self.finding.verdict == "INCONCLUSIVE" and not self.config.getoption("mpmverify_strict"):
            pytest.skip(str(self.finding))  # neither passed nor failed
        if self.finding.verdict != "PASS":
            pytest.fail(_explained(self.finding), pytrace=False)
        self.add_report_section("call", ROOT, str(self.finding))  # `-rP` shows it

    def reportinfo(self) -> tuple[Path, None, str]:
        return self.config.rootpath / ROOT, None, " ".join(self.identity)

    def __repr__(self) -> str:
        return f"<Criterion {self.name}>"


def _explained(finding: "Finding") -> str:
    return f"{finding}\n    expected by: {finding.source}"


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Give the workers of pytest-xdist a common temporary folder for this session."""
    config = node.config
    if _collects(config):
        if SHARED not in config.stash:
            config.stash[SHARED] = tempfile.TemporaryDirectory(prefix="mpmverify-")
            config.add_cleanup(config.stash[SHARED].cleanup)
        node.workerinput["mpmverify_shared"] = config.stash[SHARED].name


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Write the report of what was judged, and say where it is."""
    if not _collects(config) or config.getoption("collectonly"):
        return
    from mpmverify import reports
    from mpmverify.dataset.files import Results

    results = Results(_folder(config))
    try:
        if results.studies():
            with warnings.catch_warnings(action="ignore"):  # the filters of the project under test are not for the pages
                terminalreporter.write_line(f"mpmverify: report in {reports.render(results)}")
    except MpmverifyError as error:
        terminalreporter.write_line(f"mpmverify: no report: {error}")


# Your own solver.


@pytest.fixture
def verify(request: pytest.FixtureRequest) -> "Callable[..., tuple[Finding, ...]]":
    """Return a function that verifies your own solver on a study: verify(MySolver(), study="elastic-bar", case="pulse").

    The solver is any object with `name`, `orders`, `conserves` and `solve(problem, discretisation) -> Solution`. The function takes

    - the solver,
    - `study`: the name of a shipped study, or a `Study`,
    - `case`: the name of a case of the study; it may be omitted where the study has one case only,
    - `refinement`: by default the case's first ladder in h at one Courant number,
    - `criteria`: by default the declared orders of the solver, limited by the smoothness of the exact solution, and the
      quantities that it declares to conserve,
    - `timeout`: time limit of a run [s]; with a limit the runs are solved in a worker process.

    It returns the findings if every verdict is PASS. Any other verdict raises an AssertionError with the sentence of each criterion
    that did not pass. A UsageError says why nothing can be judged.
    """
    tier = request.config.getoption("mpmverify_tier")

    def check(
        solver: "Solver",
        study: "str | Study",
        case: str = "",
        *,
        refinement: "Refinement | None" = None,
        criteria: "Iterable[Criterion] | None" = None,
        timeout: float | None = None,
    ) -> "tuple[Finding, ...]":
        __tracebackhide__ = True
        from mpmverify import studies
        from mpmverify.convergence.verdict import Verdict
        from mpmverify.execution.verify import verify as verified

        try:
            declared = studies.get(study) if isinstance(study, str) else study
            demanded = None if criteria is None else tuple(criteria)
            findings = verified(solver, declared, case, refinement=refinement, criteria=demanded, tier=tier, timeout=timeout)
        except MpmverifyError as error:
            raise error.with_traceback(None) from None
        broken = [finding for finding in findings if finding.verdict is not Verdict.PASS]
        if broken or not findings:
            raise AssertionError("\n".join(_explained(finding) for finding in broken) or "nothing was judged")
        print(*findings, sep="\n")  # `-rP` shows it
        return findings

    return check
