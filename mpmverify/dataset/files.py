"""Paths of the files in a results folder, the check that mpmverify wrote a file, and what is done with a damaged one."""

import contextlib
import itertools
import logging
import tempfile
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any, Literal

import netCDF4

from mpmverify.errors import DamagedError, ResultsError

SCHEMA = 6
"""Version of the layout of run and study files; part of the keys of runs."""
SIGNATURE = b"\x89HDF\r\n\x1a\n"
"""First bytes of every netCDF-4 file."""
SMALL = 4096
"""Size up to which an array is stored as it is [bytes]: the index of its compressed parts would take more than compression saves."""


@dataclass(frozen=True)
class Results:
    """The paths in a results folder."""

    path: Path

    @property
    def runs(self) -> Path:
        return self.path / "runs"

    def run(self, key: str) -> Path:
        return self.runs / f"{key}.nc"

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
            self.runs.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.runs):
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
    attributes = _attributes(path, kind)
    schema = attributes.get("mpmverify_schema", "none")
    if str(schema) != str(SCHEMA):
        raise ResultsError(f"'{path}' has schema {schema} and this version reads {SCHEMA}: move it away and run again")
    return attributes


def is_run(path: Path) -> bool:
    """Whether a file is a run of any version, or a damaged one."""
    try:
        _attributes(path, "run")
    except DamagedError:
        return True
    except ResultsError:
        return False
    return True


def _attributes(path: Path, kind: str) -> dict[str, Any]:
    try:
        with netCDF4.Dataset(path) as file:
            attributes = {name: file.getncattr(name) for name in file.ncattrs()}
    except FileNotFoundError as error:
        raise ResultsError(f"'{path}' does not exist: run `mpmverify run` first") from error
    except (
        OSError,
        RuntimeError,
        AttributeError,
        UnicodeDecodeError,
    ) as error:  # the third: of an attribute that cannot be opened
        if _was_netcdf(path):
            raise damaged(path) from error
        raise ResultsError(f"'{path}' is not a readable netCDF file: move it away or choose another folder") from error
    if attributes.get("mpmverify_kind") != kind:
        raise ResultsError(f"'{path}' is not an mpmverify {kind} file: move it away or choose another folder")
    return attributes


def _was_netcdf(path: Path) -> bool:
    """Whether an unreadable file is a netCDF-4 file that was damaged, cut off, emptied or filled with zeros."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(len(SIGNATURE))
    return SIGNATURE.startswith(head) or not head.strip(b"\0")


def damaged(path: Path) -> DamagedError:
    """Return the error on a file of mpmverify that cannot be read."""
    command = "selftest" if path.name == "selftest.nc" else "run"
    return DamagedError(f"'{path}' is damaged: run `mpmverify {command}` again, which sets it aside and makes it anew")


def set_aside(path: Path) -> None:
    """Rename a damaged file and say so, so that it can be made anew and nothing in it is lost."""
    names = itertools.chain([f"{path.name}.damaged"], (f"{path.name}.damaged-{k}" for k in itertools.count(2)))
    aside = next(place for name in names if not (place := path.with_name(name)).exists())
    with contextlib.suppress(FileNotFoundError):  # another process was faster
        path.rename(aside)
    logging.getLogger("mpmverify").warning("'%s' is damaged: it is set aside as '%s'.", path, aside.name)


def make_way(path: Path, kind: str) -> None:
    """Check that a file may be written: there is none, or one of this kind by this version or an older one; set a damaged one aside.

    Raises
    ------
    ResultsError
        If the file was written by another program or by a newer version.
    """
    if not path.exists():
        return
    try:
        schema = _attributes(path, kind).get("mpmverify_schema")
    except DamagedError:
        set_aside(path)
        return
    if not (isinstance(schema, Integral) and schema <= SCHEMA):
        raise ResultsError(f"'{path}' has another schema than {SCHEMA}, that of this version: move it away and run again")


def compression(size: int) -> Literal["zlib"] | None:
    """Return how a variable of some size [bytes] is compressed: without loss, and so that every reader of netCDF-4 takes it."""
    return "zlib" if size > SMALL else None
