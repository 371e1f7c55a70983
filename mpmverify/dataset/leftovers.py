"""Files in a results folder that no study refers to: runs of earlier inputs, damaged runs, halves that a killed process left."""

import re
from pathlib import Path

import netCDF4

from mpmverify.dataset.files import Results, check_ours, damaged, is_run

RUN = re.compile(r"[0-9a-f]{24}\.nc")
SET_ASIDE = re.compile(r"[0-9a-f]{24}\.nc\.damaged(-\d+)?")
HALF = re.compile(r"\..+-[0-9a-f]{16}\.(nc|json|html)")


def leftovers(results: Results) -> list[Path]:
    """Return the files that can be removed, sorted; files that mpmverify did not write are not among them.

    Raises
    ------
    ResultsError
        If a study cannot be read: it may refer to any run.
    """
    referred = {results.run(key) for path in results.studies() for key in _keys(path)}
    found = [path for folder in (results.path, results.runs, results.report) for path in _matching(folder, HALF)]
    found += _matching(results.runs, SET_ASIDE)
    found += [path for path in _matching(results.runs, RUN) if path not in referred and is_run(path)]
    return sorted(found)


def _matching(folder: Path, pattern: re.Pattern[str]) -> list[Path]:
    return [path for path in folder.iterdir() if pattern.fullmatch(path.name) and path.is_file()] if folder.is_dir() else []


def _keys(path: Path) -> list[str]:
    """Keys of the runs of a study."""
    check_ours(path, "study")
    try:
        with netCDF4.Dataset(path) as file:
            return [str(key) for group in file.groups.values() for key in group["run"][...]]
    except (OSError, RuntimeError, AttributeError, LookupError, ValueError) as error:
        raise damaged(path) from error
