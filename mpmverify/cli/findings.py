"""What the command line shows of findings: a line of counts for each study as it is judged, then the findings that did not pass."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.text import Text

from mpmverify.cli.console import STYLES
from mpmverify.convergence.verdict import Verdict
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import KNOWN_LIMIT, counts, ranked, tally

if TYPE_CHECKING:
    from mpmverify.dataset.files import Results
    from mpmverify.study import Study

LISTED = 20
"""Findings listed below the table unless all are asked for."""


class StudyTable:
    """Numbers of verdicts and seconds of studies: aligned lines, each printed when its study is judged.

    Parameters
    ----------
    output : Console
    studies : sequence of str
        All studies that may come.
    timed : bool
        Whether there is a column of seconds.
    """

    def __init__(self, output: Console, studies: Sequence[str], *, timed: bool = False) -> None:
        self._output = output
        self._columns = [*tally(())] + (["seconds"] if timed else [])
        self._first = max(map(len, ("study", *studies)))
        self._begun = False

    def add(self, study: str, findings: Sequence[Finding], seconds: float | None = None) -> None:
        """Print the line of a study, with its time [s] if there is a column for it."""
        if not self._begun:  # with the first line, since there may be an error before it
            self._print("study", [Text(name) for name in self._columns], "bold")
            self._begun = True
        counted = tally(findings).items()
        cells = [Text(str(count), _style(column) if count else "dim") for column, count in counted]
        self._print(study, cells + ([] if seconds is None else [Text(f"{seconds:.1f}")]))

    def _print(self, study: str, cells: Sequence[Text], style: str = "") -> None:
        line = Text(study.ljust(self._first), style)
        for name, cell in zip(self._columns, cells, strict=True):
            line += Text(" " * (2 + max(len(name), 5) - len(cell))) + cell
        self._output.print(line, soft_wrap=True)


def _style(column: str) -> str:
    return STYLES[Verdict.PASS if column == KNOWN_LIMIT else Verdict(column)]


def show(output: Console, findings: Sequence[Finding], *, explain: bool = False) -> None:
    """Print what is no PASS (with `explain`, everything), with the reason, and the number of findings of each verdict.

    A failed run is the reason of every criterion of its series, and is printed once.
    """
    if explain:
        for finding in findings:
            _print(output, finding, str(finding))
            output.print(f"    expected by: {finding.source}", style="dim", highlight=False, markup=False)
    else:
        groups: dict[object, list[Finding]] = {}
        for finding in ranked(findings):
            alone = finding.verdict is not Verdict.ERROR
            groups.setdefault((finding.study, finding.solver, finding.reason, id(finding) if alone else 0), []).append(finding)
        for group in list(groups.values())[:LISTED]:
            first = group[0]
            cases = ", ".join(dict.fromkeys(finding.case for finding in group))
            together = f"{first.word} {first.study}/{first.solver}: {len(group)} criteria on {cases}: {first.reason}"
            _print(output, first, together if len(group) > 1 else str(first))
        if rest := sum(map(len, list(groups.values())[LISTED:])):
            output.print(f"and {rest} more: --explain shows all")
    output.print(f"{counts(findings)}.", highlight=False)


def show_diagnosis(output: Console, studies: "Sequence[Study]", findings: Sequence[Finding], results: "Results") -> None:
    """Print what errors like those of an own solver come from, if a criterion on it failed."""
    from mpmverify.dataset.study import read_study
    from mpmverify.execution.diagnosis import diagnose

    def belongs(study: str, solver: str) -> bool:
        return study.endswith(f"-with-{solver}")

    failed = [finding for finding in findings if finding.verdict is Verdict.FAIL and belongs(finding.study, finding.solver)]
    if failed:
        levels = {study.name: read_study(results.study(study.name)).levels for study in studies}
        if said := diagnose(studies, levels, failed[0].solver):
            output.print(escape(f"{failed[0].solver}: {said}."), highlight=False)


def _print(output: Console, finding: Finding, text: str) -> None:
    output.print(
        f"[{STYLES[finding.verdict]}]{finding.word}[/]", escape(text.removeprefix(finding.word).strip()), highlight=False
    )
