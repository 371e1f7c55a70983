"""Solvers and studies of one's own on the command line: FILE.py:NAME and MODULE:NAME."""

import json
import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from handbook import file

from mpmverify import studies
from mpmverify.adapters.names import own_solver, own_study
from mpmverify.cli import cli
from mpmverify.errors import UsageError
from mpmverify.execution.keys import digest
from mpmverify.execution.verify import verify

STUDY = """
import dataclasses

from mpmverify import studies

VIBRATION = studies.get("axial-vibration")
STUDY = VIBRATION.with_solver(Leapfrog())
ONE_CASE = dataclasses.replace(VIBRATION, name="one-case", cases=VIBRATION.cases[:1])
"""
OTHERS = """
import time

class Bare:
    name = "bare"


class Asking(Leapfrog):
    def __init__(self, order):
        self.order = order


class Raising(Leapfrog):
    def solve(self, problem, discretisation):
        return self.helper([])

    def helper(self, nothing):
        return nothing[3]


class Hanging(Leapfrog):
    def solve(self, problem, discretisation):
        time.sleep(600)


ORDINARY = Asking(2)
NUMBER = 3
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Path:
    """Working folder with a module of own code, of a name that no other test imports."""
    name = f"own_{abs(hash(request.node.name))}"
    (tmp_path / f"{name}.py").write_text(file("test_leapfrog.py") + STUDY + OTHERS, encoding="utf-8")
    (tmp_path / "broken.py").write_text("1 / 0\n", encoding="utf-8")
    (tmp_path / "json.py").write_text("", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    return tmp_path / f"{name}.py"


def run(*arguments: str):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def test_a_solver_in_a_file_gets_verdicts_a_file_and_a_page_beside_a_shipped_one(folder):
    result = run("run", "axial-vibration", "large-deformation", "--with", f"{folder.name}:Leapfrog", "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "Left out: large-deformation, bar; " in result.output
    stored = json.loads(Path("results/verdicts.json").read_text(encoding="utf-8"))["studies"]
    assert list(stored) == ["axial-vibration-with-leapfrog"]
    findings = stored["axial-vibration-with-leapfrog"]["findings"]
    assert {finding["gate"] for finding in findings} == {"verification"}
    assert {finding["solver"] for finding in findings} > {"leapfrog"}
    assert Path("results/report/axial-vibration-with-leapfrog.html").is_file()
    mine = [finding["reason"] for finding in findings if (finding["solver"], finding["case"]) == ("leapfrog", "literature")]
    direct = verify(own_solver(f"{folder.name}:Leapfrog"), studies.get("axial-vibration"), "literature")
    assert [finding.reason for finding in direct] == mine
    assert run("gate", "--strict").exit_code == 0
    again = run("run", "axial-vibration", "--with", f"{folder.name}:Leapfrog", "--jobs", "1")
    assert "0 runs solved" in again.output


def test_a_failure_is_said_once_with_its_place(folder):
    result = run("run", "axial-vibration", "--with", f"{folder.name}:Raising", "--jobs", "1")
    assert result.exit_code == 3
    said = " ".join(result.output.split())
    assert said.count("IndexError: list index out of range") == 1
    assert "2 criteria on literature, small-strain: every level: crashed" in said
    assert f"({folder.name}:" in said
    checked = run("check", f"{folder.name}:Raising", "axial-vibration")
    assert checked.exit_code == 3
    assert "return self.helper([])" in checked.output
    assert "return nothing[3]" in checked.output


def test_of_a_solver_that_hangs_one_level_is_tried(folder):
    result = run("run", f"{folder.stem}:ONE_CASE", "--with", f"{folder.name}:Hanging", "--jobs", "1", "--timeout", "1")
    assert result.exit_code == 3
    stored = json.loads(Path("results/verdicts.json").read_text(encoding="utf-8"))["studies"]
    (findings,) = (study["findings"] for study in stored.values())
    reasons = {finding["reason"] for finding in findings if finding["solver"] == "leapfrog"}
    assert reasons == {
        "h=1.5625: timed out; no result within 1 s; the run exceeded its time limit: raise the limit or coarsen the level"
    }


def test_a_study_in_a_file_is_listed_run_and_judged_by_its_name(folder):
    listed = run("list", folder.name)
    assert listed.output.startswith("axial-vibration-with-leapfrog: ")
    ran = run("run", f"{folder.stem}:STUDY", "--jobs", "1")
    assert ran.exit_code == 0, ran.output
    assert run("gate", folder.name, "--strict").exit_code == 0
    own = run("gate", "--strict", "--baseline", studies.BASELINE)
    assert own.exit_code == 4
    assert "not in the baseline" in own.output.replace("\n", " "), "a baseline that is named gates every study"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run", "none.py"], "there is no file 'none.py'"),
        (["run", "nowhere:STUDY"], "cannot be imported (No module named 'nowhere')"),
        (["run", "json.py"], "has the name of another module, 'json'"),
        (["run", "broken.py"], "ZeroDivisionError"),
        (["run", "{}:NUMBER"], "is of type int: give the name of a Study"),
        (["run", "--with", "{}"], "names no solver: give FILE.py:NAME"),
        (["run", "--with", "{}:None"], "has no attribute 'None'"),
        (["run", "--with", "{}:Bare"], "is not a solver: it lacks orders, conserves, solve"),
        (["run", "--with", "{}:Asking"], "is a class that needs arguments"),
        (
            ["run", "axial-vibration", "--with", "{}:ORDINARY"],
            "has no content key: make Asking a frozen dataclass with the fields order",
        ),
        (["run", "advection", "--with", "{}:Leapfrog"], "declares no order of u"),
        (["run", "nope", "--with", "{}:Leapfrog"], "unknown study 'nope'"),
    ],
)
def test_what_cannot_be_used_is_said_in_a_sentence(folder, arguments, sentence):
    result = run(*(argument.replace("{}", folder.name) for argument in arguments))
    assert result.exit_code == 2
    assert sentence in result.output.replace("\n", " ")
    assert "Traceback" not in result.output


def test_an_instance_without_attributes_is_known_by_its_class(folder):
    one, other = (own_solver(f"{folder.name}:Leapfrog") for _ in range(2))
    assert one is not other
    assert digest(one) == digest(other) != digest(own_study(folder.name).cases[0].series[1].solver)
    with pytest.raises(UsageError, match="no content key"):
        digest(own_solver(f"{folder.name}:ORDINARY"))


@pytest.mark.parametrize("name", ["mpm-stability", "dispersion"])
def test_a_study_that_expects_an_order_of_nobody_is_refused(name, folder):
    with pytest.raises(UsageError, match="expects an order of no solver"):
        studies.get(name).with_solver(own_solver(f"{folder.name}:Leapfrog"))


def test_a_solver_that_is_run_beside_itself_is_run_once():
    study = studies.get("generalised-vortex")
    shipped = study.cases[0].series[0].solver
    case = study.cases[0].with_solver(shipped)
    assert [series.solver for series in case.series] == [shipped]


def test_a_solver_of_an_installed_package_is_known_by_its_name(folder):
    """Two packages with the same name for a solver are one too many."""
    declare(folder, "one", f"leapfrog = {folder.stem}:Leapfrog")
    assert own_solver("leapfrog").name == "leapfrog"
    with pytest.raises(UsageError, match=r"'frog' names no solver: .* or one of the installed leapfrog"):
        own_solver("frog")
    declare(folder, "two", f"leapfrog = {folder.stem}:SCALED")
    with pytest.raises(UsageError, match=r"'leapfrog' names several solvers: choose from own_\d+:Leapfrog, own_\d+:SCALED"):
        own_solver("leapfrog")


def declare(folder: Path, package: str, entry: str) -> None:
    """Write what an installed package says of itself."""
    info = folder.parent / f"{package}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(f"[mpmverify.solvers]\n{entry}\n", encoding="utf-8")
    sys.path[:0] = [folder for folder in (str(info.parent), str(folder.parent)) if folder not in sys.path]


def test_cases_that_are_left_out_for_the_same_reason_share_a_line(folder):
    result = run("check", f"{folder.name}:Leapfrog", "axial-vibration", "large-deformation", "plane-waves")
    (line,) = [line for line in result.output.splitlines() if line.startswith("Left out: ") and " more: " in line]
    assert re.search(r"^Left out: large-deformation, bar; .*; .* and \d+ more: solver 'leapfrog' takes ", line)
