"""The page of a study is made in the process that judged it, from what goes into its file, and not once more."""

import dataclasses
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from faulty_solvers import Scripted, plan, study
from stored_results import MIXED

from mpmverify import cli, reports, studies
from mpmverify.dataset.files import Results
from mpmverify.errors import UsageError
from mpmverify.execution import processes
from mpmverify.execution.runner import run
from mpmverify.reports import render, render_study, site
from mpmverify.reports.reader import read, record_of


def same(one, other):
    """Whether two records hold the same, arrays bit for bit."""
    if isinstance(one, np.ndarray):
        return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if dataclasses.is_dataclass(one):
        return type(one) is type(other) and all(
            same(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one)
        )
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[name], other[name]) for name in one)
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other or (one != one and other != other)


def groups_of(results, name, groups):
    return groups


def test_what_is_written_and_what_is_read_back_make_the_same_record(tmp_path):
    (judged,) = run([MIXED], plan(tmp_path), show=groups_of)
    assert same(record_of("mixed", judged.shown), read(tmp_path / "mixed.nc"))


@pytest.mark.parametrize("jobs", [0, 2])
def test_a_page_that_is_made_is_the_one_that_render_makes_and_its_file_is_not_read(tmp_path, monkeypatch, jobs):
    results, other = Results(tmp_path), study(Scripted(order=1.0), name="other")
    judged = {entry.study: entry.shown for entry in run([study(), other], plan(tmp_path, jobs=jobs), show=render_study)}
    made = {path.name: path.read_bytes() for path in results.report.glob("*.html")}
    assert made.keys() == {"scripted.html", "other.html"}
    with monkeypatch.context() as patched:
        patched.setattr(site, "read", lambda path: pytest.fail(f"{path} is read"))
        render(results, pages=judged)
    assert {name: (results.report / name).read_bytes() for name in made} == made
    render(results, fresh=True)
    assert {name: (results.report / name).read_bytes() for name in made} == made


class Unsendable:
    """What raises another error when it is pickled than pickle does."""

    def __call__(self, *_):
        return None

    def __reduce__(self):
        raise ValueError("not to be copied")


@pytest.mark.parametrize("show", [lambda *_: None, Unsendable()], ids=["no name", "raises"])
def test_a_study_that_cannot_be_sent_to_another_process_is_judged_before_that_is_said(tmp_path, show):
    both = [study(), study(Scripted(order=1.0), name="other")]
    with pytest.raises(UsageError, match="cannot be sent to a worker process"):
        list(run(both, plan(tmp_path, jobs=2), show=show))
    assert list(tmp_path.glob("*.nc")), "a study whose runs were finished"


def test_a_file_that_changed_since_is_read_again(tmp_path):
    results = Results(tmp_path)
    (judged,) = run([study()], plan(tmp_path), show=render_study)
    list(run([dataclasses.replace(study(), title="Another title")], plan(tmp_path)))
    render(results, pages={judged.study: judged.shown})
    assert "Another title" in (results.report / "scripted.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("change", [lambda page, old: page.write_bytes(old), lambda page, old: page.unlink()])
def test_a_page_that_another_process_has_written_or_removed_is_made_again(tmp_path, change):
    results, page = Results(tmp_path), tmp_path / "report" / "scripted.html"
    (judged,) = run([study(Scripted(order=1.0))], plan(tmp_path), show=render_study)
    old = page.read_bytes()
    (judged,) = run([study()], plan(tmp_path), show=render_study)
    new = page.read_bytes()
    assert old != new
    change(page, old)
    render(results, pages={"scripted": judged.shown})
    assert page.read_bytes() == new


def test_a_page_is_not_made_of_what_another_process_has_replaced(tmp_path):
    results, page = Results(tmp_path), tmp_path / "report" / "scripted.html"
    (ours,) = run([study(Scripted(order=1.0))], plan(tmp_path), show=groups_of)
    list(run([study()], plan(tmp_path), show=render_study))
    theirs = page.read_bytes()
    assert render_study(results, "scripted", ours.shown) is None
    assert page.read_bytes() == theirs


def test_a_study_with_the_name_of_another_page_leaves_that_page_as_it_is(tmp_path):
    results = Results(tmp_path)
    list(run([study()], plan(tmp_path)))
    index = render(results)
    before = index.read_bytes()
    (judged,) = run([dataclasses.replace(study(), name="index")], plan(tmp_path), show=render_study)
    assert judged.shown is None
    assert index.read_bytes() == before


def test_a_page_that_cannot_be_made_is_an_error_of_the_report_and_not_of_the_study(tmp_path, monkeypatch):
    page = tmp_path / "report" / "scripted.html"
    page.parent.mkdir()
    page.write_text("my notes")
    monkeypatch.setitem(sys.modules, "mpmverify.studies.scripted", SimpleNamespace(STUDY=study()))
    monkeypatch.setattr(studies, "NAMES", ("scripted",))
    monkeypatch.setattr(processes, "over_processes", lambda tasks, jobs, timeout: processes.inline(tasks))
    done = CliRunner().invoke(cli.cli, ["run", "scripted", "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert "scripted.html' is not a page of an mpmverify report" in done.stderr
    assert "3 runs solved, 0 already at hand." in done.stdout
    assert page.read_text() == "my notes"


def test_an_error_of_a_page_is_left_to_the_report(tmp_path, monkeypatch):
    def breaks(*_):
        raise ZeroDivisionError("of the page")

    monkeypatch.setattr(site, "study_page", breaks)
    (judged,) = run([study()], plan(tmp_path), show=render_study)
    assert judged.shown is None
    with pytest.raises(ZeroDivisionError, match="of the page"):
        reports.render(Results(tmp_path), pages={judged.study: judged.shown})
