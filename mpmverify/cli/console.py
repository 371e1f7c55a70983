"""The console that commands print to, with a colour for each verdict."""

import re
from collections.abc import Sequence

import click
from rich.console import Console

from mpmverify.convergence.verdict import Verdict

STYLES = {Verdict.PASS: "green", Verdict.INCONCLUSIVE: "yellow", Verdict.FAIL: "bold red", Verdict.ERROR: "bold magenta"}
WIDTH = 200
"""Width where the output is no terminal."""
NAMED_CASES = 3
"""Number of cases left out for the same reason that are named."""


def console() -> Console:
    """Return the console of the terminal, or one of fixed width where the output is a file or a pipe."""
    terminal = Console()
    return terminal if terminal.is_terminal else Console(width=WIDTH)


def say_left_out(refused: Sequence[tuple[str, str]]) -> None:
    """Print which cases are left out, given with their reasons; cases with the same reason but for the name of the problem in one line."""
    groups: dict[str, list[tuple[str, str]]] = {}
    for case, reason in refused:
        groups.setdefault(re.sub("(cannot solve|case) '[^']*'", "", reason), []).append((case, reason))
    for cases in groups.values():
        more = f" and {len(cases) - NAMED_CASES} more" if len(cases) > NAMED_CASES else ""
        names = "; ".join(case for case, _ in cases[:NAMED_CASES])
        reason = (
            cases[0][1] if len(cases) == 1 else re.sub("cannot solve '[^']*': it |case '[^']*' (?=expects)", "", cases[0][1])
        )
        click.echo(f"Left out: {names}{more}: {reason}", err=True)
