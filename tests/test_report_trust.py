"""The page of the self-test: what was caught, by which study, and when there is such a page."""

import dataclasses
from pathlib import Path

import netCDF4
import pytest
from report_pages import stamps
from sample_study import FAULTS, SELF_TEST, one_solver

from mpmverify.dataset.files import Results
from mpmverify.dataset.selftest import write_selftest
from mpmverify.judgement.kill_table import Fate
from mpmverify.reports import render
from mpmverify.reports.trust_page import trust_page


@pytest.fixture
def fresh(tmp_path: Path) -> Results:
    return one_solver(tmp_path)


def test_the_trust_page_shows_what_each_study_saw_of_each_fault() -> None:
    killed = dataclasses.replace(FAULTS[0], fate=Fate.KILLED, killed_by="bar,ring", passed="deck")
    alone = dataclasses.replace(FAULTS[1], fate=Fate.KILLED, killed_by="ring", passed="bar")
    shown = trust_page(dataclasses.replace(SELF_TEST, faults=(killed, alone), every_study=True), "selftest", (), (), "")
    assert [(row.study, row.ran, row.killed, row.alone) for row in shown.studies] == [
        ("bar", "2", "1", "0"),
        ("deck", "1", "0", "0"),
        ("ring", "2", "2", "1"),
    ]
    assert [row.cells for row in shown.kills] == [("passed", "", "killed"), ("killed", "passed", "killed")]
    assert "--every-study" in shown.command
    assert trust_page(dataclasses.replace(SELF_TEST, faults=(killed, alone)), "selftest", (), (), "").kills == ()


def test_an_explained_survivor_is_not_a_failure() -> None:
    survivors = [fault for fault in FAULTS if fault.fate is Fate.SURVIVED]
    explained = tuple(dataclasses.replace(fault, explanation="it is too small") for fault in survivors)
    for faults, kind in ((tuple(survivors), "fail"), (explained, "inconclusive")):
        page = trust_page(dataclasses.replace(SELF_TEST, faults=faults), "selftest", (), (), "generator")
        assert {row.mark.kind for row in page.survivors} == {kind}
        assert all(row.mark.text.startswith("survived") for row in page.survivors)
    assert all(row.reason == "it is too small" for row in page.survivors)


def test_the_trust_page_exists_while_the_self_test_file_does(fresh: Results) -> None:
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    write_selftest(fresh.selftest, SELF_TEST)
    render(fresh)
    assert (fresh.report / "trust.html").exists()
    before = stamps(fresh)
    render(fresh)
    assert stamps(fresh) == before
    fresh.selftest.unlink()
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    assert "trust.html" not in (fresh.report / "index.html").read_text(encoding="utf-8")


def test_a_self_test_that_lacks_what_the_pages_show_is_set_aside(fresh: Results) -> None:
    write_selftest(fresh.selftest, SELF_TEST)
    with netCDF4.Dataset(fresh.selftest, "a") as file:
        file.delncattr("every_study")
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    assert fresh.selftest.with_name("selftest.nc.damaged").exists()


def test_a_damaged_self_test_is_set_aside_and_its_page_removed(fresh: Results) -> None:
    write_selftest(fresh.selftest, SELF_TEST)
    render(fresh)
    fresh.selftest.write_bytes(fresh.selftest.read_bytes()[:5000])
    render(fresh)
    assert not (fresh.report / "trust.html").exists()
    assert fresh.selftest.with_name("selftest.nc.damaged").stat().st_size == 5000
