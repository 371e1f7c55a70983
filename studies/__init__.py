"""Declared studies, imported by name on demand."""

from importlib import import_module

from mpmverify.errors import UsageError
from mpmverify.study import Study

NAMES = ("advection", "elastic-bar", "gehojerez-deck", "axial-vibration", "manufactured-1d")


def get(name: str) -> Study:
    """Return the study of that name.

    Raises
    ------
    UsageError
        If there is none.
    """
    if name not in NAMES:
        raise UsageError(f"unknown study {name!r}: choose from {', '.join(NAMES)}")
    study: Study = import_module(f"mpmverify.studies.{name.replace('-', '_')}").STUDY
    return study
