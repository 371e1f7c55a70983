"""What differs between two results folders: one thing, its direction and its size."""

from dataclasses import dataclass
from enum import StrEnum


class Direction(StrEnum):
    """Where a change leads: the worst first, and each as far from one end as its opposite from the other."""

    WORSE = "worse"
    LOST = "lost"
    SLOWER = "slower"
    FASTER = "faster"
    NEW = "new"
    BETTER = "better"

    @property
    def opposite(self) -> "Direction":
        order = list(Direction)
        return order[-1 - order.index(self)]


class Kind(StrEnum):
    """What changed: the cause before what follows from it."""

    STUDY = "study"
    CASE = "case"
    SOLVER = "solver"
    LADDER = "ladder"
    LEVEL = "level"
    CRITERION = "criterion"
    NORM = "error norm"
    OUTCOME = "outcome"
    VERDICT = "verdict"
    ORDER = "order"
    ERROR = "error"
    STEPS = "steps"
    SECONDS = "seconds"


@dataclass(frozen=True)
class Change:
    """One thing that differs.

    Parameters
    ----------
    direction : Direction
    kind : Kind
    study, case, solver, refinement, level : str
        Where; "" for what spans them.
    name : str
        The criterion, or "quantity norm"; "" where the place says it all.
    before, after : str, float or None
        In the first folder and in the second; None where there is nothing.
    size : float
        How far it changed, to rank changes of one kind: the logarithm of a ratio, a difference of orders or of ranks.
    """

    direction: Direction
    kind: Kind
    study: str
    case: str = ""
    solver: str = ""
    refinement: str = ""
    level: str = ""
    name: str = ""
    before: str | float | None = None
    after: str | float | None = None
    size: float = 0.0
