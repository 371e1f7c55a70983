"""Layout and direction of imports: what the design promises about the shape of the code, read from the code."""

import ast
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
"""Folder of each part of the one import namespace."""
LAYERS = (
    {"errors"},
    {"atomic", "material", "quantities", "shapes", "boundary", "problem", "verdict"},
    {"solution", "waves", "bisection"},
    {"exact", "norms", "convergence", "gate", "baseline", "criteria", "synthetic", "axis", "superposition", "separation"},
    {"study"},
    {"dataset"},
    {"evaluation", "pool", "runner", "summary", "display", "verification", "bench", "change", "comparison"},
    {"selftest"},
    {"cli", "pytest_plugin"},
    {"__main__"},
)
"""Modules and packages of the core; right may import left, and its own layer in one direction."""


@cache
def tracked() -> tuple[str, ...]:
    """Files that git tracks, or would when asked to add all."""
    command = ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("not in a git checkout: the layout is that of the repository")
    return tuple(sorted(name for name in set(listed) if name and (ROOT / name).is_file()))


def modules() -> dict[str, Path]:
    """Source of every module by its import name."""
    found = {}
    for package, folder in MAPPED.items():
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            found[".".join((package, *parts)).removesuffix(".__init__")] = path
    return found


MODULES = modules()


def imports(module: str) -> set[str]:
    """Absolute names that a module imports anywhere in its source: modules, or attributes of modules where nobody can tell."""
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
    """Return the mapped folder that a module lies in."""
    return next(folder for package, folder in reversed(MAPPED.items()) if f"{module}.".startswith(f"{package}."))


def core_imports(module: str) -> set[str]:
    """Names of the modules and packages of the core that a module imports: "problem", "dataset"; "" is the package itself."""
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
    """Names in the wheel of the tracked files, which is built in a copy: a build folder would leak into the next wheel."""
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


def test_the_wheel_holds_the_tracked_files_and_its_metadata_alone(wheel):
    expected = set()
    for name in tracked():
        folder, _, rest = name.partition("/")
        if folder in MAPPED.values():
            expected.add(f"mpmverify/{rest}" if folder == "mpmverify" else f"mpmverify/{folder}/{rest}")
    installed = {name for name in wheel if ".dist-info/" not in name}
    assert installed == expected
    assert {name.rpartition("/")[2] for name in wheel - installed} >= {"METADATA", "RECORD", "entry_points.txt"}
    assert "mpmverify/py.typed" in installed


def test_no_folder_is_a_package_of_its_own(tmp_path, monkeypatch):
    """A user has folders of these names too."""
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry and Path(entry).resolve() != ROOT])
    monkeypatch.chdir(tmp_path)
    assert [name for name in ("solvers", "studies", "reports") if find_spec(name)] == []


@pytest.mark.parametrize("module", [*MODULES, *(path.stem for path in sorted((ROOT / "tests").glob("*.py")))])
def test_nobody_imports_a_folder_bare(module):
    path = MODULES.get(module, ROOT / "tests" / f"{module}.py")
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and not node.level:
            names = [node.module or ""]
        assert not {name.partition(".")[0] for name in names} & {"solvers", "studies", "reports"}


def test_inside_a_mapped_folder_siblings_are_imported_relatively():
    """Type checkers then need no mapping."""
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


def test_the_reader_of_imports_sees_them():
    """Otherwise what follows would hold of any code."""
    assert {"mpmverify.dataset.content", "mpmverify.pool", "mpmverify.gate"} <= imports("mpmverify.runner")
    reading = core_imports("mpmverify.cli.judging")
    assert {"dataset", "gate", "baseline", "reports"} & reading == {"dataset", "gate", "baseline"}
    assert "mpmverify.solvers.fem.solver" in imports("mpmverify.solvers.fem")


def test_every_module_of_the_core_has_its_layer():
    placed = set().union(*LAYERS)
    assert {module.split(".")[1] for module in of("mpmverify") if module != "mpmverify"} == placed


def test_the_core_imports_from_left_to_right():
    layer = {name: rank for rank, names in enumerate(LAYERS) for name in names} | {"": -1}
    against = []
    for module in of("mpmverify"):
        if module != "mpmverify":
            mine = layer[module.split(".")[1]]
            against += [f"{module} imports {name}" for name in core_imports(module) if layer[name] > mine]
    assert against == []


def test_no_modules_of_the_core_import_one_another_in_a_circle():
    edges = {module: {name for name in imports(module) if name in MODULES and name != module} for module in of("mpmverify")}
    # A package holds its modules together: importing one runs its __init__, which may name the others.
    edges = {module: {name for name in names if not module.startswith(f"{name}.")} for module, names in edges.items()}
    while edges:
        free = {module for module, names in edges.items() if not names & edges.keys()}
        assert free, f"a circle among {sorted(edges)}"
        edges = {module: names for module, names in edges.items() if module not in free}


def test_the_core_imports_no_solver_study_or_page_but_in_the_command_line_and_the_plugin():
    for module in of("mpmverify"):
        if module.removeprefix("mpmverify").strip(".").partition(".")[0] not in ("cli", "pytest_plugin", "__main__"):
            outside = {name for name in imports(module) if name in MODULES and part(name) != "mpmverify"}
            assert outside == set(), module


@pytest.mark.parametrize("module", of("solvers"))
def test_a_solver_never_sees_its_answer(module):
    assert core_imports(module) <= {"errors", "material", "problem", "solution"}
    assert {part(name) for name in imports(module) if name in MODULES} <= {"mpmverify", "solvers"}
    libraries = {"numpy", "numba", "llvmlite", "scipy", "skfem", "mpmverify"}
    assert {name.partition(".")[0] for name in imports(module)} <= libraries | sys.stdlib_module_names


FAMILIES = ("mpm", "taylor_galerkin", "fem")


@pytest.mark.parametrize("family", FAMILIES)
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
        ("from mpmverify.norms import errors", "mpmverify.norms"),
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


def test_the_reference_shares_no_kernel_and_alone_imports_skfem():
    fem = {module for module in of("solvers") if module.startswith("mpmverify.solvers.fem")}
    assert fem
    users = {module for module in MODULES if any(name.partition(".")[0] == "skfem" for name in imports(module))}
    assert users
    assert users <= fem
    for module in of("solvers"):
        if module != "mpmverify.solvers":
            siblings = {name for name in imports(module) if name in MODULES and part(name) == "solvers"}
            assert all((name in fem) == (module in fem) for name in siblings), module


@pytest.mark.parametrize("module", of("reports"))
def test_a_report_is_made_from_stored_results_alone(module):
    assert core_imports(module) <= {"", "atomic", "axis", "errors", "dataset", "convergence", "separation", "gate", "summary"}
    assert {part(name) for name in imports(module) if name in MODULES} <= {"mpmverify", "reports"}


def test_templates_are_rendered_in_one_module():
    users = {module for module in MODULES if any(name.partition(".")[0] == "jinja2" for name in imports(module))}
    assert len(users) == 1
    assert {part(module) for module in users} == {"reports"}


def test_the_command_line_imports_lazily():
    commands = [module for module in MODULES if f"{module}.".startswith("mpmverify.cli.")]
    for module in ("mpmverify", "mpmverify.__main__", "mpmverify.errors", *commands):
        body = ast.parse(MODULES[module].read_text(encoding="utf-8")).body
        heavy = {alias.name for node in body if isinstance(node, ast.Import) for alias in node.names}
        heavy |= {node.module or "" for node in body if isinstance(node, ast.ImportFrom)}
        allowed = {*sys.stdlib_module_names, "click"}
        assert {name for name in heavy if name.partition(".")[0] not in allowed} <= {
            "mpmverify",
            "mpmverify.errors",
            *commands,
        }
