"""The page of the benchmarks: files are read strictly, numbers are those of the file, and times of different machines are never compared."""

import copy
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from browser import BROWSER, acted
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st
from report_pages import Page, broken_links, pages
from sample_study import HOSTILE, store, study

from mpmverify.cli import cli
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError, UsageError
from mpmverify.reports import render
from mpmverify.reports.benchmark_reader import read_benchmarks
from mpmverify.reports.performance_page import performance_page
from mpmverify.reports.time_strips import HISTORY, MARGIN, WIDTH, axis, history_line, seconds, time_ruler, time_strip

TIMES = st.floats(1e-12, 1e6)


def benchmark(name: str, median: float, group: str | None = "steps", **stats: Any) -> dict[str, Any]:
    table = {"q1": 0.9 * median, "median": median, "q3": 1.2 * median, "iqr": 0.3 * median, "rounds": 7, "iterations": 1}
    return {
        "group": group,
        "name": name,
        "fullname": f"test_x.py::{name}",
        "extra_info": {"rate": 41.23456},
        "options": {"timer": "StepClock"},
        "stats": table | stats,
    }


def content(*benchmarks: dict[str, Any], cpu: str = "CPU 1", day: int = 1, commit: str = "abc") -> dict[str, Any]:
    return {
        "machine_info": {
            "node": "host",
            "machine": "x86_64",
            "system": "Linux",
            "python_implementation": "CPython",
            "python_version": "3.12.1",
            "cpu": {"brand_raw": cpu, "count": 8},
        },
        "commit_info": {"id": commit, "dirty": False},
        "benchmarks": list(benchmarks),
        "datetime": f"2026-01-{day:02d}T10:00:00+00:00",
        "version": "5.1.0",
    }


PLAIN = content(benchmark("slow", 4e-3), benchmark("fast", 1e-3), benchmark("alone", 2.0, None))


def stored(path: Path, table: Any) -> Path:
    path.write_text(table if isinstance(table, str) else json.dumps(table), encoding="utf-8")
    return path


@pytest.fixture
def results(tmp_path: Path) -> Results:
    made = Results(tmp_path / "results")
    store(made, study(solvers=("good",)))
    return made


def report(results: Results, *files: Path) -> Result:
    given = [part for file in files for part in ("--benchmarks", str(file))]
    return CliRunner().invoke(cli, ["report", "--out", str(results.path), *given])


def test_a_file_of_pytest_benchmark_makes_a_page(results: Results, tmp_path: Path) -> None:
    """A true file, from the version that is installed."""
    (tmp_path / "test_sums.py").write_text(
        "import pytest\n"
        "@pytest.mark.benchmark(group='sums')\n"
        "@pytest.mark.parametrize('n', [10, 1000])\n"
        "def test_sum(benchmark, n):\n"
        "    benchmark.extra_info['items'] = n\n"
        "    benchmark.pedantic(sum, args=(range(n),), rounds=7)\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_sums.py", "--benchmark-json=times.json"]
    alone = {name: value for name, value in os.environ.items() if name != "PYTEST_XDIST_WORKER"}  # or else nothing is timed
    subprocess.run(command, cwd=tmp_path, env=alone, check=True, capture_output=True)
    shown = report(results, tmp_path / "times.json")
    assert shown.exit_code == 0, shown.output
    page = Page(results.report / "performance.html")
    text = " ".join(" ".join(page.text).split())
    assert "sums" in page.text
    assert "test_sum[10]" in text
    assert "items: 1000" in text
    assert "2 benchmarks of times.json" in text
    assert "performance.html" in Page(results.report / "index.html").links
    known = pages(results)
    for name in known:
        assert not broken_links(results, known, name), name


def test_the_table_of_a_group_has_the_numbers_of_the_file_the_fastest_first(results: Results, tmp_path: Path) -> None:
    assert report(results, stored(tmp_path / "b.json", PLAIN)).exit_code == 0
    page = Page(results.report / "performance.html")
    cells = [" ".join(cell.split()) for cell in page.cells]
    k = cells.index("fast test_x.py rate: 41.23; timer: StepClock")
    assert cells[k + 2 : k + 6] == ["1.00 ms", "300 µs", "7", "1.00 fastest"]
    k = cells.index("slow test_x.py rate: 41.23; timer: StepClock")
    assert cells[k + 2 : k + 6] == ["4.00 ms", "1.20 ms", "7", "4.00"]
    k = cells.index("alone test_x.py rate: 41.23; timer: StepClock")
    assert cells[k + 2 : k + 6] == ["2.00 s", "600 ms", "7", "–"], "there is nothing to compare it with"
    text = " ".join(page.text)
    assert "CPU 1, 8 processors, Linux x86_64, host host" in text
    assert "History" not in text


def test_the_page_is_removed_when_the_report_is_made_without_benchmarks(results: Results, tmp_path: Path) -> None:
    file = stored(tmp_path / "b.json", PLAIN)
    render(results, benchmarks=[file])
    page = results.report / "performance.html"
    before = page.stat().st_mtime_ns
    render(results, benchmarks=[file])
    assert page.stat().st_mtime_ns == before, "unchanged"
    stored(file, content(benchmark("other", 1.0)))
    render(results, benchmarks=[file])
    assert "other" in "".join(Page(page).text)
    render(results)
    assert not page.exists()
    assert "performance.html" not in Page(results.report / "index.html").links
    page.write_text("my notes")
    with pytest.raises(ResultsError, match=r"performance\.html"):
        render(results, benchmarks=[file])
    assert page.read_text() == "my notes"
    store(results, study("performance", ("good",)))
    with pytest.raises(ResultsError, match="rename the study"):
        render(results)


def changed(*path: str | int, value: Any) -> dict[str, Any]:
    """The plain file with one value changed."""
    table = copy.deepcopy(PLAIN)
    inner: Any = table
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return table


STATS = ("benchmarks", 0, "stats")


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("", "is cut off or no JSON (line 1)"),
        (json.dumps(PLAIN)[:-200], "is cut off or no JSON"),
        ("[" * 100_000, "is cut off or no JSON"),
        ("[]", "it holds no table"),
        ({}, "it has no 'machine_info'"),
        ({"report": {}, "tests": []}, "it has no 'machine_info'"),
        (changed("machine_info", value=[]), "it has no 'machine_info'"),
        (changed("benchmarks", value={}), "it has no list 'benchmarks'"),
        (changed("benchmarks", value=[]), "it holds no benchmark"),
        (changed("benchmarks", 0, value=3), "entry 1 of 'benchmarks' is no table"),
        (changed("benchmarks", 1, "name", value=""), "entry 2 of 'benchmarks' has no 'name'"),
        (changed("benchmarks", 1, "fullname", value="test_x.py::slow"), "it has the benchmark 'test_x.py::slow' twice"),
        (changed("benchmarks", 0, "stats", value=None), "the benchmark 'slow' has no 'stats'"),
        (changed(*STATS, "median", value="4"), "'median' of 'slow' is no time in seconds"),
        (changed(*STATS, "median", value=-1.0), "'median' of 'slow' is no time in seconds"),
        (changed(*STATS, "median", value=10**400), "'median' of 'slow' is no time in seconds"),
        (changed(*STATS, "q3", value=True), "'q3' of 'slow' is no time in seconds"),
        (json.dumps(PLAIN).replace("0.004", "NaN"), "is cut off or no JSON"),
        (changed(*STATS, "q1", value=1.0), "the median of 'slow' is not between its quartiles"),
        (changed(*STATS, "rounds", value=0), "'rounds' of 'slow' is no positive number"),
        (changed("datetime", value="yesterday"), "it has no 'datetime'"),
        (changed("datetime", value="0001-01-01T00:00:00+23:00"), "its 'datetime' is out of range"),
    ],
)
def test_a_corrupt_or_foreign_file_gets_one_sentence_with_the_remedy(
    results: Results, tmp_path: Path, table: Any, said: str
) -> None:
    shown = report(results, stored(tmp_path / "b.json", table))
    assert shown.exit_code == 2
    words = " ".join(shown.output.split())
    assert said in words
    assert "make it anew with `pytest --benchmark-json=FILE`" in words
    assert words.count("Error: ") == 1
    assert "Traceback" not in words
    assert not (results.report / "performance.html").exists()


def test_a_missing_file_a_folder_and_bytes_are_named(results: Results, tmp_path: Path) -> None:
    (tmp_path / "b.json").write_bytes(b"\xff\xfe\x00")
    for path, said in ((tmp_path / "none.json", "cannot read"), (tmp_path, "cannot read"), (tmp_path / "b.json", "no text")):
        shown = report(results, path)
        assert (shown.exit_code, said in shown.output) == (2, True), shown.output
    shown = CliRunner().invoke(cli, ["report", "--out", str(results.path), "--format", "md", "--benchmarks", "x"])
    assert (shown.exit_code, "leave --format md out" in shown.output) == (2, True)


def test_several_files_of_one_machine_give_a_history(results: Results, tmp_path: Path) -> None:
    old = content(benchmark("slow", 8e-3), benchmark("fast", 2e-3), day=1)
    new = content(benchmark("slow", 3e-3), benchmark("fast", 1e-3), benchmark("new", 5e-3), day=2)
    files = [stored(tmp_path / "new.json", new), stored(tmp_path / "old.json", old)]
    assert report(results, *files).exit_code == 0
    made = performance_page(read_benchmarks(files), "generator")
    assert [file.name for file in made.files] == ["old.json", "new.json"]
    (group,) = made.groups
    assert [(row.name, row.ratios, row.change) for row in group.history] == [
        ("fast", ("1.00", "1.00"), "× 0.500"),
        ("slow", ("4.00", "3.00"), "× 0.375"),
        ("new", ("–", "5.00"), "–"),
    ]
    assert made.machines == ()
    assert not any("machine" in caution for caution in made.cautions)
    assert "History of the ratio" in " ".join(Page(results.report / "performance.html").text)


def test_times_of_different_machines_are_not_compared(tmp_path: Path) -> None:
    tables = [
        content(benchmark("slow", 8e-3), benchmark("fast", 2e-3), cpu="CPU 2", day=1),
        content(benchmark("slow", 6e-3), benchmark("fast", 2e-3), day=2),
        content(benchmark("slow", 3e-3), benchmark("fast", 1e-3), day=3),
    ]
    files = [stored(tmp_path / f"{k}.json", table) for k, table in enumerate(tables)]
    page = performance_page(read_benchmarks(files), "generator")
    assert [file.letter for file in page.files] == ["A", "B", "B"]
    assert page.cautions[0].startswith("The files are from 2 machines. Times of different machines are not compared")
    assert {row.name: row.change for row in page.groups[0].history} == {"fast": "× 0.500", "slow": "× 0.500"}
    two = performance_page(read_benchmarks(files[:2]), "generator")
    assert {row.change for row in two.groups[0].history} == {"–"}, "one file of each machine"


def test_names_never_become_markup(results: Results, tmp_path: Path) -> None:
    table = content(benchmark(HOSTILE, 1.0, HOSTILE), benchmark("x", 2.0, HOSTILE), cpu=HOSTILE, commit=HOSTILE)
    table["benchmarks"][0]["extra_info"] = {HOSTILE: [HOSTILE]}
    assert report(results, stored(tmp_path / "b.json", table)).exit_code == 0
    page = Page(results.report / "performance.html")
    assert page.scripts == 1
    assert HOSTILE in "".join(page.text)


def test_a_time_of_zero_has_no_dot_and_no_ratio(tmp_path: Path) -> None:
    nothing = benchmark("nothing", 0.0)
    page = performance_page(
        read_benchmarks([stored(tmp_path / "b.json", content(nothing, benchmark("some", 1.0)))]), "generator"
    )
    (group,) = page.groups
    assert [row.ratio for row in group.rows] == ["–", "–"]
    assert "<circle" not in group.rows[0].strip


@given(TIMES, TIMES, TIMES, TIMES)
def test_every_strip_of_a_time_stays_in_its_frame(a: float, b: float, c: float, d: float) -> None:
    low, median, high = sorted((a, b, c))
    ends = axis([low, median, high, d])
    for picture in (time_strip(median, low, high, ends), time_ruler(ends)):
        ElementTree.fromstring(picture)
        drawn = re.sub(r'aria-label="[^"]*"', "", picture)
        places = [float(x) for x in re.findall(r'(?:M|H|cx="|<text x=")(-?[\d.]+)', drawn)]
        assert all(0 <= x <= WIDTH for x in places)
    assert time_ruler(ends).count("<text") >= 1
    assert MARGIN < WIDTH / 2


@given(st.lists(st.one_of(st.floats(1e-3, 1e3), st.just(math.nan)), max_size=9))
def test_a_history_stays_in_its_frame_and_needs_two_ratios(ratios: list[float]) -> None:
    picture = history_line(ratios)
    assert bool(picture) == (sum(map(math.isfinite, ratios)) > 1)
    for x, y in re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", picture):
        assert 0 <= float(x) <= HISTORY
        assert 0 <= float(y) <= 22


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
@pytest.mark.parametrize("window", ["1280,900", "390,800"])
def test_the_page_opens_without_errors_and_does_not_scroll_sideways(results: Results, tmp_path: Path, window: str) -> None:
    files = [stored(tmp_path / f"{k}.json", content(*PLAIN["benchmarks"], day=k)) for k in range(1, 7)]
    assert report(results, *files).exit_code == 0
    act = "return { wide: document.documentElement.scrollWidth - innerWidth };"
    found = acted(results.report / "performance.html", results.report, act, tmp_path / "profile", window=window)
    assert (found["faults"], found["missing"]) == ([], [])
    assert found["wide"] <= 0


@given(st.floats(1e-9, 900.0))
def test_a_time_is_written_with_a_unit_that_leaves_few_digits(value: float) -> None:
    shown, unit = seconds(value).split(" ")
    assert "×" not in shown
    factor = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}[unit]
    assert math.isclose(float(shown) * factor, value, rel_tol=0.006)


def test_a_reader_of_a_missing_file_raises_what_the_command_line_shows(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot read"):
        read_benchmarks([tmp_path / "none"])
