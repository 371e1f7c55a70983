"""The command `new`: a start for a solver, a study or a program of one's own."""

from importlib.resources import files
from pathlib import Path

import click

from mpmverify.errors import UsageError

STARTS = {
    "solver": (("test_own_mpm.py",), "mpmverify run generalised-vortex --with test_own_mpm.py:OwnMPM"),
    "study": (("my_study.py",), "mpmverify run my_study.py"),
    "bench": (("bench.toml", "mpm.c"), "cc -O2 -o mpm mpm.c -lm && mpmverify run generalised-vortex --with bench.toml"),
}
"""Files of each start, and the commands that judge it."""


@click.command()
@click.argument("what", metavar="|".join(STARTS), type=click.Choice(list(STARTS)))
@click.option("-o", "--out", "folder", type=click.Path(path_type=Path), default=Path(), help="Folder  [default: this one]")
def new(what: str, folder: Path) -> None:
    """Write a start that passes as it is: a solver in Python, a study, or a program in C with its bench.toml."""
    names, commands = STARTS[what]
    if taken := [name for name in names if (folder / name).exists()]:
        raise UsageError(f"'{folder / taken[0]}' exists: choose another folder by -o")
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).write_text(files("mpmverify.adapters").joinpath("templates", name).read_text("utf-8"), encoding="utf-8")
    click.echo(f"Wrote {', '.join(names)}. Next{'' if folder == Path() else f', in {folder}'}: {commands}")
