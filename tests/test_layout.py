"""Layout of the repository and direction of imports, read from the source."""

import ast
import re
import subprocess
import sys
import tomllib
import zipfile
from functools import cache
from importlib.util import find_spec, resolve_name
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MAPPED = {
    "mpmverify": "mpmverify",
    "mpmverify.solvers": "solvers",
    "mpmverify.studies": "studies",
    "mpmverify.reports": "reports",
}
"""Folder of each package of the import namespace `mpmverify`."""
ROOMS = (
    "errors",
    "atomic",
    "problem",
    "solution",
    "exact",
    "convergence",
    "criteria",
    "judgement",
    "study",
    "dataset",
    "execution",
    "adapters",
    "selftest",
    "cli",
    "pytest_plugin",
    "__main__",
)
"""Rooms of the core from the ground up: a room imports itself and the rooms before it only."""
MODULES_OF_THEIR_OWN = {"errors", "atomic", "solution", "pytest_plugin", "__main__"}
"""Rooms that are one module; every other room is a package."""


@cache
def tracked() -> tuple[str, ...]:
    """Files that git tracks or that `git add --all` would add."""
    command = ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("needs a git checkout: the tracked files are tested")
    return tuple(sorted(name for name in set(listed) if name and (ROOT / name).is_file()))


def modules() -> dict[str, Path]:
    """Source of every module by its import name."""
    found = {}
    for package, folder in MAPPED.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            if path.parent.name == "templates":  # what `mpmverify new` writes is a reader's code
                continue
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            found[".".join((package, *parts)).removesuffix(".__init__")] = path
    return found


MODULES = modules()


def imports(module: str) -> set[str]:
    """Absolute names that a module imports anywhere in its source; outside of mpmverify a name may be an attribute of a module."""
    path = MODULES[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), package) if node.level else node.module or ""
            inner = {f"{base}.{alias.name}" for alias in node.names}
            names |= {name if name in MODULES else base for name in inner}
    return names


def part(module: str) -> str:
    """Return the folder that contains a module."""
    return next(folder for package, folder in reversed(MAPPED.items()) if f"{module}.".startswith(f"{package}."))


def core_imports(module: str) -> set[str]:
    """Rooms of the core that a module imports, such as "problem"; "" stands for the package `mpmverify` itself."""
    mine = {name for name in imports(module) if name.partition(".")[0] == "mpmverify" and part(name) == "mpmverify"}
    return {name.removeprefix("mpmverify").removeprefix(".").partition(".")[0] for name in mine}


def of(folder: str) -> list[str]:
    return [module for module in MODULES if part(module) == folder]


# Layout.


def test_the_top_level_has_the_seven_entries():
    top = {name.partition("/")[0] for name in tracked()}
    promised = {"pyproject.toml", "README.md", "mpmverify", "solvers", "studies", "reports", "tests"}
    assert promised <= top
    assert {name for name in top - promised if not name.startswith(".") and name != "LICENSE"} == set()


def test_every_package_is_listed():
    with (ROOT / "pyproject.toml").open("rb") as file:
        setuptools = tomllib.load(file)["tool"]["setuptools"]
    packages = {module for module, path in MODULES.items() if path.name == "__init__.py"}
    assert set(setuptools["packages"]) == packages
    assert setuptools["package-dir"] == MAPPED


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Names of the files in a wheel built from a copy of the tracked files; in place, an old build folder would add its files."""
    copy, out = tmp_path_factory.mktemp("copy"), tmp_path_factory.mktemp("wheel")
    for name in tracked():
        target = copy / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(out), str(copy)]
    for attempt in (["--no-build-isolation"], []):
        done = subprocess.run([*command, *attempt], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            break
    else:
        if "No matching distribution" in done.stderr or "No module named pip" in done.stderr:
            pytest.skip("no wheel can be built: setuptools is too old here and pip or the package index cannot be reached")
        pytest.fail(done.stderr)
    (built,) = out.glob("*.whl")
    with zipfile.ZipFile(built) as archive:
        return set(archive.namelist())


def test_the_wheel_has_the_tracked_files_and_its_metadata_only(wheel):
    expected = set()
    for name in tracked():
        folder, _, rest = name.partition("/")
        if folder in MAPPED.values():
            expected.add(f"mpmverify/{rest}" if folder == "mpmverify" else f"mpmverify/{folder}/{rest}")
    installed = {name for name in wheel if ".dist-info/" not in name}
    assert installed == expected
    assert {name.rpartition("/")[2] for name in wheel - installed} >= {"METADATA", "RECORD", "entry_points.txt"}
    assert "mpmverify/py.typed" in installed


def test_no_folder_is_a_top_level_package(tmp_path, monkeypatch):
    """They would clash with a user's folders of the same names."""
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry and Path(entry).resolve() != ROOT])
    monkeypatch.chdir(tmp_path)
    assert [name for name in ("solvers", "studies", "reports") if find_spec(name)] == []


@pytest.mark.parametrize("module", [*MODULES, *(path.stem for path in sorted((ROOT / "tests").glob("*.py")))])
def test_no_module_imports_a_folder_as_a_top_level_package(module):
    path = MODULES.get(module, ROOT / "tests" / f"{module}.py")
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and not node.level:
            names = [node.module or ""]
        assert not {name.partition(".")[0] for name in names} & {"solvers", "studies", "reports"}


def test_inside_a_mapped_folder_siblings_are_imported_relatively():
    """So that type checkers need no mapping of folders to packages."""
    for folder in ("solvers", "studies", "reports"):
        for module in of(folder):
            for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and not node.level:
                    assert not f"{node.module}.".startswith(f"mpmverify.{folder}."), f"{module} imports {node.module}"


def test_modules_are_nouns_of_the_field():
    banned = {"util", "utils", "helper", "helpers", "misc", "common", "tools"}
    assert {module for module in MODULES if module.rpartition(".")[2].strip("_") in banned} == set()


def test_no_module_is_longer_than_three_hundred_lines():
    lengths = {module: len(path.read_text(encoding="utf-8").splitlines()) for module, path in MODULES.items()}
    assert {module: length for module, length in lengths.items() if length > 300} == {}


# Direction of imports.


def test_imports_are_found_in_the_source():
    """Otherwise the following tests would pass for any code."""
    expected = {"mpmverify.execution.keys", "mpmverify.execution.processes", "mpmverify.judgement.judging"}
    assert expected <= imports("mpmverify.execution.runner")
    reading = core_imports("mpmverify.cli.reading")
    assert {"dataset", "execution", "judgement", "reports"} & reading == {"dataset", "execution", "judgement"}
    assert "mpmverify.solvers.fem.solver" in imports("mpmverify.solvers.fem")


def test_every_module_of_the_core_is_in_a_room():
    top = {module.split(".")[1] for module in of("mpmverify") if module != "mpmverify"}
    assert top == set(ROOMS)
    modules = {path.stem for path in (ROOT / "mpmverify").glob("*.py")} - {"__init__"}
    assert modules == MODULES_OF_THEIR_OWN


@pytest.mark.parametrize("room", [*sorted(set(ROOMS) - MODULES_OF_THEIR_OWN), *list(MAPPED)[1:]])
def test_the_docstring_of_every_room_is_a_paragraph(room):
    module = room if room in MAPPED else f"mpmverify.{room}"
    words = ast.get_docstring(ast.parse(MODULES[module].read_text(encoding="utf-8"))) or ""
    assert len(words.split()) >= 25, module


def test_a_room_imports_lower_rooms_only():
    rank = {room: place for place, room in enumerate(ROOMS)} | {"": -1}
    upward = []
    for module in of("mpmverify"):
        if module != "mpmverify":
            mine = rank[module.split(".")[1]]
            upward += [f"{module} imports {room}" for room in core_imports(module) if rank[room] > mine]
    assert upward == []


def test_convergence_imports_the_errors_only():
    for module in of("mpmverify"):
        if f"{module}.".startswith("mpmverify.convergence."):
            assert core_imports(module) <= {"errors", "convergence"}, module


def test_the_imports_of_the_core_have_no_cycle():
    edges = {module: {name for name in imports(module) if name in MODULES and name != module} for module in of("mpmverify")}
    # A module may import from its package, whose __init__ runs first and may import the other modules.
    edges = {module: {name for name in names if not module.startswith(f"{name}.")} for module, names in edges.items()}
    while edges:
        free = {module for module, names in edges.items() if not names & edges.keys()}
        assert free, f"a cycle among {sorted(edges)}"
        edges = {module: names for module, names in edges.items() if module not in free}


def test_only_the_command_line_and_the_plugin_import_solvers_studies_and_reports():
    for module in of("mpmverify"):
        if module.removeprefix("mpmverify").strip(".").partition(".")[0] not in ("cli", "pytest_plugin", "__main__"):
            outside = {name for name in imports(module) if name in MODULES and part(name) != "mpmverify"}
            assert outside == set(), module


@pytest.mark.parametrize("module", of("solvers"))
def test_a_solver_imports_neither_exact_solutions_nor_files(module):
    assert core_imports(module) <= {"errors", "problem", "solution"}
    assert {part(name) for name in imports(module) if name in MODULES} <= {"mpmverify", "solvers"}
    libraries = {"numpy", "numba", "llvmlite", "scipy", "skfem", "mpmverify"}
    assert {name.partition(".")[0] for name in imports(module)} <= libraries | sys.stdlib_module_names


FAMILIES = ("mpm", "taylor_galerkin", "fem")


@pytest.mark.parametrize("family", [*FAMILIES, "tracing"])
def test_a_family_of_solvers_imports_no_other(family):
    mine = [module for module in of("solvers") if f"{module}.".startswith(f"mpmverify.solvers.{family}.")]
    others = tuple(f"mpmverify.solvers.{other}." for other in FAMILIES if other != family)
    assert mine
    assert [name for module in mine for name in imports(module) if f"{name}.".startswith(others)] == []


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("import xarray", "xarray"),
        ("import mpmverify.exact", "mpmverify.exact"),
        ("from mpmverify import exact", "mpmverify.exact"),
        ("from mpmverify import studies as s", "mpmverify.studies"),
        ("from mpmverify.criteria.norms import errors", "mpmverify.criteria.norms"),
        ("from mpmverify.exact.vibration import Mode", "mpmverify.exact.vibration"),
        ("from mpmverify.solvers.fem import kernel", "mpmverify.solvers.fem.kernel"),
        ("from ..fem.kernel import advance", "mpmverify.solvers.fem.kernel"),
        ("from .. import fem", "mpmverify.solvers.fem"),
        ("from ...exact import ExactSolution", "mpmverify.exact"),
        ("def late():\n    from mpmverify.studies import get", "mpmverify.studies"),
    ],
)
def test_an_import_of_a_solver_is_seen_however_it_is_written(line, name, tmp_path, monkeypatch):
    path = tmp_path / "kernels.py"
    path.write_text(f"import numpy as np\nfrom mpmverify.problem import Array\n{line}\n", encoding="utf-8")
    monkeypatch.setitem(MODULES, "mpmverify.solvers.mpm.kernels", path)
    assert imports("mpmverify.solvers.mpm.kernels") - {"numpy", "mpmverify.problem"} == {name}


def test_only_the_finite_elements_import_skfem_and_they_share_no_kernel():
    fem = {module for module in of("solvers") if module.startswith("mpmverify.solvers.fem")}
    assert fem
    users = {module for module in MODULES if any(name.partition(".")[0] == "skfem" for name in imports(module))}
    assert users
    assert users <= fem
    for module in of("solvers"):
        if module != "mpmverify.solvers":
            siblings = {name for name in imports(module) if name in MODULES and part(name) == "solvers"}
            assert all((name in fem) == (module in fem) for name in siblings), module


def test_only_the_tracing_compiler_imports_llvmlite_and_the_internals_of_numba():
    """The text of all tracked files is searched, which also finds imports inside functions."""
    internals = re.compile(r"\b(import|from)\s+llvmlite\b|\bnumba\.core\b|\bfrom\s+numba\s+import\b.*\bcore\b")
    paths = [name for name in tracked() if name.endswith(".py") and name.partition("/")[0] in MAPPED.values()]
    users = {name for name in paths if internals.search((ROOT / name).read_text(encoding="utf-8"))}
    assert users
    assert {name.rpartition("/")[0] for name in users} == {"solvers/tracing"}


@pytest.mark.parametrize("module", of("reports"))
def test_reports_import_neither_solvers_nor_studies_nor_exact_solutions(module):
    assert core_imports(module) <= {"", "atomic", "errors", "dataset", "convergence", "judgement"}
    assert {part(name) for name in imports(module) if name in MODULES} <= {"mpmverify", "reports"}


def test_one_module_renders_templates():
    users = {module for module in MODULES if any(name.partition(".")[0] == "jinja2" for name in imports(module))}
    assert len(users) == 1
    assert {part(module) for module in users} == {"reports"}


def loaded_by(*arguments):
    """Third-party packages that are loaded after a command has run in a new process."""
    run = f"from mpmverify.cli import cli; cli({list(arguments)!r}, standalone_mode=False)"
    show = "import sys; print('loaded', *sorted({name.partition('.')[0] for name in sys.modules}))"
    code = f"try:\n    {run}\nexcept SystemExit:\n    pass\n{show}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.rpartition("\nloaded ")[2].split()) - set(sys.stdlib_module_names)


def test_help_loads_click_only():
    assert {name for name in loaded_by("--help") if not name.startswith(("_", "sitecustomize"))} == {"click", "mpmverify"}


@pytest.mark.parametrize("command", ["judge", "gci"])
def test_reading_a_table_loads_click_and_numpy_only(tmp_path, command):
    (tmp_path / "errors.csv").write_text("h,error\n0.1,1e-2\n0.05,2.5e-3\n0.025,6e-4\n", encoding="utf-8")
    loaded = loaded_by(command, str(tmp_path / "errors.csv"))
    assert {name for name in loaded if not name.startswith(("_", "sitecustomize"))} == {"click", "mpmverify", "numpy"}
