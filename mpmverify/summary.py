"""Verdicts for machines and for pull requests: JUnit XML and a Markdown summary."""

from collections import Counter
from collections.abc import Sequence
from xml.etree import ElementTree

from mpmverify.gate import Finding, Verdict, worst

MARKDOWN_ROWS = 50
"""Failures listed in a summary; hosts limit its size."""
XML_FORBIDDEN = dict.fromkeys({*range(32), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF} - {9, 10, 13})

MARKDOWN_ESCAPES = str.maketrans({"\\": "\\\\", "|": "\\|", "&": "&amp;", "<": "&lt;", ">": "&gt;"})


def matrix(findings: Sequence[Finding]) -> dict[str, dict[str, Verdict]]:
    """Worst verdict by solver and study."""
    table: dict[str, dict[str, list[Verdict]]] = {}
    for finding in findings:
        table.setdefault(finding.solver, {}).setdefault(finding.study, []).append(finding.verdict)
    return {solver: {study: worst(verdicts) for study, verdicts in row.items()} for solver, row in table.items()}


def ranked(findings: Sequence[Finding]) -> list[Finding]:
    """Findings that are no PASS, the worst first."""
    order = list(Verdict)
    return sorted((f for f in findings if f.verdict is not Verdict.PASS), key=lambda f: -order.index(f.verdict))


def counts(findings: Sequence[Finding]) -> str:
    """Return "3 FAIL, 40 PASS": how many of each verdict, the worst first."""
    count = Counter(finding.verdict for finding in findings)
    return ", ".join(f"{count[verdict]} {verdict}" for verdict in reversed(Verdict) if count[verdict]) or "nothing judged"


def junit(findings: Sequence[Finding]) -> bytes:
    """JUnit XML: a suite by study, a test case by finding; INCONCLUSIVE is skipped, with the reason."""
    tags = {Verdict.FAIL: "failure", Verdict.ERROR: "error", Verdict.INCONCLUSIVE: "skipped"}

    def plain(text: str) -> str:
        return text.translate(XML_FORBIDDEN)

    def totals(some: Sequence[Finding]) -> dict[str, str]:
        count = Counter(finding.verdict for finding in some)
        return {
            "tests": str(len(some)),
            "failures": str(count[Verdict.FAIL]),
            "errors": str(count[Verdict.ERROR]),
            "skipped": str(count[Verdict.INCONCLUSIVE]),
            "time": "0",
        }

    root = ElementTree.Element("testsuites", {"name": "mpmverify"} | totals(findings))
    for study in dict.fromkeys(finding.study for finding in findings):
        mine = [finding for finding in findings if finding.study == study]
        suite = ElementTree.SubElement(root, "testsuite", {"name": plain(study)} | totals(mine))
        for finding in mine:
            name = plain(f"{finding.case} ({finding.refinement}) {finding.gate}: {finding.criterion}")
            classname = plain(f"{study}.{finding.solver}")
            case = ElementTree.SubElement(suite, "testcase", classname=classname, name=name, time="0")
            if finding.verdict in tags:
                reason = plain(finding.reason)
                child = ElementTree.SubElement(case, tags[finding.verdict], message=reason)
                if finding.verdict is not Verdict.INCONCLUSIVE:
                    child.set("type", plain(finding.gate))
                    child.text = f"{reason}\nexpected by: {plain(finding.source)}"
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)


def markdown(findings: Sequence[Finding]) -> str:
    """Markdown summary: the count, what is no PASS with reasons, and the matrix of solver by study."""

    def row(*cells: str) -> str:
        return "| " + " | ".join(" ".join(cell.translate(MARKDOWN_ESCAPES).split()) for cell in cells) + " |"

    lines = [f"## mpmverify: {worst(f.verdict for f in findings)}", "", f"{counts(findings)}.", ""]
    bad = ranked(findings)
    if bad:
        lines += [row("verdict", "where", "criterion", "reason"), row(*["---"] * 4)]
        for f in bad[:MARKDOWN_ROWS]:
            lines.append(row(str(f.verdict), f"{f.study} / {f.case} / {f.solver} ({f.refinement})", f.criterion, f.reason))
        if len(bad) > MARKDOWN_ROWS:
            lines += ["", f"and {len(bad) - MARKDOWN_ROWS} more in verdicts.json."]
        lines.append("")
    studies = list(dict.fromkeys(f.study for f in findings))
    lines += [row("solver", *studies), row(*["---"] * (len(studies) + 1))]
    lines += [row(solver, *(str(cells.get(study, "")) for study in studies)) for solver, cells in matrix(findings).items()]
    return "\n".join(lines) + "\n"
