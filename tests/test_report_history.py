"""What changed since the run before: kept in the file of a study, said on the overview, and not lost by a run with nothing to do."""

import dataclasses
import re
from pathlib import Path

import netCDF4
import pytest
from faulty_solvers import Scripted, plan, study
from report_pages import Page
from sample_study import HOSTILE

from mpmverify.criteria import Balance, Order
from mpmverify.dataset import provenance
from mpmverify.dataset.files import Results
from mpmverify.dataset.history import BEFORE, RUN, History
from mpmverify.dataset.study import read_study_groups
from mpmverify.dataset.tree import write_groups
from mpmverify.execution.runner import run
from mpmverify.judgement.change import Change, Direction, Kind
from mpmverify.reports import render
from mpmverify.reports.reader import read
from mpmverify.reports.record import Record
from mpmverify.reports.verdict_changes import UNFOLDED, verdict_changes
from mpmverify.study import Study

DAYS = [f"2026-01-0{day}T09:05:59Z" for day in range(1, 10)]


@pytest.fixture
def judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Run studies on the day with a number, and return the sentences of the overview."""

    def judge(day: int, *studies: Study, **choices: object) -> list[str]:
        monkeypatch.setattr(provenance, "now", lambda: DAYS[day - 1])
        list(run(studies, plan(tmp_path, **choices)))
        render(Results(tmp_path))
        return sentences(tmp_path)

    return judge


def sentences(folder: Path) -> list[str]:
    page = (folder / "report" / "index.html").read_text(encoding="utf-8")
    found = re.findall(r'<p class="since">(.*?)</p>|<details class="since"[^>]*>\s*<summary>(.*?)</summary>', page)
    return [one or other for one, other in found]


def changed(folder: Path, name: str = "scripted") -> list[tuple[str, str, str | None, str | None]]:
    past = read(folder / f"{name}.nc").history
    return [(str(change.direction), change.name, change.before, change.after) for change in past.changes]


ORDER = "verification: order of u in L2 in [1.9, 2.1]"
TURNED = "1 criterion turned from PASS to FAIL."


def test_the_overview_says_what_turned_and_a_run_with_nothing_to_do_leaves_it(tmp_path: Path, judged) -> None:
    assert judged(1, study()) == [], "nothing was judged before"
    said = judged(2, study(Scripted(order=1.0)))
    assert said == [f"Since the run before (2026-01-01 09:05 UTC): {TURNED}"]
    assert changed(tmp_path) == [("worse", ORDER, "PASS", "FAIL")]
    before = (tmp_path / "scripted.nc").read_bytes()
    assert judged(3, study(Scripted(order=1.0))) == said
    assert (tmp_path / "scripted.nc").read_bytes() == before
    assert judged(4, dataclasses.replace(study(Scripted(order=1.0)), title="Another title")) == [
        "No verdict changed since the run before (2026-01-02 09:05 UTC)."
    ]
    assert judged(5, study()) == ["Since the run before (2026-01-04 09:05 UTC): 1 criterion turned from FAIL to PASS."]


def test_the_run_of_one_study_leaves_what_an_older_run_changed_in_the_others(judged) -> None:
    judged(1, study(), study(name="twin"))
    judged(2, study(Scripted(order=1.0)), study(name="twin"))
    older = f"The run of 2026-01-02 09:05 UTC, against that of 2026-01-01 09:05 UTC: {TURNED}"
    assert judged(3, dataclasses.replace(study(name="twin"), title="Twin")) == [
        "No verdict changed since the run before (2026-01-01 09:05 UTC). 1 of 2 studies was judged anew.",
        older,
    ]
    assert judged(4, study(name="third")) == ["Judged for the first time: Scripted.", older]
    assert judged(5, study()) == [
        "Since the run before (2026-01-02 09:05 UTC): 1 criterion turned from FAIL to PASS. 1 of 3 studies was judged anew."
    ]


def test_new_and_lost_criteria_are_counted(tmp_path: Path, judged) -> None:
    judged(1, study())
    other = (Order("u", "L1", 1.9, 2.1, "made so"), Order("u", "Linf", 1.9, 2.1, "made so"), Balance("mass", "", "made so"))
    said = judged(2, study(criteria=other))
    assert said == ["Since the run before (2026-01-01 09:05 UTC): 2 criteria are new, 1 is gone."]
    assert [entry[0] for entry in changed(tmp_path)] == ["lost", "new", "new"]
    page = Page(tmp_path / "report" / "index.html")
    assert any("PASS" in cell and "gone" in cell for cell in page.cells)
    assert sum("new" in cell and "PASS" in cell for cell in page.cells) == 1, "two criteria of one series share a row"


def test_a_run_of_a_part_of_a_study_has_lost_nothing(judged) -> None:
    both = study(Scripted(), Scripted("unstable", below=0.0))
    judged(1, both)
    assert judged(2, both.restricted(("scripted-good",), None)) == [
        "No verdict changed since the run before (2026-01-01 09:05 UTC)."
    ]
    assert judged(3, both) == ["No verdict changed since the run before (2026-01-02 09:05 UTC)."]


def test_a_run_that_is_tried_again_in_vain_does_not_hide_what_broke(tmp_path: Path, judged) -> None:
    """A run that failed leaves no file, so that its study is judged again by each run."""
    judged(1, study(Scripted(order=2.0)))
    said = judged(2, study(Scripted("good", order=2.0), Scripted("raises")))
    assert said == ["Since the run before (2026-01-01 09:05 UTC): 3 criteria are new."]
    assert judged(3, study(Scripted("good", order=2.0), Scripted("raises"))) == said
    assert read(tmp_path / "scripted.nc").history.run == DAYS[1]
    assert judged(4, study(Scripted("good", order=1.0), Scripted("raises"))) == [
        f"Since the run before (2026-01-02 09:05 UTC): {TURNED}"
    ]


def test_lost_verdicts_are_judged_again_and_change_nothing(tmp_path: Path, judged) -> None:
    judged(1, study())
    said = judged(2, study(Scripted(order=1.0)))
    Results(tmp_path).verdicts.unlink()
    assert judged(3, study(Scripted(order=1.0))) == said == [f"Since the run before (2026-01-01 09:05 UTC): {TURNED}"]


def as_older(path: Path) -> None:
    groups = read_study_groups(path)
    attributes = {name: value for name, value in groups["/"].attributes.items() if name not in (RUN, BEFORE)}
    write_groups(path, groups | {"/": dataclasses.replace(groups["/"], attributes=attributes)})


def as_damaged(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-400])


def with_unknown_verdict(path: Path) -> None:
    with netCDF4.Dataset(path, "a") as file:
        verdicts = file.groups["scripted-good"].variables["verdict_verdict"]
        verdicts.set_auto_chartostring(False)
        verdicts[...] = b"?"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (as_older, [f"Since the run before (2026-01-01 09:05 UTC): {TURNED}"]),
        (as_damaged, []),
        (with_unknown_verdict, []),
        (Path.unlink, []),
    ],
)
def test_an_older_file_is_compared_and_a_damaged_one_is_not(tmp_path: Path, judged, change, said: list[str]) -> None:
    judged(1, study())
    change(tmp_path / "scripted.nc")
    assert judged(2, study(Scripted(order=1.0))) == said
    assert judged(3, study()) == ["Since the run before (2026-01-02 09:05 UTC): 1 criterion turned from FAIL to PASS."]


def test_a_file_of_a_version_without_history_is_shown_as_before(tmp_path: Path, judged) -> None:
    judged(1, study())
    judged(2, study(Scripted(order=1.0)))
    as_older(tmp_path / "scripted.nc")
    assert read(tmp_path / "scripted.nc").history == History()
    assert verdict_changes([read(tmp_path / "scripted.nc")], {"scripted": {}}) == ()


def change(case: str, before: str | None, after: str | None, direction: Direction) -> Change:
    kind = Kind.VERDICT if before and after else Kind.CRITERION
    return Change(
        direction, kind, "scripted", case, "solver", "ladder", name=f"verification: {HOSTILE}", before=before, after=after
    )


def test_many_changes_are_folded_and_the_worst_is_first() -> None:
    better = [change(f"case {k}", "FAIL", "PASS", Direction.BETTER) for k in range(UNFOLDED)]
    worse = change("case", "PASS", "ERROR", Direction.WORSE)
    for changes, unfolded in ((better, True), ([*better, worse], False)):
        record = Record("scripted", {"title": "T"}, (), {}, (), history=History(DAYS[1], DAYS[0], tuple(changes)))
        (shown,) = verdict_changes([record], {"scripted": {("case", "solver"): "place"}})
        assert shown.unfolded is unfolded
        assert len(shown.rows) == len(changes)
    assert (shown.rows[0].case, shown.rows[0].href) == ("case", "scripted.html#place")
    assert {row.href for row in shown.rows[1:]} == {""}
    assert shown.sentence == (
        "Since the run before (2026-01-01 09:05 UTC): 1 criterion turned from PASS to ERROR, 6 turned from FAIL to PASS."
    )
