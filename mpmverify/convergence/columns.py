"""Which columns of a table are sizes, errors or values, and neither; counts are turned into sizes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.axis import Axis, axis
from mpmverify.convergence.column_names import COUNTS, SIZES, Role, role
from mpmverify.convergence.header import INDEX
from mpmverify.convergence.levels import SAME, Array
from mpmverify.convergence.table import Table
from mpmverify.errors import UsageError

Conversion = Mapping[Role, float]
"""How counts become sizes: the dimension for cells and degrees of freedom, and the ratio of neighbouring sizes for levels."""
NO_CONVERSION: Conversion = {}
OPTION = {Role.CELLS: "--cells DIM", Role.DOFS: "--dofs DIM", Role.LEVEL: "--levels RATIO"}
"""Option that turns a count into a size."""
SPACE, TIME, PARTICLES = "h", "dt", "1/ppc"
"""Sizes as `axis` names them."""
DEGREES = frozenset("pkq")
"""Names of degrees in whole numbers; p may also be a pressure, and k a time step."""
AXES = {Role.TIME_STEP: TIME, Role.STEPS: TIME, Role.PARTICLES: PARTICLES}
"""Size that a column gives; all others give h."""


@dataclass(frozen=True)
class Size:
    """A column as a size.

    Parameters
    ----------
    column : str
    label : str
        The size in terms of the column: "dx", "1/ppc", "cells^(-1/2)".
    symbol : str
        Its name: that of the column, or h, dt or 1/ppc where it is converted.
    values : Array
        (n,).
    sure : bool
        Whether the column is a size by its name.
    """

    column: str
    label: str
    symbol: str
    values: Array
    sure: bool = True


@dataclass(frozen=True)
class Group:
    """Rows that make one series or one design.

    Parameters
    ----------
    label : str
        What these rows have in common, such as "method=FLIP"; "" where the table is one group.
    rows : array of int
        Their indices.
    axis : Axis
        What varies over them.
    """

    label: str
    rows: np.ndarray
    axis: Axis

    def named(self, column: str) -> str:
        """Name of one column of these rows."""
        return f"{column} ({self.label})" if self.label else column


@dataclass(frozen=True)
class Columns:
    """What was taken for what.

    Parameters
    ----------
    table : Table
    sizes : mapping of str to Size
        By the names of `axis`: h, dt and 1/ppc.
    judged : tuple of str
        Columns of errors, or of values.
    by : tuple of str
        Columns that tell groups of rows apart.
    neither : tuple of str
    groups : tuple of Group
    """

    table: Table
    sizes: Mapping[str, Size]
    judged: tuple[str, ...]
    by: tuple[str, ...]
    neither: tuple[str, ...]
    groups: tuple[Group, ...]

    def size(self, group: Group) -> Size:
        """Size in which the orders of a ladder are measured."""
        return self.sizes.get(group.axis.size) or next(iter(self.sizes.values()))

    def given(self, name: str, group: Group) -> tuple[np.ndarray, tuple[str, ...]]:
        """Rows of a group where a column holds anything, and the sizes and lines of the others."""
        given, size = self.table.given(name)[group.rows], self.size(group)
        others = group.rows[~given]
        return group.rows[given], tuple(
            f"{size.symbol}={size.values[row]:g} (line {self.table.rows[row][0]})" for row in others
        )


def choose(
    table: Table,
    *,
    sizes: Sequence[str] = (),
    judged: Sequence[str] = (),
    conversion: Conversion = NO_CONVERSION,
    what: str = "error",
) -> Columns:
    """Choose the columns of sizes and of errors by their names.

    Parameters
    ----------
    table : Table
    sizes, judged : sequence of str
        Columns that the user names; by default those whose names are those of sizes, and all that are known as nothing else.
    conversion : mapping of Role to float
        By CELLS, DOFS and LEVEL.
    what : str
        "error" or "value", for messages.

    Raises
    ------
    UsageError
        If there is no such column, no column is a size, or none is left to be judged.
    """
    for name in (*sizes, *judged):
        table.cells(name)
        if name in sizes and name in judged:
            raise UsageError(f"the column {name!r} holds the sizes, and no {what}s: choose others with --h or --{what}")
    if not (table.named or judged):
        raise UsageError(
            f"{table.place} begins with numbers: name the columns in the first line, such as h,{what}, or say which is which, "
            f"such as --h 1 --{what} 2"
        )
    counters = [name for name in table.names if role(name) not in (*SIZES, Role.LEVEL) and _counts_rows(table, name)]
    found = _sizes(table, sizes, [name for name in table.names if name not in (*judged, *counters)], conversion)
    rest = [name for name in table.names if name not in {size.column for size in found.values()}]
    apart = [name for name in rest if name not in judged and _tells_apart(table, name)]
    by = _grouping(table, found, apart)
    told = tuple(dict.fromkeys(judged))
    known = (*apart, *counters, INDEX)
    judged = told or tuple(name for name in rest if name not in known and (role(name) is Role.ERROR or name == "p"))
    if not judged:
        named = " and ".join(repr(size.column) for size in found.values())
        raise UsageError(f"{table.place} has no column of {what}s beside {named}: name one with --{what}")
    neither = tuple(name for name in rest if name not in (*judged, *by))
    groups = tuple(_groups(table, found, by))
    for name in neither:
        if role(name) in SIZES:
            _refuse_hidden(table, name, found, groups)
    for name in () if told else judged:
        _refuse_parameter(table, name, found, groups)
    return Columns(table, found, judged, by, neither, groups)


def _refuse_hidden(table: Table, name: str, sizes: Mapping[str, Size], groups: Sequence[Group]) -> None:
    """Refuse to leave out a size that varies where the others do not: its levels would count as repeated runs."""
    for group in groups:
        met: dict[tuple[float, ...], str] = {}
        for row in group.rows:
            key = tuple(size.values[row] for size in sizes.values())
            if met.setdefault(key, table.cells(name)[row]) != table.cells(name)[row]:
                told = ", ".join(f"{size.symbol}={size.values[row]:g}" for size in sizes.values())
                raise UsageError(
                    f"{table.place} has several {name!r} at {told}: give both by --h, or the rows of one {name!r} only"
                )


def _counts_rows(table: Table, name: str) -> bool:
    """Whether a column is 0, 1, 2 and so on."""
    return table.cells(name) == tuple(str(row) for row in range(len(table.rows)))


def _tells_apart(table: Table, name: str) -> bool:
    """Whether a column may tell series apart: a text, a case, or a degree in small whole numbers."""
    if table.is_text(name) or role(name) is not Role.VARIANT:
        return table.is_text(name)
    values = table.numbers(name)
    return name not in DEGREES or bool(np.all((values == np.round(values)) & (values >= 0) & (values < 32)))


def _refuse_parameter(table: Table, name: str, sizes: Mapping[str, Size], groups: Sequence[Group]) -> None:
    """Refuse numbers that are the same at several sizes and others at the same size: no errors, but a parameter of several series."""
    for group in groups:
        at: dict[str, set[tuple[float, ...]]] = {}
        for row in group.rows:
            at.setdefault(table.cells(name)[row], set()).add(tuple(size.values[row] for size in sizes.values()))
        counts = [len(met) for met in at.values()]
        if len(at) > 1 and min(counts) > 1 and sum(counts) == len(group.rows) > len(set.union(*at.values())):
            raise UsageError(
                f"{table.place} has several series, told apart by {name!r}: give the rows of one {name!r}, or call it 'case'"
            )


def _sizes(table: Table, told: Sequence[str], others: Sequence[str], conversion: Conversion) -> dict[str, Size]:
    """Sizes by their axes: of several columns for one axis a count that an option converts, or else a size, or else the first."""
    kinds = {name: _kind(table, name) for name in told or others}
    if told and len(conversion) == 1:
        kinds |= {
            name: next(iter(conversion)) for name, kind in kinds.items() if kind not in SIZES and not table.directions(name)
        }
    for kind in conversion:
        if kind not in kinds.values():
            raise UsageError(f"{table.place} has no column that is a {kind.value} by its name: say which with --h COLUMN")
    ready = {name: kind in SIZES or kind in conversion or bool(table.directions(name)) for name, kind in kinds.items()}
    counts = [name for name, kind in kinds.items() if kind in COUNTS and not ready[name]]
    found: dict[str, Size] = {}
    best = (*conversion, Role.SPACE, Role.TIME_STEP, *(kind for kind in Role if kind not in conversion))
    for name, kind in sorted(kinds.items(), key=lambda entry: (best.index(entry[1]), entry[0].lower() == "n")):
        if ready[name] or (told and name not in counts):
            found.setdefault(AXES.get(kind, SPACE), _size(table, name, kind, conversion))
    varying = {axis: size for axis, size in found.items() if np.ptp(size.values) > SAME * size.values.max()}
    varied = [name for name in counts if kinds[name] is not Role.LEVEL and len(set(table.cells(name))) > 1]
    if counts and (not varying or (varied and SPACE not in varying)):
        hints = " or ".join(f"{OPTION[kinds[name]]} (for {name!r})" for name in counts)
        raise UsageError(f"{table.place} gives counts and no sizes: turn a count into a size by {hints}, or name a size by --h")
    if not found:
        raise UsageError(
            f"{table.place} has no column of sizes by its name ({', '.join(table.names)}): say which with --h COLUMN"
        )
    return varying or found


def _kind(table: Table, name: str) -> Role:
    return Role.CELLS if table.directions(name) else role(name)


def _size(table: Table, name: str, kind: Role, conversion: Conversion) -> Size:
    values = table.numbers(name)
    for (line, _), cell, value in zip(table.rows, table.cells(name), values, strict=True):
        if not (np.isfinite(value) and (value > 0 or kind is Role.LEVEL)):
            raise UsageError(f"{table.place}, line {line}: every {name} must be positive and finite, not {cell or 'empty'}")
    symbol = AXES.get(kind, SPACE)
    if kind is Role.LEVEL:
        return Size(name, f"{conversion[kind]:g}^-{name}", symbol, conversion[kind] ** -values)
    if kind in COUNTS:
        dimension = table.directions(name) or conversion[kind]
        return Size(name, f"1/{name}" if dimension == 1 else f"{name}^(-1/{dimension:g})", symbol, values ** (-1 / dimension))
    if kind in (Role.DIRECTION, Role.STEPS) or (kind is Role.PARTICLES and not name.startswith("1/")):
        return Size(name, f"1/({name})" if "/" in name else f"1/{name}", symbol, 1 / values)
    whole = np.all((values == np.round(values)) & (values >= 1))
    return Size(name, name, name, values, sure=kind in SIZES and not whole)


def _grouping(table: Table, sizes: Mapping[str, Size], candidates: Sequence[str]) -> tuple[str, ...]:
    """Columns of text or degrees that tell rows of the same sizes apart."""
    rows = list(zip(*(size.values.round(12).tolist() for size in sizes.values()), strict=True))
    if len(set(rows)) == len(rows):
        return ()
    return tuple(name for name in candidates if 1 < len(set(table.cells(name))) < len(rows))


def _groups(table: Table, sizes: Mapping[str, Size], by: Sequence[str]) -> Iterator[Group]:
    keys = list(zip(*(table.cells(name) for name in by), strict=True)) if by else [()] * len(table.rows)
    one = np.ones(len(table.rows))
    for key in dict.fromkeys(keys):
        rows = np.flatnonzero([other == key for other in keys])
        h, dt, parts = (sizes[name].values if name in sizes else one for name in (SPACE, TIME, PARTICLES))
        label = ", ".join(f"{name}={cell}" for name, cell in zip(by, key, strict=True))
        yield Group(label, rows, axis(h[rows], dt[rows], 1 / parts[rows]))
