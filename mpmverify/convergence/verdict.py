"""Three states of a judgement, and ERROR where there is nothing to judge."""

from collections.abc import Iterable, Sequence
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


def exit_status(verdicts: Sequence[Verdict], *, strict: bool = False) -> int:
    """Exit status of a gate: 0 pass, 1 a gate failed, 3 a run erred or nothing was judged, 4 inconclusive under `strict`."""
    verdict = worst(verdicts) if verdicts else Verdict.ERROR
    if verdict is Verdict.INCONCLUSIVE:
        return 4 if strict else 0
    return {Verdict.PASS: 0, Verdict.FAIL: 1, Verdict.ERROR: 3}[verdict]
