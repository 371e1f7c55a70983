"""Object code on the disk, shared by all processes: where it lies, and how it is written and read."""

import json
import os
import tempfile
import zlib
from pathlib import Path
from typing import Any


def folder_for(sources: Path) -> Path | None:
    """Folder of the compiled code of some sources; None if no file can be written anywhere.

    It is that of NUMBA_CACHE_DIR, which other compiled solvers use as well, if this is set; else `__pycache__` beside the sources, or a
    folder of the user.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    of_user = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "mpmverify"
    for folder in [Path(chosen)] if chosen else [sources / "__pycache__", of_user]:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


def read(path: Path) -> tuple[bytes, Any] | None:
    """Code and the form of its result; None if there is no file, or one that is not whole."""
    try:
        header, _, code = path.read_bytes().partition(b"\n")
        said = json.loads(header)
        return (code, said["form"]) if said["crc"] == zlib.crc32(code) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def write(path: Path, code: bytes, form: Any) -> None:
    """Write code and the form of its result, at once and whole; without room on the disk the code is compiled again next time."""
    header = json.dumps({"crc": zlib.crc32(code), "form": form}).encode()
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=path.stem, suffix=".part", delete=False) as part:
            part.write(header + b"\n" + code)
        Path(part.name).replace(path)
    except OSError:
        return
