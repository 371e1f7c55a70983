"""Summaries of findings for machines and pull requests: well-formed, complete, and consistent with the findings."""

import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest
import xmlschema
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence.verdict import Verdict, worst
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import (
    ANNOTATIONS,
    CELL,
    MARKDOWN_ROWS,
    STEP_SUMMARY,
    annotations,
    by_study,
    counts,
    junit,
    markdown,
    ranked,
)

LIGHT = settings(max_examples=30)
TAGS = {Verdict.FAIL: "failure", Verdict.ERROR: "error", Verdict.INCONCLUSIVE: "skipped"}
NASTY = [
    "<script>",
    "a & b",
    "]]>",
    "\x00\x08\x1b",
    "\ud800",
    "\ufffe",
    "|",
    "\\|",
    "\\",
    "\n",
    "\r\n| PASS |",
    "\u2028",
    '"',
    "é≤",
]
TEXT = st.lists(st.sampled_from(NASTY) | st.text(max_size=8), max_size=4).map("".join)
NAMES = st.sampled_from(["bar", "advection", "a&b<c>", "x|y"])


@st.composite
def findings(draw) -> Finding:
    return Finding(
        study=draw(NAMES),
        case=draw(TEXT),
        solver=draw(NAMES),
        refinement=draw(TEXT),
        gate=draw(st.sampled_from(["verification", "regression"])),
        criterion=draw(TEXT),
        verdict=draw(st.sampled_from(list(Verdict))),
        reason=draw(TEXT),
        source=draw(TEXT),
    )


def finding(verdict=Verdict.PASS, study="bar", solver="tg", reason="order 2", **rest) -> Finding:
    values = {"case": "step", "refinement": "nu_C=0.5", "gate": "verification", "criterion": "order of u", "source": "theory"}
    return Finding(study=study, solver=solver, verdict=verdict, reason=reason, **values | rest)


# JUnit.


@LIGHT
@given(st.lists(findings(), max_size=8))
def test_junit_is_well_formed_and_its_counts_are_those_of_its_test_cases(several):
    root = ElementTree.fromstring(junit(several))
    assert (root.tag, root.get("name")) == ("testsuites", "mpmverify")
    assert [suite.tag for suite in root] == ["testsuite"] * len({f.study for f in several})
    for element in (root, *root):
        cases = list(element.iter("testcase"))
        assert int(element.get("tests")) == len(cases)
        for attribute, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            if element is not root or tag != "skipped":
                assert int(element.get(attribute)) == len(element.findall(f".//testcase/{tag}"))
        assert float(element.get("time")) == 0
    for suite in root:
        assert suite.get("name")
        for case in suite:
            assert case.tag == "testcase"
            assert set(case.attrib) == {"classname", "name", "time"}
            assert len(case) <= 1
    assert Counter(case[0].tag for case in root.iter("testcase") if len(case)) == Counter(
        TAGS[f.verdict] for f in several if f.verdict is not Verdict.PASS
    )


SCHEMA = xmlschema.XMLSchema(Path(__file__).with_name("junit.xsd"))


@LIGHT
@given(st.lists(findings(), max_size=8))
def test_junit_is_valid_by_the_schema(several):
    SCHEMA.validate(junit(several).decode())


@pytest.mark.parametrize("verdict", Verdict)
@pytest.mark.parametrize("text", ["", *NASTY, "::error::", "x" * 100_000])
def test_junit_with_special_characters_is_valid_by_the_schema(verdict, text):
    SCHEMA.validate(
        junit([finding(verdict, text, text, text, case=text, refinement=text, criterion=text, source=text)]).decode()
    )


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (r"(</?)testsuites\b", r"\1testsuite"),
        (r"(</?)failure\b", r"\1broken"),
        (r'tests="1"', 'tests="one"'),
        (r'failures="1"', ""),
        (r'time="0"', 'time="-1"'),
        (r"<testcase", '<testcase verdict="FAIL"'),
        (r'name="mpmverify"', 'skipped="0"'),
    ],
)
def test_the_schema_refuses_invalid_junit(right, wrong):
    """Without this the tests above could pass for any text. Readers of JUnit accept `skipped` in <testsuite> only."""
    text = junit([finding(Verdict.FAIL)]).decode()
    assert SCHEMA.is_valid(text)
    changed, times = re.subn(right, wrong, text)
    assert times
    assert not SCHEMA.is_valid(changed)


@LIGHT
@given(findings())
def test_a_parser_reads_back_the_finding(one):
    def legal(text):
        return re.sub("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]", "", text)

    (suite,) = ElementTree.fromstring(junit([one]))
    (case,) = suite
    assert suite.get("name") == one.study
    assert case.get("classname") == f"{one.study}.{one.solver}"
    assert case.get("name") == legal(f"{one.case} ({one.refinement}) {one.gate}: {one.criterion}")
    if one.verdict is Verdict.PASS:
        assert len(case) == 0
        return
    (child,) = case
    assert child.tag == TAGS[one.verdict]
    assert child.get("message") == legal(one.reason)
    if one.verdict is not Verdict.INCONCLUSIVE:
        assert child.get("type") == one.gate
        expected = legal(f"{one.reason}\nexpected by: {one.source}").replace("\r\n", "\n").replace("\r", "\n")
        assert child.text == expected


def test_junit_of_nothing_is_empty_and_well_formed():
    root = ElementTree.fromstring(junit([]))
    assert len(root) == 0
    assert root.get("tests") == "0"


# Markdown.


def cells(row: str) -> list[str]:
    """Cells of a table row as GitHub splits them: a backslash escapes the next character."""
    parts = re.findall(r"((?:\\.|[^|\\])*)\|", row.strip())
    assert parts[0] == ""
    return [re.sub(r"\\(.)", r"\1", part).strip() for part in parts[1:]]


def tables(text: str) -> list[list[list[str]]]:
    found: list[list[list[str]]] = [[]]
    for line in text.split("\n"):
        if line.startswith("|"):
            found[-1].append(cells(line))
        elif found[-1]:
            found.append([])
    return [table for table in found if table]


@LIGHT
@given(st.lists(findings(), min_size=1, max_size=8))
def test_special_characters_do_not_break_a_table(several):
    text = markdown(several)
    bad = [f for f in several if f.verdict is not Verdict.PASS]
    found = tables(text)
    assert len(found) == (2 if bad else 1)
    for table in found:
        assert {len(row) for row in table} == {len(table[0])}
        assert set(table[1]) == {"---"}
    assert len(found[0]) - 2 == len(bad) if bad else True
    for line in text.splitlines():
        assert line == "" or line.startswith(("|", "## mpmverify: ", counts(several)))
    assert "<" not in text
    assert ">" not in text
    assert text.startswith(f"## mpmverify: {worst(f.verdict for f in several)}\n")


def test_markdown_shows_the_findings():
    nasty = finding(Verdict.FAIL, reason="a | b \\| c \\ d\r\n<b> & e")
    (row,) = tables(markdown([nasty]))[0][2:]
    assert row == ["FAIL", "bar / step / tg (nu_C=0.5)", "order of u", "a | b \\| c \\ d &lt;b&gt; &amp; e"]


@LIGHT
@given(st.lists(findings(), max_size=8))
def test_failures_come_first_and_passes_are_not_listed(several):
    order = [Verdict.ERROR, Verdict.FAIL, Verdict.INCONCLUSIVE]
    listed = ranked(several)
    assert [f.verdict for f in listed] == sorted((f.verdict for f in several if f.verdict in order), key=order.index)
    for verdict in order:
        assert [f for f in listed if f.verdict is verdict] == [f for f in several if f.verdict is verdict]


@pytest.mark.parametrize("count", [MARKDOWN_ROWS - 1, MARKDOWN_ROWS, MARKDOWN_ROWS + 7])
def test_a_long_list_is_truncated_with_a_note(count):
    doubts = [finding(Verdict.INCONCLUSIVE, reason=f"doubt {k}") for k in range(count - 1)]
    text = markdown([*doubts, finding(Verdict.FAIL, reason="the one failure")])
    rows = tables(text)[0][2:]
    assert len(rows) == min(count, MARKDOWN_ROWS)
    assert rows[0][0] == "FAIL"
    assert ("more in verdicts.json" in text) is (count > MARKDOWN_ROWS)
    if count > MARKDOWN_ROWS:
        assert "and 7 more in verdicts.json." in text


def test_the_summary_counts_the_verdicts_of_each_study():
    several = [
        finding(Verdict.PASS),
        finding(Verdict.FAIL),
        finding(Verdict.ERROR, study="advection"),
        finding(Verdict.PASS, solver="fem", limit="known limit"),
    ]
    assert by_study(several) == {"bar": [several[0], several[1], several[3]], "advection": [several[2]]}
    assert tables(markdown(several))[-1] == [
        ["study", "PASS", "known limit", "INCONCLUSIVE", "FAIL", "ERROR"],
        ["---"] * 6,
        ["bar", "1", "1", "0", "1", "0"],
        ["advection", "0", "0", "0", "0", "1"],
    ]


@LIGHT
@given(st.lists(findings(), max_size=12))
def test_counts_add_up(several):
    sentence = counts(several)
    assert sum(int(number) for number in re.findall(r"\d+", sentence)) == len(several)
    for verdict in Verdict:
        number = sum(f.verdict is verdict for f in several)
        assert (f"{number} {verdict}" in sentence.split(", ")) is (number > 0)


def test_the_summary_without_findings_is_not_a_pass():
    assert counts([]) == "nothing judged"
    assert markdown([]).startswith("## mpmverify: INCONCLUSIVE\n\nnothing judged.\n")
    assert "PASS" not in markdown([])


# Limits of hosts.


def many(count=10_000, studies=1):
    """Return findings with long reasons of multi-byte characters."""
    verdicts = [Verdict.INCONCLUSIVE, Verdict.PASS, Verdict.FAIL, Verdict.ERROR]
    return [
        finding(verdicts[k % 4], study=f"Löser {k % studies} {'ß' * 200}", reason=f"{k} " + "größer € 𝜎 " * 500)
        for k in range(count)
    ]


@pytest.mark.parametrize("studies", [1, 10_000])
@pytest.mark.parametrize(
    "there", [0, 1000, STEP_SUMMARY - 2000, STEP_SUMMARY - 100, STEP_SUMMARY - 10, STEP_SUMMARY, STEP_SUMMARY + 1]
)
def test_a_summary_keeps_to_its_number_of_bytes(studies, there):
    several = many(studies=studies)
    text = markdown(several, STEP_SUMMARY - there)
    assert not text or there + len(text.encode()) <= STEP_SUMMARY
    if there <= STEP_SUMMARY - 100:
        assert text.startswith("## mpmverify: ERROR\n\n2500 ERROR, 2500 FAIL, 2500 INCONCLUSIVE, 2500 PASS.\n")
    if there <= STEP_SUMMARY - 2000:
        shown = [line for line in text.split("\n") if line.startswith(("| ERROR", "| FAIL", "| INCONCLUSIVE"))]
        assert f"and {7500 - len(shown)} more in verdicts.json." in text
        assert all(line.startswith("| ERROR") for line in shown), "there are more errors than rows"
        assert all(len(cell) <= CELL for line in shown for cell in cells(line))
    if there <= 1000:
        assert len(shown) == MARKDOWN_ROWS
    if studies > 1 and there <= 1000:
        assert re.search(r"\nand \d+ more studies\.\n$", text)


@LIGHT
@given(st.lists(findings(), max_size=8), st.integers(0, 3000))
def test_shown_and_omitted_rows_add_up_at_any_size(several, room):
    text = markdown(several, room)
    assert len(text.encode()) <= room
    whole = markdown(several)
    bad = ranked(several)
    if len(whole.encode()) <= room:
        assert text == whole
    elif text and bad:
        rows = [line for line in text.split("\n") if re.match(r"\| (ERROR|FAIL|INCONCLUSIVE) \|", line)]
        left = re.search(r"\nand (\d+) more in verdicts\.json\.\n", text)
        assert len(rows) + int(left[1]) == len(bad) if left else len(rows) in (0, len(bad))


# Annotations.


def read(command: str) -> tuple[str, dict[str, str], str]:
    """Read a workflow command as the runner of GitHub does."""
    kind, properties, message = re.fullmatch(r"::(\w+) (.*?)::(.*)", command).groups()

    def plain(text):
        for escape, letter in (("%0D", "\r"), ("%0A", "\n"), ("%3A", ":"), ("%2C", ","), ("%25", "%")):
            text = text.replace(escape, letter)
        return text

    return kind, {k: plain(v) for k, v in (entry.split("=", 1) for entry in properties.split(","))}, plain(message)


@LIGHT
@given(st.lists(findings(), max_size=14))
def test_annotations_are_the_ten_worst_findings(several):
    commands = annotations(several, Path("out") / "a,b: c%")
    worst_ten = ranked(several)[:ANNOTATIONS]
    assert len(commands) == len(worst_ten)
    for command, f in zip(commands, worst_ten, strict=True):
        assert len(command.splitlines()) == 1
        assert command.isprintable() or not f"{f.case}{f.refinement}{f.criterion}{f.reason}".isprintable()
        command.encode()
        kind, properties, message = read(command)
        assert kind == ("warning" if f.verdict is Verdict.INCONCLUSIVE else "error")
        assert set(properties) == {"title", "file"}
        assert properties["file"] == f"out/a,b: c%/{f.study}.nc"
        assert properties["title"].startswith(f"{f.verdict}: {f.study} /")
        assert len(properties["title"]) <= CELL
        assert len(message) <= CELL


def test_annotations_escape_special_characters():
    nasty = finding(Verdict.FAIL, reason="50 % of a: b, c\r\n::error::x", case="a, b: c%0A")
    (command,) = annotations([nasty, finding()], Path("results"))
    assert command == (
        "::error title=FAIL%3A bar / a%2C b%3A c%250A / tg (nu_C=0.5),file=results/bar.nc"
        "::order of u: 50 %25 of a: b, c ::error::x"
    )


def test_a_long_reason_is_shortened_in_an_annotation():
    (command,) = annotations([finding(Verdict.ERROR, reason="€" * 70_000)], Path("results"))
    assert command.endswith("€...")
    assert len(command.encode()) < 4096
