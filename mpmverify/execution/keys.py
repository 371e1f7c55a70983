"""Content keys: two runs share a key when their problem, solver and discretisation, and all code behind these, are the same."""

import ast
import dataclasses
import hashlib
import importlib.machinery
import importlib.util
import json
import sys
import sysconfig
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

from mpmverify.dataset.provenance import library_versions
from mpmverify.errors import UsageError


class Reduced(NamedTuple):
    """A value that is reduced to JSON already, see `canonical`, with the modules of what it is made of."""

    body: Any
    modules: frozenset[str]


def reduced(value: Any) -> Reduced:
    """Reduce a value that goes into many digests."""
    modules: set[str] = set()
    return Reduced(canonical(value, modules), frozenset(modules))


def digest(*parts: Any, code: Iterable[str] = ()) -> str:
    """Return a hexadecimal digest of values, the modules of their classes and the numerical libraries.

    Parameters
    ----------
    *parts : object
        Values: numbers, strings, frozen dataclasses, functions of a module, paths of files, and tuples, sets and mappings of them. A path
        stands for the name and the bytes of its file, such as a program that a solver calls.
    code : iterable of str
        Further modules that the result depends on, beside those of the classes of the parts.

    Raises
    ------
    UsageError
        If a part is not a value, such as a lambda, a closure or a mutable object; if the module of its class has no file; or if the
        file of a path cannot be read.

    Notes
    -----
    The digest does not see what a program or a compiled module imports or links to, nor what code calls other than by import or path.
    """
    modules = set(code)
    body = json.dumps([canonical(part, modules) for part in parts], sort_keys=True)
    for name in sorted(modules):
        if module_file(name) is None:
            raise UsageError(f"the source of module {name!r} cannot be found, so that its runs have no key: put it into a file")
    return hashlib.sha256(f"{body}{code_digest(frozenset(modules))}{json.dumps(library_versions())}".encode()).hexdigest()[:24]


@cache
def code_digest(modules: frozenset[str]) -> str:
    """Digest of the files of some modules and of all that they import."""
    files = {name: module_digest(name) for name in sorted(import_closure(modules))}
    return hashlib.sha256(json.dumps(files).encode()).hexdigest()


def canonical(value: Any, modules: set[str]) -> Any:
    """Reduce a value to JSON, and collect the modules of the classes and functions that it is made of."""
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Enum)):
        return value
    if isinstance(value, Reduced):
        modules |= value.modules
        return value.body
    if isinstance(value, Enum):
        modules.add(type(value).__module__)
        return [f"{type(value).__module__}.{type(value).__qualname__}", canonical(value.value, modules)]
    if dataclasses.is_dataclass(value) and not isinstance(value, type) and "<locals>" not in type(value).__qualname__:
        modules.add(type(value).__module__)
        fields = {f.name: _of_field(value, f.name, modules) for f in dataclasses.fields(value)}
        return [f"{type(value).__module__}.{type(value).__qualname__}", fields]
    if isinstance(value, Path):
        return ["path", value.name, _path_digest(value)]
    if isinstance(value, Mapping) and all(isinstance(name, str) for name in value):
        return {str(name): canonical(entry, modules) for name, entry in value.items()}
    if isinstance(value, tuple | list):
        return [canonical(entry, modules) for entry in value]
    if isinstance(value, frozenset):
        return ["set", *sorted((canonical(entry, modules) for entry in value), key=json.dumps)]
    if isinstance(value, FunctionType) and value.__closure__ is None and "<" not in value.__qualname__:
        modules.add(value.__module__)
        return f"{value.__module__}.{value.__qualname__}"
    if _is_its_class(value):
        modules.add(type(value).__module__)
        return [f"{type(value).__module__}.{type(value).__qualname__}", {}]
    shown = textwrap.shorten(repr(value), 80)
    kind, kept = type(value).__name__, list(getattr(value, "__dict__", {}))
    remedy = "use numbers, strings, paths, and frozen dataclasses and functions of a module"
    if "<locals>" in type(value).__qualname__:
        remedy = f"define {kind} at the top of a module"
    elif kept and not callable(value):
        remedy = f"make {kind} a frozen dataclass with the fields {', '.join(kept)}"
    raise UsageError(f"{shown} has no content key: {remedy}")


def _of_field(value: Any, name: str, modules: set[str]) -> Any:
    try:
        return canonical(getattr(value, name), modules)
    except UsageError as error:
        raise UsageError(f"{type(value).__name__}.{name}: {error}") from error


def _path_digest(path: Path) -> str:
    try:
        status = path.stat()
        return _bytes_digest(path.absolute(), status.st_size, status.st_mtime_ns)
    except OSError as error:
        reason = error.strerror or error
        raise UsageError(
            f"runs that depend on '{path}' have no key ({reason}): build this file, or correct its path"
        ) from error


@cache
def _bytes_digest(path: Path, size: int, modified: int) -> str:
    """Digest of a file in the state that its size and modification time show."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _is_its_class(value: Any) -> bool:
    """Whether the class of an instance, in Python and in a module, is all that it is: it has no attributes of its own."""
    kind = type(value)
    plain = kind.__new__ is object.__new__ and not any("__slots__" in vars(base) for base in kind.__mro__)
    return plain and getattr(value, "__dict__", None) == {} and "<locals>" not in kind.__qualname__


def import_closure(modules: Iterable[str]) -> set[str]:
    """Modules reached by imports from some modules: of their own packages, of mpmverify, and those outside any library."""
    reached: set[str] = set()
    pending = list(modules)
    while pending:
        name = pending.pop()
        if name not in reached and module_file(name) is not None:
            reached.add(name)
            pending.extend(imported_names(name))
    return reached


@cache
def module_file(module: str) -> Path | None:
    """File of a module, Python source or compiled; None when it does not exist, is built in or has no file."""
    package = module.rpartition(".")[0]
    if package and not _folders(package):
        return None  # an attribute of a module: looking for it would import the module
    loaded = sys.modules.get(module)
    origin = getattr(loaded, "__file__", None)
    if origin is None:
        try:
            spec = importlib.util.find_spec(module)
        except (ImportError, ValueError):
            return None
        origin = spec.origin if spec else None
    return Path(origin) if origin and origin.endswith(tuple(importlib.machinery.all_suffixes())) else None


@cache
def _folders(package: str) -> tuple[str, ...]:
    """Folders of a package, with an __init__ or without; none when the name is not a package."""
    path = module_file(package)
    if path is not None:
        return (str(path.parent),) if _is_init(path) else ()
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        return ()
    return tuple(spec.submodule_search_locations or ()) if spec and spec.origin is None else ()


def _is_init(path: Path) -> bool:
    """Whether a file is the __init__ of a package; a compiled one has the platform between its name and its suffix."""
    return path.name.partition(".")[0] == "__init__"


@cache
def module_digest(module: str) -> str:
    path = module_file(module)
    return file_digest(path) if path else ""


@cache
def imported_names(module: str) -> frozenset[str]:
    """Modules, and attributes of modules, that a module imports from its own package, mpmverify and outside any library."""
    path = module_file(module)
    if path is None or not path.name.endswith(tuple(importlib.machinery.SOURCE_SUFFIXES)):
        return frozenset()
    package = module if _is_init(path) else module.rpartition(".")[0]
    names: set[str] = set()
    for node in _statements(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
            names.update(alias.name.partition(".")[0] for alias in node.names)  # `import a.b` binds a
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                base = importlib.util.resolve_name("." * node.level + base, package)
            names.add(base)
            names.update(f"{base}.{alias.name}" for alias in node.names)
    packages = {module.partition(".")[0], "mpmverify"}
    return frozenset(name for name in names if (top := name.partition(".")[0]) in packages or _is_open(top))


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements within a statement or a module; `ast.walk` also goes through their expressions, where nothing is imported."""
    waiting = [node]
    while waiting:
        node = waiting.pop()
        for part in ("body", "orelse", "handlers", "finalbody", "cases"):
            yield from getattr(node, part, ())
            waiting.extend(getattr(node, part, ()))


@cache
def _is_open(package: str) -> bool:
    """Whether a top-level package or module lies outside any library, so that it may change between two runs."""
    path = module_file(package) if package else None
    places = [path] if path else [Path(folder) for folder in _folders(package)] if package else []
    return any(not in_library(place) for place in places)


def in_library(path: Path) -> bool:
    """Whether a file belongs to Python or to an installed package."""
    standard = {Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib")}
    return not {"site-packages", "dist-packages"}.isdisjoint(path.parts) or not standard.isdisjoint(path.resolve().parents)


def file_digest(path: Path) -> str:
    """Digest of a file's bytes; "" when there is none."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else ""
