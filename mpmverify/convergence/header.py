"""The names of the columns of a table: where they stand, and what stands beside them."""

import re
from collections.abc import Callable, Sequence

from mpmverify.convergence.column_names import SIZES, Role, role
from mpmverify.convergence.markup import Row
from mpmverify.convergence.numerals import is_missing, plain

INDEX = "(no name)"
"""Name of a column without one, such as the index that pandas writes."""
IsNumber = Callable[[str], bool]
Names = tuple[str, ...]
_UNIT = re.compile(
    r"\[.*\]|\(.*\)|-*|1|%|[µumkMG]?(?:m|s|g|N|Pa|J|W|K|Hz)(?:\W*\d)?(?:[/*. ]+[µumkMG]?(?:m|s|g|N|Pa|J|W|K|Hz)(?:\W*\d)?)*|1/\w+"
)
_TWO_NAMES = re.compile(r"([^\W\d]\w*)\s*(?:\\+|/|\||[,;:]|\s[x*]\s|\bvs\b\.?)\s*([^\W\d][\w ]*)")


def header(rows: Sequence[Row], comments: Sequence[tuple[int, str]], is_number: IsNumber) -> tuple[Names, list[Row]]:
    """Divide rows into the names of the columns and the levels.

    Parameters
    ----------
    rows : sequence of Row
    comments : sequence of (int, str)
        Comments above the first row: one may name the columns.
    is_number : callable
        Whether a cell is a number.

    Returns
    -------
    (tuple of str, list of Row)
        The names, empty where nothing names the columns, "" for an index; and the levels. There may be more or fewer names than cells.
    """
    start = next((at for at in range(len(rows)) if _is_level(rows, at, is_number)), len(rows))
    named, body = [cells for _, cells in rows[:start]], list(rows[start:])
    while body and not any(map(is_number, body[-1][1])):
        body.pop()  # expected orders, say
    if not body:
        return (named[-1] if named else ()), body
    width = max(len(cells) for _, cells in body)
    while len(named) > 1 and all(_UNIT.fullmatch(cell) for cell in named[-1]):
        named.pop()
    while len(named) > 1 and width > 1 and len(set(named[0]) - {""}) <= 1:
        named.pop(0)  # a title
    if named:
        return _distinct(_completed(_joined(named), body, is_number), body), body
    for _, comment in list(comments)[:-3:-1]:
        for pattern in (r"[,;\t|]", r"\s{2,}", r"\s+"):
            words = [plain(word) for word in re.split(pattern, comment.strip())]
            names = _completed(tuple(words), body, is_number)
            if len(names) == width > 1 and not any(map(is_number, names)):
                return _distinct(names, body), body
    return (), body


def _is_level(rows: Sequence[Row], at: int, is_number: IsNumber) -> bool:
    """Whether a row holds numbers, and neither units nor numbers that name its columns."""
    cells = rows[at][1]
    if not any(map(is_number, cells)):
        return False
    below = rows[at + 1][1] if at + 1 < len(rows) else ()
    titles = all(len(set(above) - {""}) <= 1 for _, above in rows[:at])
    numbered = len(cells) > 2 and not is_number(cells[0]) and all(map(is_number, cells[1:]))
    if titles and numbered and below and is_number(below[0]):
        return False  # columns that are named by numbers
    units = all(_UNIT.fullmatch(cell) for cell in cells) and len(below) == len(cells)
    unlike = any(
        is_number(low) and not is_number(cell) and not is_missing(cell) for cell, low in zip(cells, below, strict=False)
    )
    return not (at > 0 and units and unlike)


def _joined(rows: Sequence[Names]) -> Names:
    """Join the rows of a header, of which the upper ones name groups of columns."""
    if len({len(row) for row in rows}) > 1:
        return rows[-1]
    groups = []
    for row in rows[:-1]:
        filled = list(row)
        for column, below in enumerate(rows[-1]):
            if column and not filled[column] and below:
                filled[column] = filled[column - 1]
        groups.append(filled)
    columns = zip(*groups, rows[-1], strict=True)
    return tuple(" ".join(dict.fromkeys(part for part in column if part)) for column in columns)


def _completed(names: Names, body: Sequence[Row], is_number: IsNumber) -> Names:
    """Name the index of pandas, and rates, whose columns begin with no number, where the header leaves them out."""
    first = body[0][1]
    while len(names) > len(first) and not names[-1]:
        names = names[:-1]
    if len(names) == len(first) - 1:
        counted = [cells[0] for _, cells in body]
        indexed = ("", *names)
        begins = [name for name, cell in zip(indexed, first, strict=True) if not is_number(cell) or cell.lower() == "nan"]
        if counted == [str(k) for k in range(len(body))] and all(role(name) is Role.RATE for name in begins):
            return indexed
        if all(is_missing(cells[-1]) for _, cells in body):
            return (*names, "")
    rates = [k for k, cell in enumerate(first) if is_missing(cell)]
    if 0 < len(rates) == len(first) - len(names):
        left = iter(names)
        return tuple("rate" if column in rates else next(left) for column in range(len(first)))
    return names


def _distinct(names: Names, body: Sequence[Row]) -> Names:
    """Tell columns of rates of the same name apart by the column before them.

    A name that spans two columns, of which the second begins with no number, is that of an error and its rate.
    """
    known: list[str] = []
    owner = ""
    for name, cell in zip(names, (*body[0][1], *[""] * len(names)), strict=False):
        if role(name) is Role.RATE and names.count(name) > 1:
            known.append(f"{owner} {name}")
        elif name == owner and is_missing(cell):
            known.append(f"{name} rate")
        else:
            known.append(name)
            owner = owner if role(name) is Role.RATE else name
        while known[-1] in known[:-1] and role(known[-1]) is Role.RATE:
            known[-1] += "'"
    return tuple(known)


def upright(rows: list[Row], is_number: IsNumber) -> list[Row]:
    """Rows for levels, where each row of the table has the name and the numbers of one quantity."""
    width = len(rows[0][1])
    across = len(rows) > 1 and width > 2 and all(len(cells) == width for _, cells in rows)
    for _, cells in rows if across else ():
        numbers = sum(map(is_number, cells[1:]))
        across = across and numbers > 0 and not is_number(cells[0]) and not is_missing(cells[0])
        across = across and all(is_number(cell) or is_missing(cell) for cell in cells[1:])
    if not across:
        return rows
    return [(rows[0][0], cells) for cells in zip(*(cells for _, cells in rows), strict=True)]


def melted(names: Names, body: Sequence[Row], is_number: IsNumber) -> tuple[Names, list[Row]] | None:
    """One row for each error of a design whose columns are headed by the values of a second size; None for other tables.

    The header is "h / dt, 0.1, 0.05" or "h, dt=0.1, dt=0.05".
    """
    if len(names) < 3:
        return None
    first, values = names[0], list(names[1:])
    pairs = [(name, value.strip()) for name, _, value in (name.partition("=") for name in values)]
    if (two := _TWO_NAMES.fullmatch(first)) and all(map(is_number, values)):
        first, second = two[1], two[2].strip()
    elif len({name for name, _ in pairs}) == 1 and all(is_number(value) for _, value in pairs):
        second, values = pairs[0][0].strip(), [value for _, value in pairs]
        if role(second) not in SIZES:
            return None
    else:
        return None
    rows: list[Row] = [
        (line, (cells[0], value, error)) for line, cells in body for value, error in zip(values, cells[1:], strict=True)
    ]
    return (first, second, "error"), rows
