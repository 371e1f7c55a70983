"""Objects of own code by the names that a command line gives them: FILE.py:NAME, or MODULE:NAME of an importable module."""

import importlib
import os
import sys
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from mpmverify.adapters.bench_file import BENCH_SUFFIX, read_bench
from mpmverify.errors import UsageError
from mpmverify.execution.contract import lacking
from mpmverify.execution.evaluation import place
from mpmverify.solution import Solver
from mpmverify.study import Study

GROUP = "mpmverify.solvers"
"""Entry points by which an installed package makes its solvers known."""


def is_own(name: str) -> bool:
    """Whether a name is one of own code, and not that of a shipped study."""
    return ":" in name or name.endswith(".py")


def own_study(name: str) -> Study:
    """Return the study with a name; FILE.py alone means its `STUDY`.

    Raises
    ------
    UsageError
        If it cannot be imported, or is no study.
    """
    study = _named(name if ":" in name else f"{name}:STUDY", "study")
    if not isinstance(study, Study):
        raise UsageError(f"{name!r} is of type {type(study).__name__}: give the name of a Study")
    return study


def own_object(name: str) -> Any:
    """Return the object with a name FILE.py:NAME or MODULE:NAME; None for a name of another form.

    Raises
    ------
    UsageError
        If it cannot be imported.
    """
    return _named(name, "object") if ":" in name and not name.endswith(BENCH_SUFFIX) else None


def own_solver(name: str) -> Solver:
    """Return the solver with a name, an instance of the class with that name, or the one that a file `bench.toml` describes.

    A name without a colon is that of an entry point in the group `mpmverify.solvers`, which an installed package declares.

    Raises
    ------
    UsageError
        If it cannot be imported, is a class that needs arguments, lacks an attribute of a `Solver`, or two packages declare it.
    """
    if name.endswith(BENCH_SUFFIX):
        return read_bench(Path(name))
    if ":" not in name:
        declared = {point.value for point in entry_points(group=GROUP, name=name)}
        if len(declared) > 1:
            raise UsageError(f"{name!r} names several solvers: choose from {', '.join(sorted(declared))}")
        if not declared:
            known = sorted(point.name for point in entry_points(group=GROUP))
            installed = f", or one of the installed {', '.join(known)}" if known else ""
            raise UsageError(f"{name!r} names no solver: give FILE.py:NAME, MODULE:NAME or a file bench.toml{installed}")
        (name,) = declared
    solver = _named(name, "solver")
    if isinstance(solver, type):
        try:
            solver = solver()
        except TypeError as error:
            raise UsageError(f"{name!r} is a class that needs arguments ({error}): name an instance of it") from error
    if missing := lacking(solver):
        raise UsageError(f"{name!r} is not a solver: it lacks {', '.join(missing)}")
    own: Solver = solver
    return own


def _named(name: str, what: str) -> Any:
    source, _, attribute = name.rpartition(":")
    folder, module = (Path(source).absolute().parent, Path(source).stem) if source.endswith(".py") else (Path.cwd(), source)
    if source.endswith(".py") and not Path(source).is_file():
        raise UsageError(f"there is no file '{source}': correct its path")
    if str(folder) not in sys.path:  # last, so that nothing in it hides a library; worker processes take it over
        sys.path.append(str(folder))
    try:
        found = importlib.import_module(module)
        if source.endswith(".py") and not os.path.samefile(found.__file__ or os.devnull, source):
            raise UsageError(f"'{source}' has the name of another module, {module!r}: rename the file")
        return getattr(found, attribute)
    except UsageError:
        raise
    except (ImportError, AttributeError, ValueError) as error:
        remedy = "give FILE.py:NAME, or MODULE:NAME of a module on Python's path"
        raise UsageError(f"the {what} {name!r} cannot be imported ({error}): {remedy}") from error
    except (Exception, SystemExit) as error:  # importing a module runs it, which may raise anything
        said = f"{type(error).__name__}: {error} ({place(error)})"
        raise UsageError(f"the {what} {name!r} cannot be imported, {said}: correct its module") from error
