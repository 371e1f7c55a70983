"""The command `judge`, for a table of errors from any code."""

import sys
from pathlib import Path

import click

from mpmverify.errors import UsageError

SIZES = ("dt", "ppc")
"""Columns that are not errors unless --error names them: they describe the level."""


@click.command(
    epilog="Exit status: 0 pass, 1 an order failed, 2 usage, 3 an error is not finite, 4 inconclusive under --strict."
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--h", "size", metavar="COLUMN", help="Column of the sizes  [default: h, else the first one]")
@click.option(
    "--error",
    "errors",
    multiple=True,
    metavar="COLUMN",
    help="Column of errors; may be repeated  [default: all others but dt and ppc]",
)
@click.option("--low", type=float, metavar="ORDER", help="Lower edge of the accepted band of orders.")
@click.option("--high", type=float, metavar="ORDER", help="Upper edge of the accepted band of orders.")
@click.option("--strict", is_flag=True, help="Exit with 4 when a verdict is inconclusive.")
def judge(file: Path, size: str | None, errors: tuple[str, ...], low: float | None, high: float | None, strict: bool) -> None:
    """Judge the order of errors in a CSV FILE from any code.

    The first line names the columns; every other line is a level, in any order. The sizes are those of the column h, or else of the
    first one; every other column but dt and ppc is one of errors, relative to the size of the exact solution. Without --low and
    --high nothing passes: the order is told, and an error that does not converge fails.
    """
    from mpmverify.cli.console import show_judgements
    from mpmverify.convergence import FLAT, PLAUSIBLE, read_table, verdict
    from mpmverify.convergence.verdict import exit_status

    table = read_table(file)
    size = size or ("h" if "h" in table.names else table.names[0])
    errors = errors or tuple(name for name in table.names if name not in (size, *SIZES))
    if not errors:
        raise UsageError(f"'{file}' has no column of errors beside {size!r}")
    if size in errors:
        raise UsageError(f"the column {size!r} holds the sizes, and no errors: choose others with --h or --error")
    band = None if low is high is None else (FLAT if low is None else low, PLAUSIBLE if high is None else high)
    h = table.numbers(size)
    judgements = {name: verdict(h, table.numbers(name), band=band) for name in dict.fromkeys(errors)}
    show_judgements(judgements)
    click.echo(f"Sizes: column {size!r}.")
    sys.exit(exit_status([found for found, _ in judgements.values()], strict=strict))
