"""Codes outside Python: a program that reads and writes files, and results that are already there."""

import dataclasses
import json
import os
import re
import shutil
import subprocess
import sys
import textwrap
import time
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from arrays import assert_close
from click.testing import CliRunner
from handbook import FOLDER, file

from mpmverify import studies
from mpmverify.adapters.bench_file import TYPES, read_bench
from mpmverify.adapters.deck import Deck
from mpmverify.adapters.executable import Executable
from mpmverify.adapters.formats import read_file
from mpmverify.cli import cli
from mpmverify.errors import UsageError
from mpmverify.exact.vortex import generalised_vortex
from mpmverify.execution.keys import digest
from mpmverify.problem import Discretisation
from mpmverify.solution import RunError, Status
from mpmverify.solvers.textbook import Textbook

PROGRAM = """
import json
import numpy as np

problem = json.load(open("problem.json"))
if problem["law"] != "LinearElastic" or problem["dimension"] > 1 or problem["body_force_modes"]:
    print("it takes elastic bars without body force")
    raise SystemExit(77)
if any(end != {"condition": "Velocity", "value": 0.0} for end in problem["boundary"].values()):
    print("it takes bars that are held at both ends")
    raise SystemExit(77)
X, weight, u, v, *_ = np.loadtxt("points.txt").T
c, dt, h = problem["wave_speed"], problem["dt"], problem["h"]
out, gained = [], dt * v
for n in range(problem["steps"] + 1):
    if n in problem["output_steps"]:
        out += [(n * dt, x, value) for x, value in zip(X, u)]
    bend = (c * dt / h) ** 2 * np.diff(u, 2)
    gained[1:-1] += bend if n else bend / 2
    u = u + gained
np.savetxt("result.csv", out, delimiter=",", header="t,X,u", comments="")
"""
POINTS_1D = ["reference", "weight", "displacement", "velocity", "stress", "displacement_gradient"]
ONE_CASE = """
import dataclasses

from mpmverify import studies

BARS = studies.get("axial-vibration")
STUDY = dataclasses.replace(BARS, name="bar", cases=tuple(case for case in BARS.cases if case.name == "literature"))
"""


def run(*arguments: object):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / study(request)).write_text(ONE_CASE, encoding="utf-8")
    write_bench(tmp_path)
    return tmp_path


def study(request: pytest.FixtureRequest) -> str:
    """Name of the file with a study of one case; no other test imports a module of this name."""
    return f"study_{abs(hash(request.node.name))}.py"


def write_bench(folder: Path, program: str = "", **entries: str) -> Path:
    """Write bench.toml, with the entries changed; and the program, where one is given."""
    if program:
        (folder / "program.py").write_text(textwrap.dedent(program), encoding="utf-8")
    lines = {
        "name": '"leapfrog"',
        "command": json.dumps([sys.executable, str(folder / "program.py")]),
        "orders": "{ displacement = 2 }",
        "sources": '["program.py"]',
        "points": '"nodes"',
    } | entries
    path = folder / "bench.toml"
    path.write_text("".join(f"{name} = {value}\n" for name, value in lines.items() if value), encoding="utf-8")
    return path


def bar():
    (case,) = (case for case in studies.get("axial-vibration").cases if case.name == "literature")
    return case, case.ladder_in_h().levels


def test_a_program_gets_verdicts_and_a_page_and_its_refusals_are_named(folder, request):
    result = run("run", study(request), "elastic-bar", "--with", "bench.toml", "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "takes bars that are held at both ends" in " ".join(result.output.split())
    stored = json.loads(Path("results/verdicts.json").read_text(encoding="utf-8"))["studies"]["bar-with-leapfrog"]
    mine = [finding for finding in stored["findings"] if finding["solver"] == "leapfrog"]
    assert mine
    assert {finding["verdict"] for finding in mine} == {"PASS"}
    assert "order 2.0" in mine[0]["reason"]
    assert Path("results/report/bar-with-leapfrog.html").is_file()
    assert "0 runs solved" in run("run", study(request), "--with", "bench.toml").output
    (folder / "program.py").write_text(PROGRAM.replace("(c * dt / h) ** 2", "c * dt / h"), encoding="utf-8")
    assert run("run", study(request), "--with", "bench.toml", "--jobs", "1").exit_code == 1, "an edited program is run anew"
    assert not list(folder.glob("leapfrog-failed"))


def test_results_that_are_already_there_get_the_verdicts_of_the_program(folder, request):
    result = run("problem", "export", study(request), "--points", "nodes", "-o", "deck")
    assert result.exit_code == 0, result.output
    assert run("run", "--with", "deck/bench.toml").exit_code == 3, "there is no result yet"
    levels = sorted(Path("deck/literature").iterdir())
    for level in levels:
        subprocess.run([sys.executable, folder / "program.py"], cwd=level, check=True)
    bench = Path("deck/bench.toml")
    declared = bench.read_text(encoding="utf-8")
    bench.write_text(declared.replace("velocity = 2, stress = 2", "").replace("2,  }", "2 }"), encoding="utf-8")
    judged = run("run", "--with", bench, "--jobs", "1")
    assert judged.exit_code == 0, judged.output
    assert run("run", study(request), "--with", "bench.toml", "--jobs", "1").exit_code == 0
    stored = json.loads(Path("results/verdicts.json").read_text(encoding="utf-8"))["studies"]

    def reasons(study: str, solver: str) -> list[str]:
        found = stored[study]["findings"]
        return [f["reason"] for f in found if f["solver"] == solver and f["case"] == "literature"]

    theirs = reasons("bar-with-my-code", "my-code")
    assert theirs
    assert theirs == reasons("bar-with-leapfrog", "leapfrog")
    (levels[0] / "result.csv").unlink()
    missing = run("run", "--with", bench, "--jobs", "1")
    assert missing.exit_code == 3
    assert "there is no file 'result.csv'" in " ".join(missing.output.split())
    assert run("run", "axial-vibration", "--with", bench).exit_code == 2


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_start_in_c_agrees_with_the_textbook(tmp_path):
    assert run("new", "bench", "-o", tmp_path).exit_code == 0
    subprocess.run(["cc", "-O2", "-o", "mpm", "mpm.c", "-lm"], cwd=tmp_path, check=True)
    problem, level = generalised_vortex(1.0), Discretisation(h=3 / 48, courant=0.2, ppc=2)
    theirs = read_bench(tmp_path / "bench.toml").solve(problem.problem, level)
    ours = Textbook("MUSL", "FLIP", "quadratic", "total").solve(problem.problem, level)
    assert_close(theirs.time, ours.time, abs=1e-14)
    for quantity in ("displacement", "velocity"):
        found, expected = theirs.fields[quantity], ours.fields[quantity]
        assert_close(found, expected, abs=1e-9 * np.max(np.abs(expected)))
    case, levels = bar()
    with pytest.raises(UsageError, match="it takes neo-Hookean bodies in two dimensions"):
        read_bench(tmp_path / "bench.toml").solve(case.problem.problem, levels[0])


@pytest.mark.parametrize(
    ("program", "status", "said"),
    [
        ("raise SystemExit(3)", Status.CRASHED, "exit status 3"),
        (
            "import os; print('out of ideas', flush=True); os.abort()",
            Status.CRASHED,
            "signal SIGABRT and printed: out of ideas",
        ),
        ("1 / 0", Status.CRASHED, "ZeroDivisionError"),
        ("pass", Status.CRASHED, "there is no file 'result.csv'"),
        ("open('result.csv', 'wb').write(bytes(range(256)))", Status.CRASHED, "'result.csv' cannot be read"),
        ("open('result.csv', 'w').write('t,u\\n0,0\\n')", Status.CRASHED, "the result has 1 points, the problem"),
        ("open('result.csv', 'w').write('0,0\\n0,0\\n')", Status.CRASHED, "does not begin with a line of column names"),
        ("print('x' * 10_000_000); raise SystemExit(1)", Status.CRASHED, "exit status 1"),
    ],
)
def test_a_program_that_fails_costs_its_run_and_its_files_are_kept(program, status, said, folder):
    case, levels = bar()
    with pytest.raises(RunError, match=said) as failed:
        read_bench(write_bench(folder, program)).solve(case.problem.problem, levels[0])
    assert failed.value.outcome.status is status
    (kept,) = (folder / "leapfrog-failed").iterdir()
    assert {"problem.json", "problem.txt", "points.txt", "printed.txt"} <= {path.name for path in kept.iterdir()}
    assert str(kept) in str(failed.value)


def test_a_program_that_hangs_is_ended_with_all_that_it_started(folder):
    program = """
        import subprocess, sys, time
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
        open("{folder}/children", "w").write(str(child.pid))
        time.sleep(600)
    """.replace("{folder}", str(folder))
    case, levels = bar()
    with pytest.raises(RunError, match="did not end within 2 s") as failed:
        read_bench(write_bench(folder, program, time_limit="2")).solve(case.problem.problem, levels[0])
    assert failed.value.outcome.status is Status.TIMED_OUT
    child = int((folder / "children").read_text())
    for _ in range(100):
        state = Path(f"/proc/{child}/stat")
        if not state.exists() or state.read_text().split()[2] == "Z":
            break
        time.sleep(0.05)
    else:
        os.kill(child, 9)
        pytest.fail("what the program started runs on")


@pytest.mark.skipif(sys.platform != "linux", reason="the limit of address space is that of Linux")
def test_a_program_that_takes_too_much_memory_fails(folder):
    case, levels = bar()
    with pytest.raises(RunError, match="MemoryError"):
        read_bench(write_bench(folder, "x = bytearray(10**10)", memory_limit="2")).solve(case.problem.problem, levels[0])


@pytest.mark.parametrize(
    ("entries", "sentence"),
    [
        ({"orders": ""}, "lacks 'orders'"),
        ({"name": ""}, "lacks 'name'"),
        ({"command": ""}, "needs either a `command`, or `problems`"),
        ({"problems": '"problems.json"'}, "needs either a `command`, or `problems`"),
        ({"command": '""'}, "must be a command line"),
        ({"command": "[]"}, "command in .* is empty"),
        ({"command": '["no-such-program"]'}, "cannot be started"),
        ({"speed": "3"}, "unknown entry 'speed'"),
        ({"orders": "{ temperature = 2 }"}, "a table of the order"),
        ({"orders": "{ displacement = nan }"}, "a table of the order"),
        ({"orders": "{ displacement = true }"}, "a table of the order"),
        ({"coarse_orders": "{ temperature = 2 }"}, "a table of the order on coarse levels"),
        ({"round_off": "0.01"}, "a relative error up to 1e-05"),
        ({"conserves": '["charm"]'}, "a list of mass, momentum, energy"),
        ({"sources": '["none.f90"]'}, "there is no file 'none.f90'"),
        ({"points": '"cells"'}, "particles or nodes"),
        ({"time_limit": "0"}, "a positive number of seconds"),
        ({"name": '"../up"'}, "a text without '/'"),
        ({"result": '"/etc/*"'}, "files in the folder of a run"),
        ({"result": '"../*"'}, "files in the folder of a run"),
        ({"histories": '"/etc/passwd"'}, "a file in the folder of a run"),
        ({"sources": '["/none.f90"]'}, "there is no file '/none.f90'"),
        ({"conserves": '["mass"]'}, "needs `histories`"),
        ({"columns": "{ a = 3 }"}, "a table of names"),
        ({"name": "leapfrog"}, "is not TOML"),
    ],
)
def test_a_wrong_bench_file_is_said_in_a_sentence(entries, sentence, folder):
    write_bench(folder, **entries)
    result = run("run", "axial-vibration", "--with", "bench.toml")
    assert result.exit_code == 2
    said = " ".join(result.output.split())
    assert "Traceback" not in said
    with pytest.raises(UsageError, match=sentence):
        raise UsageError(said)


def test_a_problem_says_all_that_a_solver_may_see_and_not_its_answer(tmp_path):
    problem, level = generalised_vortex(0.5), Discretisation(h=3 / 24, courant=0.3, ppc=2)
    deck = Deck(problem.problem, level)
    deck.write(tmp_path)
    stated = json.loads((tmp_path / "problem.json").read_text(encoding="utf-8"))
    lines = [line.split() for line in (tmp_path / "problem.txt").read_text(encoding="utf-8").splitlines()]
    listed = {words[0]: words[1:] for words in lines if words[0] != "boundary"}
    for name in ("h", "dt", "end_time", "lame_lambda", "shear_modulus", "density"):
        assert float(listed[name][0]) == stated[name]
    assert (stated["steps"], stated["dt"]) == level.time_steps(problem.problem)
    assert [int(n) for n in listed["output_steps"]] == stated["output_steps"]
    assert {face: entry["condition"] for face, entry in stated["boundary"].items()} == dict.fromkeys(
        problem.problem.boundary, "Traction"
    )
    X, weight = deck.sample
    table = np.loadtxt(tmp_path / "points.txt")
    assert np.array_equal(table[:, :2], X)
    assert np.array_equal(table[:, 2], weight)
    assert_close(weight.sum(), problem.problem.measure, rel=1e-12)
    assert np.array_equal(table[:, 5:7], problem.problem.initial_field("velocity", X))
    amplitudes, modes = np.loadtxt(tmp_path / "body_force_amplitudes.txt"), np.loadtxt(tmp_path / "body_force_modes.txt")
    found = np.einsum("tk,pkc->tpc", amplitudes, modes.reshape(len(X), -1, 2))
    expected = problem.problem.body_force(X, level.time_steps(problem.problem)[1] / 2 * np.arange(len(amplitudes)))
    assert_close(found, expected, abs=1e-12 * np.max(np.abs(expected)))
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "body_force_amplitudes.txt", "body_force_modes.txt", "points.txt", "problem.json", "problem.txt"
    ]  # fmt: skip


def test_a_value_at_a_face_that_varies_has_a_table(tmp_path):
    (case,) = (case for case in studies.get("driven-bar").cases if case.name == "loaded-right")
    level = case.ladder_in_h().levels[0]
    Deck(case.problem.problem, level, "nodes").write(tmp_path)
    stated = json.loads((tmp_path / "problem.json").read_text(encoding="utf-8"))
    face, entry = next((face, entry) for face, entry in stated["boundary"].items() if "table" in entry)
    t, value, integral = np.loadtxt(tmp_path / entry["table"]).T
    history = case.problem.problem.boundary[face].value
    assert np.array_equal(value, history(t))
    assert np.array_equal(integral, history.integral(t))
    assert_close(t[-1], case.problem.problem.end_time, rel=1e-12)


def test_nodes_have_the_weights_of_the_trapezoidal_rule():
    (case,) = (case for case in studies.get("plane-waves").cases if case.name == "clamped")
    level = case.ladder_in_h().levels[0]
    X, weight = Deck(case.problem.problem, level, "nodes").sample
    assert_close(weight.sum(), case.problem.problem.measure, rel=1e-13)
    centre = (np.array(case.problem.problem.lower) + case.problem.problem.upper) / 2
    assert_close(weight @ X / weight.sum(), centre, abs=1e-13)
    with pytest.raises(UsageError, match="does not fill its box"):
        Deck(generalised_vortex(1.0).problem, Discretisation(h=0.125, courant=0.3), "nodes")


def test_what_cannot_be_exported_is_said(folder):
    result = run("problem", "export", "moving-bodies", "--case", "disk")
    assert result.exit_code == 2
    assert "depends on current positions" in " ".join(result.output.split())
    assert run("problem", "export", "axial-vibration", "--case", "none").exit_code == 2
    assert run("problem", "export", "axial-vibration", "--levels", "99").exit_code == 2
    (folder / "problems").mkdir()
    (folder / "problems" / "mine").write_text("", encoding="utf-8")
    assert "is not empty" in run("problem", "export", "axial-vibration").output
    assert not list((folder / "problems").glob("*.json"))


@pytest.mark.parametrize(
    "damage", ["", "{}", "[1, 2]", '{"format": "mpmverify problems 0"}', '{"format": "mpmverify problems 1", "cases": 3}']
)
def test_a_damaged_index_is_said_in_a_sentence(damage, folder):
    assert run("problem", "export", "axial-vibration", "--case", "literature", "--levels", "3", "-o", "deck").exit_code == 0
    Path("deck/problems.json").write_text(damage, encoding="utf-8")
    result = run("run", "--with", "deck/bench.toml")
    assert result.exit_code == 2
    assert "export" in result.output
    assert "Traceback" not in result.output


def test_a_program_is_known_by_its_bytes_and_its_entries(folder):
    one = read_bench(folder / "bench.toml")
    assert isinstance(one, Executable)
    assert digest(one) == digest(read_bench(folder / "bench.toml"))
    assert digest(one) != digest(dataclasses.replace(one, sources=()))
    write_bench(folder, time_limit="30")
    assert digest(one) != digest(read_bench(folder / "bench.toml"))


def test_the_starts_are_those_of_the_handbook():
    start = files("mpmverify.adapters").joinpath("templates")
    assert start.joinpath("test_own_mpm.py").read_text("utf-8") == file("test_own_mpm.py")
    entries = {line.partition("=")[0].strip("# ") for line in start.joinpath("bench.toml").read_text("utf-8").splitlines()[1:]}
    page = (FOLDER / "own-program.md").read_text(encoding="utf-8")
    assert entries <= set(TYPES)
    assert {f"`{entry}`" for entry in TYPES if entry != "problems"} <= set(re.findall(r"`\w+`", page))
    lines = len(start.joinpath("mpm.c").read_text("utf-8").splitlines())
    assert f"in {lines} lines of C" in page


def test_the_start_of_a_study_passes_as_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    assert run("new", "study").exit_code == 0
    result = run("run", "my_study.py", "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "4 PASS." in result.output


@pytest.mark.parametrize("start", ["solver", "study", "bench"])
def test_a_start_is_written_once(start, tmp_path):
    assert run("new", start, "-o", tmp_path / "here").exit_code == 0
    again = run("new", start, "-o", tmp_path / "here")
    assert again.exit_code == 2
    assert "exists: choose another folder" in again.output


def test_a_table_is_read_by_its_names(tmp_path):
    path = tmp_path / "result.txt"
    path.write_text("# t x ux\n0 1 2\n1 3 4\n", encoding="utf-8")
    assert {name: values.tolist() for name, values in read_file(path, 1).items()} == {"t": [0, 1], "x": [1, 3], "ux": [2, 4]}
