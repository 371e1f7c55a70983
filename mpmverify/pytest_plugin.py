"""pytest plugin: studies as tests, one a criterion, and the `verify` fixture for a solver of one's own.

Every session of pytest imports this module, so that it imports nothing but pytest until a study or the fixture is used.
"""

import argparse
import importlib
import tempfile
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
"""First part of the node id of every criterion, and its marker."""
SHARED = pytest.StashKey[tempfile.TemporaryDirectory[str]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup(ROOT, "verification studies")
    group.addoption("--mpmverify", action="store_true", help="Collect the shipped studies as tests, one a criterion.")
    group.addoption(
        "--mpmverify-study",
        action="append",
        default=[],
        metavar="STUDY",
        help="Collect this study alone: a shipped name, or MODULE:NAME for a study of your own; may be repeated.",
    )
    group.addoption("--mpmverify-out", metavar="DIR", help="Results folder; by default in the cache of pytest.")
    group.addoption("--mpmverify-tier", choices=["quick", "full"], default="quick", help="How many levels.")
    group.addoption("--mpmverify-jobs", type=_jobs, metavar="N", help="Worker processes; by default one a processor.")
    group.addoption("--mpmverify-strict", action="store_true", help="An inconclusive verdict fails instead of being skipped.")


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} worker processes can solve nothing: give a number from 1")
    return int(text)


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", f"{ROOT}: a criterion of a study, collected by --mpmverify.")
    # Here, where pytest shows one line for it, and not in a test, where it shows this file.
    if _collects(config) and not (config.getoption("mpmverify_out") or config.pluginmanager.has_plugin("cacheprovider")):
        raise pytest.UsageError("the cache of pytest is switched off: choose a results folder with --mpmverify-out")


def pytest_report_header(config: pytest.Config) -> str | None:
    if not _collects(config):
        return None
    return f"mpmverify: {config.getoption('mpmverify_tier')} tier, results in {_folder(config)}"


def _collects(config: pytest.Config) -> bool:
    return bool(config.getoption("mpmverify") or config.getoption("mpmverify_study"))


def _folder(config: pytest.Config) -> Path:
    """Results folder: runs that are solved are at hand in the next session."""
    if chosen := config.getoption("mpmverify_out"):
        return Path(config.invocation_params.dir, chosen)
    return Path(config.cache.mkdir(ROOT))


# Collection: mpmverify::study::case::solver::refinement::criterion, from the declarations alone.


@pytest.hookimpl(hookwrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, None]:
    """Add the studies to what the session collects from files."""
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
            If one is unknown or has no criterion, or two share a name.
        """
        from mpmverify import studies
        from mpmverify.execution.shared_study import SharedStudy

        shared = getattr(self.config, "workerinput", {}).get("mpmverify_shared", "")
        known: dict[str, str] = {}
        try:
            for name in dict.fromkeys(self.config.getoption("mpmverify_study") or studies.NAMES):
                study = _own_study(name) if ":" in name else studies.get(name)
                if known.setdefault(study.name, name) != name:
                    raise UsageError(f"{known[study.name]!r} and {name!r} are both named {study.name!r}: rename one")
                bench = SharedStudy(study, self._plan, partial(self._wanted, study.name), ":" not in name, shared)
                tree = bench.declared()
                if not any(titles for cases in tree.values() for ladders in cases.values() for titles in ladders.values()):
                    raise UsageError(f"the study {name!r} has no criterion: say what must hold of its series")
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
        return Plan(
            results=Results(_folder(self.config)),
            baseline=read_baseline(studies.BASELINE),
            tier=option("mpmverify_tier"),
            jobs=option("mpmverify_jobs") or processors(),
        )


def _own_study(name: str) -> "Study":
    from mpmverify.execution.evaluation import place
    from mpmverify.study import Study

    module, _, attribute = name.partition(":")
    try:
        study = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        remedy = "give MODULE:NAME of a module that Python finds, as `python -m pytest` finds those of this folder"
        raise UsageError(f"the study {name!r} cannot be imported ({error}): {remedy}") from error
    except (Exception, SystemExit) as error:  # a module may raise anything
        said = f"{type(error).__name__}: {error} ({place(error)})"
        raise UsageError(f"the study {name!r} cannot be imported, {said}: mend its module") from error
    if not isinstance(study, Study):
        raise UsageError(f"{name!r} is of the type {type(study).__name__}: give the name of a Study")
    return study


class Branch(pytest.Collector):
    """A study, a case of it, a solver or a refinement; `tree` is what lies below it, by name, and `above` what leads to it."""

    KINDS = ("Study", "Case", "Solver", "Refinement")

    def __init__(self, *, bench: "SharedStudy", tree: Any, above: tuple[str, ...] = (), **choices: Any) -> None:
        super().__init__(**choices)
        self.bench, self.tree, self.above = bench, tree, above

    def collect(self) -> "Iterator[Branch | CriterionItem]":
        for name in self.tree:
            here = (*self.above, name)
            if len(here) == len(self.KINDS):
                # As text, which pytest takes apart as it does the ids in its cache: a title may end in a bracket.
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
        """Have the study solved; a run that erred is an error of the set-up, as nothing could be judged."""
        try:
            self.finding = self.bench.finding(self.identity)
            failure = _explained(self.finding) if self.finding.verdict == "ERROR" else ""
        except MpmverifyError as error:
            failure = str(error)
        if failure:  # here, where pytest does not show what was handled above
            pytest.fail(failure, pytrace=False)

    def runtest(self) -> None:
        if self.finding.verdict == "INCONCLUSIVE" and not self.config.getoption("mpmverify_strict"):
            pytest.skip(str(self.finding))  # neither green nor red: nothing was decided
        if self.finding.verdict != "PASS":
            pytest.fail(_explained(self.finding), pytrace=False)

    def reportinfo(self) -> tuple[Path, None, str]:
        return self.config.rootpath / ROOT, None, " ".join(self.identity)

    def __repr__(self) -> str:
        return f"<Criterion {self.name}>"


def _explained(finding: "Finding") -> str:
    return f"{finding}\n    expected by: {finding.source}"


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Give the workers of pytest-xdist a folder that they share in this session alone."""
    config = node.config
    if _collects(config):
        if SHARED not in config.stash:
            config.stash[SHARED] = tempfile.TemporaryDirectory(prefix="mpmverify-")
            config.add_cleanup(config.stash[SHARED].cleanup)
        node.workerinput["mpmverify_shared"] = config.stash[SHARED].name


# A solver of one's own.


@pytest.fixture
def verify(request: pytest.FixtureRequest) -> "Callable[..., tuple[Finding, ...]]":
    """Put a solver of your own on a study: verify(MySolver(), study="elastic-bar", case="pulse").

    The solver is any object with `name`, `orders`, `conserves` and `solve(problem, discretisation) -> Solution`. Its declared orders,
    limited by the smoothness of the exact solution, and what it declares to conserve must hold on the first ladder of the case in h
    at one Courant number; `refinement` and `criteria` replace these. All but PASS is an AssertionError with the sentence of every
    criterion that does not hold; where nothing can be judged, a UsageError says why. With `timeout` (seconds a run) the runs are
    solved in a worker process.
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
        return findings

    return check
