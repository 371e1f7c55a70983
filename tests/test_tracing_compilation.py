"""The disk cache: code is compiled anew when a source of the solver or of its compiler has changed, and not otherwise."""

import json
import os
import shutil
import subprocess
import sys
from collections import namedtuple
from importlib import import_module
from pathlib import Path

import pytest

import mpmverify.solvers
from mpmverify.selftest.faults import Fault
from mpmverify.selftest.planting import planted
from mpmverify.solvers.tracing import Compiled, checksum, disk

SOURCES = Path(mpmverify.solvers.__file__).parent
LAW = "return shifted(lame * trace(eps), 2 * shear, eps)"
SOLVE = """
import json
from copied.mpm import MaterialPoint, loop
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Discretisation

problem = axial_vibration().problem
solution = MaterialPoint("USL").solve(problem, Discretisation(problem.lengths[0] / 16, 0.3, 2))
print(json.dumps([float(abs(solution.fields["stress"]).sum()).hex(), loop.march.from_disk]))
"""


@pytest.fixture
def copy(tmp_path):
    """The solvers as a package of their own, whose files a test may edit."""
    shutil.copytree(SOURCES, tmp_path / "copied", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "copied"


def solved(copy):
    """Stress of a bar by the solvers of a copy in another process, and how many loops came from the disk."""
    path = os.pathsep.join([str(copy.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    settings = {"PYTHONPATH": path, "NUMBA_CACHE_DIR": str(copy.parent / "cache")}
    command = [sys.executable, "-c", SOLVE]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_an_edited_law_is_compiled_and_no_stale_code_runs(copy):
    stress, hits = solved(copy)
    assert hits == 0
    assert solved(copy) == [stress, 1]
    (law,) = (path for path in (copy / "mpm").glob("*.py") if LAW in path.read_text(encoding="utf-8"))
    law.write_text(law.read_text(encoding="utf-8").replace(LAW, LAW.replace("2 *", "4 *")), encoding="utf-8")
    other, hits = solved(copy)
    assert other != stress
    assert hits == 0


@pytest.mark.parametrize(
    "damage", [lambda code: b"", lambda code: code[:-9], lambda code: code[:-9] + b"?" * 9, lambda code: b"[1]"]
)
def test_a_file_of_code_that_is_not_whole_is_compiled_anew(copy, damage):
    stress, _ = solved(copy)
    (file,) = (copy.parent / "cache").glob("march-*.code")
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert solved(copy) == [stress, 0]
    assert file.read_bytes() == whole


def test_code_is_kept_beside_the_sources_or_where_the_user_may_write(tmp_path, monkeypatch):
    sources, home = tmp_path / "sources", tmp_path / "home"
    sources.mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    assert disk.folder_for(sources) == sources / "__pycache__"
    (sources / "__pycache__").rmdir()
    (sources / "__pycache__").touch()
    assert disk.folder_for(sources) == home / "mpmverify"
    (home / "mpmverify").rmdir()
    (home / "mpmverify").touch()
    assert disk.folder_for(sources) is None
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    assert disk.folder_for(sources) == tmp_path / "chosen"


def test_without_a_folder_code_is_compiled_and_runs(tmp_path, monkeypatch):
    (tmp_path / "taken").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "taken"))
    doubled = Compiled(lambda x: 2 * x, "doubled", SOURCES / "fem")
    assert doubled(1.5) == 3.0
    assert (doubled.made, doubled.from_disk) == (1, 0)


def test_a_full_disk_loses_no_run(tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(Path, "replace", full)
    assert Compiled(lambda x: 2 * x, "doubled", SOURCES / "fem")(1.5) == 3.0
    assert not list(tmp_path.iterdir()), "and leaves nothing behind"


def test_code_of_a_process_is_not_kept_for_sources_that_changed_since(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    law = tmp_path / "sources" / "laws" / "law.py"
    law.parent.mkdir(parents=True)
    law.write_text("old\n", encoding="utf-8")
    running = Compiled(lambda x: 2 * x, "law", tmp_path / "sources")
    law.write_text("new\n", encoding="utf-8")
    assert running(1.5) == 3.0
    later = Compiled(lambda x: 4 * x, "law", tmp_path / "sources")
    assert [later(1.5), later.made, later.from_disk] == [6.0, 1, 0]
    law.rename(law.with_name("other.py"))
    renamed = Compiled(lambda x: 5 * x, "law", tmp_path / "sources")
    assert [renamed(1.5), renamed.made] == [7.5, 1]


def test_the_order_of_the_fields_of_a_named_tuple_tells_code_apart(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    found = []
    for fields in ("a b", "b a"):
        pair = namedtuple("Pair", fields)
        found.append(Compiled(lambda p: p.a, "first", SOURCES / "fem")(pair(1, 2)))
    assert found == [1, 2]


def test_a_user_without_a_home_compiles_without_a_folder(tmp_path, monkeypatch):
    def no_home():
        raise RuntimeError("Could not determine home directory.")

    (tmp_path / "__pycache__").touch()
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    assert disk.folder_for(tmp_path) is None
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    assert disk.folder_for(tmp_path) == tmp_path / "chosen"


def test_functions_of_one_name_and_other_arguments_have_files_of_their_own(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    found = [Compiled(lambda x: 2 * x, "doubled", SOURCES / "fem") for _ in range(2)]
    assert [one(x) for one in found for x in (2, 1.5)] == [4, 3.0] * 2
    assert [(one.made, one.from_disk) for one in found] == [(2, 0), (0, 2)]
    assert len(list(tmp_path.glob("doubled-*.code"))) == 2


def test_the_checksum_is_that_of_the_solver_and_of_its_compiler(tmp_path):
    with planted(Fault("mpm", "named", "none", ()), SOURCES, tmp_path) as name:
        package, of = tmp_path / name, import_module(f"{name}.tracing").checksum
        before = of(package / "mpm")
        assert before == checksum(SOURCES / "mpm")
        assert of(package / "fem") != before
        for file, changes in (("mpm/constitution.py", True), ("tracing/values.py", True), ("fem/kernel.py", False)):
            text = (package / file).read_text(encoding="utf-8")
            (package / file).write_text(f"{text}# edited\n", encoding="utf-8")
            assert (of(package / "mpm") != before) == changes, file
            (package / file).write_text(text, encoding="utf-8")
        assert of(package / "mpm") == before


def test_the_loops_of_the_material_point_method_are_kept_with_the_checksum_of_their_folder():
    loop = import_module("mpmverify.solvers.mpm.loop")
    assert loop.SOURCES == SOURCES / "mpm"
