"""Manifest: the inputs that a report was made from, so that unchanged pages are not rendered again."""

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib import metadata
from pathlib import Path

import mpmverify
from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError

TRUST = "trust"
"""Name of the page of the self-test."""
HANDBOOK = Path(__file__).parent / "handbook"
"""Folder of the Markdown and the pictures of the handbook."""
HANDBOOK_INDEX = "README.md"
"""File of its index, which tells the order of its pages."""
PROBLEMS = "problems"
"""Name of the catalogue of the problems."""
SOLVERS, SOLVER = "solvers", "solver-"
"""Name of the page that lists the solvers, and the beginning of the names of their own pages."""
PERFORMANCE = "performance"
"""Name of the page of the benchmarks."""
COMPARE = "compare"
"""Name of the page that compares two solvers."""
LIBRARIES = ("jinja2", "latex2mathml", "markdown-it-py", "plotly", "pygments")
ROOMS = ("convergence", "criteria", "dataset", "judgement")
"""Packages of `mpmverify` on which the pages depend, in addition to the modules of the report."""


@dataclass(frozen=True)
class Source:
    """State of an input file: size [bytes] and modification time [ns]. A file is always replaced whole, so these show every change."""

    size: int
    modified: int

    @classmethod
    def of(cls, path: Path) -> "Source":
        status = path.stat()
        return cls(status.st_size, status.st_mtime_ns)


@dataclass(frozen=True)
class Manifest:
    """Inputs of a report.

    Parameters
    ----------
    code : str
        Digest of the code, templates, assets and library versions that turn a dataset into a page.
    studies : mapping of str to Source
        Study files, by stem.
    selftest : Source, optional
        File of the self-test, if there is one.
    handbook : mapping of str to str
        Digests of the files of the handbook, by their name.
    benchmarks : tuple of str
        Digests of the files of benchmarks.
    written : mapping of str to str
        Digests of the files of the report, by their path in its folder.
    """

    code: str = ""
    studies: Mapping[str, Source] = field(default_factory=dict)
    selftest: Source | None = None
    handbook: Mapping[str, str] = field(default_factory=dict)
    benchmarks: tuple[str, ...] = ()
    written: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def read(cls, results: Results) -> "Manifest":
        """Read the manifest of the existing report; return an empty one if none can be read."""
        try:
            stored = json.loads(_path(results).read_text(encoding="utf-8"))
            studies = {name: Source(**entry) for name, entry in stored["studies"].items()}
            selftest = Source(**stored["selftest"]) if stored["selftest"] else None
            benchmarks = tuple(map(str, stored["benchmarks"]))
            return cls(stored["code"], studies, selftest, dict(stored["handbook"]), benchmarks, dict(stored["written"]))
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            return cls()

    @classmethod
    def of(cls, results: Results, benchmarks: Sequence[Path] = ()) -> "Manifest":
        """Make the manifest of an up-to-date report of the results and of files of benchmarks.

        Raises
        ------
        ResultsError
            If a study has the name of another page of the report.
        """
        studies = {path.stem: Source.of(path) for path in results.studies()}
        selftest = Source.of(results.selftest) if results.selftest.exists() else None
        for study in studies:
            check_name(results, study)
        texts = {path.name: _digest(path) for path in handbook_files()}
        return cls(_code(), studies, selftest, texts, tuple(map(_digest, benchmarks)))

    def describes(self, known: "Manifest", results: Results) -> bool:
        """Whether the existing report, whose manifest is `known`, is up to date."""
        unchanged = replace(known, written={}) == self and not self.stale(known, results)
        return unchanged and all(known.wrote(results.report / name, results) for name in known.written)

    def wrote(self, path: Path, results: Results) -> bool:
        """Whether a file of the report is as it was written."""
        return path.is_file() and self.written.get(_name(path, results)) == _digest(path)

    def stale(self, known: "Manifest", results: Results) -> list[str]:
        """Return the names of the pages that are missing or were made from other inputs: stems of studies, "trust", "handbook/index" and so on."""
        required, existing = self.pages(), known.pages()
        return [
            name
            for name, source in required.items()
            if self.code != known.code or existing.get(name) != source or not known.wrote(page(results, name), results)
        ]

    def pages(self) -> dict[str, Source | str]:
        """Return the input of every page that is made of one file, by page name; a page of the handbook also shows what its index says.

        The index, the catalogue and the pages of the solvers are made of all studies, and written whenever one of them has changed.
        """
        index = self.handbook.get(HANDBOOK_INDEX, "")
        texts = {handbook_name(name): index + digest for name, digest in self.handbook.items() if name.endswith(".md")}
        return dict(self.studies) | ({TRUST: self.selftest} if self.selftest else {}) | texts

    def pictures(self, results: Results) -> dict[Path, Path]:
        """Return the pictures of the handbook by their path in the report."""
        return {results.report / "handbook" / name: HANDBOOK / name for name in self.handbook if not name.endswith(".md")}

    def write(self, results: Results, known: "Manifest", whole: Collection[str], made: Mapping[str, str]) -> None:
        """Write the manifest, and remove pages and pictures whose study, self-test, solver or text no longer exists.

        Parameters
        ----------
        results : Results
        known : Manifest
            Manifest of the report before.
        whole : collection of str
            Names of the pages that are made of all studies or of no study: those of the problems, the solvers and the benchmarks.
        made : mapping of str to str
            Digests of the pages of studies that were made before, by name.
        """
        required = {*self.pages(), "index", *whole}
        old = {name.removesuffix(".html") for name in known.written if name.endswith(".html")}
        before = {name for name in old if name.startswith(SOLVER) or name == PERFORMANCE}
        for name in (known.pages().keys() | before) - required:
            page(results, name).unlink(missing_ok=True)
        for picture in known.pictures(results).keys() - self.pictures(results).keys():
            picture.unlink(missing_ok=True)
        files = [page(results, name) for name in sorted(required - made.keys())]
        files += [*(results.report / "assets").glob("*.*"), *self.pictures(results)]
        written = {_name(path, results): _digest(path) for path in files}
        written |= {_name(page(results, name), results): digest for name, digest in made.items()}
        text = json.dumps(asdict(replace(self, written=written)), indent=1, sort_keys=True) + "\n"
        write_atomic(_path(results), lambda temporary: temporary.write_text(text, encoding="utf-8"))


def check_name(results: Results, study: str) -> None:
    """Raise a `ResultsError` if a study has the name of another page of the report."""
    taken = {
        "index": "the index page",
        TRUST: "the trust page",
        SOLVERS: "the list of solvers",
        COMPARE: "the comparison of solvers",
        PERFORMANCE: "the page of the benchmarks",
        PROBLEMS: "the catalogue",
    }
    if name := taken.get(study, "the page of a solver" if study.startswith(SOLVER) else ""):
        raise ResultsError(f"'{results.study(study)}' would overwrite {name} of the report: rename the study")


def handbook_files() -> list[Path]:
    """Return the files of the handbook."""
    return sorted(path for kind in ("*.md", "*.svg") for path in HANDBOOK.glob(kind))


def handbook_name(file: str) -> str:
    """Return the name of the page of a text of the handbook."""
    return "handbook/index" if file == HANDBOOK_INDEX else f"handbook/{Path(file).stem}"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def page(results: Results, study: str) -> Path:
    return results.report / f"{study}.html"


def _name(path: Path, results: Results) -> str:
    return path.relative_to(results.report).as_posix()


def _path(results: Results) -> Path:
    return results.report / "manifest.json"


def _code() -> str:
    here, core = Path(__file__).parent, Path(mpmverify.__file__).parent
    files = sorted(path for kind in ("*.py", "templates/*.html", "assets/*") for path in here.glob(kind))
    files += sorted(path for room in ROOMS for path in (core / room).rglob("*.py"))
    total = hashlib.sha256()
    for path in files:
        total.update(path.read_bytes())
    versions = [mpmverify.__version__, *(metadata.version(name) for name in LIBRARIES)]
    total.update(" ".join(versions).encode())
    return total.hexdigest()[:24]
