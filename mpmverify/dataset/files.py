"""Files of a results folder: where they are, opened or written whole or not at all."""

import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4

from mpmverify.errors import ResultsError

SCHEMA = 2
"""Version of the layout of run and study files."""


@dataclass(frozen=True)
class Results:
    """A results folder."""

    path: Path

    def run(self, key: str) -> Path:
        return self.path / "runs" / f"{key}.nc"

    def study(self, name: str) -> Path:
        return self.path / f"{name}.nc"

    @property
    def verdicts(self) -> Path:
        return self.path / "verdicts.json"

    @property
    def report(self) -> Path:
        return self.path / "report"

    def studies(self) -> list[Path]:
        # A hidden file is what another process is writing, or what a killed one left.
        return sorted(path for path in self.path.glob("*.nc") if not path.name.startswith("."))

    def create(self) -> None:
        """Make the folder and prove that it can be written to.

        Raises
        ------
        ResultsError
            If it cannot.
        """
        try:
            (self.path / "runs").mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.path / "runs"):
                pass
        except OSError as error:
            reason = error.strerror or error
            raise ResultsError(f"cannot write results to '{self.path}' ({reason}): choose another folder with --out") from error


def write_atomic(path: Path, write: Callable[[Path], Any]) -> None:
    """Call `write` on a temporary file beside `path`, then move it into place: readers see all of it or nothing.

    Raises
    ------
    ResultsError
        If the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
        os.close(handle)
        temporary = Path(name)
        try:
            write(temporary)
            # mkstemp makes private files; a result is as readable as its folder lets it be.
            umask = os.umask(0)
            os.umask(umask)
            temporary.chmod(0o666 & ~umask)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except ResultsError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError when the disk is full
        raise ResultsError(
            f"cannot write '{path}' ({getattr(error, 'strerror', '') or error}): free the disk or choose --out"
        ) from error


def check_ours(path: Path, kind: str) -> dict[str, Any]:
    """Return the root attributes of a file of ours.

    Parameters
    ----------
    path : Path
    kind : str
        "run" or "study".

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, foreign or of another schema.
    """
    try:
        with netCDF4.Dataset(path) as file:
            attributes = {name: file.getncattr(name) for name in file.ncattrs()}
    except FileNotFoundError as error:
        raise ResultsError(f"'{path}' does not exist: run `mpmverify run` first") from error
    except (OSError, RuntimeError) as error:
        raise ResultsError(
            f"'{path}' is not a readable netCDF file: move it away or choose another folder with --out"
        ) from error
    if attributes.get("mpmverify_kind") != kind:
        raise ResultsError(f"'{path}' is not an mpmverify {kind} file: move it away or choose another folder with --out")
    schema = attributes.get("mpmverify_schema", "none")
    if str(schema) != str(SCHEMA):
        raise ResultsError(f"'{path}' has schema {schema}, this version reads {SCHEMA}: move it away and run again")
    return attributes
