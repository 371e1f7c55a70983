"""Files that are written whole or not at all."""

import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mpmverify.errors import ResultsError


def write_atomic(path: Path, write: Callable[[Path], Any], remedy: str = "free the disk or choose --out") -> None:
    """Call `write` on a temporary file beside `path`, then move it into place: readers see all of it or nothing.

    Parameters
    ----------
    path : Path
        Its folder is made where there is none.
    write : callable
        Called with the path of the temporary file.
    remedy : str
        What the user may do when the file cannot be written.

    Raises
    ------
    ResultsError
        If the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Not by mkstemp, whose files are private: a result is as readable as its folder lets it be.
        temporary = path.with_name(f".{path.stem}-{secrets.token_hex(8)}{path.suffix}")
        try:
            write(temporary)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except ResultsError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError when the disk is full
        raise ResultsError(f"cannot write '{path}' ({getattr(error, 'strerror', '') or error}): {remedy}") from error
