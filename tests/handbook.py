"""The README and the pages of the handbook, read for their code blocks and links."""

import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "reports" / "handbook"
PAGES = (ROOT / "README.md", *sorted(FOLDER.glob("*.md")))
_BLOCK = re.compile(r"^((?:<!-- [^\n]* -->\n)*)```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_MARK = re.compile(r"<!-- (\w+)(?:: (.*?))? -->")


@dataclass(frozen=True)
class Block:
    """A fenced block of code.

    Parameters
    ----------
    language : str
        Behind the fence; "" for none.
    marks : dict of str to str
        The comments `<!-- name: value -->` on the lines before it, which no reader sees:

        - `file: NAME`, it is written to this file in the reader's folder;
        - `status: N`, it exits with N instead of 0;
        - `command: NAME`, `.ci/run` runs it in a fresh clone;
        - `parsed: WHY`, its commands take long or need more than there is: their options alone are checked, and a program is parsed;
        - `sweep: WHY`, a test in `tests/sweeps` runs it;
        - `workflow`, a service of continuous integration runs it.
    text : str
    """

    language: str
    marks: dict[str, str]
    text: str


def environment() -> dict[str, str]:
    """Variables of a reader who has activated the environment of the tests."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    alone = {name: value for name, value in os.environ.items() if name != "PYTEST_XDIST_WORKER"}  # a reader has no workers
    return {**alone, "PATH": path, "PYTHONWARNINGS": "error::RuntimeWarning"}


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks(page: Path) -> list[Block]:
    """Blocks of a page in its order."""
    return [Block(language, dict(_MARK.findall(marks)), code) for marks, language, code in _BLOCK.findall(text(page))]


def prose(page: Path) -> str:
    """A page without its blocks."""
    return _BLOCK.sub("", text(page))


def file(name: str) -> str:
    """Text of the one file of this name that the pages show."""
    (found,) = {block.text for page in PAGES for block in blocks(page) if block.marks.get("file") == name}
    return found
