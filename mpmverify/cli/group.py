"""Command group that turns an error which the user can fix into one sentence and exit status 2."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from mpmverify.errors import MpmverifyError

INTERRUPTED, NOBODY_READS = 130, 141
"""Exit status after SIGINT and SIGPIPE, as shells have it: 1 would say that a gate failed."""


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
    """Turn the library's errors, click's and the system's into one sentence and exit status 2; an interrupt is no verdict either."""
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        raise _Abort(error.format_message()) from error
    except MpmverifyError as error:
        raise _Abort(str(error)) from error
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left to be written is written when Python ends
        sys.exit(NOBODY_READS)
    except OSError as error:
        place = f"'{error.filename}'" if error.filename else "the output"
        raise _Abort(f"cannot use {place} ({error.strerror or error}): choose another place") from error
    except KeyboardInterrupt:
        click.echo("Interrupted: finished runs are kept, run again to go on.", err=True)
        sys.exit(INTERRUPTED)
