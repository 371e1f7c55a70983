"""Verdicts for machines and for pull requests: well-formed, complete, and never rosier than the findings."""

import re
from collections import Counter
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.gate import Finding, Verdict, worst
from mpmverify.summary import MARKDOWN_ROWS, counts, junit, markdown, matrix, ranked

LIGHT = settings(max_examples=30, deadline=None)
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


@LIGHT
@given(findings())
def test_a_parser_reads_back_what_was_found(one):
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
    """Cells of a table row as GitHub splits them: a backslash takes the character behind it along."""
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
def test_no_text_breaks_a_table(several):
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


def test_what_markdown_shows_is_what_was_found():
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
def test_the_list_is_cut_where_hosts_cut_it_and_says_so(count):
    doubts = [finding(Verdict.INCONCLUSIVE, reason=f"doubt {k}") for k in range(count - 1)]
    text = markdown([*doubts, finding(Verdict.FAIL, reason="the one failure")])
    rows = tables(text)[0][2:]
    assert len(rows) == min(count, MARKDOWN_ROWS)
    assert rows[0][0] == "FAIL"
    assert ("more in verdicts.json" in text) is (count > MARKDOWN_ROWS)
    if count > MARKDOWN_ROWS:
        assert "and 7 more in verdicts.json." in text


def test_the_matrix_shows_the_worst_of_each_solver_and_study():
    several = [
        finding(Verdict.PASS),
        finding(Verdict.FAIL),
        finding(Verdict.INCONCLUSIVE, solver="fem"),
        finding(Verdict.ERROR, study="advection"),
    ]
    expected = {"tg": {"bar": Verdict.FAIL, "advection": Verdict.ERROR}, "fem": {"bar": Verdict.INCONCLUSIVE}}
    assert matrix(several) == expected
    assert tables(markdown(several))[-1] == [
        ["solver", "bar", "advection"],
        ["---"] * 3,
        ["tg", "FAIL", "ERROR"],
        ["fem", "INCONCLUSIVE", ""],
    ]


@LIGHT
@given(st.lists(findings(), max_size=12))
def test_counts_add_up(several):
    sentence = counts(several)
    assert sum(int(number) for number in re.findall(r"\d+", sentence)) == len(several)
    for verdict in Verdict:
        number = sum(f.verdict is verdict for f in several)
        assert (f"{number} {verdict}" in sentence.split(", ")) is (number > 0)


def test_nothing_judged_is_said_and_is_no_pass():
    assert counts([]) == "nothing judged"
    assert markdown([]).startswith("## mpmverify: INCONCLUSIVE\n\nnothing judged.\n")
    assert "PASS" not in markdown([])
