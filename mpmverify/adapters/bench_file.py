"""The file `bench.toml`: a code outside Python as a solver."""

import dataclasses
import shlex
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from mpmverify.adapters.executable import Executable
from mpmverify.adapters.files import Files, read_index
from mpmverify.criteria.errors import LARGEST_ROUND_OFF
from mpmverify.criteria.expectations import INVARIANTS
from mpmverify.errors import UsageError
from mpmverify.problem.quantities import UNITS

BENCH_SUFFIX = ".toml"


def read_bench(path: Path) -> Executable | Files:
    """Return the solver that a file describes: a program (`command`), or results that are already there (`problems`).

    Raises
    ------
    UsageError
        If the file cannot be read, an entry is missing, unknown or of another type, or a source does not exist.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read '{path}' ({getattr(error, 'strerror', '') or error}): correct its path") from error
    try:
        entries = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"'{path}' is not TOML ({error}): correct it") from error
    if ("command" in entries) == ("problems" in entries):
        raise UsageError(f"'{path}' needs either a `command`, or `problems`, the index of exported ones")
    kind: type[Executable] | type[Files] = Executable if "command" in entries else Files
    known = [f.name for f in dataclasses.fields(kind) if f.name != "bench"]
    if unknown := sorted(entries.keys() - set(known)):
        raise UsageError(f"'{path}' has an unknown entry {unknown[0]!r}: known are {', '.join(known)}")
    for name in ("name", "orders"):
        if name not in entries:
            raise UsageError(f"'{path}' lacks {name!r}: add it")
    for name, value in entries.items():
        accepts, what = TYPES[name]
        if not accepts(value):
            raise UsageError(f"{name} = {value!r} in '{path}' must be {what}")
    if entries.get("conserves") and not entries.get("histories"):
        raise UsageError(f"conserves in '{path}' needs `histories`, the table of what is conserved: name it")
    values: dict[str, Any] = entries | {"bench": path, "conserves": frozenset(entries.get("conserves", ()))}
    folder = path.absolute().parent
    if kind is Files:
        values["problems"] = folder / entries["problems"]
        values["sources"] = _results(values["problems"], entries)
        return Files(**values)
    command = shlex.split(entries["command"]) if isinstance(entries["command"], str) else entries["command"]
    if not command:
        raise UsageError(f"command in '{path}' is empty: name a program")
    values["command"] = tuple(command)
    sources = [source for pattern in entries.get("sources", ()) for source in _matching(folder, pattern, path)]
    own = [folder / part for part in command if (folder / part).is_file()]
    values["sources"] = tuple(dict.fromkeys(own + sources))
    return Executable(**values)


def _results(index: Path, entries: Mapping[str, Any]) -> tuple[Path, ...]:
    """Files of the results that exist; a run without one says so."""
    patterns = [entries.get("result", "result.csv"), *([entries["histories"]] if entries.get("histories") else [])]
    folders = [index.parent / level["folder"] for case in read_index(index)["cases"] for level in case["levels"]]
    return tuple(found for folder in folders for pattern in patterns for found in sorted(folder.glob(pattern)))


def _matching(folder: Path, pattern: str, path: Path) -> list[Path]:
    places = [Path(pattern)] if Path(pattern).is_absolute() else folder.glob(pattern)
    found = sorted(entry for entry in places if entry.is_file())
    if not found:
        raise UsageError(f"sources in '{path}': there is no file {pattern!r}; build it, or correct the name")
    return found


def _orders(value: Any) -> bool:
    return isinstance(value, dict) and value.keys() <= UNITS.keys() and all(map(_number, value.values()))


def _texts(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(entry, str) and entry for entry in value)


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < float("inf")


def _text(value: Any) -> bool:
    return isinstance(value, str) and bool(value) and "\0" not in value


def _name(value: Any) -> bool:
    return _text(value) and "/" not in value and not value.startswith(".")


def _inside(value: Any) -> bool:
    return _text(value) and not Path(value).is_absolute() and ".." not in Path(value).parts


TYPES: Mapping[str, tuple[Callable[[Any], bool], str]] = {
    "name": (_name, "a text without '/' that does not begin with '.'"),
    "orders": (
        lambda value: _orders(value) and bool(value),
        f"a table of the order of each of {', '.join(UNITS)} that the code returns",
    ),
    "coarse_orders": (
        _orders,
        f"a table of the order on coarse levels of some of {', '.join(UNITS)}",
    ),
    "round_off": (
        lambda value: _number(value) and value <= LARGEST_ROUND_OFF,
        f"a relative error up to {LARGEST_ROUND_OFF:g}, such as 1e-6 of single precision",
    ),
    "conserves": (lambda value: _texts(value) and set(value) <= set(INVARIANTS), f"a list of {', '.join(INVARIANTS)}"),
    "command": (lambda value: _text(value) or _texts(value), "a command line, or a list of its parts"),
    "problems": (_text, "the name of a file"),
    "sources": (_texts, "a list of names or patterns of files"),
    "points": (lambda value: value in ("particles", "nodes"), "particles or nodes"),
    "result": (_inside, "the name or pattern of files in the folder of a run"),
    "histories": (lambda value: value == "" or _inside(value), "the name of a file in the folder of a run"),
    "columns": (
        lambda value: isinstance(value, dict) and all(isinstance(entry, str) for entry in value.values()),
        "a table of names of columns",
    ),
    "time_limit": (lambda value: _number(value) and value > 0, "a positive number of seconds"),
    "memory_limit": (_number, "a number of GB"),
}
