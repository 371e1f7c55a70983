"""Verdicts for machines and for pull requests: JUnit XML, a Markdown summary and annotations."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from mpmverify.convergence.verdict import Verdict, worst
from mpmverify.errors import UsageError
from mpmverify.judgement.findings import Finding

MARKDOWN_ROWS = 50
"""Failures listed in a summary."""
STEP_SUMMARY = 1024 * 1024
"""Bytes that the summary of one step may have on GitHub, which shows nothing of a larger one."""
ANNOTATIONS = 10
"""Annotations of one kind that GitHub shows of one step."""
CELL = 300
"""Characters of a text in a summary or an annotation; longer ones are shortened."""
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
            "time": "0",
        }

    root = ElementTree.Element("testsuites", {"name": "mpmverify"} | totals(findings))
    for study in dict.fromkeys(finding.study for finding in findings):
        mine = [finding for finding in findings if finding.study == study]
        skipped = str(sum(finding.verdict is Verdict.INCONCLUSIVE for finding in mine))  # no schema has it of all the suites
        suite = ElementTree.SubElement(root, "testsuite", {"name": plain(study), "skipped": skipped} | totals(mine))
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


def write_junit(path: Path, findings: Sequence[Finding]) -> None:
    """Write the JUnit XML of some findings.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    with _opened(path, "wb") as file:
        file.write(junit(findings))


def append_markdown(path: Path, findings: Sequence[Finding]) -> bool:
    """Append the Markdown summary to a file that may hold `STEP_SUMMARY` bytes, and return whether there was room for it.

    Raises
    ------
    UsageError
        If the file cannot be written.
    """
    with _opened(path, "ab") as file:
        text = markdown(findings, STEP_SUMMARY - (file.tell() if file.seekable() else 0))
        file.write(text.encode())
    return bool(text)


@contextmanager
def _opened(path: Path, mode: str) -> Iterator[Any]:
    try:
        with path.open(mode) as file:
            yield file
    except OSError as error:
        raise UsageError(f"cannot write '{path}' ({error.strerror}): choose another file") from error


def markdown(findings: Sequence[Finding], room: int = STEP_SUMMARY) -> str:
    """Markdown summary: the count, what is no PASS with reasons, the worst first, and the matrix of solver by study.

    Parameters
    ----------
    findings : sequence of Finding
    room : int
        Bytes that it may take in UTF-8. Rows that do not fit are left out, and a sentence says how many; the summary is empty where
        not even the count fits.
    """
    text = f"## mpmverify: {worst(f.verdict for f in findings)}\n\n{counts(findings)}.\n"
    bad = ranked(findings)
    if bad:
        rows = [(f.verdict, f"{f.study} / {f.case} / {f.solver} ({f.refinement})", f.criterion, f.reason) for f in bad]
        columns = ("verdict", "where", "criterion", "reason")
        text += _table(columns, rows, "in verdicts.json", room - _bytes(text), most=MARKDOWN_ROWS)
    studies = list(dict.fromkeys(f.study for f in findings))
    solvers = [(solver, *(cells.get(study, "") for study in studies)) for solver, cells in matrix(findings).items()]
    text += _table(("solver", *studies), solvers, "solvers", room - _bytes(text))
    return text if _bytes(text) <= room else ""


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]], what: str, room: int, most: int | None = None) -> str:
    """As many of the first rows as there is room for, and how many more there are; "" where not even that fits."""

    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(_short(cell).translate(MARKDOWN_ESCAPES) for cell in cells) + " |\n"

    def left_out(count: int) -> str:
        return f"\nand {count} more {what}.\n" if count else ""

    head = "\n" + line(columns) + line(["---"] * len(columns))
    lines = [line(cells) for cells in rows[:most]]
    if _bytes(whole := head + "".join(lines) + left_out(len(rows) - len(lines))) <= room:
        return whole
    end = left_out(len(rows))
    room -= _bytes(head) + _bytes(end)
    if room < 0:
        return end if room + _bytes(head) >= 0 else ""
    fitting = 0
    while (room := room - _bytes(lines[fitting])) >= 0:
        fitting += 1
    return head + "".join(lines[:fitting]) + left_out(len(rows) - fitting)


def annotations(findings: Sequence[Finding], results: Path) -> list[str]:
    """Workflow commands by which GitHub shows the worst findings beside a run and its pull request.

    Parameters
    ----------
    findings : sequence of Finding
    results : Path
        Results folder, whose files they are about.
    """

    def data(text: str) -> str:
        return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")

    def value(text: str) -> str:
        return data(text).replace(":", "%3A").replace(",", "%2C")

    commands = []
    for f in ranked(findings)[:ANNOTATIONS]:
        kind = "warning" if f.verdict is Verdict.INCONCLUSIVE else "error"
        title = _short(f"{f.verdict}: {f.study} / {f.case} / {f.solver} ({f.refinement})")
        file = (results / f"{f.study}.nc").as_posix()
        commands.append(f"::{kind} title={value(title)},file={value(file)}::{data(_short(f'{f.criterion}: {f.reason}'))}")
    return commands


def _short(text: str) -> str:
    """One line that every host takes."""
    plain = " ".join(text.translate(XML_FORBIDDEN).split())
    return plain if len(plain) <= CELL else f"{plain[: CELL - 3]}..."


def _bytes(text: str) -> int:
    return len(text.encode())
