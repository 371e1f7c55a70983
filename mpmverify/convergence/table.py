"""Tables of numbers with named columns, read from a file or from standard input in whatever layout people have them."""

import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpmverify.convergence.column_names import Role, role
from mpmverify.convergence.header import INDEX, header, melted, upright
from mpmverify.convergence.layouts import rows
from mpmverify.convergence.levels import Array
from mpmverify.convergence.markup import Row, Text
from mpmverify.convergence.numerals import Decimal, decimal_sign, grid, is_missing, number
from mpmverify.errors import ResultsError, UsageError

STANDARD_INPUT = Path("-")
LONGEST_WORD = 1000
"""Largest number of characters without a blank or a separator that a table may have."""


@dataclass(frozen=True)
class Table:
    """Rows of cells under named columns.

    Parameters
    ----------
    place : str
        The file in quotes, or "standard input", for messages.
    names : tuple of str
        Names of the columns.
    rows : tuple of (int, tuple of str)
        Line number in the file and the cells of each row, without markup.
    decimal : Decimal
        What commas and points between digits mean.
    named : bool
        Whether the file names its columns; otherwise their names are "1", "2" and so on.
    """

    place: str
    names: tuple[str, ...]
    rows: tuple[Row, ...]
    decimal: Decimal = Decimal.POINT
    named: bool = True

    def cells(self, name: str) -> tuple[str, ...]:
        """Return the cells of one column (n,).

        Raises
        ------
        UsageError
            If there is no such column.
        """
        if name not in self.names:
            raise UsageError(f"{self.place} has no column {name!r}: choose from {', '.join(self.names)}")
        column = self.names.index(name)
        return tuple(cells[column] for _, cells in self.rows)

    def given(self, name: str) -> np.ndarray:
        """Whether each cell of one column holds anything (n,)."""
        return np.array([not is_missing(cell) for cell in self.cells(name)])

    def numbers(self, name: str) -> Array:
        """Return one column as numbers (n,).

        Parameters
        ----------
        name : str
            Name of the column.

        Returns
        -------
        Array
            NaN where a cell is missing, too; `given` tells them from cells of "nan".

        Raises
        ------
        UsageError
            If there is no such column, or a cell in it is neither a number nor missing; "nan" and "inf" are numbers.
        """
        values = [np.nan if is_missing(cell) else number(cell, self.decimal) for cell in self.cells(name)]
        for (line, _), cell, value in zip(self.rows, self.cells(name), values, strict=True):
            if value is None:
                raise UsageError(
                    f"{self.place}, line {line}: {cell!r} in column {name!r} is not a number: remove the column, or correct it"
                )
        return np.array(values, dtype=float)

    @property
    def commas(self) -> str:
        """What commas in numbers do, such as "separates thousands"; "" where there are none."""
        if self.decimal is Decimal.COMMA:
            return "is the decimal sign"
        numbers = (cell for _, cells in self.rows for cell in cells if "," in cell)
        return "separates thousands" if any(number(cell) is not None for cell in numbers) else ""

    def is_text(self, name: str) -> bool:
        """Whether no cell of one column is a number."""
        return all(number(cell, self.decimal) is None for cell in self.cells(name))

    def directions(self, name: str) -> int:
        """Return how many directions the grids of one column have, such as 2 for "16 x 16"; 0 for other cells."""
        lengths = {len(grid(cell)) for cell in self.cells(name)}
        return lengths.pop() if len(lengths) == 1 else 0


def read_table(path: Path) -> Table:
    """Read a table whose columns are named.

    Parameters
    ----------
    path : Path
        A text file, or "-" for standard input. Columns may be separated by commas, semicolons, tabs, bars or white space; Markdown, LaTeX,
        HTML and JSON are read too, and lists or pairs such as "h = [0.1, 0.05]". The names stand in the first line or in the comment
        above it. A row of units, ruled lines, comments and the index column of pandas are left out.

    Raises
    ------
    ResultsError
        If the file cannot be read.
    UsageError
        If it is not text, holds no table or several ones, or a line has another number of cells than the others.
    """
    if path == STANDARD_INPUT:
        return parse_table(_decoded(sys.stdin.buffer.read(), "standard input"), "standard input")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ResultsError(f"cannot read '{path}' ({error.strerror}): choose another file") from error
    return parse_table(_decoded(content, f"'{path}'"), f"'{path}'")


def _decoded(content: bytes, place: str) -> str:
    wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    for encoding in ("utf-16",) if wide else ("utf-8-sig", "cp1252"):
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if not re.search(r"[\x00-\x08\x0e-\x1f]", text):
            return re.sub(r"\r\n|\r", "\n", text)
    raise UsageError(f"{place} is not text: give a table with a column h and a column of errors")


def parse_table(text: str, place: str) -> Table:
    """Read a table from text.

    Parameters
    ----------
    text : str
        Its lines end with line feeds.
    place : str
        Name in messages.

    Raises
    ------
    UsageError
        As in `read_table`.
    """
    if max(map(len, re.split(r"[\s<>|,;&]+", text))) > LONGEST_WORD:
        raise UsageError(f"{place} has a word of more than {LONGEST_WORD} characters: give the table alone")
    found = rows(Text(place, text))
    if not found.rows:
        raise UsageError(f"{place} is empty: give a table with a column h and a column of errors")
    decimal = decimal_sign((cell for _, cells in found.rows for cell in cells), place)

    def is_number(cell: str) -> bool:
        return number(cell, decimal) is not None

    across = upright(found.rows, is_number)
    names, body = header(across, found.comments, is_number)
    if not body:
        raise UsageError(f"{place} has no level below the line of column names: add one line for each level")
    body[0] = body[0][0], _padded(body[0][1], names)
    width = len(body[0][1])
    hint = "; if commas are decimal signs, separate the columns with semicolons" if "," in text else ""
    for line, cells in body:
        if len(cells) != width:
            raise UsageError(f"{place}, line {line} has {_count(len(cells), 'cell')} where line {body[0][0]} has {width}{hint}")
        if cells == names:
            raise UsageError(f"{place} holds two tables, the second at line {line}: give one of them")
    if not names:
        return Table(place, tuple(str(column + 1) for column in range(width)), tuple(body), decimal, named=False)
    if len(names) != width:
        named = f"{_count(len(names), 'column')} {'are' if len(names) != 1 else 'is'} named"
        raise UsageError(
            f"{place}, line {body[0][0]} has {_count(width, 'cell')} where {named}: the first line must name every column{hint}"
        )
    if molten := melted(names, body, is_number):
        names, body = molten
    used = [column for column, name in enumerate(names) if name or any(not is_missing(cells[column]) for _, cells in body)]
    names = tuple(names[column] or INDEX for column in used)
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise UsageError(f"{place} names two columns {twice!r}: give each column its own name")
    return Table(place, names, tuple((line, tuple(cells[column] for column in used)) for line, cells in body), decimal)


def _padded(cells: tuple[str, ...], names: tuple[str, ...]) -> tuple[str, ...]:
    """Cells of the first level with empty ones for rates that it leaves out at its end."""
    left_out = names[len(cells) :]
    return (*cells, *[""] * len(left_out)) if all(role(name) is Role.RATE for name in left_out) else cells


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"
