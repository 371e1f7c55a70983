"""Tables in LaTeX, Markdown, HTML and JSON, and tables drawn with bars: from text to rows of cells."""

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser

from mpmverify.convergence.numerals import plain
from mpmverify.errors import UsageError

Row = tuple[int, tuple[str, ...]]
"""Number of the line [1], and the cells."""
_TABULAR = re.compile(
    r"\\begin\{(tabular[xy]?\*?|array|longtable|tabu)\}(?:\[[^\]]*\])?(?:\{(?:[^{}]|\{[^{}]*\})*\})*(.*?)\\end\{\1\}", re.DOTALL
)
_DRAWN = re.compile(
    r"\\(?:hline|toprule|midrule|bottomrule|cmidrule|cline|specialrule|addlinespace|rowcolor|endhead|endfirsthead|endfoot|noalign"
    r"|centering|small|footnotesize|scriptsize)(?![a-z])(?:\([^)]*\)|\[[^\]]*\]|\{[^{}]*\})*"
)
_BEGIN = re.compile(rf"(?:\s|{_DRAWN.pattern})*")
_BOX = dict.fromkeys(range(0x2500, 0x2580), "+")
_BOX |= {ord(sign): "|" for sign in "│┃║┆┊╎"} | {ord(sign): "-" for sign in "─━═╌╴╶╸"}


@dataclass(frozen=True)
class Text:
    """Text of a table.

    Parameters
    ----------
    place : str
        Name of the file in error messages.
    content : str
        Its lines end with line feeds.
    """

    place: str
    content: str

    @property
    def lines(self) -> list[tuple[int, str]]:
        """Lines with their numbers, without empty lines."""
        return [(at, line) for at, line in enumerate(self.content.split("\n"), start=1) if line.strip()]


@dataclass(frozen=True)
class Rows:
    """Rows of plain cells.

    Parameters
    ----------
    rows : list of Row
    comments : list of (int, str)
        Lines and text of the comments above the first row.
    """

    rows: list[Row]
    comments: list[tuple[int, str]] = field(default_factory=list)


def is_rule(line: str) -> bool:
    """Whether a line is drawn, as in Markdown, reStructuredText, Org and the shells of databases."""
    signs = set(line.strip())
    drawn = bool(signs & set("-=_")) and signs <= set("-=_|+: \t")
    return drawn and (bool(signs & set("|+:")) or re.search("[-=_]{2}", line) is not None)


def plain_cells(cells: Iterable[str]) -> tuple[str, ...]:
    return tuple(plain(cell) for cell in cells)


def _one(place: str, blocks: list[list[Row]]) -> Rows:
    """Return the only block of rows."""
    blocks = [block for block in blocks if block]
    if len(blocks) > 1:
        starts = ", ".join(str(block[0][0]) for block in blocks)
        raise UsageError(f"{place} holds {len(blocks)} tables, at lines {starts}: give one of them")
    return Rows(blocks[0] if blocks else [])


def latex(text: Text) -> Rows | None:
    if not all(re.search(sign, text.content) for sign in (r"(?<!\\)&", r"\\\\|\\tabularnewline|\\cr\b")):
        return None
    content = re.sub(r"(?<!\\)%.*", "", text.content)
    bodies = [(found.start(2), found.end(2)) for found in _TABULAR.finditer(content)] or [(0, len(content))]
    return _one(text.place, [list(_latex_rows(content, *span)) for span in bodies])


def _latex_rows(content: str, start: int, end: int) -> Iterator[Row]:
    for found in re.finditer(r"(.*?)(?:\\\\(?:\s*\[[^\]]*\])?|\\tabularnewline|\\cr\b|$)", content[start:end], re.DOTALL):
        row = _DRAWN.sub("", found[1])
        if re.search(r"(?<!\\)&", row):
            text_at = start + found.start() + len(found[1]) - len(_BEGIN.sub("", found[1], count=1))
            cells = (part for cell in re.split(r"(?<!\\)&", row) for part in _spanned(cell))
            yield content.count("\n", 0, text_at) + 1, plain_cells(cells)


def _spanned(cell: str) -> list[str]:
    r"""Cells of a \multicolumn, which has the same text over all of its columns; the cell itself elsewhere."""
    rowed = re.sub(r"\\multirow\s*(?:\[[^\]]*\])?\{[^{}]*\}(?:\[[^\]]*\])?\s*(?:\{[^{}]*\}|\*)", "", cell)
    found = re.search(r"\\multicolumn\s*\{(\d+)\}\s*\{(?:[^{}]|\{[^{}]*\})*\}\s*(\{.*\})\s*$", rowed, re.DOTALL)
    return [found[2]] * int(found[1]) if found else [rowed]


class _Cells(HTMLParser):
    """Collects the cells of the tables of a page, whether its elements are closed or not."""

    def __init__(self) -> None:
        super().__init__()
        self.tables: list[list[tuple[int, list[str]]]] = [[]]
        self.text: list[str] | None = None
        """Pieces of the open cell."""
        self.span = 1

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("table", "tr", "td", "th"):
            self.end_cell()
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append((self.getpos()[0], []))
        elif tag in ("td", "th") and self.tables[-1]:
            span = dict(attrs).get("colspan") or ""
            self.text, self.span = [], int(span) if span.isdecimal() and len(span) < 3 else 1
        elif tag == "sup":
            self.handle_data("^")

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th", "tr", "table"):
            self.end_cell()

    def handle_data(self, data: str) -> None:
        if self.text is not None:
            self.text.append(data)

    def end_cell(self) -> None:
        if self.text is not None:
            self.tables[-1][-1][1].extend(["".join(self.text)] * self.span)
            self.text = None


def html(text: Text) -> Rows | None:
    if not re.search(r"<tr[\s>]", text.content, re.IGNORECASE):
        return None
    parser = _Cells()
    parser.feed(text.content)
    parser.close()
    parser.end_cell()
    return _one(text.place, [[(at, plain_cells(cells)) for at, cells in table if cells] for table in parser.tables])


def from_json(text: Text) -> Rows | None:
    try:
        found = json.loads(text.content)
    except ValueError:
        return None
    if isinstance(found, dict) and found and all(isinstance(values, dict) for values in found.values()):
        found = {name: list(values.values()) for name, values in found.items()}  # as pandas writes it
    if isinstance(found, dict) and found and all(isinstance(values, list) for values in found.values()):
        lengths = {len(values) for values in found.values()}
        if len(lengths) == 1:
            columns = found
            found = [{name: values[k] for name, values in columns.items()} for k in range(lengths.pop())]
    if not (isinstance(found, list) and found and all(isinstance(record, dict) for record in found)):
        return None
    names = tuple(dict.fromkeys(name for record in found for name in record))
    cells = [tuple("" if record.get(name) is None else plain(str(record[name])) for name in names) for record in found]
    return Rows([(1, plain_cells(names)), *((at, row) for at, row in enumerate(cells, start=1))])


def piped(text: Text) -> Rows | None:
    lines = [(at, line.translate(_BOX)) for at, line in text.lines]
    drawn = [is_rule(line) for _, line in lines]
    piped = ["|" in line and not rule for (_, line), rule in zip(lines, drawn, strict=True)]
    ruled = any(rule and ("|" in line or "+" in line) for (_, line), rule in zip(lines, drawn, strict=True))
    if sum(piped) < 2 or not (ruled or all(here or rule for here, rule in zip(piped, drawn, strict=True))):
        return None
    blocks: list[list[Row]] = []
    last = -1
    for (at, line), here, rule in zip(lines, piped, drawn, strict=True):
        if not (here or rule):
            last = -1
        elif here:
            inner = line.strip().removeprefix("|")
            inner = inner if inner.endswith("\\|") else inner.removesuffix("|")
            cells = re.split(r"(?<!\\)\|", inner)
            if last < 0 or (blocks and len(cells) != len(blocks[-1][0][1]) and at > last + 2):
                blocks.append([])
            blocks[-1].append((at, plain_cells(cells)))
            last = at
    return _one(text.place, [block for block in blocks if len(block) > 1 or len(blocks) == 1])
