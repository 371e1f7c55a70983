"""What the report was made from, so that what has not changed is not rendered again."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib import metadata
from pathlib import Path

import mpmverify
from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError

TRUST = "trust"
"""Page of the self-test."""
LIBRARIES = ("jinja2", "latex2mathml", "plotly")
ROOMS = ("convergence", "criteria", "dataset", "judgement")
"""Packages of the core that a page depends on, beside the report itself."""


@dataclass(frozen=True)
class Source:
    """A study's file, which is only ever written anew: its size and its time tell whether it was."""

    size: int
    modified: int


@dataclass(frozen=True)
class Manifest:
    """Sources of a report.

    Parameters
    ----------
    code : str
        Digest of everything that turns a dataset into a page.
    studies : mapping of str to Source
        By the stem of the study's file.
    selftest : Source, optional
        None where there is no self-test.
    """

    code: str = ""
    studies: Mapping[str, Source] = field(default_factory=dict)
    selftest: Source | None = None

    @classmethod
    def read(cls, results: Results) -> "Manifest":
        """Manifest of the report that was written last; empty when there is none, or none that can be read."""
        try:
            stored = json.loads(_path(results).read_text(encoding="utf-8"))
            studies = {name: Source(**entry) for name, entry in stored["studies"].items()}
            return cls(stored["code"], studies, Source(**stored["selftest"]) if stored["selftest"] else None)
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            return cls()

    @classmethod
    def of(cls, results: Results) -> "Manifest":
        """Manifest of the report that the results ask for.

        Raises
        ------
        ResultsError
            If a study would take the place of the index page or of the page on trust.
        """
        studies = {path.stem: _source(path) for path in results.studies()}
        for taken, name in (("index", "the index page"), (TRUST, "the page on trust")):
            if taken in studies:
                raise ResultsError(f"'{results.study(taken)}' would take the place of {name}: name the study otherwise")
        return cls(_code(), studies, _source(results.selftest) if results.selftest.exists() else None)

    def describes(self, known: "Manifest", results: Results) -> bool:
        """Whether the report at hand is the one that `self` asks for."""
        return self == known and not self.stale(known, results)

    def stale(self, known: "Manifest", results: Results) -> list[str]:
        """Pages, by study or as "trust", that are missing or were made from something else."""
        wanted, had = self.pages(), known.pages()
        return [
            name
            for name, source in wanted.items()
            if self.code != known.code or had.get(name) != source or not page(results, name).exists()
        ]

    def pages(self) -> dict[str, Source]:
        """What each page but the index is made from, by its name."""
        return dict(self.studies) | ({TRUST: self.selftest} if self.selftest else {})

    def write(self, results: Results, known: "Manifest") -> None:
        """Record this report, and remove the pages of studies that are gone."""
        for name in known.pages().keys() - self.pages().keys():
            page(results, name).unlink(missing_ok=True)
        text = json.dumps(asdict(self), indent=1, sort_keys=True) + "\n"
        write_atomic(_path(results), lambda temporary: temporary.write_text(text, encoding="utf-8"))


def _source(path: Path) -> Source:
    status = path.stat()
    return Source(status.st_size, status.st_mtime_ns)


def page(results: Results, study: str) -> Path:
    return results.report / f"{study}.html"


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
