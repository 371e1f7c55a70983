"""The Markdown page for a pull request: complete, escaped, and small enough for a comment on GitHub."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from markdown_it.token import Token
from sample_study import HOSTILE, store, study

from mpmverify.cli import cli
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Order
from mpmverify.dataset.files import Results
from mpmverify.judgement.findings import Finding
from mpmverify.reports.markdown import LIMIT, ROWS, markdown, sentence, title
from mpmverify.reports.record import Estimate, Record, Series

NASTY = (
    "a|b",
    "a\nb",
    "<b>",
    "`x`",
    "a`",
    "*a* _b_ ~~c~~",
    "[x](y)",
    "![x](y)",
    "a\\",
    "\\|",
    "&lt;",
    "$x$",
    "</details>",
    "<!-- x",
)
ATTRIBUTES = {
    "commit": "0123456789abcdef",
    "commit_state": "clean",
    "date_created": "2020-02-02T02:02:02Z",
    "platform": "Some-Platform",
    "tier": "quick",
    "source": "mpmverify 0",
}
ORDER = "order of u in L2 in [1.8, 2.2]"


def finding(verdict: Verdict = Verdict.FAIL, name: str = "name", gate: str = "verification", **rest: str) -> Finding:
    values = {"criterion": ORDER, "reason": "order 1.2", "source": "theory", "refinement": "nu_C=0.5"} | rest
    return Finding("bar", name, name, gate=gate, verdict=verdict, **values)


def series(*findings: Finding, name: str = "name", order: float = 1.95) -> Series:
    estimate = Estimate((), (), "m", (), (), (), order, order - 0.1, order + 0.1, 0.0, "asymptotic")
    measure = ("u", "L2")
    judged = {"type": "Order", "quantity": measure[0], "norm": measure[1], "low": 1.8, "high": 2.2}
    return Series(name, name, "f", "nu_C=0.5", "h", {}, (), {measure: estimate}, {"order": judged}, findings)


def record(*several: Series, **attributes: str) -> Record:
    return Record("bar", ATTRIBUTES | attributes, (), {}, several)


def tokens(text: str) -> list[Token]:
    return MarkdownIt("commonmark").enable(["table", "strikethrough"]).parse(text)


def tables(text: str) -> list[list[list[str]]]:
    """Cells of every table of a page as a reader sees them, without the empty characters."""
    found: list[list[list[str]]] = []
    for token in tokens(text):
        if token.type == "table_open":
            found.append([])
        elif token.type == "tr_open":
            found[-1].append([])
        elif token.type == "inline" and token.level == 4:
            found[-1][-1].append("".join(child.content for child in token.children or ()).replace("\u200b", ""))
    return found


@pytest.mark.parametrize("name", [*NASTY, HOSTILE])
def test_cells_are_shown_as_they_are(name: str) -> None:
    text = markdown([record(series(finding(name=name, reason=name, criterion=name), name=name), commit=name)])
    _, failed, provenance = tables(text)
    (row,) = failed[1:]
    shown = " ".join(name.split())
    assert row == ["FAIL", "bar", shown, shown, "Courant 0.5", shown, shown]
    assert provenance[1][1].startswith(shown)
    markup = [child for token in tokens(text) for child in token.children or () if child.type not in ("text", "text_special")]
    assert not markup
    blocks = [token.content for token in tokens(text) if token.type == "html_block"]
    assert all(block.startswith("<!-- mpmverify") for block in blocks)


def test_nobody_is_called_and_no_other_pull_request_is_named() -> None:
    text = markdown([record(series(finding(reason="@someone, see #12")))])
    assert "@someone" not in text
    assert "#12" not in text
    assert "@someone, see #12" in text.replace("\u200b", "")


@given(st.lists(st.tuples(st.text(max_size=30), st.text(max_size=30), st.sampled_from(list(Verdict))), max_size=6))
def test_any_text_leaves_the_tables_whole(several: list[tuple[str, str, Verdict]]) -> None:
    judged = [series(finding(verdict, name, reason=reason), name=name) for name, reason, verdict in several]
    for table in tables(markdown([record(*judged)])):
        assert len({len(row) for row in table}) == 1


def test_a_page_of_five_thousand_failures_is_small_and_counts_what_it_leaves_out() -> None:
    long = "ü|" * 400
    judged = [
        series(
            finding(name=f"{k} {long}", reason=f"{k} {long}"),
            finding(name=f"{k} {long}", gate="regression"),
            name=f"{k} {long}",
        )
        for k in range(5000)
    ]
    for several in (judged, [series(finding(name=f"{k}", reason=f"order {k}"), name=f"{k}") for k in range(5000)]):
        text = markdown([record(*several)])
        assert len(text) <= len(text.encode()) <= LIMIT
        assert len(text.encode()) > 0.9 * LIMIT, "the room is used"
        _, failed, *_ = tables(text)
        assert 1 < len(failed) <= ROWS + 1
        assert f"and {5000 - len(failed) + 1} more" in text
        assert "0123456789abcdef" in text, "whatever is left out, not where the results come from"
        assert text.count("<details") == text.count("</details>") == 1


def test_every_failure_of_a_small_run_is_listed_the_worst_first() -> None:
    verdicts = [Verdict.PASS, Verdict.INCONCLUSIVE, Verdict.FAIL, Verdict.ERROR]
    judged = [series(finding(verdict, f"solver {verdict}"), name=f"solver {verdict}") for verdict in verdicts]
    _, failed, orders, _ = tables(markdown([record(*judged)]))
    assert [row[0] for row in failed[1:]] == ["ERROR", "FAIL", "INCONCLUSIVE"]
    assert [row[-1] for row in orders[1:]] == ["ERROR", "FAIL", "INCONCLUSIVE", "PASS"]


def test_the_orders_stand_beside_their_bands() -> None:
    text = markdown([record(series(finding(Verdict.PASS)))])
    head, row = tables(text)[1]
    assert head == ["study", "case", "solver", "ladder", "quantity", "order", "95 % interval", "accepted", "verdict"]
    assert row == ["bar", "name", "name", "Courant 0.5", "u in L2", "1.95", "[1.85, 2.05]", "[1.80, 2.20]", "PASS"]
    assert "<details open>" in text
    many = markdown([record(*(series(finding(Verdict.PASS, str(k)), name=str(k)) for k in range(ROWS + 1)))])
    assert "<details>" in many


def test_an_order_is_found_by_the_title_of_its_criterion() -> None:
    for low, high in ((1.8, 2.2), (-0.3, 1 / 3), (1, 1e-7)):
        assert title("velocity", "L2-max", low, high) == Order("velocity", "L2-max", low, high, "theory").title


def test_changes_against_the_baseline_are_listed_apart() -> None:
    rose = finding(gate="regression", criterion="errors against the accepted baseline", reason="u rose from 1 to 2")
    text = markdown([record(series(finding(Verdict.PASS), rose))])
    assert "Nothing: all 1 criteria of the verification gate passed." in text
    assert text.index("### What changed against the baseline") < text.index("u rose from 1 to 2")
    assert "The regression gate judged nothing." in markdown([record(series(finding(Verdict.PASS)))])


@pytest.mark.parametrize(
    ("verdicts", "said"),
    [
        ((), "Nothing was judged."),
        ((Verdict.PASS, Verdict.PASS), "All 2 criteria passed."),
        ((Verdict.PASS, Verdict.INCONCLUSIVE), "Nothing failed, but 1 of 2 criteria are inconclusive."),
        ((Verdict.FAIL, Verdict.INCONCLUSIVE), "1 of 2 criteria failed."),
        ((Verdict.FAIL, Verdict.ERROR), "1 of 2 criteria ended in an error, and 1 failed."),
    ],
)
def test_the_verdict_is_one_sentence(verdicts: tuple[Verdict, ...], said: str) -> None:
    assert sentence([finding(verdict) for verdict in verdicts]) == said


def report(folder: Path, *options: str) -> tuple[int, str]:
    done = CliRunner().invoke(cli, ["report", "--out", str(folder), *options])
    return done.exit_code, done.output


def test_the_command_writes_the_page_and_says_where(tmp_path: Path) -> None:
    results = Results(tmp_path)
    findings = store(results, study())
    page = results.report / "report.md"
    assert report(tmp_path, "--format", "md") == (0, f"Report: {page}\n")
    assert not (results.report / "index.html").exists()
    first = page.read_text(encoding="utf-8")
    assert "## mpmverify: ERROR" in first
    assert all(shown in first for shown in ("crashed", "bad", "good"))
    assert f"of {len(findings)} criteria ended in an error" in first
    page.write_text(first[:100], encoding="utf-8")
    assert report(tmp_path, "--format", "md")[0] == 0
    assert page.read_text(encoding="utf-8") == first
    assert report(tmp_path) == (0, f"Report: {results.report / 'index.html'}\n")
    assert page.exists()


def test_the_command_refuses_what_it_cannot_use(tmp_path: Path) -> None:
    status, said = report(tmp_path, "--format", "md")
    assert (status, said.count("\n")) == (2, 1)
    assert "run `mpmverify run" in said
    results = Results(tmp_path)
    store(results, study(solvers=("good",)))
    page = results.report / "report.md"
    page.parent.mkdir()
    page.write_text("my notes", encoding="utf-8")
    status, said = report(tmp_path, "--format", "md")
    assert (status, said.count("\n")) == (2, 1)
    assert "report.md' is not a page of an mpmverify report" in said
    assert page.read_text(encoding="utf-8") == "my notes"
    assert report(tmp_path, "--format", "doc")[0] == 2
