"""Layouts of tables: from text to rows of cells, whatever separates them.

Each layout is a function from the text to its rows, or None where the text has another layout. `rows` tries them in turn.
"""

import csv
import re
from collections.abc import Callable, Sequence
from itertools import combinations, pairwise

from mpmverify.convergence.column_names import Role, role
from mpmverify.convergence.markup import Rows, Text, from_json, html, is_rule, latex, piped, plain_cells
from mpmverify.convergence.numerals import is_missing, number, plain
from mpmverify.errors import UsageError

COMMENT = re.compile(r"\s*(?:#+|%+|!+|//)\s?(.*)")
LARGEST_HEADER = 16
"""Largest number of single spaces in a line of names that are tried."""
_PAIR = re.compile(r"([^\s=:,;|][^=:,;|]*?)\s*(?:=|:(?!\S*:))\s*([^\s,;|=]+)(?=[\s,;|]|$)")
_LIST = re.compile(
    r"[\"']?([^\s=:,;\[\]{}()\"'][^=:\[\]{}()\"'\n]*?)[\"']?\s*[=:]\s*(?:[\w.]+\()?[\[{(]+([^=:\[\]{}()]*)[\]})]+'?\)*"
)


def rows(text: Text) -> Rows:
    """Split a text into rows of plain cells.

    Raises
    ------
    UsageError
        If the text holds two tables, or quotes that do not end.
    """
    layouts: tuple[Callable[[Text], Rows | None], ...] = (html, from_json, piped, latex, _lists, _pairs)
    return next((found for layout in layouts if (found := layout(text)) is not None), None) or _separated(text)


def _lists(text: Text) -> Rows | None:
    """Read one list for each column, as in Python, MATLAB or YAML: h = [0.1, 0.05]."""
    content = re.sub(r"(?m)(?:^|(?<=\s))(?:#|%|!|//).*", "", text.content)
    found = list(_LIST.finditer(content))
    if len(found) < 2 or re.search(r"[^\s;,{}]", _LIST.sub("", content)):
        return None
    lines = (content.count("\n", 0, match.start(1)) + 1 for match in found)
    cells = ((match[1], *re.findall(r"[^\s,;]+", match[2])) for match in found)
    return Rows([(at, plain_cells(row)) for at, row in zip(lines, cells, strict=True)])


def _pairs(text: Text) -> Rows | None:
    """Read names and values in each line, as in a log: h = 0.1, L2 = 1e-3."""
    lines = [(at, _PAIR.findall(line)) for at, line in text.lines]
    names = tuple(name for name, _ in lines[0][1]) if lines else ()
    if len(names) < 2 or any(tuple(name for name, _ in pairs) != names for _, pairs in lines):
        return None
    if any(number(plain(value)) is None and not is_missing(value) for _, pairs in lines for _, value in pairs[-1:]):
        return None
    return Rows([(lines[0][0], plain_cells(names)), *((at, plain_cells(value for _, value in pairs)) for at, pairs in lines)])


def _separated(text: Text) -> Rows:
    """Read columns that are separated by tabs, semicolons, commas or white space."""
    lines: list[tuple[int, str]] = []
    comments: list[tuple[int, str]] = []
    levels: list[int] = []
    separators = "\t;,"
    for at, line in text.lines:
        if declared := re.fullmatch(r'"?sep=(.)"?', line.strip()):  # the first line of a spreadsheet
            separators = declared[1]
        elif comment := COMMENT.fullmatch(line):
            if not lines and comment[1].strip() and not is_rule(comment[1]):
                comments.append((at, comment[1]))
        elif not is_rule(line):
            if number(plain(re.split(r"[\s,;]", line.strip(), maxsplit=1)[0])) is None:
                lines.append((at, line))
            else:
                lines.append((at, re.sub(r"\s(?:#|!|//).*", "", line)))
                levels.append(at)
    _refuse_blocks(text, levels)
    if lines and "\t\t" in lines[0][1].strip():  # they align columns
        lines = [(at, re.sub(r"\t+", "\t", line.strip())) for at, line in lines]
    for separator in separators:
        if 2 * sum(separator in line.strip() for _, line in lines) > len(lines):
            found = _cut(text.place, lines, comments, separator)
            if not any(re.search(r"\d\s+[-+\d.]", cell) for _, cells in found.rows[1:] for cell in cells):
                return found
    return _spaced(lines, comments)


def _refuse_blocks(text: Text, levels: Sequence[int]) -> None:
    """Refuse levels that two empty lines divide, as they divide data sets in files for gnuplot."""
    lines = text.content.split("\n")
    for before, after in pairwise(levels):
        if any(not (lines[at].strip() or lines[at + 1].strip()) for at in range(before, after - 2)):
            raise UsageError(f"{text.place} holds two tables, the second at line {after}: give one of them")


def _cut(place: str, lines: list[tuple[int, str]], comments: list[tuple[int, str]], separator: str) -> Rows:
    def cut(line: str) -> tuple[str, ...]:
        return plain_cells(next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True)))

    cells = []
    for at, line in lines:
        try:
            cells.append((at, cut(line)))
        except csv.Error as error:
            raise UsageError(f"{place}, line {at}: {error}") from error
    return Rows([row for row in cells if any(row[1])], comments)


def _spaced(lines: list[tuple[int, str]], comments: list[tuple[int, str]]) -> Rows:
    """Split at white space; a name may hold single spaces."""
    joined = [(at, re.sub(r"(?<=[\d.])\s+([*x×·⋅/^])\s+(?=[\d-])", r"\1", line)) for at, line in lines]
    cells = [(at, plain_cells(cell.strip("\"'") for cell in line.split())) for at, line in joined]
    width = len(cells[-1][1]) if cells else 0
    start = next(
        (k for k, (_, row) in enumerate(cells) if len(row) == width and any(number(cell) is not None for cell in row)), 0
    )
    for k in range(start):
        at, line = joined[k]
        cells[k] = at, plain_cells(_words_over(line, joined[start][1]))
    return Rows(cells, comments)


def _words_over(line: str, level: str) -> list[str]:
    """Names in a line, as many as the level below has columns that begin with a value, or as it has columns.

    Words that are a single space apart may be one name: those are joined that then stand closest to the middle of their columns.
    """
    words, columns = list(re.finditer(r"\S+", line)), list(re.finditer(r"\S+", level))
    blocks: list[tuple[int, int]] = []
    for column in columns:
        if blocks and is_missing(plain(column[0])):
            blocks[-1] = blocks[-1][0], column.end()
        else:
            blocks.append((column.start(), column.end()))
    wide = re.split(r"\s{2,}|\t", line.strip())
    names = [word[0] for word in words]
    known = [name for name in names if role(name) is not Role.RATE]
    if len(words) <= len(blocks) or (len(words) == len(columns) and len(set(known)) == len(known)):
        return names
    if len(wide) in (len(blocks), len(columns)):
        return wide
    gaps = [k for k in range(1, len(words)) if words[k].start() - words[k - 1].end() == 1]
    joins = len(words) - len(blocks)
    if len(gaps) > LARGEST_HEADER:
        return wide

    def groups(joined: Sequence[int]) -> list[tuple[int, int]]:
        starts = [k for k in range(len(words)) if k not in joined]
        return [(words[k].start(), words[after - 1].end()) for k, after in zip(starts, [*starts[1:], len(words)], strict=True)]

    def misfit(joined: Sequence[int]) -> float:
        return sum(abs(sum(group) - sum(block)) for group, block in zip(groups(joined), blocks, strict=True))

    ways = list(combinations(gaps, joins))
    return [line[start:end] for start, end in groups(min(ways, key=misfit))] if ways else wide
