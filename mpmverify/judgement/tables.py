"""A results folder as flat tables: what two folders can be compared by."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from mpmverify.convergence.verdict import Verdict

PROVENANCE = ("commit", "commit_state", "tier", "versions", "platform", "date_created")


class SeriesKey(NamedTuple):
    """One solver on one ladder."""

    study: str
    case: str
    solver: str
    refinement: str


class Run(NamedTuple):
    """How one level was solved: its outcome, its steps, particles or elements times steps, and seconds without compilation."""

    outcome: str
    steps: int
    point_steps: int
    seconds: float


class Order(NamedTuple):
    """Fitted order with its interval, and the levels that were there to be fitted."""

    order: float
    low: float
    high: float
    levels: frozenset[str]


@dataclass(frozen=True)
class Tables:
    """What the studies of one results folder hold.

    Parameters
    ----------
    provenance : mapping
        `PROVENANCE` attributes by study.
    runs : mapping
        By (series, level); a level is "h=... nu_C=... ppc=...".
    errors : mapping
        (absolute error, exact norm), in the unit of the field, by (series, level, "quantity norm"). A run that did not complete has none.
    orders : mapping
        By (series, "quantity norm"), where a line was fitted.
    verdicts : mapping
        By (series, "gate: criterion"): the worst where several criteria share their title.
    """

    provenance: Mapping[str, Mapping[str, str]]
    runs: Mapping[tuple[SeriesKey, str], Run]
    errors: Mapping[tuple[SeriesKey, str, str], tuple[float, float]]
    orders: Mapping[tuple[SeriesKey, str], Order]
    verdicts: Mapping[tuple[SeriesKey, str], Verdict]
