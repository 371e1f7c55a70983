"""Provenance of a result: commit, versions, platform and time."""

import platform
import subprocess
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path

import mpmverify
from mpmverify.dataset.files import SCHEMA


@cache
def commit() -> tuple[str, str]:
    """Return the commit of the checkout that contains the package and "clean" or "dirty"; else ("none", "installed")."""
    root = Path(mpmverify.__file__).parent.parent

    def git(*arguments: str) -> str:
        done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True, check=True, timeout=20)
        return done.stdout.strip()

    try:
        if not git("ls-files", "mpmverify/__init__.py"):
            return "none", "installed"
        return git("rev-parse", "HEAD"), "dirty" if git("status", "--porcelain") else "clean"
    except (OSError, subprocess.SubprocessError):
        return "none", "installed"


@cache
def versions() -> str:
    """Return the versions of Python and of the libraries that compute and store the results."""
    table = library_versions() | {name: metadata.version(name) for name in ("xarray", "netCDF4")}
    return ", ".join(f"{name} {version}" for name, version in table.items())


def now() -> str:
    """Return the time by ISO 8601."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def attributes(kind: str, title: str, summary: str) -> dict[str, str | int]:
    """Return the global attributes of a file by CF-1.11 and ACDD-1.3, with its provenance."""
    revision, state = commit()
    written = now()
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": title,
        "summary": summary,
        "keywords": "verification, convergence, material point method, finite element method, wave propagation",
        "source": f"mpmverify {mpmverify.__version__}",
        "history": f"{written} written by mpmverify {mpmverify.__version__}",
        "date_created": written,
        "creator_name": "mpmverify",
        "creator_type": "institution",
        "standard_name_vocabulary": "none",
        "processing_level": "numerical experiment" if kind == "run" else "errors, orders and verdicts",
        "mpmverify_kind": kind,
        "mpmverify_schema": SCHEMA,
        "commit": revision,
        "commit_state": state,
        "versions": versions(),
        "platform": platform.platform(),
    }


NUMERICAL_LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "scikit-fem")


@cache
def library_versions() -> dict[str, str]:
    """Return the versions of Python, of the numerical libraries and the machine type, which can change a result."""
    return {"python": platform.python_version(), "machine": platform.machine()} | {
        name: metadata.version(name) for name in NUMERICAL_LIBRARIES
    }
