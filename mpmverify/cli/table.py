"""The command that judges a table of errors from any code, with no solver near."""

import sys
from pathlib import Path

import click

from mpmverify.errors import UsageError


@click.command(
    epilog="Exit status: 0 pass, 1 an order failed, 2 usage, 3 an error is not finite, 4 inconclusive under --strict."
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--h", "size", metavar="COLUMN", help="Column of the sizes  [default: the first one]")
@click.option(
    "--error", "errors", multiple=True, metavar="COLUMN", help="Column of errors; may be repeated  [default: all others]"
)
@click.option("--low", type=float, metavar="ORDER", help="Lower edge of the accepted band of orders.")
@click.option("--high", type=float, metavar="ORDER", help="Upper edge of the accepted band of orders.")
@click.option("--strict", is_flag=True, help="Exit with 4 when a verdict is inconclusive.")
def judge(file: Path, size: str | None, errors: tuple[str, ...], low: float | None, high: float | None, strict: bool) -> None:
    """Judge the order of errors in a CSV FILE from any code.

    The first line names the columns; every other line is a level, in any order. Errors are relative to the size of the exact
    solution. Without --low and --high nothing passes: the order is told, and an error that does not converge fails.
    """
    from mpmverify.convergence import FLAT, PLAUSIBLE, read_table, verdict
    from mpmverify.display import show_judgements
    from mpmverify.gate import exit_status

    table = read_table(file)
    size = size or table.names[0]
    errors = errors or tuple(name for name in table.names if name != size)
    if not errors:
        raise UsageError(f"'{file}' has no column of errors beside {size!r}")
    band = None if low is high is None else (FLAT if low is None else low, PLAUSIBLE if high is None else high)
    h = table.numbers(size)
    judgements = {name: verdict(h, table.numbers(name), band=band) for name in dict.fromkeys(errors)}
    show_judgements(judgements)
    sys.exit(exit_status([found for found, _ in judgements.values()], strict=strict))
