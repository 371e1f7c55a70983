"""The commands under `problem`: problems as files, for a code that runs elsewhere."""

import shlex
from pathlib import Path

import click

from mpmverify.cli.options import EPILOG


@click.group(epilog=EPILOG)
def problem() -> None:
    """Write problems as files."""


@problem.command()
@click.argument("study", metavar="STUDY")
@click.option("--case", "cases", multiple=True, metavar="NAME", help="Export this case alone; may be repeated.")
@click.option(
    "--levels", type=click.IntRange(min=1), help="Number of levels, coarsest first  [default: those of the quick tier]"
)
@click.option(
    "--points", type=click.Choice(["particles", "nodes"]), default="particles", show_default=True, help="Sample points."
)
@click.option(
    "-o", "--out", "folder", type=click.Path(path_type=Path), default=Path("problems"), show_default=True, help="New folder."
)
def export(study: str, cases: tuple[str, ...], levels: int | None, points: str, folder: Path) -> None:
    """Write what a code in any language needs to run the cases of STUDY, without their answers.

    Run your code in each folder, edit bench.toml, and judge the results by `mpmverify run --with`.
    """
    from mpmverify.adapters.files import BENCH
    from mpmverify.adapters.files import export as write
    from mpmverify.cli.console import say_left_out
    from mpmverify.cli.solving import declared

    refused = write(declared(study), study, folder, cases=cases, levels=levels, points=points)
    say_left_out(list(refused.items()))
    click.echo(f"Wrote '{folder}'. Next: mpmverify run --with {shlex.quote(str(folder / BENCH))}")
