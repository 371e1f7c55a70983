"""Paths of the files in a results folder, and the check that mpmverify wrote a file."""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4

from mpmverify.errors import ResultsError

SCHEMA = 4
"""Version of the layout of run and study files."""


@dataclass(frozen=True)
class Results:
    """The paths in a results folder."""

    path: Path

    def run(self, key: str) -> Path:
        return self.path / "runs" / f"{key}.nc"

    def study(self, name: str) -> Path:
        return self.path / f"{name}.nc"

    @property
    def verdicts(self) -> Path:
        return self.path / "verdicts.json"

    @property
    def selftest(self) -> Path:
        return self.path / "selftest" / "selftest.nc"

    @property
    def report(self) -> Path:
        return self.path / "report"

    def studies(self) -> list[Path]:
        # Hidden files are temporary: another process is writing them, or a killed one left them.
        return sorted(path for path in self.path.glob("*.nc") if not path.name.startswith("."))

    def create(self) -> None:
        """Create the folder and check that it is writable.

        Raises
        ------
        ResultsError
            If the folder cannot be created or written to.
        """
        try:
            (self.path / "runs").mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.path / "runs"):
                pass
        except OSError as error:
            reason = error.strerror or error
            raise ResultsError(f"cannot write results to '{self.path}' ({reason}): choose another folder with --out") from error


def check_ours(path: Path, kind: str) -> dict[str, Any]:
    """Check that mpmverify wrote a file of this kind, and return its global attributes.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        "run", "study" or "selftest".

    Raises
    ------
    ResultsError
        If the file is missing or unreadable, or was written by another program or in another schema.
    """
    try:
        with netCDF4.Dataset(path) as file:
            attributes = {name: file.getncattr(name) for name in file.ncattrs()}
    except FileNotFoundError as error:
        raise ResultsError(f"'{path}' does not exist: run `mpmverify run` first") from error
    except (OSError, RuntimeError) as error:
        raise ResultsError(f"'{path}' is not a readable netCDF file: move it away or choose another folder") from error
    if attributes.get("mpmverify_kind") != kind:
        raise ResultsError(f"'{path}' is not an mpmverify {kind} file: move it away or choose another folder")
    schema = attributes.get("mpmverify_schema", "none")
    if str(schema) != str(SCHEMA):
        raise ResultsError(f"'{path}' has schema {schema} and this version reads {SCHEMA}: move it away and run again")
    return attributes
