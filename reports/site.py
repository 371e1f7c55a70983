"""Write the pages as HTML; the only module that uses the template engine."""

import dataclasses
import hashlib
import importlib.util
import re
from collections.abc import Collection, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

import mpmverify
from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results, check_ours, set_aside
from mpmverify.dataset.selftest import read_selftest
from mpmverify.dataset.tree import Group
from mpmverify.errors import ResultsError
from mpmverify.judgement.kill_table import SelfTest

from .benchmark_reader import Measured
from .catalogue_page import CataloguePage, catalogue_page
from .changes_page import ChangesPage
from .compare_page import ComparePage, compare_page
from .handbook_page import HandbookPage, handbook_pages
from .index_page import index_page
from .manifest import COMPARE, HANDBOOK, PERFORMANCE, PROBLEMS, SOLVERS, TRUST, Manifest, check_name, page
from .pages import IndexPage, StudyPage, TrustPage
from .parts import Link
from .performance_page import PerformancePage, performance_page
from .reader import read, record_of
from .record import Record
from .solver_page import solver_pages
from .solver_pages import SolverPage, SolversPage
from .study_page import study_page
from .trust_page import trust_page

GENERATOR = f"mpmverify {mpmverify.__version__}"
SIGNATURE = b'<meta name="generator" content="mpmverify '
BEGINNING = b'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n' + SIGNATURE
END = b"</html>\n"
"""How every page begins, and how it ends unless it is cut off."""
Page = (
    IndexPage
    | StudyPage
    | TrustPage
    | SolverPage
    | SolversPage
    | ComparePage
    | ChangesPage
    | CataloguePage
    | HandbookPage
    | PerformancePage
)
TEMPLATES = {
    IndexPage: "index.html",
    StudyPage: "study.html",
    TrustPage: "trust.html",
    SolverPage: "solver.html",
    SolversPage: "solvers.html",
    ComparePage: "compare.html",
    ChangesPage: "changes.html",
    CataloguePage: "problems.html",
    HandbookPage: "handbook.html",
    PerformancePage: "performance.html",
}
PLOTLY = "plotly.min.js"
ORIGIN = {"Written": "date_created", "Commit": "commit", "Tier": "tier", "Versions": "versions", "Platform": "platform"}
"""Attributes of the self-test file that the trust page shows, by label."""


def write_study(results: Results, study: str, groups: Mapping[str, Group]) -> tuple[Record, str]:
    """Write the page of a study from the groups of its file, and return what it was made of, and its digest.

    Raises
    ------
    ResultsError
        If the study has the name of another page, a file that is no page of a report has the path of the page, or it cannot be written.
    """
    check_name(results, study)
    record, path = record_of(study, groups), page(results, study)
    make_way(path)
    text = render(study_page(record, _runs(results), GENERATOR))
    _write(path, text)
    return record, hashlib.sha256(_encoded(text)).hexdigest()


def _runs(results: Results) -> set[str]:
    return {path.stem for path in results.runs.glob("*.nc")}


def write(
    results: Results,
    manifest: Manifest,
    known: Manifest,
    benchmarks: Sequence[Measured] = (),
    made: Mapping[str, Record] = MappingProxyType({}),
) -> tuple[str, ...]:
    """Write the pages that are stale beside the `known` report, the pages that are made of all studies, and the assets.

    Of the studies that `made` has, `write_study` has written the pages.

    Returns
    -------
    tuple of str
        Names of the pages of the problems, solvers and benchmarks: only the studies tell them.

    Raises
    ------
    ResultsError
        If a study file is damaged, plotly is missing, or a file that is no page of a report has the path of a page.
    """
    stale = [name for name in manifest.stale(known, results) if name not in made]
    for name in (*stale, "index"):
        make_way(page(results, name))
    runs = _runs(results)
    records = [made.get(name) or read(results.study(name)) for name in sorted(manifest.studies)]
    _write_assets(results, manifest)
    test = read_selftest(results.selftest) if manifest.selftest else None
    whole: dict[str, Page] = {PROBLEMS: catalogue_page(records, test.faults if test else (), GENERATOR)}
    whole |= solver_pages(records, runs, GENERATOR)
    whole[COMPARE] = compare_page(records, GENERATOR)
    if benchmarks:
        whole[PERFORMANCE] = performance_page(benchmarks, GENERATOR)
    for name in whole:
        make_way(page(results, name))
    for record in records:
        if record.name in stale:
            _write(page(results, record.name), render(study_page(record, runs, GENERATOR)))
    if test and TRUST in stale:
        _write(page(results, TRUST), render(_trust(results, test)))
    _write_handbook(results, manifest, stale)
    for name, content in whole.items():
        _write(page(results, name), render(content))
    further = [Link("How far to trust this", f"{TRUST}.html")] if test else []
    further += [Link("Performance", f"{PERFORMANCE}.html")] if benchmarks else []
    _write(page(results, "index"), render(index_page(records, GENERATOR, further)))
    return tuple(whole)


def _trust(results: Results, test: SelfTest) -> TrustPage:
    attributes = check_ours(results.selftest, "selftest")
    facts = [(name, str(attributes[key])) for name, key in ORIGIN.items()]
    file = results.selftest.relative_to(results.path).with_suffix("").as_posix()
    links = (Link("Overview", "index.html"), Link("Solvers", f"{SOLVERS}.html"), Link("Problems", f"{PROBLEMS}.html"))
    return trust_page(test, file, facts, links, GENERATOR)


def _write_handbook(results: Results, manifest: Manifest, stale: Collection[str]) -> None:
    if any(name.startswith("handbook/") for name in stale):
        texts = {name: (HANDBOOK / name).read_text(encoding="utf-8") for name in manifest.handbook}
        for name, content in handbook_pages(texts, GENERATOR).items():
            if name in stale:
                _write(page(results, name), render(content))


def render(content: Page) -> str:
    """Render a page to HTML."""
    fields = {field.name: getattr(content, field.name) for field in dataclasses.fields(content)}
    return environment().get_template(TEMPLATES[type(content)]).render(fields)


@cache
def environment() -> Environment:
    """Return the template engine, which escapes every value and raises on an unknown name."""
    engine = Environment(
        loader=PackageLoader("mpmverify.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    engine.filters["cited"] = cited
    engine.filters["markup"] = Markup  # only for MathML and figures, which are escaped where they are made
    return engine


def cited(text: str) -> Markup:
    """Escape a text and turn its DOIs into links."""
    return Markup(re.sub(r"doi:(10\.\d+/[^\s,;]*[^\s,;.)])", r'<a href="https://doi.org/\1">doi:\1</a>', str(escape(text))))


def make_way(path: Path) -> None:
    """Check that a file is a page and may be written; one that is cut off, emptied or filled with zeros is set aside."""
    if not path.exists():
        return
    content = path.read_bytes() if path.is_file() else b"a folder"
    if not content.strip(b"\0") or BEGINNING.startswith(content) or (SIGNATURE in content[:2000] and not content.endswith(END)):
        set_aside(path)
    elif SIGNATURE not in content[:2000]:
        raise ResultsError(f"'{path}' is not a page of an mpmverify report: move it away or choose another place")


def _write(path: Path, text: str) -> None:
    write_atomic(path, lambda temporary: temporary.write_bytes(_encoded(text)))


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", errors="replace")


def _write_assets(results: Results, manifest: Manifest) -> None:
    folder = results.report / "assets"
    assets = {folder / path.name: path for path in (Path(__file__).parent / "assets").glob("*.*")}
    spec = importlib.util.find_spec("plotly")
    if spec is None or spec.origin is None:
        raise ResultsError("the report needs plotly: install it with `pip install plotly`")
    assets[folder / PLOTLY] = Path(spec.origin).parent / "package_data" / PLOTLY
    for target, source in sorted((assets | manifest.pictures(results)).items()):
        content = source.read_bytes()
        if not target.exists() or target.read_bytes() != content:
            write_atomic(target, partial(Path.write_bytes, data=content))
