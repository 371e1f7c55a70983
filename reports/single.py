"""One page in one file: the page of a study with its style, its script and the charting library, without links to other files."""

import base64
import re
from pathlib import Path

from mpmverify.atomic import write_atomic
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError

SUFFIX = "-self-contained.html"


def write(results: Results, study: str) -> Path:
    """Write the page of a study as one file that needs no other, beside the report, and return its path.

    Raises
    ------
    ResultsError
        If the report has no page of this study, or the file cannot be written.
    """
    page = results.report / f"{study}.html"
    if study not in {path.stem for path in results.studies()} or not page.exists():
        known = ", ".join(sorted(path.stem for path in results.studies())) or "none"
        raise ResultsError(f"'{results.path}' has no study {study!r}: choose from {known}")
    target = results.report / f"{study}{SUFFIX}"
    text = self_contained(page.read_text(encoding="utf-8"), results.report)
    write_atomic(target, lambda temporary: temporary.write_text(text, encoding="utf-8", errors="replace"))
    return target


def write_alone(page: str, target: Path) -> Path:
    """Write a page that has no charts as one file that needs no other, and return its path.

    Raises
    ------
    ResultsError
        If the file cannot be written.
    """
    text = self_contained(page, Path(__file__).parent, charts=False)
    write_atomic(
        target, lambda temporary: temporary.write_text(text, encoding="utf-8", errors="replace"), "choose another file"
    )
    return target


def self_contained(page: str, folder: Path, *, charts: bool = True) -> str:
    """Put the assets of a page into it, and turn its links to other files into text.

    Parameters
    ----------
    page : str
        HTML as the report writes it.
    folder : Path
        Folder of the page.
    charts : bool
        Whether the page needs the charting library.
    """

    def read(name: str) -> str:
        return (folder / name).read_text(encoding="utf-8")

    def script(name: str) -> str:
        return f"<script>{read(name)}</script>"

    page = re.sub(r'<link rel="stylesheet" href="([^"]+)">', lambda link: f"<style>{read(link[1])}</style>", page)
    page = re.sub(r'<img([^>]*) src="([^":]+\.svg)"', lambda image: f'<img{image[1]} src="{_picture(folder / image[2])}"', page)
    page = re.sub(r'<a\b[^>]*\bhref="(?!#|https?:|data:)[^"]*"[^>]*>(.*?)</a>', r"<span>\1</span>", page, flags=re.DOTALL)
    # The charting library comes first: the script of the report uses it where it is there, and loads it as a file where not.
    first, *others = re.split(r'<script src="([^"]+\.js)"[^>]*></script>', page)
    pairs = zip(others[::2], others[1::2], strict=True)
    library = f"{script('assets/plotly.min.js')}\n" if charts else ""
    return f"{first}{library}" + "".join(f"{script(name)}{rest}" for name, rest in pairs)


def _picture(path: Path) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(path.read_bytes()).decode()}"
