"""The command `judge`, for a table of errors from any code."""

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mpmverify.cli.table import NOTHING, Command, Shown, chosen, show, table_options, taken

if TYPE_CHECKING:
    from mpmverify.convergence.columns import Columns
    from mpmverify.convergence.judged_table import JudgedColumn

ROUND_OFF_HINT = (
    "Errors of at most {limit:g} count as round-off, as they would if they were relative to the solution: if they are absolute, "
    "give the size of the solution by --scale."
)


class ByColumn(click.ParamType[tuple[str, float]]):
    """A number for all columns, or COLUMN=NUMBER."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, float]:
        if isinstance(value, tuple):
            return value
        column, _, number = value.rpartition("=")
        try:
            return column.strip(), float(number)
        except ValueError:
            self.fail(f"{value!r} is neither a number nor COLUMN=NUMBER", param, ctx)


def by_column(name: str, metavar: str, text: str) -> Callable[[Command], Command]:
    return click.option(name, type=ByColumn(), multiple=True, metavar=f"[COLUMN=]{metavar}", help=text)


@click.command(
    epilog="Exit status: 0 pass, 1 an order failed, 2 usage, 3 an error is not finite, 4 inconclusive under --strict."
)
@table_options
@click.option(
    "--error",
    "errors",
    multiple=True,
    metavar="COLUMN",
    help="Column of errors; may be repeated  [default: all that are nothing else]",
)
@by_column("--low", "ORDER", "Lower edge of the accepted band of orders.")
@by_column("--high", "ORDER", "Upper edge of the accepted band of orders.")
@by_column("--scale", "SIZE", "Size of the solution, where errors are absolute.")
@click.option("--round-off", type=float, metavar="ERROR", help="Relative error that round-off may cause  [default: 1e-12]")
@click.option("--uncertainty", type=float, default=0.0, metavar="ERROR", help="Uncertainty of a numerical reference.")
@click.option("--exact", type=float, metavar="TOL", help="Demand that no relative error exceeds TOL, instead of an order.")
@click.option("--strict", is_flag=True, help="Exit with 4 when a verdict is inconclusive.")
def judge(
    file: Path,
    sizes: tuple[str, ...],
    cells: int | None,
    dofs: int | None,
    levels: float | None,
    form: str,
    errors: tuple[str, ...],
    low: tuple[tuple[str, float], ...],
    high: tuple[tuple[str, float], ...],
    scale: tuple[tuple[str, float], ...],
    round_off: float | None,
    uncertainty: float,
    exact: float | None,
    strict: bool,
) -> None:
    """Judge the order of errors in a table FILE from any code ("-" reads standard input).

    The table may be CSV, separated by tabs or white space, Markdown, LaTeX, HTML or JSON. Sizes (h, dx, dt, ppc) and columns that are
    no errors (time, rate, iterations) are known by their names; the output says what was taken for what. Where h and dt vary
    independently, their orders are separated. Without --low and --high nothing passes: the order is told, and an error that does not
    converge fails.
    """
    from mpmverify.convergence.judged_table import Demands, judge_table
    from mpmverify.convergence.series import ROUND_OFF
    from mpmverify.convergence.verdict import exit_status

    columns = chosen(file, sizes, errors, "error", cells=cells, dofs=dofs, levels=levels)
    limit = ROUND_OFF if round_off is None else round_off
    found = judge_table(columns, Demands(dict(low), dict(high), dict(scale), limit, uncertainty, exact))
    notes = [taken(columns, "error")]
    if not scale and any(column.has_round_off for column in found):
        notes.append(ROUND_OFF_HINT.format(limit=limit))
    lines = [*notes, *(f"{column.verdict} {column.name}: {column.reason}" for column in found)]
    show(form, list(_tables(columns, found, form)), lines, _data(columns, found))
    sys.exit(exit_status([column.verdict for column in found], strict=strict))


def _tables(columns: "Columns", found: Iterable["JudgedColumn"], form: str) -> Iterator[Shown]:
    """One table of levels for each group of rows, and one of sources for each column of a design."""
    for group in columns.groups:
        mine = [column for column in found if column.group is group]
        sizes = mine[0].sizes
        names = [size.symbol for size in sizes]
        for column in mine:
            orders = [f"{column.column} order" if form == "csv" else "order"] if column.series else []
            names += [column.column, *orders]
        rows = sorted(group.rows.tolist(), key=lambda row: [-size.values[row] for size in sizes])
        shown: list[list[str | float]] = [[float(size.values[row]) for row in rows] for size in sizes]
        shown += [cells for column in mine for cells in _cells(columns, column, rows)]
        body = zip(*shown, strict=True)
        yield Shown(tuple(names), tuple(body), group.label)
        for column in mine:
            if column.separation and column.separation.sources:
                sources = [(s.size, s.exponent, s.low, s.high, s.share) for s in column.separation.sources]
                yield Shown(("size", "exponent", "low", "high", "largest share"), tuple(sources), f"Sources of {column.name}")


def _cells(columns: "Columns", column: "JudgedColumn", rows: Sequence[int]) -> Iterator[list[str | float]]:
    """Errors of rows, and observed orders where there are any."""
    errors, given = columns.table.numbers(column.column).tolist(), columns.table.given(column.column)
    yield [errors[row] if math.isfinite(errors[row]) else str(errors[row]) if given[row] else NOTHING for row in rows]
    if column.series:
        orders = (column.orders.get(row, math.nan) for row in rows)
        yield [NOTHING if math.isnan(order) else f"{round(order, 3) + 0.0:.3f}" for order in orders]


def _data(columns: "Columns", found: Iterable["JudgedColumn"]) -> dict[str, Any]:
    """Content of the output as JSON."""
    return {
        "sizes": {size.symbol: size.label for size in columns.sizes.values()},
        "left out": columns.neither,
        "columns": [_column(columns, column) for column in found],
    }


def _column(columns: "Columns", column: "JudgedColumn") -> dict[str, Any]:
    errors = columns.table.numbers(column.column)
    data: dict[str, Any] = {"name": column.name, "verdict": column.verdict, "reason": column.reason}
    if fit := column.series and column.series.fit:
        data |= {"order": fit.order, "low": fit.low, "high": fit.high, "constant": fit.constant}
    if column.series:
        data |= {"class": column.series.classification, "dropped": column.series.dropped}
    if column.separation:
        data["sources"] = [vars(source) for source in column.separation.sources]
    data["levels"] = [
        {size.symbol: float(size.values[row]) for size in column.sizes}
        | {"error": float(errors[row]), "order": column.orders.get(int(row))}
        for row in column.group.rows
    ]
    return data
