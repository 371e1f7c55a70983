"""The pytest plugin: one test per criterion, the pytest outcome of each verdict, and the fixture `verify`."""

import subprocess
import sys
from collections import Counter
from importlib.metadata import entry_points
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner
from faulty_solvers import SECOND_ORDER, Scripted, plan, study

from mpmverify.cli import cli
from mpmverify.criteria import Stall
from mpmverify.execution.runner import run
from mpmverify.execution.shared_study import SharedStudy

TESTS = Path(__file__).parent
OWN = """
from faulty_solvers import Scripted, study

STUDY = study(Scripted(journal="{journal}"), Scripted("flat-fields", journal="{journal}"), Scripted("raises", order=1.0, below=0.0))
SHORT = study(Scripted(journal="{journal}"), name="short", levels=2)
TWIN = study(name="short")
VAIN = study(criteria=())
NUMBER = 3
"""
ORDER = "order of u in L2 in [1.9, 2.1]"
SERIES = "mpmverify::scripted::hill::scripted-{}::nu_C=0.5::{}"
FAILING = SERIES.format("raises", ORDER)


@pytest.fixture
def journal(tmp_path_factory):
    """File to which the scripted solvers write one line for every run."""
    path = tmp_path_factory.mktemp("journal") / "journal"
    path.touch()
    return path


@pytest.fixture
def project(pytester, journal, monkeypatch):
    """Project of a user: one ordinary test, and a module of studies whose solvers are those of these tests."""
    monkeypatch.setenv("PYTHONPATH", f"{TESTS}:{pytester.path}")
    pytester.syspathinsert(TESTS)
    pytester.syspathinsert()
    pytester.makepyfile(own=OWN.format(journal=journal))
    pytester.makepyfile(broken="1 / 0", leaving="raise SystemExit(3)")
    pytester.makepyfile("def test_of_the_project(): pass")
    monkeypatch.delitem(sys.modules, "own", raising=False)
    return pytester


def studies_of(*names):
    return [f"--mpmverify-study=own:{name}" for name in names]


def outcomes(result, **expected):
    found = result.parseoutcomes()
    assert {name: count for name, count in found.items() if name != "warnings" and name != "warning"} == expected


def solved(journal):
    """Number of solved runs by solver."""
    return Counter(line.split()[0] for line in journal.read_text().splitlines())


# A session without studies.


def test_the_plugin_is_an_entry_point_of_pytest():
    (found,) = [entry for entry in entry_points(group="pytest11") if entry.name == "mpmverify"]
    assert found.value == "mpmverify.pytest_plugin"


def test_a_session_without_studies_imports_the_plugin_and_the_errors_only(pytester):
    pytester.makepyfile(
        """
        import sys

        def test_nothing_is_imported():
            heavy = {"numpy", "numba", "scipy", "xarray", "netCDF4", "click", "sqlite3"} & sys.modules.keys()
            assert heavy == set()
            assert {m for m in sys.modules if m.startswith("mpmverify")} == {
                "mpmverify", "mpmverify.errors", "mpmverify.pytest_plugin"
            }
        """
    )
    others = [f"-pno:{name}" for name in ("hypothesispytest", "benchmark", "xdist")]
    outcomes(pytester.runpytest_subprocess(*others), passed=1)


def test_the_harness_does_not_import_pytest():
    code = "import sys, mpmverify.cli, mpmverify.execution.shared_study, mpmverify.execution.verify; sys.exit('pytest' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# Collection.


def test_every_criterion_is_a_selectable_item_and_collecting_solves_nothing(project, journal):
    result = project.runpytest_inprocess("--collect-only", "-q", *studies_of("STUDY", "SHORT"))
    listed = [line for line in result.outlines if line.startswith("mpmverify::")]
    titles = (ORDER, "mass conserved")
    expected = [SERIES.format(name, title) for name in ("good", "flat-fields", "raises") for title in titles]
    assert listed == expected + [f"mpmverify::short::hill::scripted-good::nu_C=0.5::{title}" for title in titles]
    assert any(line.endswith("::test_of_the_project") for line in result.outlines)
    assert journal.read_text() == ""
    assert not (project.path / ".pytest_cache/d/mpmverify/runs").exists()
    few = project.runpytest_inprocess("--collect-only", "-q", *studies_of("STUDY", "SHORT"), "-k", "short and mass")
    assert [line for line in few.outlines if "::" in line] == [
        "mpmverify::short::hill::scripted-good::nu_C=0.5::mass conserved"
    ]


def test_without_an_option_no_study_is_collected(project):
    result = project.runpytest_inprocess("-p", "no:cacheprovider", "--strict-markers")
    outcomes(result, passed=1)


@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        (["nope"], "unknown study 'nope': choose from advection, elastic-bar, gehojerez-deck"),
        (["own:NOPE"], "the study 'own:NOPE' cannot be imported (module 'own' has no attribute 'NOPE'): give FILE.py:NAME"),
        (["nowhere:STUDY"], "the study 'nowhere:STUDY' cannot be imported (No module named 'nowhere'): give FILE.py:NAME"),
        (
            ["broken:STUDY"],
            "the study 'broken:STUDY' cannot be imported, ZeroDivisionError: * (broken.py:1): correct its module",
        ),
        (["leaving:STUDY"], "the study 'leaving:STUDY' cannot be imported, SystemExit: 3 (leaving.py:1): correct its module"),
        (["own:VAIN"], "the study 'own:VAIN' has no criterion: declare one for its series"),
        (["own:NUMBER"], "'own:NUMBER' is of type int: give the name of a Study"),
        (["own:SHORT", "own:TWIN"], "'own:SHORT' and 'own:TWIN' are both named 'short': rename one"),
    ],
)
def test_a_study_that_cannot_be_collected_is_an_error_of_one_sentence(project, names, sentence):
    result = project.runpytest_inprocess(*(f"--mpmverify-study={name}" for name in names))
    result.stdout.fnmatch_lines([sentence.replace("[", "[[]") + "*"])
    assert result.ret == pytest.ExitCode.INTERRUPTED
    assert "Traceback" not in result.stdout.str()


@pytest.mark.parametrize("jobs", ["0", "-1", "two", "1.5"])
def test_an_invalid_number_of_workers_is_refused(project, jobs):
    result = project.runpytest_inprocess(f"--mpmverify-jobs={jobs}", "--collect-only")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*the number of worker processes must be at least 1, not '{jobs}'"])


def test_without_a_cache_a_results_folder_is_required(project):
    options = ("-p", "no:cacheprovider", "--collect-only", "-q", *studies_of("SHORT"))
    result = project.runpytest_inprocess(*options)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert [line for line in result.errlines if line] == [
        "ERROR: pytest's cache is disabled: choose a results folder with --mpmverify-out"
    ]
    assert project.runpytest_inprocess("--mpmverify-out=r", *options).ret == 0


def test_every_item_of_a_study_has_a_finding_and_every_finding_an_item(tmp_path):
    """Otherwise a verdict would not be shown, or a listed test would never be judged."""
    stalled = study(criteria=(Stall("u", "L2-max", 0.5, 0.0, 1.0, "made so"), *SECOND_ORDER), name="stalled")
    for declared in (study(Scripted(), Scripted("nan")), stalled):
        tree = SharedStudy(declared, lambda: plan(tmp_path), set, gated=True).declared()
        listed = {(c, s, r, t) for c, below in tree.items() for s, rs in below.items() for r, ts in rs.items() for t in ts}
        (judged,) = run([declared], plan(tmp_path))
        assert listed == {(f.case, f.solver, f.refinement, f.criterion) for f in judged.findings}


# Verdicts.


def test_each_item_reports_its_own_verdict_without_a_traceback(project, journal):
    report = project.path / "junit.xml"
    result = project.runpytest_inprocess("-v", "-rs", f"--junitxml={report}", *studies_of("STUDY", "SHORT"))
    # The second solver ends in an error for both criteria; the third is of first order; two levels are too few for an order.
    outcomes(result, passed=5, failed=1, errors=2, skipped=1)
    text = result.stdout.str()
    assert "Traceback" not in text
    assert "pytest_plugin.py:" not in text.replace("SKIPPED [1]", "").split("short test summary")[0]
    result.stdout.fnmatch_lines(
        [
            f"{SERIES.format('good', 'mass conserved')} PASSED*",
            "ERROR scripted/hill/scripted-flat-fields (nu_C=0.5): order of u*crashed; it returned an inconsistent solution*",
            "    expected by: made so",
            "FAIL scripted/hill/scripted-raises (nu_C=0.5): order of u*: order 1.000*lies outside [[]1.9, 2.1[]]*",
            "    expected by: made so",
            "SKIPPED*INCONCLUSIVE short/hill/scripted-good (nu_C=0.5): order of u*2 of 2 levels can be used*",
        ]
    )
    assert solved(journal) == {"scripted-good": 4, "scripted-flat-fields": 3}, (
        "each run is solved once, for all items of both studies, but for the one that only the second shows"
    )
    (suite,) = ElementTree.parse(report).getroot()
    cases = {f"{case.get('classname')}.{case.get('name')}": [child.tag for child in case] for case in suite}
    assert cases[f"mpmverify.scripted.hill.scripted-raises.nu_C=0.5.{ORDER}"] == ["failure"]
    assert cases[f"mpmverify.scripted.hill.scripted-flat-fields.nu_C=0.5.{ORDER}"] == ["error"]
    assert cases[f"mpmverify.short.hill.scripted-good.nu_C=0.5.{ORDER}"] == ["skipped"]
    assert cases["mpmverify.scripted.hill.scripted-good.nu_C=0.5.mass conserved"] == []

    # With --lf the next session reuses the finished runs and solves the failed ones again.
    again = project.runpytest_inprocess("--lf", *studies_of("STUDY", "SHORT"))
    outcomes(again, failed=1, errors=2, deselected=6)
    assert solved(journal) == {"scripted-good": 4, "scripted-flat-fields": 6}
    strict = project.runpytest_inprocess("--mpmverify-strict", *studies_of("SHORT"))
    outcomes(strict, passed=2, failed=1)
    strict.stdout.fnmatch_lines(["INCONCLUSIVE short/hill/scripted-good (nu_C=0.5): order of u*an order needs three*"])
    full = project.runpytest_inprocess("--mpmverify-strict", "--mpmverify-tier=full", *studies_of("SHORT"))
    outcomes(full, passed=3)


def test_only_selected_items_are_solved(project, journal):
    arguments = ("--mpmverify-out=results", "--mpmverify-jobs=1", *studies_of("STUDY"))
    outcomes(project.runpytest_inprocess("-m", "mpmverify", "-k", "raises", *arguments), passed=1, failed=1, deselected=5)
    assert journal.read_text() == ""
    assert len(list((project.path / "results/runs").glob("*.nc"))) == 3
    outcomes(project.runpytest_inprocess("--deselect", "mpmverify::scripted", *arguments), passed=1, deselected=6)
    assert journal.read_text() == ""


def test_a_pass_says_what_was_measured_and_the_report_is_written(project, journal):
    arguments = ("--mpmverify-out=results", "--mpmverify-jobs=1", "-rP", *studies_of("STUDY"))
    result = project.runpytest_inprocess("-k", "good", *arguments)
    result.stdout.fnmatch_lines(
        ["PASS scripted/hill/scripted-good *: order of u in L2 in *: order 2.0*", "mpmverify: report in *"]
    )
    assert (project.path / "results/report/index.html").is_file()
    assert (project.path / "results/report/scripted.html").is_file()


def test_runs_are_solved_again_when_asked(project, journal):
    arguments = ("--mpmverify-out=results", "--mpmverify-jobs=1", *studies_of("SHORT"))
    project.runpytest_inprocess(*arguments)
    first = solved(journal)
    project.runpytest_inprocess(*arguments)
    assert solved(journal) == first
    project.runpytest_inprocess("--mpmverify-no-cache", *arguments)
    assert solved(journal) == first + first


def test_a_baseline_that_is_named_gates_own_studies(project):
    arguments = ("--mpmverify-out=results", "--mpmverify-jobs=1", "-k", "good", *studies_of("STUDY"))
    missing = project.runpytest_inprocess("--mpmverify-baseline=none.json", *arguments)
    missing.stdout.fnmatch_lines(["there is no baseline 'none.json': make it with `mpmverify baseline accept`*"])
    project.runpytest_inprocess(*arguments)
    accepted = ["baseline", "accept", "--out", "results", "--baseline", "own.json", "--reason", "first"]
    assert CliRunner().invoke(cli, accepted).exit_code == 0
    outcomes(project.runpytest_inprocess("--mpmverify-baseline=own.json", *arguments), passed=3, deselected=7)


def test_xdist_workers_solve_a_study_once(project, journal):
    result = project.runpytest_subprocess("-n2", "--mpmverify-jobs=1", *studies_of("STUDY", "SHORT"))
    outcomes(result, passed=5, failed=1, errors=2, skipped=1)
    assert solved(journal) == {"scripted-good": 4, "scripted-flat-fields": 3}, (
        "the other worker does not repeat runs that ended in an error"
    )
    assert "Traceback" not in result.stdout.str()


def test_a_foreign_file_in_the_results_folder_is_named_and_kept(project):
    (project.path / "results").mkdir()
    (project.path / "results/short.nc").write_text("mine")
    result = project.runpytest_inprocess("--mpmverify-out=results", *studies_of("SHORT"))
    outcomes(result, passed=1, errors=2)
    result.stdout.fnmatch_lines(["'*short.nc' is not a readable netCDF file: move it away*"])
    assert "Traceback" not in result.stdout.str()
    assert "another exception" not in result.stdout.str()
    assert (project.path / "results/short.nc").read_text() == "mine"
    uncached = project.runpytest_inprocess("-p", "no:cacheprovider", *studies_of("SHORT"))
    assert uncached.ret == pytest.ExitCode.USAGE_ERROR
    uncached.stderr.fnmatch_lines(["ERROR: pytest's cache is disabled: choose a results folder with --mpmverify-out"])


def test_warnings_as_errors_do_not_change_a_verdict(project):
    outcomes(project.runpytest_inprocess("-W", "error", *studies_of("STUDY")), passed=4, failed=1, errors=2)


# The fixture.

FIXTURE = """
    import pytest
    from dataclasses import dataclass
    from faulty_solvers import Scripted, study, ladder, transported
    from mpmverify.criteria import Exact
    from mpmverify.errors import UsageError

    HILL = study()

    class Mine:
        name = "mine"
        orders = {{"u": 2.0}}
        conserves = frozenset({{"mass"}})

        def solve(self, problem, discretisation):
            return transported(problem, discretisation, discretisation.h**2)

    def test_it(verify):
        {body}
"""


@pytest.mark.parametrize(
    ("body", "passes", "lines"),
    [
        ("assert [f.verdict for f in verify(Mine(), HILL)] == ['PASS', 'PASS']", True, []),
        ("verify(Mine(), study='advection', case='gaussian', refinement=ladder(4))", True, []),
        ("verify(Mine(), HILL, criteria=[Exact('u', 'L2', 0.1, 'ours')])", True, []),
        (
            "Mine.orders = {'u': 1.0}; verify(Mine(), HILL)",
            False,
            [
                "E*AssertionError: FAIL scripted/hill/mine (nu_C=0.5): order of u in L2-max in *: order 2.000*lies outside*",
                "E*expected by: the solver declares order 1 of u on smooth data; where it is better than that*",
            ],
        ),
        ("verify(Scripted('nan'), HILL)", False, ["E*AssertionError: ERROR *non-finite; the solver reports completion*"]),
        ("verify(Scripted('raises'), HILL)", False, ["E*AssertionError: ERROR *crashed; ZeroDivisionError: *"]),
        ("verify(Scripted('hangs', below=0.04), HILL, timeout=1)", False, ["E*AssertionError: ERROR *timed out; no result*"]),
        ("verify(Mine(), HILL, refinement=ladder(2))", False, ["E*AssertionError: INCONCLUSIVE *an order needs three*"]),
        ("Mine.orders = {}; verify(Mine(), HILL)", False, ["E*UsageError: solver 'mine' declares no order of u*"]),
        ("verify(Mine(), HILL, criteria=[])", False, ["E*UsageError: no criterion is given for solver 'mine'*"]),
        ("verify(object(), HILL)", False, ["E*UsageError: object is not a solver: it lacks name, orders, conserves, solve"]),
        ("verify(Mine(), study='nope')", False, ["E*UsageError: unknown study 'nope': choose from advection*"]),
        (
            "pytest.raises(AssertionError, verify, Mine(), HILL, case='misspelt')",
            False,
            ["E*UsageError: study 'scripted' has no case 'misspelt': choose from hill"],
        ),
    ],
)
def test_the_fixture_passes_only_if_every_criterion_passes(project, body, passes, lines):
    project.makepyfile(test_fixture=FIXTURE.format(body=body))
    result = project.runpytest_inprocess("test_fixture.py")
    outcomes(result, **{"passed" if passes else "failed": 1})
    result.stdout.fnmatch_lines(lines)
    assert "execution/verify.py" not in result.stdout.str(), "the traceback has no frames of the library"


def test_the_fixture_judges_more_levels_in_the_full_tier(project):
    project.makepyfile(test_fixture=FIXTURE.format(body="verify(Mine(), HILL, refinement=ladder(2))"))
    outcomes(project.runpytest_inprocess("test_fixture.py", "--mpmverify-tier=full"), passed=1)
