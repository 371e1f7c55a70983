"""The report: pages made from stored results only, in HTML that opens from disk without a network, or one page in Markdown.

Here belong readers of study files, the data and the template of each page, the Markdown page, and the handbook. To add a page, write
a module that makes its dataclass (`pages`), a template, and an entry in `site` and `manifest`. Nothing is solved or judged here.

Notes
-----
A page is rendered if it is missing, or if its study file or the code of the report has changed. Changes are detected from the size
and modification time of each file, without reading a dataset.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from mpmverify.dataset.files import Results, set_aside
from mpmverify.errors import DamagedError

from .manifest import Manifest, Source

if TYPE_CHECKING:
    from mpmverify.dataset.tree import Group
    from mpmverify.judgement.comparison import Comparison
    from mpmverify.judgement.tables import Tables

    from .benchmark_reader import Measured
    from .record import Record

__all__ = ["MadePage", "render", "render_alone", "render_comparison", "render_markdown", "render_pdf", "render_study"]


class MadePage(NamedTuple):
    """What the page of a study was made of, and the state of its file then."""

    record: "Record"
    source: Source


def render_study(results: Results, study: str, groups: "Mapping[str, Group]") -> MadePage | None:
    """Write the page of a study that was just judged, so that `render` need not.

    Parameters
    ----------
    results : Results
    study : str
    groups : mapping of str to Group
        What was written to its file.

    Returns
    -------
    MadePage or None
        None if the page cannot be made; then `render` tries again, and says why.
    """
    from .site import write_study

    try:
        return MadePage(write_study(results, study, groups), Source.of(results.study(study)))
    except Exception:  # `render` raises it again, when the verdicts have been shown
        return None


def render(
    results: Results,
    *,
    fresh: bool = False,
    benchmarks: Sequence[Path] = (),
    pages: Mapping[str, MadePage | None] = MappingProxyType({}),
) -> Path:
    """Write the report of a results folder; pages that are up to date are not rendered again.

    Parameters
    ----------
    results : Results
    fresh : bool
        Render every page, even if it is up to date.
    benchmarks : sequence of Path
        Files of pytest-benchmark, of which a page is made; a report that is made without them has no such page.
    pages : mapping of str to MadePage or None
        Pages of studies that are made, by name; one whose file has changed since is made again.

    Returns
    -------
    Path
        Path of the index page.

    Raises
    ------
    ResultsError
        If a results file is foreign or damaged, or a page cannot be written. A damaged page or self-test is set aside.
    UsageError
        If a file of benchmarks is none of pytest-benchmark.
    """
    measured = _measured(benchmarks)
    manifest = Manifest.of(results, benchmarks)
    known = Manifest() if fresh else Manifest.read(results)
    if fresh or not manifest.describes(known, results):
        from mpmverify.dataset.selftest import read_selftest

        from .site import write

        try:
            if manifest.selftest:
                read_selftest(results.selftest)
        except DamagedError:  # cut off, or written before it held what the pages show
            set_aside(results.selftest)
            manifest = Manifest.of(results, benchmarks)
        made = {name: page.record for name, page in pages.items() if page and manifest.studies.get(name) == page.source}
        manifest.write(results, known, write(results, manifest, known, measured, made))
    return results.report / "index.html"


def _measured(benchmarks: Sequence[Path]) -> "tuple[Measured, ...]":
    if not benchmarks:
        return ()
    from .benchmark_reader import read_benchmarks

    return read_benchmarks(benchmarks)


def render_markdown(results: Results) -> Path:
    """Write one Markdown page for a pull request and return its path.

    Raises
    ------
    ResultsError
        If a results file is foreign or damaged, or the page cannot be written.
    """
    from .markdown import write

    return write(results)


def render_pdf(results: Results) -> Path:
    """Print the pages that `render` wrote as PDF and return the path of the first.

    Raises
    ------
    UsageError
        If no Chromium is found.
    ResultsError
        If a page cannot be printed.
    """
    from .pdf import write

    return write(results)


def render_alone(results: Results, study: str) -> Path:
    """Write the page of a study that `render` wrote as one file, without links to others, and return its path.

    Raises
    ------
    ResultsError
        If there is no such study, or the file cannot be written.
    """
    from .single import write

    return write(results, study)


def render_comparison(comparison: "Comparison", tables: "tuple[Tables, Tables]", names: tuple[str, str], target: Path) -> Path:
    """Write the comparison of two results folders as one file, without links to others, and return its path.

    Parameters
    ----------
    comparison : Comparison
    tables : (Tables, Tables)
        What was compared.
    names : (str, str)
        Names of the folders, for the page.
    target : Path
        File to write; an older page is replaced.

    Raises
    ------
    ResultsError
        If a file that is no page of mpmverify has this path, or it cannot be written.
    """
    from .changes_page import changes_page
    from .single import write_alone
    from .site import GENERATOR, make_way, render

    make_way(target)
    return write_alone(render(changes_page(comparison, *tables, names, GENERATOR)), target)
