"""Command line: exit statuses, error messages of one sentence, and imports on demand."""

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import xarray as xr
from click.testing import CliRunner
from faulty_solvers import Scripted, study
from rich.console import Console
from stored_results import tree_of

from mpmverify import cli, reports, studies
from mpmverify.cli.console import console
from mpmverify.cli.findings import StudyTable, show
from mpmverify.cli.progress import Progress
from mpmverify.convergence.verdict import Verdict
from mpmverify.errors import ResultsError
from mpmverify.execution import processes as pool
from mpmverify.execution import runner
from mpmverify.execution.runner import nothing
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import STEP_SUMMARY

STUDIES = {
    "scripted": study(Scripted()),
    "slow": study(Scripted(order=1.0), Scripted("unstable"), name="slow"),
    "broken": study(Scripted("raises", below=0.04), name="broken"),
}


@pytest.fixture(autouse=True)
def bench(monkeypatch):
    """Scripted studies, solved in this process, without a report."""
    monkeypatch.delenv("GITHUB_STEP_SUMMARY", raising=False)
    monkeypatch.delenv("GITHUB_ACTIONS", raising=False)
    monkeypatch.setattr(studies, "NAMES", tuple(STUDIES))
    for name, declared in STUDIES.items():
        monkeypatch.setitem(sys.modules, f"mpmverify.studies.{name}", SimpleNamespace(STUDY=declared))
    monkeypatch.setattr(pool, "over_processes", lambda tasks, jobs, timeout: pool.inline(tasks))
    monkeypatch.setattr(reports, "render", lambda results, **_: results.report / "index.html")
    monkeypatch.setattr(reports, "render_study", nothing)


def call(*arguments, **environment):
    return CliRunner().invoke(cli.cli, [str(argument) for argument in arguments], env=environment)


@pytest.fixture(autouse=True)
def nothing_accepted(tmp_path):
    """Baseline without any accepted series."""
    path = tmp_path / "baseline.json"
    Baseline(path).write()
    return path


@pytest.fixture
def out(tmp_path):
    """Results folder with the scripted study, whose regression gate has no baseline yet."""
    path = tmp_path / "results"
    assert call("run", "scripted", "--out", path, "--baseline", tmp_path / "baseline.json").exit_code == 0
    return path


def contents(path):
    return {file.relative_to(path): (file.read_bytes(), file.stat().st_mtime_ns) for file in path.rglob("*") if file.is_file()}


# Help.


@pytest.mark.parametrize(
    "command",
    [
        *([], ["run"], ["gate"], ["report"], ["list"], ["judge"], ["gci"], ["compare"], ["baseline"], ["baseline", "accept"]),
        ["clean"],
    ],
)
def test_every_command_has_help(command):
    result = call(*command, "--help")
    assert result.exit_code == 0
    assert result.output.startswith("Usage: ")


def test_help_imports_nothing_heavy():
    program = (
        "import sys; sys.argv = ['mpmverify', 'run', '--help']\n"
        "try:\n    from mpmverify.cli import main; main()\n"
        "finally:\n    print(sorted({name.partition('.')[0] for name in sys.modules}), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "Exit status: 0 pass, 1 a gate failed, 2 usage" in " ".join(done.stdout.split())
    loaded = done.stderr
    assert "'click'" in loaded
    assert not [name for name in ("numpy", "numba", "xarray", "scipy", "netCDF4", "rich", "jinja2") if f"'{name}'" in loaded]


# Exit statuses.


def test_exit_0_when_every_criterion_passes(tmp_path):
    result = call("run", "scripted", "--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    assert result.exit_code == 0
    assert "3 runs solved, 0 already at hand." in result.output
    assert f"Report: {tmp_path / 'r' / 'report' / 'index.html'}" in result.output.replace("\n", "")
    assert "1 INCONCLUSIVE, 2 PASS." in result.output
    assert result.stderr == "", "the lines of the studies are the progress"
    again = call("run", "scripted", "--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    assert "0 runs solved, 3 already at hand." in again.output


def test_exit_1_when_a_gate_fails(tmp_path):
    where = ("--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    result = call("run", "slow", "--solver", "scripted-good", *where)
    assert result.exit_code == 1
    assert "order 1.000" in result.output
    assert call("gate", *where).exit_code == 1


def test_exit_3_when_a_run_ends_in_an_error_even_if_another_fails(tmp_path):
    where = ("--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    assert call("run", "broken", *where).exit_code == 3
    assert call("gate", *where).exit_code == 3
    assert call("run", "slow", *where).exit_code == 3
    shown = call("gate", "broken", *where).output
    assert "ZeroDivisionError: a mass of [/zero] at node 3" in " ".join(shown.split()), "text is not interpreted as markup"


def test_exit_4_when_inconclusive_with_strict_only(out, tmp_path):
    where = ("--out", out, "--baseline", tmp_path / "baseline.json")
    assert call("gate", *where).exit_code == 0
    assert call("gate", "--strict", *where).exit_code == 4


def test_an_interrupt_ends_without_a_verdict(tmp_path, monkeypatch):
    def interrupted(tasks, jobs, timeout):
        raise KeyboardInterrupt

    monkeypatch.setattr(pool, "over_processes", interrupted)
    result = call("run", "scripted", "--out", tmp_path / "r")
    assert result.exit_code == 130
    assert result.stderr.strip() == "Interrupted: finished runs are kept, run again to go on."


# Errors that the user can correct: one sentence, exit status 2.


def corrupt_run(out):
    path = sorted((out / "runs").iterdir())[0]
    path.write_bytes(path.read_bytes()[:1000])
    (out / "scripted.nc").unlink()
    return path


def corrupt_study(out):
    path = out / "scripted.nc"
    path.write_bytes(path.read_bytes()[:1000])
    return path


def foreign_study(out):
    path = out / "scripted.nc"
    path.unlink()
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(path)
    return path


def corrupt_verdicts(out):
    path = out / "verdicts.json"
    path.write_text('{"studies": {"scripted": 3}}')
    return path


def corrupt_baseline(out):
    path = out.parent / "baseline.json"
    path.write_text("[1, 2]")
    return path


def foreign_run(out):
    path = sorted((out / "runs").iterdir())[0]
    path.unlink()
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(path)
    (out / "scripted.nc").unlink()
    return path


@pytest.mark.parametrize(
    ("damage", "commands"),
    [
        (foreign_run, ["run"]),
        (corrupt_study, ["gate", "baseline accept", "clean"]),
        (foreign_study, ["run", "gate", "baseline accept"]),
        (corrupt_verdicts, ["run"]),
        (corrupt_baseline, ["run", "gate", "baseline accept"]),
    ],
)
def test_a_foreign_or_damaged_file_is_named_and_not_changed(out, tmp_path, damage, commands):
    path = damage(out)
    before = path.read_bytes()
    for command in commands:
        reason = ["--reason", "why not"] if command == "baseline accept" else []
        where = [] if command == "clean" else ["scripted", "--baseline", tmp_path / "baseline.json"]
        result = call(*command.split(), *where, "--out", out, *reason)
        assert_one_sentence(result, str(path))
        assert path.read_bytes() == before


@pytest.mark.parametrize("damage", [corrupt_run, corrupt_study])
def test_a_run_sets_a_damaged_file_aside_and_makes_it_anew(out, tmp_path, damage, caplog):
    path = damage(out)
    bad = path.read_bytes()
    result = call("run", "scripted", "--out", out, "--baseline", tmp_path / "baseline.json")
    assert result.exit_code == 0
    assert f"{1 if damage is corrupt_run else 0} runs solved" in result.output
    assert caplog.messages == [f"'{path}' is damaged: it is set aside as '{path.name}.damaged'."]
    assert path.with_name(f"{path.name}.damaged").read_bytes() == bad
    assert call("gate", "--out", out, "--baseline", tmp_path / "baseline.json").exit_code == 0


def test_clean_removes_the_runs_that_no_study_refers_to(out, tmp_path):
    where = ("--out", out)
    assert call("clean", *where).output == "Removed 0 files that no study refers to, 0.0 MB.\n"
    referred = set((out / "runs").iterdir())
    assert call("run", "slow", *where, "--solver", "scripted-good", "--baseline", tmp_path / "baseline.json").exit_code == 1
    (out / "slow.nc").unlink()
    orphans = set((out / "runs").iterdir()) - referred
    first = min(orphans)
    first.write_bytes(first.read_bytes()[:3000])
    halves = {out / "runs" / f".{'0' * 24}-{'f' * 16}.nc", out / ".verdicts-0123456789abcdef.json"}
    aside = {out / "runs" / f"{'0' * 24}.nc.damaged-2"}
    foreign = {out / "runs" / f"{'a' * 24}.nc", out / "runs" / "notes.nc", out / "runs" / f"{'b' * 24}.nc", out / ".hidden.nc"}
    for path in halves | aside | foreign:
        path.write_text("mine")
    (out / "runs" / f"{'b' * 24}.nc").unlink()
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(out / "runs" / f"{'b' * 24}.nc")
    doomed = orphans | halves | aside
    size = sum(path.stat().st_size for path in doomed)
    before = contents(out)
    listed = call("clean", *where, "--dry-run").output.splitlines()
    assert contents(out) == before
    assert [line.split("bytes  ")[1] for line in listed[:-1]] == sorted(map(str, doomed))
    assert listed[-1] == f"{len(doomed)} files that no study refers to, {size / 1e6:.1f} MB."
    assert call("clean", *where).output == f"Removed {listed[-1]}\n"
    assert {out / path for path in contents(out)} == {out / path for path in before} - doomed
    assert (
        "0 runs solved, 3 already at hand." in call("run", "scripted", *where, "--baseline", tmp_path / "baseline.json").output
    )


def assert_one_sentence(result, *parts):
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("Error: ")
    for part in parts:
        assert part in lines[0]


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ("frobnicate", "'frobnicate'"),
        ("--frobnicate", "--frobnicate"),
        ("run nowhere", "unknown study 'nowhere': choose from scripted, slow, broken"),
        ("run scripted --solver magic", "unknown solver 'magic': choose from scripted-good"),
        ("run scripted --solver scripted-unstable", "unknown solver 'scripted-unstable': choose from scripted-good"),
        ("run --courant 0", "'--courant': must be positive and finite, not 0"),
        ("run --courant -1", "'--courant': must be positive and finite, not -1"),
        ("run --courant nan", "'--courant': must be positive and finite, not nan"),
        ("run --courant inf", "'--courant': must be positive and finite, not inf"),
        ("run --courant abc", "'--courant': 'abc' is not a valid float"),
        ("run --timeout nan", "'--timeout': must be positive and finite, not nan"),
        ("run --timeout 0", "'--timeout': must be positive and finite, not 0"),
        ("run --jobs 0", "'--jobs': 0 is not in the range"),
        ("run --jobs 1.5", "'--jobs': '1.5' is not a valid integer"),
        ("run --tier huge", "'--tier': 'huge' is not one of 'quick', 'full'"),
        ("gate --out EMPTY", "no results in 'EMPTY': run `mpmverify run --out EMPTY` first"),
        ("gate slow --out EMPTY", "no results of 'slow' in 'EMPTY': run `mpmverify run slow --out EMPTY` first"),
        ("gate --out FILE", "no results in 'FILE'"),
        ("report --out EMPTY", "no results in 'EMPTY': run `mpmverify run --out EMPTY` first"),
        ("baseline accept --out EMPTY --reason new", "no results in 'EMPTY'"),
        ("baseline accept --out EMPTY", "'--reason'"),
        ("run scripted --out FILE/results", "cannot write results to 'FILE/results' (Not a directory)"),
        ("run scripted --out FILE", "cannot write results to 'FILE'"),
        ("run scripted --out /proc/results", "cannot write results to '/proc/results'"),
        (
            "run scripted --out EMPTY --baseline NOTHING",
            "there is no baseline 'NOTHING': make it with `mpmverify baseline accept`",
        ),
        ("gate --out EMPTY --baseline NOTHING", "there is no baseline 'NOTHING'"),
        ("selftest --out EMPTY --baseline NOTHING", "there is no baseline 'NOTHING'"),
        ("run scripted --out EMPTY --baseline FOLDER", "'FOLDER' is not an mpmverify baseline"),
        ("run scripted --out EMPTY --baseline LONG", "cannot use 'LONG' (File name too long): choose another place"),
        ("gate --out LONG", "cannot use 'LONG' (File name too long)"),
        ("gate LONG --out EMPTY", "(File name too long)"),
        ("compare LONG EMPTY", "cannot use 'LONG' (File name too long)"),
    ],
)
def test_bad_input_gets_one_sentence(tmp_path, arguments, part):
    places = {"EMPTY": tmp_path / "empty", "FILE": tmp_path / "file", "FOLDER": tmp_path, "NOTHING": tmp_path / "none.json"}
    places["LONG"] = tmp_path / ("long" * 100)
    places["FILE"].write_text("mine")
    for name, path in places.items():
        arguments, part = arguments.replace(name, str(path)), part.replace(name, str(path))
    assert_one_sentence(call(*arguments.split()), part)
    assert places["FILE"].read_text() == "mine"


@pytest.mark.parametrize("name", ["", " ", " results", "\tresults", "x\udcff"])
def test_a_folder_name_that_netcdf_would_change_is_refused(name, tmp_path, monkeypatch):
    """An empty shell variable would name the working folder, and netCDF drops a blank at the start of a path."""
    monkeypatch.chdir(tmp_path)
    for arguments in (("run", "--out", name), ("gate", "--out", name), ("compare", name, "results")):
        assert_one_sentence(call(*arguments), "cannot name a results folder: give a name in UTF-8 that begins with no blank")
    assert [path.name for path in tmp_path.iterdir()] == ["baseline.json"]


def test_a_file_without_permission_is_named(out, tmp_path, monkeypatch):
    def forbidden(path, **_):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "exists", forbidden)
    path = tmp_path / "baseline.json"
    assert_one_sentence(call("gate", "--out", out, "--baseline", path), f"cannot use '{path}' (Permission denied)")


def test_verdicts_are_shown_even_if_the_report_cannot_be_written(tmp_path, monkeypatch):
    def foreign(results, **_):
        raise ResultsError("'index.html' is not ours: move it away")

    monkeypatch.setattr(reports, "render", foreign)
    result = call("run", "scripted", "--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    assert result.exit_code == 2
    assert "1 INCONCLUSIVE, 2 PASS." in result.stdout
    assert result.stderr.endswith("Error: 'index.html' is not ours: move it away\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
def test_an_output_that_is_closed_or_full_is_an_error():
    command = [sys.executable, "-m", "mpmverify", "list"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert "No space left on device" in done.stderr
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as unread:
        unread.stdout.close()
        assert unread.stderr.read() == b""
    assert unread.returncode == 141


def test_a_baseline_needs_a_reason_that_is_not_blank(out, tmp_path):
    for reason in ("", "  "):
        result = call("baseline", "accept", "--out", out, "--baseline", tmp_path / "b.json", "--reason", reason)
        assert_one_sentence(result, "--reason must say why the errors may change")
    assert not (tmp_path / "b.json").exists()


@pytest.mark.parametrize("option", ["--junit", "--summary"])
def test_a_gate_that_cannot_write_its_summary_names_the_file(out, tmp_path, option):
    for path in (tmp_path / "missing" / "file", out / "scripted.nc" / "file"):
        assert_one_sentence(call("gate", "--out", out, option, path), f"cannot write '{path}' (")
    assert_one_sentence(call("gate", "--out", out, option, tmp_path), str(tmp_path))


def test_a_baseline_that_cannot_be_written_is_named(out):
    path = out / "missing" / "baseline.json"
    assert_one_sentence(call("baseline", "accept", "--out", out, "--baseline", path, "--reason", "new"), f"'{path}'")


def test_a_study_with_unfinished_runs_cannot_be_accepted(tmp_path):
    where = ("--out", tmp_path / "r", "--baseline", tmp_path / "b.json")
    call("run", "broken", "--out", tmp_path / "r")
    assert_one_sentence(
        call("baseline", "accept", *where, "--reason", "new"), "broken/hill/scripted-raises", "did not complete"
    )
    assert not (tmp_path / "b.json").exists()


# Commands.


def test_list_names_every_study_case_and_solver():
    result = call("list")
    assert result.exit_code == 0
    for name, declared in STUDIES.items():
        assert f"{name}: {declared.title}" in result.output
        for solver in declared.solvers():
            assert solver in result.output
        for case in declared.cases:
            assert case.name in result.output


def test_solver_restricts_the_study(tmp_path):
    result = call(
        "run", "slow", "scripted", "--solver", "scripted-unstable", "--out", tmp_path, "--baseline", tmp_path / "baseline.json"
    )
    assert result.exit_code == 3
    assert list(tree_of(tmp_path / "slow.nc").children) == ["scripted-unstable"]
    assert not (tmp_path / "scripted.nc").exists()


def test_courant_changes_every_level(tmp_path):
    result = call("run", "scripted", "--courant", "0.125", "--out", tmp_path, "--baseline", tmp_path / "baseline.json")
    assert result.exit_code == 0
    stored = tree_of(tmp_path / "scripted.nc")["scripted-good"]
    assert stored["courant"].values.tolist() == [0.125] * 3
    assert (stored["dt"].values <= 0.125 * stored["h"].values * (1 + 1e-12)).all()
    assert set(stored["refinement"].values.tolist()) == {"nu_C=0.125"}


def test_no_cache_solves_again_and_the_full_tier_solves_more(out, tmp_path):
    where = ("run", "scripted", "--out", out, "--baseline", tmp_path / "baseline.json")
    assert "3 runs solved, 0 already" in call(*where, "--no-cache").output
    assert "1 runs solved, 3 already" in call(*where, "--tier", "full").output


def test_explain_prints_every_verdict_with_its_source(out, tmp_path):
    result = call("gate", "--out", out, "--baseline", tmp_path / "baseline.json", "--explain")
    assert result.output.count("PASS scripted/hill/scripted-good") == 2
    assert result.output.count("expected by: made so") == 2


def test_gate_changes_nothing_and_writes_its_summaries(out, tmp_path):
    before = contents(out)
    junit, summary = tmp_path / "junit.xml", tmp_path / "summary.md"
    summary.write_text("# Of the job\n")
    where = ("gate", "--out", out, "--baseline", tmp_path / "baseline.json", "--junit", junit)
    assert call(*where, GITHUB_STEP_SUMMARY=str(summary)).exit_code == 0
    assert contents(out) == before
    suites = ElementTree.parse(junit).getroot()
    assert len(suites.findall(".//testcase")) == 3
    assert len(suites.findall(".//skipped")) == 1
    assert suites.find(".//failure") is None
    text = summary.read_text()
    assert text.startswith("# Of the job\n## mpmverify: INCONCLUSIVE")
    assert "| scripted | 2 | 0 | 1 | 0 | 0 |" in text
    call(*where, "--summary", summary)
    assert summary.read_text().count("## mpmverify") == 2, "the summary is appended"
    assert call(*where, GITHUB_STEP_SUMMARY="").exit_code == 0


def test_only_baseline_accept_writes_a_baseline(out, tmp_path):
    """Results that became their own baseline would always pass."""
    path = tmp_path / "baseline.json"
    empty = path.read_bytes()
    where = ("--out", out, "--baseline", path)
    for _ in range(2):
        assert "not in the baseline" in " ".join(call("run", "scripted", *where).output.split())
        assert "not in the baseline" in " ".join(call("gate", *where).output.split())
        assert path.read_bytes() == empty
    call("baseline", "accept", *where, "--reason", "the first")
    before = path.read_bytes()
    call("run", "scripted", "--no-cache", *where)
    call("gate", *where)
    assert path.read_bytes() == before


def test_gate_annotates_on_github_only(tmp_path):
    where = ("--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    call("run", "slow", "scripted", *where)
    result = call("gate", *where, GITHUB_ACTIONS="true")
    commands = [line for line in result.stdout.split("\n") if line.startswith("::")]
    kinds = [command.split()[0] for command in commands]
    assert kinds == sorted(kinds)
    assert set(kinds) == {"::error", "::warning"}
    assert commands[0].startswith("::error title=ERROR%3A slow / hill / scripted-unstable (nu_C=0.5),file=")
    for elsewhere in ("", "false"):
        assert "::error" not in call("gate", *where, GITHUB_ACTIONS=elsewhere).stdout


def test_a_summary_that_would_become_too_long_is_not_changed(out, tmp_path):
    summary = tmp_path / "summary.md"
    summary.write_bytes(b"x" * STEP_SUMMARY)
    result = call("gate", "--out", out, "--baseline", tmp_path / "baseline.json", "--summary", summary)
    assert result.exit_code == 0
    assert result.stderr == f"'{summary}' is full: no verdicts were added to it.\n"
    assert summary.read_bytes() == b"x" * STEP_SUMMARY


def test_gate_judges_stored_results_by_the_present_baseline(out, tmp_path):
    where = ("--out", out, "--baseline", tmp_path / "baseline.json")
    assert call("gate", "scripted", "scripted", *where).output.count("INCONCLUSIVE scripted/hill") == 1
    assert call("baseline", "accept", *where, "--reason", " the first ").output.startswith("Accepted 1 series into")
    body = json.loads((tmp_path / "baseline.json").read_text())
    assert [entry["reason"] for entry in body["accepted"]] == ["the first"]
    result = call("gate", "--strict", *where)
    assert result.exit_code == 0
    assert "3 PASS." in result.output

    level = body["errors"]["scripted"]["scripted-good"]["hill | nu_C=0.5"]
    for errors in level.values():
        errors["u L2"] /= 1.5
    (tmp_path / "baseline.json").write_text(json.dumps(body))
    assert call("gate", *where).exit_code == 1


def test_a_study_that_lacks_series_of_its_baseline_is_inconclusive(tmp_path):
    """There is one verdict per study for all series of the baseline that were not run, for whatever reason."""
    where = ("--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    call("run", "scripted", *where)
    call("baseline", "accept", *where, "--reason", "the first")
    assert call("gate", "--strict", *where).exit_code == 0
    body = json.loads((tmp_path / "baseline.json").read_text())
    body["errors"]["scripted"]["other"] = body["errors"]["scripted"]["scripted-good"] | {"hill | nu_C=1": {}}
    body["errors"]["never run"] = body["errors"]["scripted"]
    (tmp_path / "baseline.json").write_text(json.dumps(body))
    for command in ("run", "gate"):
        result = call(command, "scripted", *where)
        said = " ".join(result.output.split())
        assert result.exit_code == 0
        assert "1 INCONCLUSIVE, 3 PASS." in said
        assert "scripted/hill/other (nu_C=0.5): errors against the accepted baseline: in the baseline, but not in the" in said
        assert "(2 of 3 series in all)" in said
    assert call("gate", "--strict", *where).exit_code == 4
    restricted = " ".join(call("run", "scripted", "--courant", "0.25", *where).output.split())
    assert "2 INCONCLUSIVE, 2 PASS." in restricted, "one for the new series, one for all missing series"
    assert "(3 of 3 series in all): the run was restricted to Courant number 0.25: run the whole study" in restricted
    stored = json.loads((tmp_path / "r" / "verdicts.json").read_text())["studies"]["scripted"]["findings"]
    assert "(3 of 3 series in all)" in stored[-1]["reason"]
    body["errors"]["scripted"] = {"scripted-good": body["errors"]["scripted"]["scripted-good"]}
    (tmp_path / "baseline.json").write_text(json.dumps(body))
    assert "3 PASS." in call("run", "scripted", *where).output
    assert "1 INCONCLUSIVE" not in call("gate", *where).output, "series that are no longer missing are not reported"


# Output.


def test_text_of_a_solver_is_not_interpreted_as_markup(capsys):
    words = (
        "study[b]",
        "case",
        "solver[red]",
        "ladder",
        "verification",
        "criterion [/]",
        Verdict.FAIL,
        "list['a'] [bold]x",
        "s",
    )
    output = console()
    finding = Finding(*words)
    StudyTable(output, [finding.study]).add(finding.study, [finding])
    show(output, [finding])
    shown = capsys.readouterr().out
    for word in ("study[b]", "solver[red]", "criterion [/]", "list['a'] [bold]x"):
        assert word in shown


def lines_of_table(text):
    """Lines of the table of studies, split into cells, by their first cell."""
    table = text[text.index("study ") :].splitlines()
    return {first: cells for first, *cells in (re.split(r"\s\s+", line) for line in table[: 1 + len(STUDIES)])}


def test_a_study_is_a_line_of_counts_and_seconds(tmp_path):
    where = ("--out", tmp_path / "r", "--baseline", tmp_path / "baseline.json")
    result = call("run", *where)
    table = lines_of_table(result.output)
    assert table["study"] == ["PASS", "known limit", "INCONCLUSIVE", "FAIL", "ERROR", "seconds"]
    stored = json.loads((tmp_path / "r" / "verdicts.json").read_text())["studies"]
    for name in STUDIES:
        found = stored[name]["findings"]
        verdicts = [f["limit"] if f["limit"] and f["verdict"] == "PASS" else f["verdict"] for f in found]
        assert table[name][:5] == [str(verdicts.count(column)) for column in table["study"][:5]]
        assert float(table[name][5]) >= 0, "the next test has its value"
        assert sum(line.startswith(f"{name} ") for line in result.output.splitlines()) == 1
    widths = {len(line) for line in result.output.splitlines()[: 1 + len(STUDIES)]}
    assert len(widths) == 1, "the lines are aligned"
    judged = lines_of_table(call("gate", *where).output)
    assert judged == {name: cells[:5] for name, cells in table.items()}, "the gate says the same, without seconds"


def test_a_line_is_printed_before_the_next_study_is_judged(tmp_path, monkeypatch, capsys):
    """Without a terminal, too."""
    printed = []

    def two_studies(chosen, plan, progress, show):
        for name, seconds in (("one", 1.25), ("another", 0.5)):
            printed.append(capsys.readouterr().out)
            yield runner.StudyRun(name, (), 0, 0, seconds)
        printed.append(capsys.readouterr().out)

    monkeypatch.setattr(runner, "run", two_studies)
    with pytest.raises(SystemExit):
        cli.cli(["run", "scripted", "--out", str(tmp_path)], standalone_mode=True)
    none, first, second = printed
    assert none == ""
    assert [line.split() for line in first.splitlines()][1] == ["one", *"00000", "1.2"]
    assert [line.split() for line in second.splitlines()] == [["another", *"00000", "0.5"]]


def test_on_a_terminal_lines_stand_above_the_bars_and_once():
    terminal = Console(file=io.StringIO(), force_terminal=True, width=100, color_system=None)
    table = StudyTable(terminal, ["one", "another"], timed=True)
    with Progress(terminal) as progress:
        progress.update("one", 1, 2)
        progress.update("another", 1, 3)
        progress.update("one", 2, 2)
        table.add("one", [], 1.0)
        progress.update("another", 3, 3)
        table.add("another", [], 2.0)
    written = terminal.file.getvalue()
    assert written.count("seconds") == written.count("   1.0\n") == written.count("   2.0\n") == 1
    below = written.partition("   1.0\n")[2]
    assert "another" in below
    assert "one" not in below, "the bar of a study that is judged is gone"


def test_progress_without_a_terminal_is_plain_text_on_standard_error_alone(capsys):
    for output in (Console(stderr=True), Console()):
        with Progress(output) as progress:
            for done in range(3):
                progress.update("scripted", done + 1, 3)
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "scripted: 3 runs\n")


def test_the_installed_command_runs_a_study_and_its_report(tmp_path):
    """End to end, with worker processes and the real report."""
    command = [sys.executable, "-m", "mpmverify", "run", "gehojerez-deck", "--jobs", "1", "--out", tmp_path / "r"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GITHUB_")}
    done = subprocess.run([*command, "--courant", "0.5"], capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stderr
    assert "2 runs solved, 0 already at hand." in done.stdout
    page = Path(done.stdout.split("Report: ")[1].strip())
    assert page.is_file()
