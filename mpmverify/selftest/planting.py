"""A fault planted in a copy of the solvers, which stands for the original in a study."""

import dataclasses
import importlib
import secrets
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mpmverify.selftest.faults import Fault
from mpmverify.solution import Solver
from mpmverify.study import Study


@contextmanager
def planted(fault: Fault, sources: Path, folder: Path) -> Iterator[str]:
    """Copy the solvers into a folder, plant the fault, and give the name under which the copy imports.

    Parameters
    ----------
    fault : Fault
    sources : Path
        Folder of the solvers, one folder a family.
    folder : Path
        What is imported, and compiled from it, goes here.

    Notes
    -----
    The name is new each time: modules, compiled code and content keys are remembered by name.
    """
    import numba

    settings: Any = numba.config
    name = f"planted_{secrets.token_hex(8)}"
    package = folder / name
    skipped = shutil.ignore_patterns("__pycache__")
    shutil.copytree(sources, package, ignore=skipped)  # a family may be built on others of these packages
    (package / "__init__.py").touch()
    for file, text in fault.planted(sources).items():
        (package / file).write_text(text, encoding="utf-8")
    compiled, settings.CACHE_DIR = settings.CACHE_DIR, ""  # beside the copy, wherever the environment wants it
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        yield name
    finally:
        sys.path.remove(str(folder))
        settings.CACHE_DIR = compiled
        for module in [module for module in sys.modules if module.partition(".")[0] == name]:
            del sys.modules[module]


def copied(package: str, solver: Solver) -> Solver:
    """Return the same solver value, of the classes in a planted package, its choices included."""
    value: Solver = _copied(package, solver, type(solver).__module__.rpartition(".")[0])
    return value


def _copied(package: str, value: Any, family: str) -> Any:
    """Value of a class of a family, and what it holds of such; anything else is itself."""
    home = type(value).__module__
    if not home.startswith(f"{family}."):
        return value
    parts = home.split(".")
    module = importlib.import_module(".".join([package, *parts[parts.index("solvers") + 1 :]]))
    choices = {field.name: _copied(package, getattr(value, field.name), family) for field in dataclasses.fields(value)}
    return getattr(module, type(value).__name__)(**choices)


def replanted(study: Study, package: str) -> Study:
    """Return a study with the solvers of a planted package in the place of its own."""
    cases = []
    for case in study.cases:
        series = tuple(dataclasses.replace(entry, solver=copied(package, entry.solver)) for entry in case.series)
        cases.append(dataclasses.replace(case, series=series))
    return dataclasses.replace(study, cases=tuple(cases))
