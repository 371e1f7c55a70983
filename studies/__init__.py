"""The shipped studies, imported by name on demand.

Declarations belong here: the problems, solvers, ladders and criteria of each study, and the accepted baseline. Closed forms and
criteria are defined in `mpmverify.exact` and `mpmverify.criteria`.
"""

from importlib import import_module
from pathlib import Path

from mpmverify.errors import UsageError
from mpmverify.study import Study

NAMES = (
    "advection",
    "elastic-bar",
    "gehojerez-deck",
    "axial-vibration",
    "manufactured-1d",
    "driven-bar",
    "dispersion",
    "error-sources",
    "patch-tests",
    "large-deformation",
    "expanding-ring",
    "generalised-vortex",
    "plane-waves",
    "loads-and-supports",
    "moving-bodies",
    "combinations",
    "mpm-stability",
)
BASELINE = Path(__file__).with_name("baseline.json")
"""Accepted errors of the regression gate."""


def get(name: str) -> Study:
    """Return the study with this name.

    Raises
    ------
    UsageError
        If no study has the name.
    """
    if name not in NAMES:
        raise UsageError(f"unknown study {name!r}: choose from {', '.join(NAMES)}")
    study: Study = import_module(f"mpmverify.studies.{name.replace('-', '_')}").STUDY
    return study
