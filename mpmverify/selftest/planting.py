"""Plant a fault in a copy of the solvers, and run studies with that copy."""

import dataclasses
import importlib
import secrets
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mpmverify.execution.workers import environment
from mpmverify.selftest.faults import Fault
from mpmverify.solution import Solver
from mpmverify.study import Study


@contextmanager
def planted(fault: Fault, sources: Path, folder: Path) -> Iterator[str]:
    """Copy the solvers into a folder, plant the fault, and yield the package name of the copy.

    Parameters
    ----------
    fault : Fault
    sources : Path
        Folder of the solvers, with one subfolder for each family.
    folder : Path
        Folder for the copy and its compiled code.

    Notes
    -----
    Each call makes a new package name, because Python, numba and the content keys cache by module name.
    """
    import numba

    settings: Any = numba.config
    name = f"planted_{secrets.token_hex(8)}"
    package = folder / name
    skipped = shutil.ignore_patterns("__pycache__")
    shutil.copytree(sources, package, ignore=skipped)  # all families: one may import another
    (package / "__init__.py").touch()
    for file, text in fault.planted(sources).items():
        (package / file).write_text(text, encoding="utf-8")
    kept, settings.CACHE_DIR = settings.CACHE_DIR, ""  # compiled code lies beside the copy, also where NUMBA_CACHE_DIR is set
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        with environment({"NUMBA_CACHE_DIR": ""}):
            yield name
    finally:
        sys.path.remove(str(folder))
        settings.CACHE_DIR = kept
        for module in [module for module in sys.modules if module.partition(".")[0] == name]:
            del sys.modules[module]


def copied(package: str, solver: Solver) -> Solver:
    """Return the solver rebuilt from the classes of a planted package, with the same choices."""
    value: Solver = _copied(package, solver, type(solver).__module__.rpartition(".")[0])
    return value


def _copied(package: str, value: Any, family: str) -> Any:
    """Rebuild a value, and the values in its fields, if their classes belong to the family; return any other value unchanged."""
    home = type(value).__module__
    if not home.startswith(f"{family}."):
        return value
    parts = home.split(".")
    module = importlib.import_module(".".join([package, *parts[parts.index("solvers") + 1 :]]))
    choices = {field.name: _copied(package, getattr(value, field.name), family) for field in dataclasses.fields(value)}
    return getattr(module, type(value).__name__)(**choices)


def replanted(study: Study, package: str) -> Study:
    """Return the study with every solver replaced by its copy in a planted package."""
    cases = []
    for case in study.cases:
        series = tuple(dataclasses.replace(entry, solver=copied(package, entry.solver)) for entry in case.series)
        cases.append(dataclasses.replace(case, series=series))
    return dataclasses.replace(study, cases=tuple(cases))
