"""Baselines, stored studies and reports that commands work on."""

import webbrowser
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import click

from mpmverify.errors import UsageError

if TYPE_CHECKING:
    from mpmverify.dataset.files import Results
    from mpmverify.judgement.baseline import Baseline
    from mpmverify.reports import MadePage


def shipped_baseline() -> Path:
    """Path of the baseline that is installed with the studies."""
    from mpmverify import studies

    return studies.BASELINE


def accepted(path: Path | None) -> "Baseline":
    """Read the baseline of the regression gate: the one at `path`, or the shipped one, which gates the shipped studies alone.

    Raises
    ------
    UsageError
        If there is no file at `path`.
    """
    from mpmverify import studies
    from mpmverify.judgement.baseline import read_baseline

    if path and not path.exists():
        raise UsageError(f"there is no baseline '{path}': make it with `mpmverify baseline accept`, or leave --baseline out")
    return read_baseline(path) if path else read_baseline(studies.BASELINE, studies.NAMES)


def stored(out: Path, names: Sequence[str]) -> list[Path]:
    """Files of the named studies in a results folder, or of all its studies.

    Raises
    ------
    UsageError
        If a study has no file, or the folder has none at all.
    """
    from mpmverify.adapters.names import is_own, own_study
    from mpmverify.dataset.files import Results

    results = Results(out)
    wanted = [own_study(name).name if is_own(name) else name for name in dict.fromkeys(names)]
    paths = [results.study(name) for name in wanted] or results.studies()
    for path in paths:
        if not path.exists():
            raise UsageError(f"no results of {path.stem!r} in '{out}': run `mpmverify run {path.stem} --out {out}` first")
    if not paths:
        raise UsageError(f"no results in '{out}': run `mpmverify run --out {out}` first")
    return paths


def show_report(
    results: "Results",
    form: str = "html",
    alone: str = "",
    benchmarks: Sequence[Path] = (),
    *,
    fresh: bool = False,
    opened: bool = False,
    pages: "Mapping[str, MadePage | None]" = MappingProxyType({}),
) -> None:
    """Render the report, print where it is, and open it in the browser when asked to.

    Parameters
    ----------
    results : Results
    form : str
        "html", "md" for one page in Markdown, or "pdf".
    alone : str
        Name of a study whose page is written as one file, too.
    benchmarks : sequence of Path
        Files of pytest-benchmark.
    fresh : bool
        Render every page, even if it is up to date.
    opened : bool
        Open it in the browser.
    pages : mapping of str to MadePage or None
        Pages of studies that `render_study` has made, by name.
    """
    from mpmverify import reports

    html = partial(reports.render, results, fresh=fresh, benchmarks=benchmarks, pages=pages)
    page = reports.render_markdown(results) if form == "md" else html()
    if form == "pdf":
        page = reports.render_pdf(results)
    elif alone:
        page = reports.render_alone(results, alone)
    click.echo(f"Report: {page}")
    if opened:
        webbrowser.open(page.resolve().as_uri())
