"""Verdicts of a case by solver, as they are listed on the page of a study."""

from collections.abc import Mapping, Sequence

from mpmverify.convergence.verdict import Verdict
from mpmverify.judgement.findings import Finding

from .failures import Failure, command
from .overview import gate_marks, judgements, mark
from .parts import Group
from .record import Record


def verdict_groups(
    record: Record,
    findings: Sequence[Finding],
    places: Mapping[tuple[str, str], str],
    failed: Mapping[tuple[str, str, str], Failure],
    sources: Sequence[str],
) -> tuple[Group, ...]:
    """Group the findings of a case by solver; a group is unfolded if a criterion failed or verification is inconclusive.

    Parameters
    ----------
    record : Record
        The study.
    findings : sequence of Finding
    places : mapping of (str, str) to str
        Anchor of the verdicts on each (case, solver).
    failed : mapping of (str, str, str) to Failure
        Failed runs by (case, solver, refinement), to which an ERROR links.
    sources : sequence of str
        Sources, in the order of their footnote numbers.
    """

    def href(finding: Finding) -> str:
        failure = failed.get((finding.case, finding.solver, finding.refinement))
        return f"#{failure.anchor}" if failure and finding.verdict is Verdict.ERROR else ""

    table: dict[str, list[Finding]] = {}
    for finding in findings:
        table.setdefault(finding.solver, []).append(finding)
    groups = []
    for solver, members in table.items():
        doubtful = any(
            f.verdict in (Verdict.FAIL, Verdict.ERROR) or (f.gate == "verification" and f.verdict is not Verdict.PASS)
            for f in members
        )
        name = places[members[0].case, solver]
        judged = judgements(members, href, sources)
        groups.append(Group(name, mark(members), solver, gate_marks(members), doubtful, judged, command(record, solver)))
    return tuple(groups)
