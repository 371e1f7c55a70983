"""The command line: every command parses its options, calls the library, and displays the result or one sentence.

Here belong commands, options and what a terminal shows. To add a command, write it in a module here and add it to the loop below.
Heavy imports stay inside the commands, and no number is computed here.
"""

from typing import NoReturn

import click

from mpmverify import __version__
from mpmverify.cli.check import check
from mpmverify.cli.cleaning import clean
from mpmverify.cli.gci import gci
from mpmverify.cli.group import Group
from mpmverify.cli.judge import judge
from mpmverify.cli.new import new
from mpmverify.cli.options import EPILOG
from mpmverify.cli.problem import problem
from mpmverify.cli.reading import baseline, compare, gate, report
from mpmverify.cli.solving import list_, run, selftest


@click.group(cls=Group, epilog=EPILOG, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mpmverify")
def cli() -> None:
    """Prove that a wave solver is right: convergence studies, accuracy gates and reports."""


for command in (list_, run, gate, report, compare, baseline, judge, gci, selftest, clean, problem, new, check):
    cli.add_command(command)


def main() -> NoReturn:
    """Run the command line."""
    cli(prog_name="mpmverify")
    raise AssertionError("click exits by itself")
