"""One difference between two results folders: its kind, its direction and its size."""

from dataclasses import dataclass
from enum import StrEnum


class Direction(StrEnum):
    """Direction of a change, from worst to best; opposite directions have mirrored positions in this order."""

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
    """What changed; causes come before their consequences."""

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
    """One difference between two results folders.

    Parameters
    ----------
    direction : Direction
    kind : Kind
    study, case, solver, refinement, level : str
        Where it occurs; "" for those that do not apply.
    name : str
        Title of the criterion, or "quantity norm"; "" for other kinds.
    before, after : str, float or None
        Value in the first and in the second folder; None if there is no value.
    size : float
        Size of the change, to sort changes of one kind: the logarithm of a ratio, or a difference of orders or of ranks.
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
