"""Three states of a judgement, and ERROR where there is nothing to judge."""

from collections.abc import Iterable
from enum import StrEnum


class Verdict(StrEnum):
    """Ordered from best to worst."""

    PASS = "PASS"
    INCONCLUSIVE = "INCONCLUSIVE"
    FAIL = "FAIL"
    ERROR = "ERROR"


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst of some verdicts; nothing judged is inconclusive."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.INCONCLUSIVE)


Judgement = tuple[Verdict, str]
"""A verdict with its reason in one sentence."""
