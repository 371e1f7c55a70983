"""One Markdown page for a pull request: the verdict, what did not pass, what changed against the baseline, and the measured orders."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import mpmverify
from mpmverify.atomic import write_atomic
from mpmverify.convergence.verdict import Verdict, worst
from mpmverify.dataset.files import Results
from mpmverify.errors import ResultsError
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import ranked, table, tally

from .notation import DASH, interval, ladder, order
from .overview import GATES, judgements
from .reader import read
from .record import Record, Series

LIMIT = 60_000
"""Largest size of a page [bytes]; GitHub takes 65,536 characters in a comment."""
ROWS = 20
"""Largest number of rows of what did not pass, and of orders that are not folded."""
SIGNATURE = "<!-- mpmverify "
UNSAID = str.maketrans({sign: f"{sign}\u200b" for sign in "@#"})
"""An empty character behind what GitHub would take for the name of a person or the number of another pull request."""


def write(results: Results) -> Path:
    """Write the Markdown page of a results folder and return its path.

    Raises
    ------
    ResultsError
        If a study file is damaged, or a file that is no page of a report has the path of the page.
    """
    path = results.report / "report.md"
    if path.exists() and not (
        path.is_file() and SIGNATURE.startswith(path.read_bytes().decode(errors="replace")[: len(SIGNATURE)])
    ):
        raise ResultsError(f"'{path}' is not a page of an mpmverify report: move it away or choose another folder with --out")
    text = markdown([read(study) for study in results.studies()])
    write_atomic(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    return path


def markdown(records: Sequence[Record]) -> str:
    """Make the Markdown page of some studies, of at most `LIMIT` bytes; rows that do not fit are left out and counted."""
    findings = [finding for record in records for finding in record.findings]
    by_gate = {gate: [finding for finding in findings if finding.gate == gate] for gate in GATES}
    parts = [
        f"{SIGNATURE}{mpmverify.__version__} -->\n## mpmverify: {worst(finding.verdict for finding in findings)}\n",
        f"\n{sentence(findings)}\n",
        _counts(by_gate),
    ]
    origin = _origin(records)

    def room(share: float = 1.0) -> int:
        return int(share * (LIMIT - sum(len(part.encode()) for part in (*parts, origin))))

    parts.append(_not_passed("What did not pass", by_gate["verification"], "verification", room(0.5)))
    parts.append(_not_passed("What changed against the baseline", by_gate["regression"], "regression", room(0.5)))
    parts.append(_orders(records, room()))
    return "".join((*parts, origin))


def sentence(findings: Sequence[Finding]) -> str:
    """Say the verdict of all findings in one sentence."""
    count, total = Counter(finding.verdict for finding in findings), len(findings)
    if not findings:
        return "Nothing was judged."
    if count[Verdict.ERROR]:
        failed = f", and {count[Verdict.FAIL]} failed" if count[Verdict.FAIL] else ""
        return f"{count[Verdict.ERROR]} of {total} criteria ended in an error{failed}."
    if count[Verdict.FAIL]:
        return f"{count[Verdict.FAIL]} of {total} criteria failed."
    if count[Verdict.INCONCLUSIVE]:
        return f"Nothing failed, but {count[Verdict.INCONCLUSIVE]} of {total} criteria are inconclusive."
    return f"All {total} criteria passed."


def _counts(by_gate: Mapping[str, Sequence[Finding]]) -> str:
    rows = [(gate, *map(str, tally(findings).values())) for gate, findings in by_gate.items() if findings]
    return table(("gate", *tally(())), rows, "gates", LIMIT) if rows else ""


def _not_passed(heading: str, findings: Sequence[Finding], gate: str, room: int) -> str:
    """Return the section on the findings of a gate other than PASS, the worst first."""
    judged = judgements(ranked(findings), lambda _: "")
    rows = [
        (
            entry.mark.text,
            entry.study,
            entry.case,
            entry.solver,
            entry.ladder,
            ", ".join(c.title for c in entry.criteria),
            entry.reason,
        )
        for entry in judged
    ]
    head = f"\n### {heading}\n"
    if not findings:
        return f"{head}\nThe {gate} gate judged nothing.\n"
    if not rows:
        return f"{head}\nNothing: all {len(findings)} criteria of the {gate} gate passed.\n"
    columns = ("verdict", "study", "case", "solver", "ladder", "criterion", "reason")
    return head + _cells(columns, rows, "in verdicts.json", room - len(head), ROWS)


def _orders(records: Sequence[Record], room: int) -> str:
    """Return the section on the measured orders, those that did not pass first; many of them are folded."""
    found = [row for record in records for series in record.series for row in _order_rows(record.name, series)]
    if not found:
        return ""
    rows = [row for verdict in reversed(Verdict) for worth, row in found if worth is verdict]
    head, end = (
        f"\n### Measured orders\n\n<details{'' if len(rows) > ROWS else ' open'}><summary>{len(rows)} orders</summary>\n",
        "\n</details>\n",
    )
    columns = ("study", "case", "solver", "ladder", "quantity", "order", "95 % interval", "accepted", "verdict")
    return head + _cells(columns, rows, "orders", room - len(head + end)) + end


def _order_rows(study: str, series: Series) -> Iterator[tuple[Verdict, tuple[str, ...]]]:
    """Yield each judged order of a series with its verdict; the title of the criterion tells which finding is on it."""
    judged = {finding.criterion: finding for finding in series.findings if finding.gate == "verification"}
    for (quantity, norm), (low, high) in series.bands.items():
        finding, estimate = judged.get(title(quantity, norm, low, high)), series.estimates.get((quantity, norm))
        if finding:
            measured = (order(estimate.order), interval(estimate.low, estimate.high)) if estimate else (DASH, DASH)
            where = (study, series.case, series.solver, ladder(series.refinement), f"{quantity} in {norm}")
            yield finding.verdict, (*where, *measured, interval(low, high), finding.word)


def title(quantity: str, norm: str, low: float, high: float) -> str:
    """Return the title of the criterion on an order, by which its finding is found."""
    return f"order of {quantity} in {norm} in [{low:g}, {high:g}]"


def _origin(records: Sequence[Record]) -> str:
    """Return where the results come from: commits, dates, platforms and tiers of all studies."""
    attributes = [record.attributes for record in records]
    dates = sorted(str(a["date_created"]) for a in attributes)
    facts = {
        "commit": [
            a["commit"] if a["commit_state"] == "installed" else f"{a['commit']} ({a['commit_state']})" for a in attributes
        ],
        "written": [dates[0], dates[-1]] if dates else [],
        "platform": [a["platform"] for a in attributes],
        "tier": [a["tier"] for a in attributes],
        "made by": [a["source"] for a in attributes],
    }
    rows = [(name, ", ".join(dict.fromkeys(map(str, values)))) for name, values in facts.items() if values]
    return f"\n### Provenance\n{_cells(('property', 'value'), rows, 'facts', LIMIT)}"


def _cells(columns: Sequence[str], rows: Iterable[Sequence[str]], what: str, room: int, most: int | None = None) -> str:
    return table(columns, [[text.translate(UNSAID) for text in row] for row in rows], what, room, most)
