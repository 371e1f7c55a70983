"""The command that removes what no study refers to."""

from pathlib import Path

import click

from mpmverify.cli.options import out_option
from mpmverify.cli.results import stored


@click.command()
@out_option
@click.option("--dry-run", is_flag=True, help="List what would be removed.")
def clean(out: Path, dry_run: bool) -> None:
    """Remove runs that no study refers to: of earlier inputs, damaged ones, and those of a run that was interrupted.

    Files that mpmverify did not write are left alone.
    """
    from mpmverify.dataset.files import Results
    from mpmverify.dataset.leftovers import leftovers

    stored(out, ())
    found = leftovers(Results(out))
    sizes = [path.stat().st_size for path in found]
    for path, size in zip(found, sizes, strict=True):
        if dry_run:
            click.echo(f"{size:12,d} bytes  {path}")
        else:
            path.unlink()
    total = f"{len(found)} files that no study refers to, {sum(sizes) / 1e6:.1f} MB"
    click.echo(f"{total}." if dry_run else f"Removed {total}.")
