"""Options and arguments that several commands take."""

import math
import os
from pathlib import Path
from typing import Any

import click

EPILOG = "Exit status: 0 pass, 1 a gate failed, 2 usage, 3 a run erred or nothing was judged, 4 inconclusive under --strict."


def positive(_ctx: click.Context, parameter: click.Parameter, value: float | None) -> float | None:
    """Accept a positive finite number or nothing."""
    if value is not None and not (math.isfinite(value) and value > 0):
        raise click.BadParameter(f"must be positive and finite, not {value:g}", param=parameter)
    return value


class Folder(click.Path):
    """A results folder. The netCDF library opens it only by a name in UTF-8 that begins with no blank."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        name = os.fsencode(value)
        if not name or name[:1].isspace() or name.decode("utf-8", "replace").encode() != name:
            self.fail(
                f"{os.fspath(value)!r} cannot name a results folder: give a name in UTF-8 that begins with no blank", param, ctx
            )
        return super().convert(value, param, ctx)


out_option = click.option("--out", type=Folder(), default=Path("results"), show_default=True, help="Results folder.")
baseline_option = click.option(
    "--baseline", type=click.Path(path_type=Path), help="Baseline of the regression gate  [default: the shipped one]"
)
studies_argument = click.argument("studies", metavar="[STUDY]...", nargs=-1)
jobs_option = click.option("--jobs", type=click.IntRange(min=1), help="Worker processes  [default: one a processor]")
explain_option = click.option(
    "--explain", is_flag=True, help="Print the reason of every verdict, and where its expectation comes from."
)
open_option = click.option("--open", "open_", is_flag=True, help="Open the report in the browser.")
