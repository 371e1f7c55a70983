"""Content keys: equal values have equal keys in every process; a change of a value, its code or a library changes the key."""

import ast
import dataclasses
import functools
import inspect
import math
import os
import subprocess
import sys
import textwrap
import types
from enum import Enum
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import faulty_solvers
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.criteria import CRITERIA, Balance, Exact, FrontPosition, Order
from mpmverify.criteria.criterion import JUDGED
from mpmverify.criteria.errors import ErrorCriterion
from mpmverify.dataset.provenance import NUMERICAL_LIBRARIES
from mpmverify.errors import UsageError
from mpmverify.exact.advection import Gaussian, PeriodicImages, advection
from mpmverify.exact.ring import expanding_ring
from mpmverify.execution import keys as content
from mpmverify.execution.keys import digest
from mpmverify.execution.run_keys import run_keys
from mpmverify.problem import Block, Bodies, Discretisation, Disk, Inflow, Outflow, Ring, Transport
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin


def run_key(problem, solver, level, criteria=()):
    (key,) = run_keys(problem, solver, [level], criteria)
    return key


PROBLEM = advection(Gaussian())
LEVEL = Discretisation(h=0.125, courant=0.5)
KEY = run_key(PROBLEM, TaylorGalerkin(), LEVEL)


class Schedule(Enum):
    USL = "usl"
    USF = "usf"


class Transfer(Enum):
    USL = "usl"


@pytest.mark.parametrize(
    "change",
    [
        {"name": "another"},
        {"upper": (2.0,)},
        {"lower": (-1.0,)},
        {"material": Transport(2.0)},
        {"boundary": {"x-": Inflow(), "x+": Outflow()}},
        {"end_time": math.nextafter(PROBLEM.problem.end_time, 2)},
        {"initial": {"u": PeriodicImages(Gaussian(width=0.11))}},
        {"body_force": faulty_solvers.transported},
        {"outputs": 33},
    ],
    ids=lambda change: next(iter(change)),
)
def test_every_field_of_the_problem_changes_the_key(change):
    other = dataclasses.replace(PROBLEM, problem=dataclasses.replace(PROBLEM.problem, **change))
    assert run_key(other, TaylorGalerkin(), LEVEL) != KEY


def test_the_test_above_changes_every_field_of_the_problem():
    cases = next(mark for mark in test_every_field_of_the_problem_changes_the_key.pytestmark if mark.name == "parametrize")
    changed = {name for change in cases.args[1] for name in change} | {"shape"}
    assert changed == {f.name for f in dataclasses.fields(PROBLEM.problem)}


def test_the_shape_of_the_body_changes_the_key():
    ring = expanding_ring()
    disk, block = Disk((0.0, 0.0), 0.6), Block((-0.6, -0.6), (-0.5, 0.0))
    shapes = (ring.problem.shape, None, Ring((0.0, 0.0), 0.4, 0.7), Ring((0.1, 0.0), 0.4, 0.6), disk, block)
    shapes = (*shapes, Bodies((Disk((0.0, 0.0), 0.4), block)), Bodies((disk,)))
    others = [dataclasses.replace(ring, problem=dataclasses.replace(ring.problem, shape=shape)) for shape in shapes]
    assert len({run_key(other, TaylorGalerkin(), LEVEL) for other in others}) == len(shapes)


def test_solver_and_discretisation_change_the_key():
    keys = [KEY, run_key(PROBLEM, TaylorGalerkin(passes=3), LEVEL)]
    keys += [
        run_key(PROBLEM, TaylorGalerkin(), dataclasses.replace(LEVEL, **change))
        for change in ({"h": 0.25}, {"courant": 0.4}, {"ppc": 2}, {"jitter": 0.1}, {"jitter": 0.1, "seed": 1})
    ]
    assert len(set(keys)) == len(keys)


def test_text_for_the_report_does_not_change_the_key():
    assert run_key(dataclasses.replace(PROBLEM, exposes="something else"), TaylorGalerkin(), LEVEL) == KEY


def test_the_exact_solution_changes_the_key():
    """The stored errors are those against it."""
    other = advection(Gaussian(width=0.3)).exact
    assert run_key(dataclasses.replace(PROBLEM, exact=other), TaylorGalerkin(), LEVEL) != KEY


def test_what_a_criterion_measures_changes_the_key_and_what_it_accepts_does_not():
    def key(*criteria):
        return run_key(PROBLEM, TaylorGalerkin(), LEVEL, criteria)

    mass, wave = Balance("mass", "inflow", "s"), FrontPosition("u", "tg-lumped", 1.0, "s")
    assert key(Order("u", "L2", 1.9, 2.1, "s"), Exact("u", "L1", 1e-12, "s")) == KEY, "norms are always stored"
    assert len({KEY, key(mass), key(Balance("mass", "", "s")), key(wave), key(mass, wave)}) == 5
    assert key(mass, wave) == key(wave, mass, mass)
    assert key(mass) == key(Balance("mass", "inflow", "another source", 1e-9))
    assert key(wave) == key(dataclasses.replace(wave, cells=2.0))


@pytest.mark.parametrize("kind", [kind for kind in CRITERIA.values() if not issubclass(kind, ErrorCriterion)])
def test_measuring_reads_no_field_that_is_not_in_the_key(kind):
    pending, read = ["measure"], set()
    while pending:
        member = inspect.getattr_static(kind, pending.pop(), None)
        function = member.fget if isinstance(member, property) else member
        if not inspect.isfunction(function):
            continue
        nodes = list(ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function)))))
        found = {node.attr for node in nodes if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "self"}
        uses = sum(isinstance(node, ast.Name) and node.id == "self" for node in nodes)
        assert uses == sum(isinstance(node, ast.Attribute) and ast.unparse(node.value) == "self" for node in nodes)
        pending += sorted(found - read)
        read |= found
    assert read.isdisjoint(JUDGED)


def test_the_order_of_a_mapping_does_not_change_the_key():
    reordered = dict(reversed(PROBLEM.problem.boundary.items()))
    assert list(reordered) != list(PROBLEM.problem.boundary)
    other = dataclasses.replace(PROBLEM, problem=dataclasses.replace(PROBLEM.problem, boundary=reordered))
    assert run_key(other, TaylorGalerkin(), LEVEL) == KEY


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3).map(tuple) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)


def typed(value):
    """Return a value that is equal for values with the same types and bits only."""
    if isinstance(value, dict):
        return {name: typed(entry) for name, entry in value.items()}
    return tuple(map(typed, value)) if isinstance(value, tuple) else (type(value), repr(value))


@settings(max_examples=60)
@given(values, values)
def test_keys_are_equal_exactly_when_values_are(one, other):
    assert (digest(one) == digest(other)) == (typed(one) == typed(other))


def test_numbers_of_different_type_or_sign_have_different_keys():
    assert len({digest(value) for value in (0, 0.0, -0.0, False, None, "0", "0.0", (0.0).hex(), math.nan, math.inf)}) == 10
    assert digest(0.1 + 0.2) != digest(0.3)
    assert digest(np.float64(0.5)) == digest(0.5)
    assert digest((1, 2), 3) != digest((1, 2, 3)) != digest(1, (2, 3))


def test_equal_members_of_different_enumerations_have_different_keys():
    assert len({digest(member) for member in (*Schedule, *Transfer, "usl")}) == 4


def _closure():
    captured = 2.0

    def field(x):
        return captured * x

    return field


def _local():
    @dataclasses.dataclass(frozen=True)
    class Local:
        x: float = 1.0

    return Local()


UNSUPPORTED = {
    "lambda": lambda x: x,
    "closure": _closure(),
    "local class": _local(),
    "partial": functools.partial(faulty_solvers.transported, error=0.0),
    "bound method": Gaussian(width=0.3).__call__,
    "class": Gaussian,
    "array": np.zeros((30, 30)),
    "numpy integer": np.int64(3),
    "ufunc": np.sin,
    "set": {1, 2},
    "bytes": b"1",
    "object": object(),
    "mapping with numbers for names": {1: "a", "1": "b"},
}


@pytest.mark.parametrize("value", UNSUPPORTED.values(), ids=UNSUPPORTED.keys())
def test_an_unsupported_value_is_refused_in_one_line(value):
    with pytest.raises(
        UsageError, match=r"has no content key: (use numbers|define \w+ at the top of a module|make \w+ a frozen dataclass)"
    ) as error:
        digest({"field": (value,)})
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 250


def test_a_class_without_source_is_refused():
    """Its code could change without changing the key, and old runs would be reused."""
    module = types.ModuleType("typed_at_a_prompt")
    exec("import dataclasses\n@dataclasses.dataclass(frozen=True)\nclass Made:\n    x: int = 1", module.__dict__)
    with pytest.raises(UsageError, match="the source of module 'typed_at_a_prompt' cannot be found"):
        digest(module.Made())


def test_a_path_is_keyed_by_the_name_and_the_bytes_of_its_file(tmp_path):
    program = tmp_path / "wave"
    program.write_bytes(b"built")
    key = digest({"program": program})
    program.write_bytes(b"other")
    os.utime(program, ns=(1, 1))
    rebuilt = digest({"program": program})
    program.write_bytes(b"built")
    moved = tmp_path / "elsewhere" / "wave"
    moved.parent.mkdir()
    program.rename(moved)
    assert rebuilt != key
    assert digest({"program": moved}) == key
    assert digest({"program": moved.rename(tmp_path / "another")}) != key
    for missing, reason in ((program, "No such file or directory"), (tmp_path, "Is a directory")):
        with pytest.raises(UsageError, match=rf"^runs that depend on '{missing}' have no key \({reason}\): build this file"):
            digest({"program": missing})


def test_a_function_is_keyed_by_its_name_and_module():
    assert digest(faulty_solvers.study) != digest(faulty_solvers.plan)


# Source code in the key: a user's package on disk, whose key a fresh process computes each time.

PACKAGE = {
    "__init__.py": "",
    "scheme.py": "from dataclasses import dataclass\nfrom mine.kernels import flux\nfrom mpmverify.solvers.taylor_galerkin "
    "import TaylorGalerkin\n\n@dataclass(frozen=True)\nclass Mine(TaylorGalerkin):\n    x: float = 1.0\n",
    "kernels/__init__.py": "from .flux import flux\n",
    "kernels/flux.py": "from . import constants\nflux = constants.C\n",
    "kernels/constants.py": "C = 1\n",
    "unrelated.py": "D = 1\n",
}
ASK = "import mine.scheme as s; from mpmverify.execution.keys import digest; print(digest(s.Mine()))"


def key_in_a_fresh_process(folder: Path, program: str = ASK, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=os.environ | {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    folder = tmp_path_factory.mktemp("package")
    for name, source in PACKAGE.items():
        path = folder / "mine" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source)
    return folder, key_in_a_fresh_process(folder)


@pytest.mark.parametrize("module", ["scheme.py", "kernels/flux.py", "kernels/constants.py", "kernels/__init__.py"])
def test_imported_source_changes_the_key(package, module):
    folder, key = package
    path = folder / "mine" / module
    source = path.read_text()
    path.write_text(source + "# touched\n")
    touched = key_in_a_fresh_process(folder)
    path.write_text(source)
    assert touched != key


def test_a_helper_beside_a_solver_is_in_its_key_and_a_library_is_not(tmp_path):
    """A project without a package, whose modules import each other by name."""
    (tmp_path / "scheme.py").write_text(
        "import dataclasses, json, numpy, helper\n@dataclasses.dataclass(frozen=True)\nclass Mine:\n    x: float = 1.0\n"
    )
    (tmp_path / "helper.py").write_text("import deeper.constants\nfrom bare.kernel import flux\n")
    (tmp_path / "deeper").mkdir()
    (tmp_path / "deeper" / "__init__.py").touch()
    (tmp_path / "deeper" / "constants.py").write_text("C = 1\n")
    (tmp_path / "bare").mkdir()  # a package without __init__.py
    (tmp_path / "bare" / "kernel.py").write_text("flux = 1\n")
    ask = (
        "import scheme; from mpmverify.execution.keys import *;"
        "print(digest(scheme.Mine()), *sorted(import_closure({'scheme'})))"
    )
    key, *reached = key_in_a_fresh_process(tmp_path, ask).split()
    assert reached == ["bare.kernel", "deeper", "deeper.constants", "helper", "scheme"]
    for module in ("helper.py", "deeper/constants.py", "bare/kernel.py"):
        (tmp_path / module).write_text((tmp_path / module).read_text() + "# touched\n")
        touched, *_ = key_in_a_fresh_process(tmp_path, ask).split()
        assert touched != key
        key = touched


def test_the_bytes_of_a_compiled_module_beside_a_solver_are_in_its_key(tmp_path):
    """A module that is rebuilt from other sources makes another solver, whose runs must be solved again."""
    (tmp_path / "scheme.py").write_text(
        "import dataclasses\n@dataclasses.dataclass(frozen=True)\nclass Mine:\n    x: float = 1.0\n"
        "    def solve(self, problem, discretisation):\n        import fast, packed.kernel, compiled, binascii\n"
    )
    suffix = EXTENSION_SUFFIXES[0]
    for place in ("packed", "compiled"):
        (tmp_path / place).mkdir()
    (tmp_path / "packed" / "__init__.py").touch()
    modules = [f"fast{suffix}", f"packed/kernel{suffix}", f"compiled/__init__{suffix}"]
    for module in modules:
        (tmp_path / module).write_bytes(b"one")
    ask = (
        "import scheme; from mpmverify.execution.keys import *;"
        "print(digest(scheme.Mine()), *sorted(import_closure({'scheme'})))"
    )
    key, *reached = key_in_a_fresh_process(tmp_path, ask).split()
    assert reached == ["compiled", "fast", "packed", "packed.kernel", "scheme"]
    for module in modules:
        (tmp_path / module).write_bytes(b"another")
        touched, *_ = key_in_a_fresh_process(tmp_path, ask).split()
        assert touched != key
        key = touched


def test_source_that_is_not_imported_and_the_process_do_not_change_the_key(package):
    folder, key = package
    (folder / "mine" / "unrelated.py").write_text("D = 2\n")
    assert key_in_a_fresh_process(folder, PYTHONHASHSEED="1") == key


def test_the_key_of_a_users_solver_that_extends_a_shipped_one_includes_both_sources(package, monkeypatch):
    folder, _ = package
    monkeypatch.syspath_prepend(folder)
    reached = content.import_closure({"mine.scheme"})
    assert {"mine.scheme", "mine.kernels", "mine.kernels.flux", "mine.kernels.constants"} <= reached
    assert {"mpmverify.solvers.taylor_galerkin.kernel", "mpmverify.problem"} <= reached
    assert "mine.unrelated" not in reached


def test_the_key_of_a_solver_does_not_depend_on_exact_solutions_or_judging():
    reached = content.import_closure({TaylorGalerkin.__module__})
    assert "mpmverify.solution" in reached
    assert not {
        name
        for name in reached
        if name.startswith(("mpmverify.exact", "mpmverify.studies", "mpmverify.criteria", "mpmverify.judgement"))
    }


def test_a_run_has_the_same_key_in_another_process():
    program = (
        "from mpmverify.execution.run_keys import run_keys; from mpmverify.exact.advection import *; from mpmverify.problem import *;"
        "from mpmverify.solvers.taylor_galerkin import TaylorGalerkin;"
        "print(*run_keys(advection(Gaussian()), TaylorGalerkin(), [Discretisation(h=0.125, courant=0.5)]))"
    )
    assert key_in_a_fresh_process(Path(), program, PYTHONHASHSEED="4242") == KEY


@pytest.mark.parametrize("library", [*NUMERICAL_LIBRARIES, "python", "machine"])
def test_the_version_of_a_numerical_library_changes_the_key(monkeypatch, library):
    versions = content.library_versions()
    assert library in versions
    monkeypatch.setattr(content, "library_versions", lambda: versions | {library: "99.9"})
    changed = digest(PROBLEM.problem)
    monkeypatch.undo()
    assert changed != digest(PROBLEM.problem)


def test_the_digest_of_a_file_depends_on_its_bytes(tmp_path):
    path = tmp_path / "baseline.json"
    absent = content.file_digest(path)
    path.write_text("{}")
    first = content.file_digest(path)
    path.write_text("{} ")
    assert len({absent, first, content.file_digest(path)}) == 3


EVERYWHERE = """
import a1
def function():
    import a2
    async def inner():
        async with x: import a3
class Kind:
    for k in range(3): import a4
    else: import a5
    while k:
        if k: import a6
        elif not k: import a7
        else: import a8
try: import a9
except OSError: import a10
else: import a11
finally: import a12
match k:
    case 1: import a13
    case _: from a14 import b
"""


def test_imports_are_found_in_a_long_chain_of_branches(tmp_path, monkeypatch):
    chain = "\n".join(f"elif k == {k}: pass" for k in range(1500))
    (tmp_path / "generated.py").write_text(f"if k: pass\n{chain}\nelse: import numerics\n")
    (tmp_path / "numerics.py").write_text("b = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert "numerics" in content.import_closure(["generated"])


def test_imports_are_found_wherever_they_stand(tmp_path, monkeypatch):
    (tmp_path / "everywhere.py").write_text(EVERYWHERE)
    for k in range(1, 15):
        (tmp_path / f"a{k}.py").write_text("b = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert {f"a{k}" for k in range(1, 15)} <= content.import_closure(["everywhere"])
