"""Summaries of findings for machines and pull requests: JUnit XML, Markdown and annotations for GitHub."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from mpmverify.convergence.verdict import Verdict, worst
from mpmverify.errors import UsageError
from mpmverify.judgement.findings import Finding

KNOWN_LIMIT = "known limit"
"""Column of the verdicts that a scheme has a limit that is known of it."""
MARKDOWN_ROWS = 50
"""Largest number of findings listed in a summary."""
STEP_SUMMARY = 1024 * 1024
"""Largest size of the summary of one step on GitHub [bytes]; GitHub does not show a larger one at all."""
ANNOTATIONS = 10
"""Largest number of annotations of one kind that GitHub shows for one step."""
CELL = 300
"""Largest number of characters of a text in a summary or an annotation; longer texts are shortened."""
XML_FORBIDDEN = dict.fromkeys({*range(32), *range(0xD800, 0xE000), 0xFFFE, 0xFFFF} - {9, 10, 13})

MARKDOWN_ESCAPES = str.maketrans({sign: f"\\{sign}" for sign in "\\|`*_[]~$"} | {"&": "&amp;", "<": "&lt;", ">": "&gt;"})


def tally(findings: Sequence[Finding]) -> dict[str, int]:
    """Number of findings of each verdict, none left out; a PASS on a known limit of a scheme counts by itself, after other ones."""
    first, *others = map(str, Verdict)
    count = Counter(KNOWN_LIMIT if finding.word not in (first, *others) else str(finding.verdict) for finding in findings)
    return {column: count[column] for column in (first, KNOWN_LIMIT, *others)}


def by_study(findings: Sequence[Finding]) -> dict[str, list[Finding]]:
    """Findings of each study."""
    studies: dict[str, list[Finding]] = {}
    for finding in findings:
        studies.setdefault(finding.study, []).append(finding)
    return studies


def ranked(findings: Sequence[Finding]) -> list[Finding]:
    """Findings other than PASS, the worst first."""
    order = list(Verdict)
    return sorted((f for f in findings if f.verdict is not Verdict.PASS), key=lambda f: -order.index(f.verdict))


def counts(findings: Sequence[Finding]) -> str:
    """Number of findings of each verdict, the worst first, such as "3 FAIL, 2 PASS (known limit), 40 PASS"."""
    order = list(Verdict)
    count = Counter((order.index(finding.verdict), finding.word) for finding in findings)
    return ", ".join(f"{count[key]} {key[1]}" for key in sorted(count, reverse=True)) or "nothing judged"


def junit(findings: Sequence[Finding]) -> bytes:
    """JUnit XML with a test suite for each study and a test case for each finding; INCONCLUSIVE counts as skipped."""
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
    for study, mine in by_study(findings).items():
        skipped = str(
            sum(finding.verdict is Verdict.INCONCLUSIVE for finding in mine)
        )  # the schemas allow it in <testsuite> only
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
    """Markdown summary: counts, findings other than PASS with their reasons, and the counts of each study.

    Parameters
    ----------
    findings : sequence of Finding
    room : int
        Largest size in UTF-8 [bytes]. Rows that do not fit are left out, and a sentence gives their number. The summary is empty if
        not even the counts fit.
    """
    text = f"## mpmverify: {worst(f.verdict for f in findings)}\n\n{counts(findings)}.\n"
    bad = ranked(findings)
    if bad:
        rows = [(f.verdict, f"{f.study} / {f.case} / {f.solver} ({f.refinement})", f.criterion, f.reason) for f in bad]
        columns = ("verdict", "where", "criterion", "reason")
        text += table(columns, rows, "in verdicts.json", room - _bytes(text), most=MARKDOWN_ROWS)
    studies = [(study, *(str(count) for count in tally(mine).values())) for study, mine in by_study(findings).items()]
    if studies:
        text += table(("study", *tally(())), studies, "studies", room - _bytes(text))
    return text if _bytes(text) <= room else ""


def table(columns: Sequence[str], rows: Sequence[Sequence[str]], what: str, room: int, most: int | None = None) -> str:
    """Markdown table of as many of the first rows as fit into `room` bytes, and the number of rows left out; "" if not even that fits.

    Parameters
    ----------
    columns : sequence of str
    rows : sequence of sequence of str
        Texts as they are: they are shortened to `CELL` characters and escaped.
    what : str
        The rows, for the sentence on those left out.
    room : int
        Size in UTF-8 [bytes].
    most : int, optional
        Largest number of rows.
    """

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
    """GitHub workflow commands that annotate a run and its pull request with the worst findings.

    Parameters
    ----------
    findings : sequence of Finding
    results : Path
        Results folder; each annotation refers to the file of its study in it.
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
    """Text as a single line without control characters, of at most `CELL` characters."""
    plain = " ".join(text.translate(XML_FORBIDDEN).split())
    return plain if len(plain) <= CELL else f"{plain[: CELL - 3]}..."


def _bytes(text: str) -> int:
    return len(text.encode())
