"""The page of the benchmarks: times by group, and the history of their ratios where several files are given."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from .benchmark_reader import Benchmark, Measured
from .manifest import PERFORMANCE
from .notation import DASH, count, number, slugs
from .parts import Fact, Link, Origin
from .time_strips import axis, history_line, seconds, time_ruler, time_strip

UNGROUPED = "Without a group"
UNFOLDED = 12
"""Largest number of rows of a history that is open at first."""


@dataclass(frozen=True)
class BenchmarkRow:
    """One benchmark.

    Parameters
    ----------
    name, place : str
        Its name, and where it is defined.
    fastest : bool
        Whether it is the fastest of its group.
    strip : str
        SVG of the median and the quartiles.
    median, iqr, rounds, ratio : str
        Median, interquartile range, number of rounds with the calls in each, and ratio of the median to the fastest of the group.
    extra : str
        What the benchmark says of itself, and its timer if it is not the usual one.
    """

    name: str
    place: str
    fastest: bool
    strip: str
    median: str
    iqr: str
    rounds: str
    ratio: str
    extra: str


@dataclass(frozen=True)
class HistoryRow:
    """Ratios of one benchmark to the fastest of its group in every file, also as SVG, and how its median changed on one machine."""

    name: str
    ratios: tuple[str, ...]
    line: str
    change: str


@dataclass(frozen=True)
class BenchmarkGroup:
    """A group of benchmarks, with the axis of its times; `history` is empty if there is one file, and `unfolded` if it is short."""

    anchor: str
    title: str
    note: str
    ruler: str
    rows: tuple[BenchmarkRow, ...]
    history: tuple[HistoryRow, ...]
    unfolded: bool


@dataclass(frozen=True)
class BenchmarkFile:
    """A file of benchmarks: `letter` tells its machine."""

    name: str
    date: str
    letter: str
    commit: str


@dataclass(frozen=True)
class PerformancePage:
    """The page of the benchmarks.

    Parameters
    ----------
    title, generator, root : str
    navigation : tuple of Link
    sentence : str
        What was measured, when.
    cautions : tuple of str
        What limits a comparison of the files.
    machine : tuple of Fact
        The machine of the last file.
    groups : tuple of BenchmarkGroup
    files : tuple of BenchmarkFile
        The oldest first.
    machines : tuple of Fact
        Machines by letter, if there are several.
    changed : str
        Title of the column of changed medians.
    made_from : str
        What the page is made from.
    origins : tuple of Origin
        None: the page is made of no study.
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    sentence: str
    cautions: tuple[str, ...]
    machine: tuple[Fact, ...]
    groups: tuple[BenchmarkGroup, ...]
    files: tuple[BenchmarkFile, ...]
    machines: tuple[Fact, ...]
    changed: str
    made_from: str
    origins: tuple[Origin, ...] = ()


def performance_page(files: Sequence[Measured], generator: str) -> PerformancePage:
    """Make the page of the benchmarks.

    Parameters
    ----------
    files : sequence of Measured
        The oldest first, at least one. Times are those of the last.
    generator : str
        Name and version of the program.
    """
    last = files[-1]
    machines = list(dict.fromkeys(measured.machine for measured in files))
    letters = {machine: chr(ord("A") + k) if k < 26 else f"A{k}" for k, machine in enumerate(machines)}
    names = list(dict.fromkeys(benchmark.group for benchmark in last.benchmarks))
    anchors = slugs([name or UNGROUPED for name in names])
    groups = tuple(_group(name, f"group-{anchors[name or UNGROUPED]}", files) for name in names)
    many = len(last.benchmarks)
    return PerformancePage(
        title="Performance",
        generator=generator,
        root="",
        navigation=(
            Link("Overview", "index.html"),
            Link("Performance", f"{PERFORMANCE}.html", True),
            *(Link(group.title, f"#{group.anchor}") for group in groups),
        ),
        sentence=(
            f"{count(many)} benchmark{'s' * (many != 1)} of {last.file}, measured on {_date(last)}: {str(last.machine) or 'machine not stated'}."
        ),
        cautions=tuple(_cautions(files, machines)),
        machine=_machine(last),
        groups=groups,
        files=tuple(BenchmarkFile(one.file, _date(one), letters[one.machine], one.commit or DASH) for one in files),
        machines=tuple(Fact(letters[one], str(one) or "not stated") for one in machines) if len(machines) > 1 else (),
        changed="Median, last to first" + (f" on machine {letters[last.machine]}" if len(machines) > 1 else ""),
        made_from="a file of pytest-benchmark" if len(files) == 1 else f"{len(files)} files of pytest-benchmark",
    )


def _cautions(files: Sequence[Measured], machines: Sequence[object]) -> Iterator[str]:
    if len(machines) > 1:
        yield (
            f"The files are from {len(machines)} machines. Times of different machines are not compared: the history shows ratios within "
            "each file, and changes of a median only between files of one machine."
        )
    pythons = list(dict.fromkeys(one.python for one in files if one.python))
    if len(pythons) > 1:
        yield f"The files are from different interpreters: {', '.join(pythons)}."
    single = [benchmark.name for benchmark in files[-1].benchmarks if benchmark.rounds < 5]
    if single:
        named = ", ".join(single[:3]) + (f" and {count(len(single) - 3)} more" if len(single) > 3 else "")
        yield f"Fewer than five rounds tell little of the spread: {named}."


def _machine(measured: Measured) -> tuple[Fact, ...]:
    machine = measured.machine
    facts = {
        "Processor": machine.processor,
        "Processors": machine.count,
        "System": machine.system,
        "Host": machine.node,
        "Python": measured.python,
        "Commit": measured.commit,
        "pytest-benchmark": measured.version,
    }
    return tuple(Fact(name, value or "not stated") for name, value in facts.items())


def _group(name: str, anchor: str, files: Sequence[Measured]) -> BenchmarkGroup:
    mine = sorted((one for one in files[-1].benchmarks if one.group == name), key=lambda one: one.median)
    ends = axis([time for one in mine for time in (one.low, one.median, one.high)])
    fastest = mine[0].median
    rows = tuple(_row(one, fastest, ends, alone=len(mine) == 1) for one in mine)
    many = len(mine)
    note = f"{count(many)} benchmark{'s' * (many != 1)}"
    history = tuple(_history(one, files) for one in mine) if len(files) > 1 else ()
    return BenchmarkGroup(anchor, name or UNGROUPED, note, time_ruler(ends), rows, history, len(history) <= UNFOLDED)


def _row(benchmark: Benchmark, fastest: float, ends: tuple[float, float], *, alone: bool) -> BenchmarkRow:
    extra = [f"{name}: {value}" for name, value in benchmark.extra.items()]
    if benchmark.timer and benchmark.timer != "perf_counter":
        extra.append(f"timer: {benchmark.timer}")
    first = benchmark.median == fastest
    calls = f" × {count(benchmark.iterations)}" if benchmark.iterations > 1 else ""
    return BenchmarkRow(
        name=benchmark.name,
        place=benchmark.place.rpartition("::")[0],
        fastest=first and not alone,
        strip=time_strip(benchmark.median, benchmark.low, benchmark.high, ends, fastest=first),
        median=seconds(benchmark.median),
        iqr=seconds(benchmark.high - benchmark.low),
        rounds=f"{count(benchmark.rounds)}{calls}",
        ratio=number(benchmark.median / fastest, 3) if fastest > 0 and not alone else DASH,
        extra="; ".join(extra),
    )


def _history(benchmark: Benchmark, files: Sequence[Measured]) -> HistoryRow:
    ratios, mine = [], list[float]()
    for measured in files:
        found = next((one for one in measured.benchmarks if one.place == benchmark.place), None)
        group = [one.median for one in measured.benchmarks if found and one.group == found.group]
        ratios.append(found.median / min(group) if found and len(group) > 1 and min(group) > 0 else math.nan)
        if found and measured.machine == files[-1].machine:
            mine.append(found.median)
    change = f"× {number(mine[-1] / mine[0], 3)}" if len(mine) > 1 and mine[0] > 0 else DASH
    return HistoryRow(benchmark.name, tuple(number(ratio, 3) for ratio in ratios), history_line(ratios), change)


def _date(measured: Measured) -> str:
    return f"{measured.written:%Y-%m-%d %H:%M} UTC"
