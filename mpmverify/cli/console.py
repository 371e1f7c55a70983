"""The console that commands print to, with a colour for each verdict."""

from rich.console import Console

from mpmverify.convergence.verdict import Verdict

STYLES = {Verdict.PASS: "green", Verdict.INCONCLUSIVE: "yellow", Verdict.FAIL: "bold red", Verdict.ERROR: "bold magenta"}
WIDTH = 200
"""Width where the output is no terminal."""


def console() -> Console:
    """Return the console of the terminal, or one of fixed width where the output is a file or a pipe."""
    terminal = Console()
    return terminal if terminal.is_terminal else Console(width=WIDTH)
