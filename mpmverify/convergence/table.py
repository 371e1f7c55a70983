"""Error series in a CSV file, with one level in each line."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mpmverify.convergence.levels import Array
from mpmverify.errors import ResultsError, UsageError

DELIMITERS = ",;\t"


@dataclass(frozen=True)
class Table:
    """Content of a CSV file with named columns.

    Parameters
    ----------
    path : Path
    names : tuple of str
        Names of the columns.
    rows : tuple of (int, tuple of str)
        Line number in the file and the cells of each row.
    """

    path: Path
    names: tuple[str, ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]

    def numbers(self, name: str) -> Array:
        """Return one column as numbers (n,).

        Parameters
        ----------
        name : str
            Name of the column.

        Raises
        ------
        UsageError
            If there is no such column, or a cell in it is not a number; "nan" and "inf" are numbers.
        """
        if name not in self.names:
            raise UsageError(f"'{self.path}' has no column {name!r}: choose from {', '.join(self.names)}")
        column = self.names.index(name)
        for line, cells in self.rows:
            if not _is_number(cells[column]):
                raise UsageError(
                    f"'{self.path}', line {line}: {cells[column]!r} in column {name!r} is not a number: remove the column, or correct it"
                )
        return np.array([float(cells[column]) for _, cells in self.rows])


def read_table(path: Path) -> Table:
    """Read a CSV file whose first line names the columns.

    Columns are separated by commas, semicolons or tabs. Empty lines are skipped.

    Parameters
    ----------
    path : Path
        A text file in UTF-8.

    Raises
    ------
    ResultsError
        If the file cannot be read or is not text.
    UsageError
        If the file has no line of names or no level, a name is missing or occurs twice, or a line has another number of cells.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ResultsError(f"cannot read '{path}' ({error.strerror}): choose another file") from error
    except UnicodeDecodeError as error:
        raise ResultsError(f"'{path}' is not text: give a CSV file with a column h and a column of errors") from error
    first = text.lstrip().partition("\n")[0]
    delimiter = max(DELIMITERS, key=first.count)
    try:
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
        lines = [(reader.line_num, tuple(cell.strip() for cell in cells)) for cells in reader if any(map(str.strip, cells))]
    except csv.Error as error:
        raise UsageError(f"'{path}', line {reader.line_num}: {error}") from error
    names = lines[0][1] if lines else ()
    _check_names(path, names)
    for line, cells in lines[1:]:
        if len(cells) != len(names):
            found = f"{len(cells)} cell{'s' * (len(cells) != 1)}"
            named = f"{len(names)} column{'s are' if len(names) != 1 else ' is'} named"
            raise UsageError(f"'{path}', line {line} has {found} where {named}: the first line must name every column")
    if len(lines) < 2:
        raise UsageError(f"'{path}' has no level below the line of column names: add one line for each level")
    return Table(path, names, tuple(lines[1:]))


def _check_names(path: Path, names: Sequence[str]) -> None:
    if not names:
        raise UsageError(f"'{path}' is empty: give a CSV file with a column h and a column of errors")
    if any(_is_number(name) for name in names):
        raise UsageError(f"'{path}' begins with numbers: name the columns in the first line, such as h,error")
    if "" in names or len(set(names)) < len(names):
        raise UsageError(f"'{path}' must name every column in the first line, and each name once")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # Python reads 1_000 as a number, but spreadsheets do not
