"""BibTeX of the sources: entries state what the citations state and nothing else, and no text breaks the file."""

import re
from pathlib import Path
from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_pages import Page
from sample_study import HOSTILE, store, study

from mpmverify import studies
from mpmverify.dataset.files import Results
from mpmverify.reports import render
from mpmverify.reports.bibliography import Reference, bibtex, downloadable, references
from mpmverify.reports.single import self_contained

DONEA = (
    "Donea J. (1984). A Taylor-Galerkin method for convective transport problems. International Journal for Numerical Methods in "
    "Engineering 20(1), 101-119, doi:10.1002/nme.1620200108"
)
IRONS = (
    "Irons B. M., Razzaque A. (1972). Experience with the patch test. In: Aziz A. K. (ed.), The Mathematical Foundations of the Finite "
    "Element Method, Academic Press, 557-587, doi:10.1016/B978-0-12-068650-6.50026-2"
)
GRAFF = "closed form by images as in Graff K. F. (1975). Wave Motion in Elastic Solids. Clarendon Press, Oxford, chapter 2 (d'Alembert)"


def parsed(text: str) -> dict[str, dict[str, str]]:
    """Entries of a file by key, read by a grammar of its own."""
    entries = {}
    for kind, key, body in re.findall(r"^@(\w+)\{([^,]+),\n((?:  \w+ = \{.*\},\n)*)\}$", text, re.MULTILINE):
        assert key not in entries
        entries[key] = {"kind": kind} | dict(re.findall(r"^  (\w+) = \{(.*)\},$", body, re.MULTILINE))
    assert len(entries) == text.count("\n@")
    return entries


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        (
            DONEA,
            "donea1984",
            {
                "kind": "article",
                "author": "Donea, J.",
                "title": "{A Taylor-Galerkin method for convective transport problems}",
                "journal": "International Journal for Numerical Methods in Engineering",
                "volume": "20",
                "number": "1",
                "pages": "101--119",
                "year": "1984",
                "doi": "10.1002/nme.1620200108",
            },
        ),
        (
            IRONS,
            "irons1972",
            {
                "kind": "incollection",
                "author": "Irons, B. M. and Razzaque, A.",
                "editor": "Aziz, A. K.",
                "title": "{Experience with the patch test}",
                "booktitle": "{The Mathematical Foundations of the Finite Element Method}",
                "pages": "557--587",
                "publisher": "Academic Press",
                "year": "1972",
                "doi": "10.1016/B978-0-12-068650-6.50026-2",
            },
        ),
        (
            GRAFF,
            "graff1975",
            {
                "kind": "book",
                "author": "Graff, K. F.",
                "title": "{Wave Motion in Elastic Solids}",
                "publisher": "Clarendon Press",
                "address": "Oxford",
                "year": "1975",
            },
        ),
        (
            "second order: Jiang, Schroeder and Teran (2017), doi:10.1016/j.jcp.2017.02.050",
            "jiang2017",
            {"kind": "misc", "author": "Jiang and Schroeder and Teran", "year": "2017", "doi": "10.1016/j.jcp.2017.02.050"},
        ),
        (
            "on smooth data: Mabssout and Pastor (2003), A Taylor-Galerkin algorithm, CMAME 192, 955-971",
            "mabssout2003",
            {
                "kind": "article",
                "author": "Mabssout and Pastor",
                "title": "{A Taylor-Galerkin algorithm}",
                "journal": "CMAME",
                "volume": "192",
                "pages": "955--971",
                "year": "2003",
            },
        ),
        (
            "Salari K., Knupp P. (2000). Code verification. Sandia report SAND2000-1444",
            "salari2000",
            {
                "kind": "misc",
                "author": "Salari, K. and Knupp, P.",
                "title": "{Code verification}",
                "howpublished": "Sandia report SAND2000-1444",
                "year": "2000",
            },
        ),
        (
            "de Vaucorbeil A., Nguyen V. P. (2020). A method. Some Journal 360, 112783",
            "devaucorbeil2020",
            {
                "kind": "article",
                "author": "de Vaucorbeil, A. and Nguyen, V. P.",
                "title": "{A method}",
                "journal": "Some Journal",
                "volume": "360",
                "pages": "112783",
                "year": "2020",
            },
        ),
        ("as everybody knows, doi:10.1000/182.", "source", {"kind": "misc", "doi": "10.1000/182"}),
    ],
)
def test_an_entry_states_what_its_citation_states(text: str, key: str, expected: dict[str, str]) -> None:
    assert parsed(bibtex([text])) == {key: expected}


def test_what_cannot_be_found_by_a_reader_is_named_and_has_no_entry() -> None:
    assert bibtex(["own derivation", "Newton's second law", "Hughes (1987), chapter 9", ""]) == ""
    text = bibtex([DONEA, "section 9.1; Belytschko and Mullen (1978)"])
    assert list(parsed(text)) == ["donea1984"]
    assert "% Not enough is stated of: Belytschko and Mullen (1978)\n" in text


def test_citations_of_one_source_are_merged_and_sources_of_one_year_are_not() -> None:
    brief = "von Neumann analysis: Donea (1984), doi:10.1002/nme.1620200108, with a remark"
    assert len(references([brief, DONEA, DONEA, "as Donea (1984) says"])) == 1
    assert parsed(bibtex([brief])) | parsed(bibtex([DONEA])) == parsed(bibtex([brief, DONEA]))
    other = "Donea J. (1984). Another text. Some Journal 1, 2-3"
    assert list(parsed(bibtex([DONEA, other]))) == ["donea1984", "donea1984-2"]
    held = (
        "The Finite Element Method: Hughes (1987), The Finite Element Method, section 9.1; as before Hughes (1987), chapter 9"
    )
    assert [one.fields["title"] for one in references([held])] == ["The Finite Element Method"]


def test_every_source_of_the_shipped_studies_that_has_a_doi_has_an_entry_with_its_own_authors() -> None:
    texts = []
    for name in studies.NAMES:
        declared = studies.get(name)
        texts += [case.problem.exact.citation for case in declared.cases]
        texts += [c.source for case in declared.cases for series in case.series for c in series.criteria]
    text = " ; ".join(texts)
    entries = parsed(bibtex(texts))
    dois = {doi.rstrip(".,)") if doi.count("(") < doi.count(")") else doi for doi in re.findall(r"doi:([^\s,;]+)", text)}
    assert {entry["doi"] for entry in entries.values() if "doi" in entry} == dois
    for key, entry in entries.items():
        for name in ("title", "journal", "publisher", "volume", "number"):
            assert entry.get(name, "").strip("{}").replace("\\_", "_") in text, (key, name)
        for author in entry["author"].split(" and "):
            surname = author.partition(",")[0]
            assert re.search(rf"{surname}[^;]*\({entry['year']}\)", text), key
    assert {"bardenhagen2002", "donea1984", "graff1975", "steffen2008", "wallstedt2008"} <= entries.keys()
    full = [key for key, entry in entries.items() if entry["kind"] in ("article", "incollection", "book")]
    assert len(full) >= 14


@given(st.lists(st.one_of(st.text(), st.from_regex(r"(?s)[A-Z][a-z]+ [A-Z]\. \(\d{4}\)\. .{0,40}doi:10\.1/[^ ]{1,9}"))))
def test_no_text_breaks_the_file(texts: list[str]) -> None:
    text = bibtex(texts)
    parsed(text)
    body = "\n".join(line for line in text.split("\n") if not line.startswith("%"))
    assert body.count("{") == body.count("}")
    assert all(isinstance(one, Reference) for one in references(texts))


@pytest.mark.parametrize(
    "text", ["Aa " * 20_000, "Aa B. " * 10_000, "Aa B., " * 10_000, "Aa, " * 20_000, "Aa (1999) " * 3_000, "a. " * 20_000]
)
def test_long_texts_are_read_in_time(text: str) -> None:
    bibtex([text])


def test_a_page_holds_the_file_and_shows_it(tmp_path: Path) -> None:
    results = Results(tmp_path)
    store(results, study(solvers=("good",)))
    render(results)
    for name, file in (("sample", "sample.bib"), ("problems", "problems.bib")):
        page = Page(results.report / f"{name}.html")
        (link,) = [link for link in page.links if link.startswith("data:application/x-bibtex;charset=utf-8,")]
        held = unquote(link.partition(",")[2])
        assert parsed(held)["source"]["doi"] == "10.1000/some.thing_1"
        assert held in "".join(page.text)
        assert f'download="{file}"' in (results.report / f"{name}.html").read_text(encoding="utf-8")
    alone = self_contained((results.report / "sample.html").read_text(encoding="utf-8"), results.report)
    assert 'href="data:application/x-bibtex' in alone
    assert downloadable([HOSTILE.replace("doi", "")], "x") is None
