"""The console that commands print to, with a colour for each verdict."""

from collections.abc import Mapping

from rich.console import Console
from rich.markup import escape

from mpmverify.convergence.verdict import Judgement, Verdict

STYLES = {Verdict.PASS: "green", Verdict.INCONCLUSIVE: "yellow", Verdict.FAIL: "bold red", Verdict.ERROR: "bold magenta"}
WIDTH = 200
"""Width where the output is no terminal."""


def console() -> Console:
    """Return the console of the terminal, or one of fixed width where the output is a file or a pipe."""
    terminal = Console()
    return terminal if terminal.is_terminal else Console(width=WIDTH)


def show_judgements(judgements: Mapping[str, Judgement]) -> None:
    """Print verdicts by name, one a line, with the reason."""
    output = Console()
    for name, (verdict, reason) in judgements.items():
        output.print(f"[{STYLES[verdict]}]{verdict}[/]", escape(f"{name}: {reason}"), highlight=False, soft_wrap=True)
