"""Options of the commands that read a table, and tables as text, Markdown, LaTeX, CSV and JSON."""

import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from mpmverify.convergence.columns import Columns

Command = TypeVar("Command", bound=Callable[..., Any])
FORMATS = ("table", "markdown", "latex", "csv", "json")
COLOURS = {"PASS": "green", "INCONCLUSIVE": "yellow", "FAIL": "red", "ERROR": "magenta"}
NOTHING = "-"


@dataclass(frozen=True)
class Shown:
    """A table that is shown.

    Parameters
    ----------
    names : tuple of str
    rows : tuple of tuple of str or float
        Cells; a NaN is shown as "-".
    title : str
    """

    names: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]
    title: str = ""


DIMENSION = click.IntRange(1, 3)
OPTIONS = (
    click.argument("file", type=click.Path(path_type=Path, allow_dash=True)),
    click.option(
        "--h", "sizes", multiple=True, metavar="COLUMN", help="Column of sizes; may be repeated  [default: by its name]"
    ),
    click.option("--cells", type=DIMENSION, metavar="DIM", help="The sizes are numbers of cells in DIM dimensions."),
    click.option("--dofs", type=DIMENSION, metavar="DIM", help="The sizes are numbers of unknowns in DIM dimensions."),
    click.option("--levels", type=float, metavar="RATIO", help="The sizes are levels, each RATIO times finer than the last."),
    click.option(
        "--format", "form", type=click.Choice(FORMATS), default="table", show_default=True, help="Format of the output."
    ),
)


def table_options(command: Command) -> Command:
    """Add the file, the options that choose its columns, and --format."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


def chosen(file: Path, sizes: Sequence[str], judged: Sequence[str], what: str, **counts: float | None) -> "Columns":
    """Read a table and choose its columns."""
    from mpmverify.convergence.column_names import Role
    from mpmverify.convergence.columns import choose
    from mpmverify.convergence.table import read_table
    from mpmverify.errors import UsageError

    ratio = counts["levels"]
    if ratio is not None and not (math.isfinite(ratio) and ratio > 1):
        raise UsageError(f"--levels must be the ratio of the sizes of neighbouring levels, above 1, not {ratio:g}")
    roles = {"cells": Role.CELLS, "dofs": Role.DOFS, "levels": Role.LEVEL}
    conversion = {roles[name]: float(number) for name, number in counts.items() if number is not None}
    return choose(read_table(file), sizes=sizes, judged=judged, conversion=conversion, what=what)


def taken(columns: "Columns", what: str) -> str:
    """Sentence that tells which column was taken for what."""
    sizes = [
        f"{size.column!r}" if size.label == size.column else f"{size.label} from {size.column!r}"
        for size in columns.sizes.values()
    ]
    told = [f"Sizes: {', '.join(sizes)}.", f"{what.capitalize()}s: {_names(columns.judged)}."]
    if columns.by:
        told.append(f"One series for each {_names(columns.by)}.")
    if columns.neither:
        told.append(f"Left out: {_names(columns.neither)}.")
    if columns.table.commas:
        told.append(f"A comma {columns.table.commas}.")
    return " ".join(told)


def _names(names: Sequence[str]) -> str:
    return ", ".join(repr(name) for name in names)


def show(form: str, tables: Sequence[Shown], lines: Sequence[str], data: Mapping[str, Any]) -> None:
    """Print tables and lines in a format of `FORMATS`; JSON holds the data instead."""
    if form == "json":
        click.echo(json.dumps(_finite(data), indent=2, ensure_ascii=False))
        return
    for table in tables:
        title = [table.title] if table.title else []
        click.echo("\n".join([*(LINE[form](line) for line in title), TABLE[form](table), ""]))
    for line in lines:
        word, _, rest = line.partition(" ")
        bold = click.style(word, fg=COLOURS[word], bold=True) if form == "table" and word in COLOURS else word
        click.echo(LINE[form](f"{bold} {rest}"))


def _finite(data: Any) -> Any:
    """Data without numbers that JSON cannot hold."""
    if isinstance(data, Mapping):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_finite(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


def _cell(cell: str | float) -> str:
    if isinstance(cell, str):
        return cell
    return NOTHING if math.isnan(cell) else f"{cell:.6g}"


def _text(table: Shown) -> str:
    rows = [table.names, *([_cell(cell) for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows)


def _markdown(table: Shown) -> str:
    rows = [table.names, ["---:"] * len(table.names), *([_cell(cell) for cell in row] for row in table.rows)]
    return "\n".join("| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in rows)


def _latex(table: Shown) -> str:
    head, *body = (
        " & ".join(_escaped(cell) for cell in row) + r" \\"
        for row in (table.names, *([_cell(c) for c in row] for row in table.rows))
    )
    columns = "r" * len(table.names)
    return "\n".join(
        [rf"\begin{{tabular}}{{{columns}}}", r"\toprule", head, r"\midrule", *body, r"\bottomrule", r"\end{tabular}"]
    )


def _escaped(cell: str) -> str:
    return "".join(
        {"^": r"\^{}", "~": r"\~{}", "\\": r"\backslash "}.get(sign, rf"\{sign}" if sign in "&%$#_{}" else sign)
        for sign in cell
    )


def _csv(table: Shown) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.names)
    writer.writerows(["" if cell != cell else cell for cell in row] for row in table.rows)
    return text.getvalue().rstrip("\n")


TABLE: dict[str, Callable[[Shown], str]] = {"table": _text, "markdown": _markdown, "latex": _latex, "csv": _csv}
LINE: dict[str, Callable[[str], str]] = {
    "table": str,
    "markdown": lambda line: f"- {line}",
    "latex": lambda line: f"% {line}",
    "csv": lambda line: f"# {line}",
}
