"""Summaries of verdicts: marks, counts, matrices, lists of the findings that did not pass, and provenance; the index page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from mpmverify.convergence.verdict import Verdict, worst
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import KNOWN_LIMIT, ranked, tally

from .notation import ladder, slugs
from .parts import Cell, Criterion, Fact, GateMark, Group, Judgement, Mark, Origin, Row, Share
from .record import Record

GATES = ("verification", "regression")
HINTS = 6
"""Largest number of reasons in the tooltip of a cell; the lists show all of them."""
MEANING = {
    0: "The gate would exit with status 0: nothing failed.",
    1: "The gate would exit with status 1: a gate failed.",
    3: "The gate would exit with status 3: a run ended in an error.",
    4: "The gate would exit with status 0, or 4 with --strict: nothing failed, but some criteria are inconclusive.",
}


def case_anchors(record: Record) -> dict[str, str]:
    """Return the anchor of each case on the page of its study."""
    return {name: f"case-{anchor}" for name, anchor in slugs([case.name for case in record.cases]).items()}


def solver_anchors(record: Record) -> dict[str, str]:
    """Return the anchor of each solver on the page of a study."""
    return {name: f"solver-{anchor}" for name, anchor in slugs(list(record.schemes)).items()}


def verdict_anchors(record: Record) -> dict[tuple[str, str], str]:
    """Return the anchor of the verdicts on each (case, solver) on the page of their study."""
    cases, names = case_anchors(record), slugs(list(record.schemes))
    return {(case, solver): f"{cases[case]}--{anchor}" for case in cases for solver, anchor in names.items()}


def mark(findings: Sequence[Finding]) -> Mark:
    """Return the worst verdict of some findings, with the number of findings that have it."""
    verdict = worst(finding.verdict for finding in findings)
    count = sum(finding.verdict is verdict for finding in findings)
    return Mark(verdict.value.lower(), verdict.value, f"{count} of {len(findings)}")


def gate_marks(findings: Sequence[Finding]) -> tuple[GateMark, ...]:
    """Return the worst verdict of each gate that has findings."""
    judged = {gate: [finding for finding in findings if finding.gate == gate] for gate in GATES}
    return tuple(GateMark(gate.capitalize(), mark(members)) for gate, members in judged.items() if members)


def shares(findings: Sequence[Finding]) -> tuple[Share, ...]:
    """Return the number of findings with each verdict, the worst first; known limits count by themselves."""
    marks = {KNOWN_LIMIT: Mark("limit", KNOWN_LIMIT)}
    marks |= {str(verdict): Mark(verdict.value.lower(), str(verdict)) for verdict in Verdict}
    return tuple(Share(marks[word], number) for word, number in reversed(tally(findings).items()) if number)


def cell(findings: Sequence[Finding], href: str) -> Cell:
    """Make the matrix cell of some findings, with a short text; its tooltip gives the reasons of the worst findings."""
    reasons = [f"{f.verdict} {f.case}, {ladder(f.refinement)}: {f.criterion}: {f.reason}" for f in ranked(findings)]
    more = [f"and {len(reasons) - HINTS} more"] if len(reasons) > HINTS else []
    worst_of = mark(findings)
    note = str(len(findings)) if worst_of.kind == "pass" else worst_of.note.replace(" of ", "/")
    return Cell(replace(worst_of, note=note), href, "\n".join(reasons[:HINTS] + more) or f"all {len(findings)} passed")


def matrix(
    findings: Sequence[Finding],
    columns: Sequence[str],
    column_of: Callable[[Finding], str],
    href: Callable[[str, str], str],
    anchors: Mapping[str, str],
    pages: Mapping[str, str],
) -> tuple[Row, ...]:
    """Make the rows of a verdict matrix: one row for each solver, with cells (verification, regression) for each column.

    Parameters
    ----------
    findings : sequence of Finding
    columns : sequence of str
    column_of : callable
        Returns the column of a finding.
    href : callable
        Returns the link of (column, solver).
    anchors : mapping of str to str
        Anchor of the row of each solver, in the order of the rows.
    pages : mapping of str to str
        File of the page of each solver.
    """
    table: dict[tuple[str, str, str], list[Finding]] = {}
    for finding in findings:
        table.setdefault((finding.solver, column_of(finding), finding.gate), []).append(finding)
    rows = []
    for solver, anchor in anchors.items():
        cells = []
        for column in columns:
            judged = [table.get((solver, column, gate), []) for gate in GATES]
            verification, regression = (cell(members, href(column, solver)) if members else None for members in judged)
            cells.append((verification, regression))
        rows.append(Row(anchor, solver, pages[solver], tuple(cells)))
    return tuple(rows)


def judgements(
    findings: Sequence[Finding], href: Callable[[Finding], str], sources: Sequence[str] = ()
) -> tuple[Judgement, ...]:
    """Merge findings that differ only in criterion and source: a run that failed is listed once for all criteria of its series.

    Parameters
    ----------
    findings : sequence of Finding
    href : callable
        Returns the link of a finding.
    sources : sequence of str
        Sources, in the order of their footnote numbers.
    """
    table: dict[Finding, list[Finding]] = {}
    for finding in findings:
        table.setdefault(replace(finding, criterion="", source=""), []).append(finding)
    return tuple(
        Judgement(
            mark=Mark(shared.verdict.value.lower(), shared.word),
            study=shared.study,
            case=shared.case,
            solver=shared.solver,
            ladder=ladder(shared.refinement),
            gate=shared.gate,
            criteria=tuple(Criterion(f.criterion, sources.index(f.source) + 1 if f.source in sources else 0) for f in members),
            reason=shared.reason,
            href=href(shared),
        )
        for shared, members in table.items()
    )


def not_passed(findings: Sequence[Finding], href: Callable[[Finding], str]) -> tuple[Group, ...]:
    """Group the findings that did not pass by verdict and gate, the worst first; long lists of INCONCLUSIVE are folded."""
    table: dict[tuple[Verdict, str], list[Finding]] = {}
    for finding in ranked(findings):
        table.setdefault((finding.verdict, finding.gate), []).append(finding)
    groups = []
    for verdict in reversed(Verdict):
        for gate in GATES:
            members = table.get((verdict, gate), [])
            if members:
                judged = judgements(members, href)
                unfolded = verdict is not Verdict.INCONCLUSIVE or len(judged) <= 12
                title = f"{gate.capitalize()}: {len(members)}"
                groups.append(Group(f"{verdict.value.lower()}-{gate}", judged[0].mark, title, (), unfolded, judged))
    return tuple(groups)


def origin(record: Record) -> Origin:
    """Return the provenance of a study file."""
    a = record.attributes
    names = {
        "Written": a["date_created"],
        "Commit": a["commit"] if a["commit_state"] == "installed" else f"{a['commit'][:12]} ({a['commit_state']})",
        "Tier": a["tier"],
        "Restricted to": record.restricted_to,
        "Made by": a["source"],
        "Versions": a["versions"],
        "Platform": a["platform"],
        "Seeds": a["seeds"],
        "Inputs": a["inputs"] or "incomplete: a run left no file",
        "Schema": f"{a['mpmverify_schema']}, {a['Conventions']}",
    }
    return Origin(record.name, f"../{record.name}.nc", tuple(Fact(name, str(value)) for name, value in names.items() if value))
