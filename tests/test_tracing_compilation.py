"""The disk cache: code is compiled anew when a source of the solver or of its compiler has changed, and not otherwise."""

import json
import os
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import mpmverify.solvers
from mpmverify.selftest.faults import Fault
from mpmverify.selftest.planting import planted
from mpmverify.solvers.tracing import checksum

SOURCES = Path(mpmverify.solvers.__file__).parent
LAW = "return shifted(lame * trace(eps), 2 * shear, eps)"
SOLVE = """
import json
from copied.mpm import MaterialPoint, loop
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Discretisation

problem = axial_vibration().problem
solution = MaterialPoint("USL").solve(problem, Discretisation(problem.lengths[0] / 16, 0.3, 2))
print(json.dumps([float(abs(solution.fields["stress"]).sum()).hex(), loop.march.stats.cache_hits.total()]))
"""


@pytest.fixture
def copy(tmp_path):
    """The solvers as a package of their own, whose files a test may edit."""
    shutil.copytree(SOURCES, tmp_path / "copied", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "copied"


def solved(copy):
    """Stress of a bar by the solvers of a copy in another process, and how many loops came from the disk."""
    path = os.pathsep.join([str(copy.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    settings = {"PYTHONPATH": path, "NUMBA_CACHE_DIR": str(copy.parent / "cache"), "NUMBA_OPT": "1"}
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


def test_an_index_of_classes_that_are_gone_is_not_read(copy):
    """Numba's index of a loop names the classes of its arguments."""
    stress, _ = solved(copy)
    for path in (copy / "mpm").glob("*.py"):
        path.write_text(path.read_text(encoding="utf-8").replace("Grid", "Lattice"), encoding="utf-8")
    assert solved(copy) == [stress, 0]


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


def test_the_loop_of_the_material_point_method_depends_on_its_checksum():
    loop = import_module("mpmverify.solvers.mpm.loop")
    for name in ("march", "march_in_threads"):
        assert getattr(loop, name).py_func.__name__ == f"{name}_{checksum(SOURCES / 'mpm'):08x}"
