"""Object code on the disk, shared by all processes: where it lies, and how it is written and read."""

import contextlib
import json
import os
import uuid
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple


class Kept(NamedTuple):
    """What is kept of a compiled function.

    code : bytes
        Object code.
    form : list, int or None
        Form of the result, see `arguments.form_of`.
    threads : bool
        Whether the code launches threads.
    """

    code: bytes
    form: Any
    threads: bool


def folder_for(sources: Path) -> Path | None:
    """Folder of the compiled code of some sources; None if no file can be written anywhere.

    It is that of NUMBA_CACHE_DIR, which other compiled solvers use as well, if this is set; else `__pycache__` beside the sources, or a
    folder of the user.
    """
    for folder in _folders(sources):
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            if os.access(folder, os.W_OK):
                return folder
    return None


def _folders(sources: Path) -> Iterator[Path]:
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(chosen)
        return
    yield sources / "__pycache__"
    with contextlib.suppress(RuntimeError):  # the user has no home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mpmverify"


def read(path: Path) -> Kept | None:
    """Read what is kept; None if there is no file, or one that is not whole."""
    try:
        check, _, content = path.read_bytes().partition(b"\n")
        if int(check) != zlib.crc32(content):
            return None
        facts, _, code = content.partition(b"\n")
        return Kept(code, **json.loads(facts))
    except (OSError, ValueError):
        return None


def write(path: Path, kept: Kept) -> None:
    """Write a file at once and whole; where that fails, as for want of room, the code is compiled again next time."""
    content = json.dumps({"form": kept.form, "threads": kept.threads}).encode() + b"\n" + kept.code
    part = path.with_name(f"{path.name}.{uuid.uuid4().hex}.part")
    try:
        part.write_bytes(b"%d\n" % zlib.crc32(content) + content)
        part.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            part.unlink()
