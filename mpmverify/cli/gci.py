"""The command `gci`, for a table of values from any code."""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mpmverify.cli.table import NOTHING, Shown, chosen, show, table_options, taken

if TYPE_CHECKING:
    from mpmverify.convergence.grid_levels import GridColumn


@click.command(epilog="Exit status: 0 computed, 2 usage, 3 a value is not finite.")
@table_options
@click.option(
    "--value",
    "values",
    multiple=True,
    metavar="COLUMN",
    help="Column of values; may be repeated  [default: all that are nothing else]",
)
@click.option("--formal", type=float, metavar="ORDER", help="Theoretical order of the scheme; two levels alone need it.")
def gci(
    file: Path,
    sizes: tuple[str, ...],
    cells: int | None,
    dofs: int | None,
    levels: float | None,
    form: str,
    values: tuple[str, ...],
    formal: float | None,
) -> None:
    """Grid convergence index of values in a table FILE from any code, without an exact solution ("-" reads standard input).

    For each level: the observed order, the limit by Richardson's extrapolation, the index with the factors of safety 1.25 (three
    levels or more) and 3, and the ratio that is 1 in the asymptotic range. FILE is read as by `mpmverify judge`.
    """
    from mpmverify.convergence.gci import Behaviour
    from mpmverify.convergence.grid_levels import grid_table

    columns = chosen(file, sizes, values, "value", cells=cells, dofs=dofs, levels=levels)
    found = grid_table(columns, formal=formal)
    lines = [taken(columns, "value"), *(_sentence(column, formal) for column in found)]
    show(form, [_table(column) for column in found], lines, {"columns": list(_data(found))})
    sys.exit(3 if any(level.behaviour is Behaviour.NON_FINITE for column in found for level in column.levels) else 0)


def _table(column: "GridColumn") -> Shown:
    names = (column.size.symbol, column.column, "change %", "order", "limit", "GCI 1.25 %", "GCI 3 %", "ratio", "behaviour")
    rows = [
        (
            level.h,
            str(level.value) if level.value != level.value else level.value,
            100 * level.change,
            level.order,
            level.limit,
            100 * level.confirmed,
            100 * level.unconfirmed,
            level.ratio,
            level.behaviour or NOTHING,
        )
        for level in column.levels
    ]
    return Shown(names, tuple(rows), column.group.label)


def _sentence(column: "GridColumn", formal: float | None) -> str:
    finest = column.levels[-1]
    told = [f"{column.name}: {finest.behaviour or 'two levels'}"]
    if finest.order == finest.order:
        told.append(f"order {finest.order:.4g}, limit {finest.limit:.7g}")
    if finest.index == finest.index:
        told.append(
            f"index of the finest level {100 * finest.confirmed:.3g} % (factor 1.25) or {100 * finest.unconfirmed:.3g} % (factor 3)"
        )
    if column.band is not None:
        around = f"{finest.value:.7g} ± {column.band.uncertainty:.3g} (factor {column.band.factor:g})"
        told.append(f"with the formal order {formal:g} the limit lies within {around}")
    if column.missing:
        told.append(f"no value is given at {', '.join(column.missing)}")
    return "; ".join(told)


def _data(found: Iterable["GridColumn"]) -> Iterator[dict[str, Any]]:
    for column in found:
        levels = [vars(level) | {"GCI 1.25": level.confirmed, "GCI 3": level.unconfirmed} for level in column.levels]
        band = None if column.band is None else vars(column.band)
        yield {"name": column.name, "size": column.size.label, "levels": levels, "band": band}
