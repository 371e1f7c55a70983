"""Atomic writing: a file is replaced as a whole or not at all."""

import secrets
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from mpmverify.errors import ResultsError

R = TypeVar("R")


def write_atomic(path: Path, write: Callable[[Path], R], remedy: str = "free the disk or choose --out") -> R:
    """Write a temporary file beside `path` and rename it to `path`: readers see the old file or the complete new one.

    Parameters
    ----------
    path : Path
        File to write; its folder is created if it does not exist.
    write : callable
        Called with the path of the temporary file.
    remedy : str
        Advice at the end of the error message.

    Returns
    -------
    object
        What `write` returns.

    Raises
    ------
    ResultsError
        If the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # mkstemp would make a file that only its owner can read.
        temporary = path.with_name(f".{path.stem}-{secrets.token_hex(8)}{path.suffix}")
        try:
            returned = write(temporary)
            temporary.replace(path)
            return returned
        finally:
            temporary.unlink(missing_ok=True)
    except ResultsError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError when the disk is full
        raise ResultsError(f"cannot write '{path}' ({getattr(error, 'strerror', '') or error}): {remedy}") from error
