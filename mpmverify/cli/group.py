"""Commands that answer what a user can mend in one sentence."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from mpmverify.errors import MpmverifyError

INTERRUPTED = 130
"""Exit status after SIGINT, as shells have it: 1 would say that a gate failed."""


class _Abort(click.ClickException):
    exit_code = 2


class Group(click.Group):
    """Commands whose errors are one sentence and exit status 2."""

    def make_context(self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any) -> Any:
        with _one_sentence():
            return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        with _one_sentence():
            return super().invoke(ctx)


@contextmanager
def _one_sentence() -> Iterator[None]:
    """Turn the library's errors and click's into one sentence and exit status 2; an interrupt is no verdict either."""
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        raise _Abort(error.format_message()) from error
    except MpmverifyError as error:
        raise _Abort(str(error)) from error
    except KeyboardInterrupt:
        click.echo("Interrupted: finished runs are kept, run again to go on.", err=True)
        sys.exit(INTERRUPTED)
