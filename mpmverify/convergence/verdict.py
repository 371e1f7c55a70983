"""Verdicts: PASS, INCONCLUSIVE and FAIL, and ERROR where there is nothing to judge."""

from collections.abc import Iterable, Sequence
from enum import StrEnum


class Verdict(StrEnum):
    """Verdicts, ordered from best to worst."""

    PASS = "PASS"
    INCONCLUSIVE = "INCONCLUSIVE"
    FAIL = "FAIL"
    ERROR = "ERROR"


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst verdict; INCONCLUSIVE if there is none."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.INCONCLUSIVE)


Judgement = tuple[Verdict, str]
"""A verdict with its reason in one sentence."""


def exit_status(verdicts: Sequence[Verdict], *, strict: bool = False) -> int:
    """Exit status of a gate.

    Parameters
    ----------
    verdicts : sequence of Verdict
    strict : bool
        Whether an inconclusive verdict counts.

    Returns
    -------
    int
        By the worst verdict: 0 for PASS, 1 for FAIL, 3 for ERROR or without any verdict; for INCONCLUSIVE 4 with `strict`, else 0.
    """
    verdict = worst(verdicts) if verdicts else Verdict.ERROR
    if verdict is Verdict.INCONCLUSIVE:
        return 4 if strict else 0
    return {Verdict.PASS: 0, Verdict.FAIL: 1, Verdict.ERROR: 3}[verdict]
