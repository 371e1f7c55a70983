"""The report: pages made from stored results only, in HTML that opens from disk without a network, or one page in Markdown.

Here belong readers of study files, the data and the template of each page, the Markdown page, and the handbook. To add a page, write
a module that makes its dataclass (`pages`), a template, and an entry in `site` and `manifest`. Nothing is solved or judged here.

Notes
-----
The page of a study is made in the process that judges it (`render_study`). `render` makes it if it is missing, or if its study file or
the code of the report has changed, and all other pages. Changes are detected from the size and modification time of each file, without
reading a dataset.
"""

import hashlib
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from mpmverify.dataset.files import Results, check_ours, set_aside
from mpmverify.dataset.tree import CHECKSUM, Group
from mpmverify.errors import DamagedError

from .manifest import Manifest, Source

if TYPE_CHECKING:
    from mpmverify.judgement.comparison import Comparison
    from mpmverify.judgement.tables import Tables

    from .benchmark_reader import Measured
    from .record import Record

__all__ = ["MadePage", "render", "render_alone", "render_comparison", "render_markdown", "render_pdf", "render_study"]


class MadePage(NamedTuple):
    """A page of a study: what it was made of, the state of the study's file then, and the digest of the page."""

    record: "Record"
    source: Source
    digest: str

    def stands(self, results: Results, study: str, manifest: Manifest) -> bool:
        """Whether both files are as they were: no other process has written to the folder."""
        page = results.report / f"{study}.html"
        unchanged = manifest.studies.get(study) == self.source
        return unchanged and page.is_file() and hashlib.sha256(page.read_bytes()).hexdigest() == self.digest


def render_study(results: Results, study: str, groups: Mapping[str, Group]) -> MadePage | None:
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
        None if the page cannot be made; then `render` tries again, and says why. None, too, if another process has replaced the file.
    """
    from .site import write_study

    path = results.study(study)
    try:
        source = Source.of(path)
        if check_ours(path, "study").get(CHECKSUM) != groups["/"].attributes[CHECKSUM]:
            return None
        record, digest = write_study(results, study, groups)
    except Exception:  # what `render` raises again, when the verdicts have been shown
        logging.getLogger("mpmverify").debug("The page of %s is not made yet.", study, exc_info=True)
        return None
    return MadePage(record, source, digest)


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
        made = {name: page for name, page in pages.items() if page and page.stands(results, name, manifest)}
        whole = write(results, manifest, known, measured, {name: page.record for name, page in made.items()})
        manifest.write(results, known, whole, {name: page.digest for name, page in made.items()})
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
