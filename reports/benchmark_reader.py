"""Read the JSON files of pytest-benchmark, strictly: what a file lacks is said in one sentence."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from mpmverify.errors import UsageError

REMEDY = "make it anew with `pytest --benchmark-json=FILE`"
SECONDS = ("q1", "median", "q3")
SHORTEST, LONGEST = 1e-15, 1e9
"""Range of a time that is not zero [s]: what lies outside was not measured."""
CLOSE = 1e-9
"""Relative difference of quartiles that counts as round-off."""


@dataclass(frozen=True)
class Benchmark:
    """Times of one benchmark.

    Parameters
    ----------
    group, name, place : str
        Its group, "" for none; its name; and its full name, which is unique in a file.
    median, low, high : float
        Median and quartiles of the time of one call [s].
    rounds, iterations : int
        Number of times measured, and of calls in each.
    extra : mapping of str to str
        What the benchmark says of itself.
    timer : str
        Name of its timer.
    """

    group: str
    name: str
    place: str
    median: float
    low: float
    high: float
    rounds: int
    iterations: int
    extra: Mapping[str, str]
    timer: str


@dataclass(frozen=True)
class Machine:
    """The machine of a file, by what times depend on."""

    node: str
    processor: str
    count: str
    system: str

    def __str__(self) -> str:
        cores = f"{self.count} processors" if self.count else ""
        return ", ".join(part for part in (self.processor, cores, self.system, self.node and f"host {self.node}") if part)


@dataclass(frozen=True)
class Measured:
    """One file of benchmarks."""

    file: str
    written: datetime
    machine: Machine
    python: str
    commit: str
    version: str
    benchmarks: tuple[Benchmark, ...]


def read_benchmarks(paths: Sequence[Path]) -> tuple[Measured, ...]:
    """Read files of pytest-benchmark, the oldest first.

    Raises
    ------
    UsageError
        If a file cannot be read, or is none of pytest-benchmark.
    """
    return tuple(sorted((_read(path) for path in dict.fromkeys(paths)), key=lambda measured: measured.written))


def _read(path: Path) -> Measured:
    def refuse(constant: str) -> None:
        raise ValueError(constant)

    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise UsageError(f"cannot read '{path}' ({error.strerror}): {REMEDY}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"'{path}' is no text in UTF-8, so no file of pytest-benchmark: {REMEDY}") from error
    try:
        content = json.loads(text, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        line = f" (line {error.lineno})" if isinstance(error, json.JSONDecodeError) else ""
        raise UsageError(f"'{path}' is cut off or no JSON{line}: {REMEDY}") from error
    try:
        return _measured(path, content)
    except _NotOursError as error:
        raise UsageError(f"'{path}' is no file of pytest-benchmark: {error}; {REMEDY}") from error


class _NotOursError(Exception):
    """What a file lacks."""


def _measured(path: Path, content: Any) -> Measured:
    top = _table(content, "it holds no table")
    machine, commit = (_table(top.get(name), f"it has no '{name}'") for name in ("machine_info", "commit_info"))
    entries = top.get("benchmarks")
    if not isinstance(entries, list):
        raise _NotOursError("it has no list 'benchmarks'")
    if not entries:
        raise _NotOursError("it holds no benchmark")
    benchmarks = tuple(_benchmark(entry, k) for k, entry in enumerate(entries, 1))
    places = [benchmark.place for benchmark in benchmarks]
    if again := next((place for k, place in enumerate(places) if place in places[:k]), None):
        raise _NotOursError(f"it has the benchmark {again!r} twice")
    cpu = machine.get("cpu")
    cpu = cpu if isinstance(cpu, dict) else {}
    return Measured(
        file=path.name,
        written=_moment(top.get("datetime")),
        machine=Machine(
            _text(machine.get("node")),
            _text(cpu.get("brand_raw")) or _text(machine.get("processor")) or _text(machine.get("machine")),
            _text(cpu.get("count")),
            " ".join(filter(None, (_text(machine.get("system")), _text(machine.get("machine"))))),
        ),
        python=" ".join(_text(machine.get(name)) for name in ("python_implementation", "python_version")).strip(),
        commit=_commit(commit),
        version=_text(top.get("version")),
        benchmarks=benchmarks,
    )


def _benchmark(entry: Any, k: int) -> Benchmark:
    table = _table(entry, f"entry {k} of 'benchmarks' is no table")
    name, place = table.get("name"), table.get("fullname")
    if not isinstance(name, str) or not isinstance(place, str) or not name or not place:
        raise _NotOursError(f"entry {k} of 'benchmarks' has no 'name' or no 'fullname'")
    stats = _table(table.get("stats"), f"the benchmark {name!r} has no 'stats'")
    low, median, high = (_seconds(stats.get(key), key, name) for key in SECONDS)
    if low > median * (1 + CLOSE) or median > high * (1 + CLOSE):
        raise _NotOursError(f"the median of {name!r} is not between its quartiles")
    extra, options = table.get("extra_info"), table.get("options")
    return Benchmark(
        group=_text(table.get("group")),
        name=name,
        place=place,
        median=median,
        low=low,
        high=high,
        rounds=_number(stats.get("rounds"), "rounds", name),
        iterations=_number(stats.get("iterations"), "iterations", name),
        extra={str(key): _shown(value) for key, value in extra.items()} if isinstance(extra, dict) else {},
        timer=_text(options.get("timer")) if isinstance(options, dict) else "",
    )


def _table(value: Any, lack: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise _NotOursError(lack)
    return value


def _seconds(value: Any, key: str, name: str) -> float:
    try:
        seconds = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
    except OverflowError:
        seconds = math.inf
    if not (seconds == 0 or SHORTEST <= seconds <= LONGEST):
        raise _NotOursError(f"{key!r} of {name!r} is no time in seconds")
    return seconds


def _number(value: Any, key: str, name: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise _NotOursError(f"{key!r} of {name!r} is no positive number")
    return value


def _moment(value: Any) -> datetime:
    try:
        moment = datetime.fromisoformat(value)
    except (TypeError, ValueError) as error:
        raise _NotOursError("it has no 'datetime'") from error
    try:
        return moment.astimezone(UTC) if moment.tzinfo else moment.replace(tzinfo=UTC)
    except (OverflowError, ValueError) as error:
        raise _NotOursError("its 'datetime' is out of range") from error


def _commit(commit: Mapping[str, Any]) -> str:
    known = _text(commit.get("id"))
    if not known or known == "unversioned":
        return ""
    return f"{known[:12]}{' with uncommitted changes' if commit.get('dirty') is True else ''}"


def _text(value: Any) -> str:
    return str(value) if isinstance(value, str | int) and not isinstance(value, bool) else ""


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else value if isinstance(value, str) else json.dumps(value)
