"""From declaration to judged study: finished runs are reused, failed runs are repeated, and a failure is a verdict."""

import dataclasses
import json
import os
import signal
import time
from functools import partial
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from faulty_solvers import BEHAVIOURS, SECOND_ORDER, Scripted, ladder, plan, study
from stored_results import tree_of

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Amplification, Balance, Order
from mpmverify.dataset.files import Results
from mpmverify.dataset.leftovers import leftovers
from mpmverify.dataset.study import read_study_groups, stored_findings
from mpmverify.errors import ResultsError, UsageError
from mpmverify.exact.advection import Gaussian, Step, advection
from mpmverify.execution import evaluation, runner
from mpmverify.execution.gate import accept, gate
from mpmverify.execution.run_keys import run_keys
from mpmverify.execution.runner import read_verdicts, run, tasks_of
from mpmverify.judgement.baseline import read_baseline
from mpmverify.problem import Discretisation
from mpmverify.solution import Status
from mpmverify.study import Case, Refinement, Series, Study, halving

LEVELS = 3


def judged_once(declared, path, **choices):
    (entry,) = run([declared], plan(path, **choices))
    return entry


def verdicts(entry, gate="verification"):
    return [finding.verdict for finding in entry.findings if finding.gate == gate]


def files(path):
    return {file.name: file.read_bytes() for file in path.rglob("*.nc")}


@pytest.fixture
def journal(tmp_path):
    """File to which the scripted solvers write one line for every run."""
    path = tmp_path / "journal"
    path.touch()
    return path


def test_two_criteria_with_different_measures_of_the_same_name_are_refused(tmp_path):
    """Otherwise both would be judged by the measure of the second."""
    modes = [Amplification(passes, 1e-12, "made so") for passes in (1, 3)]
    with pytest.raises(UsageError, match="two criteria measure 'amplification_defect' differently"):
        judged_once(study(criteria=(*SECOND_ORDER, *modes)), tmp_path)
    twice = (Balance("mass", "", "made so"), Balance("mass", "", "made so", bound=1e-3))
    assert set(verdicts(judged_once(study(criteria=twice), tmp_path))) == {Verdict.PASS}


def test_a_second_run_solves_nothing_and_writes_nothing(tmp_path, journal):
    declared = study(Scripted(journal=str(journal)))
    first = judged_once(declared, tmp_path)
    assert (first.solved, first.reused) == (LEVELS, 0)
    before = files(tmp_path)
    second = judged_once(declared, tmp_path)
    assert (second.solved, second.reused) == (0, LEVELS)
    assert second.findings == first.findings
    assert files(tmp_path) == before
    assert len(journal.read_text().splitlines()) == LEVELS


def test_the_verdicts_follow_from_the_scripted_errors(tmp_path):
    entry = judged_once(study(Scripted(order=2.0)), tmp_path)
    assert verdicts(entry) == [Verdict.PASS, Verdict.PASS]
    assert verdicts(entry, "regression") == [Verdict.INCONCLUSIVE]
    assert verdicts(judged_once(study(Scripted(order=1.0)), tmp_path / "first")) == [Verdict.FAIL, Verdict.PASS]


def test_one_changed_level_solves_one_run(tmp_path, journal):
    declared = study(Scripted(journal=str(journal)))
    judged_once(declared, tmp_path)
    case, series = next(declared.series())
    levels = (*series.refinement.levels[:2], dataclasses.replace(series.refinement.levels[2], courant=0.25))
    changed = dataclasses.replace(series, refinement=Refinement(series.refinement.label, levels, LEVELS))
    entry = judged_once(dataclasses.replace(declared, cases=(dataclasses.replace(case, series=(changed,)),)), tmp_path)
    assert (entry.solved, entry.reused) == (1, LEVELS - 1)
    assert len(journal.read_text().splitlines()) == LEVELS + 1


def test_an_added_solver_or_level_solves_its_own_runs_only(tmp_path):
    judged_once(study(Scripted()), tmp_path)
    wider = judged_once(study(Scripted(), Scripted("unstable")), tmp_path)
    assert (wider.solved, wider.reused) == (LEVELS, LEVELS)
    finer = judged_once(study(Scripted(), Scripted("unstable")), tmp_path, tier="full")
    assert (finer.solved, finer.reused) == (2, 2 * LEVELS)


def test_without_reuse_everything_is_solved(tmp_path, journal):
    declared = study(Scripted(journal=str(journal)))
    judged_once(declared, tmp_path)
    entry = judged_once(declared, tmp_path, reuse=False)
    assert (entry.solved, entry.reused) == (LEVELS, 0)
    assert len(journal.read_text().splitlines()) == 2 * LEVELS


def test_two_studies_share_their_runs(tmp_path):
    declared = study(), study(name="twin")
    first, second = run(declared, plan(tmp_path))
    assert first.solved == LEVELS
    assert second.reused == LEVELS


@pytest.mark.parametrize(
    "change",
    [
        lambda s: dataclasses.replace(s, title="Another title"),
        lambda s: study(criteria=(Order("u", "L1", 1.9, 2.1, "made so"), *SECOND_ORDER)),
    ],
    ids=["title", "criteria"],
)
def test_a_change_of_title_or_criteria_solves_nothing(tmp_path, change):
    judged_once(study(), tmp_path)
    entry = judged_once(change(study()), tmp_path)
    assert (entry.solved, entry.reused) == (0, LEVELS)
    stored = read_study_groups(tmp_path / "scripted.nc")
    assert stored_findings(stored) == entry.findings
    assert stored["/"].attributes["title"] == change(study()).title


def test_a_changed_baseline_changes_verdicts_without_solving(tmp_path):
    path = tmp_path / "baseline.json"
    before = judged_once(study(), tmp_path, baseline=read_baseline(path))
    assert verdicts(before, "regression") == [Verdict.INCONCLUSIVE]
    baseline = read_baseline(path)
    assert accept(baseline, [tmp_path / "scripted.nc"], "the first") == 1
    baseline.write()
    after = judged_once(study(), tmp_path, baseline=read_baseline(path))
    assert (after.solved, after.reused) == (0, LEVELS)
    assert verdicts(after, "regression") == [Verdict.PASS]
    worse = judged_once(study(Scripted(order=1.9)), tmp_path, baseline=read_baseline(path))
    assert verdicts(worse, "regression") == [Verdict.FAIL]
    assert verdicts(judged_once(study(), tmp_path, baseline=read_baseline(path)), "regression") == [Verdict.PASS]


def test_verdicts_json_has_every_finding_of_every_study(tmp_path):
    entries = list(run([study(), study(Scripted("raises"), name="broken")], plan(tmp_path)))
    stored = json.loads((tmp_path / "verdicts.json").read_text())
    assert stored["schema"] == 1
    assert set(stored["studies"]) == {"scripted", "broken"}
    for entry in entries:
        assert stored["studies"][entry.study]["findings"] == [dataclasses.asdict(finding) for finding in entry.findings]
    (tmp_path / "broken.nc").unlink()
    judged_once(dataclasses.replace(study(), title="t"), tmp_path)
    assert set(read_verdicts(Results(tmp_path))) == {"scripted"}, "a study whose file was deleted has no verdicts"


def test_a_missing_study_file_is_rebuilt_from_the_runs(tmp_path):
    first = judged_once(study(), tmp_path)
    (tmp_path / "scripted.nc").unlink()
    again = judged_once(study(), tmp_path)
    assert (again.solved, again.reused) == (0, LEVELS)
    assert again.findings == first.findings
    assert (tmp_path / "scripted.nc").exists()


# Failures of solvers are verdicts.

REASONS = {
    "raises": "crashed; ZeroDivisionError: a mass of [/zero] at node 3 ? (faulty_solvers.py:",
    "leaves": "crashed; SystemExit: 7 (",
    "returns-nothing": "crashed; it returned NoneType instead of a Solution",
    "nan": "non-finite; the solver reports completion, but u is not finite",
    "nan-weight": "non-finite; the solver reports completion, but weight is not finite",
    "nan-history": "non-finite; the solver reports completion, but history of mass is not finite",
    "unstable": "unstable; at step 3; the solution grew without bound: lower the Courant number",
    "unstable-at-once": "unstable; at step 0; the solution grew without bound: lower the Courant number",
    "flat-fields": "crashed; it returned an inconsistent solution: u has the shape (5, 32), expected (5, 32, 1) of 5 output times and 32 points",
    "too-few-points": "crashed; it returned an inconsistent solution: u has the shape (5, 31, 1), expected",
    "scalar-weight": "crashed; it returned an inconsistent solution: weight has the shape (), expected",
    "ragged-histories": "crashed; it returned an inconsistent solution: history of mass has the shape (2,), expected",
    "no-history": "crashed; it returned an inconsistent solution: the histories' time has the shape (0,), which must be (N + 1,)",
    "scalar-histories": "crashed; it returned an inconsistent solution: the histories' time has the shape (), which must be",
    "no-time": "crashed; it returned an inconsistent solution: the histories lack their time",
    "no-output": "crashed; it returned an inconsistent solution: time (0,) must be (T,) and reference",
    "unknown-field": "crashed; it returned an inconsistent solution: the field 'temperature' is unknown: known are u,",
    "unknown-history": "crashed; it returned the unknown history 'entropy': known are time, mass",
    "stops-early": "crashed; it reports completion, but its last output is at 0.75 s and the final time is 1 s",
    "text-fields": "crashed; it returned an inconsistent solution: u has the type <U3, and must hold real numbers",
    "complex-fields": "crashed; it returned an inconsistent solution: u has the type complex128, and must hold real",
    "masked-fields": "crashed; it returned an inconsistent solution: u is of type MaskedArray instead of numpy.ndarray",
    "masked-weight": "crashed; it returned an inconsistent solution: weight is of type MaskedArray instead of",
    "listed-fields": "crashed; it returned an inconsistent solution: u is of type list instead of numpy.ndarray",
    "tuple-of-fields": "crashed; it returned an inconsistent solution: fields is of type tuple instead of Mapping",
    "no-work": "crashed; it returned an inconsistent solution: work is of type NoneType instead of Work",
    "plane-points": "crashed; its points have 2 coordinates in 1 dimensions",
    "no-step": "crashed; its time step dt is 0.0, which is not positive and finite",
    "nan-step": "crashed; its time step dt is nan, which is not positive and finite",
    "text-step": "crashed; its time step dt is 'short', which is not positive and finite",
    "long-step": "crashed; its time step is 0.015640625 s, above the limit of 0.015625 s at the Courant number 0.5",
    "nan-work": "crashed; its work has seconds = nan, which must be finite and not negative",
    "negative-work": "crashed; its work has steps = -1, which must be finite and not negative",
    "late-outputs": "crashed; its first output is at 0.1 s instead of 0",
    "repeated-outputs": "crashed; its output times do not rise strictly",
    "late-histories": "crashed; its first history is at 0.1 s instead of 0",
    "falling-histories": "crashed; its history times do not rise strictly",
    "short-histories": "crashed; it reports completion, but its last history is at 0.99999999 s and the final time is 1 s",
    "negative-weight": "crashed; its weights are negative, down to -0.03125",
    "half-weight": "crashed; its first weights sum to 0.5, and the measure of the box is 1",
    "singular": "crashed; LinAlgError: Singular matrix (faulty_solvers.py:",
}
FINISHED = {"nan", "nan-weight", "nan-history", "unstable", "unstable-at-once"}
"""Runs that end with an outcome of the scheme, which are stored; the other failed runs are repeated."""


def test_every_scripted_failure_is_tested():
    assert REASONS.keys() | {"good", "dies", "hangs", "dawdles"} == BEHAVIOURS.keys()


@pytest.fixture(scope="module")
def failing(tmp_path_factory):
    """Study in which every solver but one fails on its finest level: folder, journal, and the entries of two runs of it."""
    path = tmp_path_factory.mktemp("failing")
    journal = path / "journal"
    declared = study(Scripted(), *(Scripted(behaviour, below=0.04, journal=str(journal)) for behaviour in REASONS))
    return path, journal, judged_once(declared, path), judged_once(declared, path)


@pytest.mark.parametrize("behaviour", REASONS)
def test_a_failure_on_the_finest_level_is_an_error_with_its_reason(failing, behaviour):
    _, journal, entry, _ = failing
    mine = [finding for finding in entry.findings if finding.solver == f"scripted-{behaviour}"]
    assert len(mine) == 3
    assert {finding.verdict for finding in mine} == {Verdict.ERROR}
    for finding in mine:
        assert f"h=0.03125: {REASONS[behaviour]}" in finding.reason
        assert "\n" not in finding.reason
    tries = journal.read_text().splitlines().count(f"scripted-{behaviour} 0.03125")
    assert tries == (1 if behaviour in FINISHED else 2)


def test_a_failure_affects_no_other_series_and_is_repeated(failing):
    path, journal, entry, again = failing
    neighbour = [f.verdict for f in entry.findings if f.solver == "scripted-good" and f.gate == "verification"]
    assert neighbour == [Verdict.PASS, Verdict.PASS]
    assert again.findings == entry.findings == stored_findings(read_study_groups(path / "scripted.nc"))
    retried = len(REASONS.keys() - FINISHED)
    assert (entry.solved, entry.reused) == (LEVELS * (len(REASONS) + 1), 0)
    assert (again.solved, again.reused) == (retried, LEVELS * (len(REASONS) + 1) - retried)
    assert not [
        line
        for line in set(journal.read_text().splitlines())
        if not line.endswith("0.03125") and journal.read_text().splitlines().count(line) > 1
    ]


def test_a_failure_on_every_level_is_an_error(tmp_path):
    entry = judged_once(study(Scripted("raises"), Scripted("unstable-at-once"), Scripted("nan")), tmp_path)
    assert {finding.verdict for finding in entry.findings} == {Verdict.ERROR}
    assert len(entry.findings) == 9


def test_a_repeated_run_that_succeeds_is_stored(tmp_path, monkeypatch):
    declared = study(Scripted("raises", below=0.04))
    assert Verdict.ERROR in verdicts(judged_once(declared, tmp_path))
    monkeypatch.setattr("faulty_solvers.BEHAVIOURS", {"raises": lambda s: s})
    again = judged_once(declared, tmp_path)
    assert (again.solved, again.reused) == (1, LEVELS - 1)
    assert verdicts(again) == [Verdict.PASS, Verdict.PASS]
    assert judged_once(declared, tmp_path).solved == 0


def test_a_measure_that_raises_is_a_verdict_error(tmp_path, monkeypatch):
    def measure(self, solution, setting):
        raise IndexError("no such history")

    monkeypatch.setattr(Balance, "measure", measure)
    entry = judged_once(study(), tmp_path)
    assert {finding.verdict for finding in entry.findings} == {Verdict.ERROR}
    assert "crashed; IndexError: no such history (test_runner.py:" in entry.findings[0].reason


def test_a_usage_error_is_raised_and_finished_runs_are_kept(tmp_path, monkeypatch):
    def refuse(_):
        raise UsageError("solver 'scripted-raises' cannot solve this")

    monkeypatch.setitem(BEHAVIOURS, "raises", refuse)
    declared = study(), study(Scripted("raises"), Scripted("nan"), name="costlier")
    with pytest.raises(UsageError, match="cannot solve this"):
        list(run(declared, plan(tmp_path)))
    assert len(list((tmp_path / "runs").iterdir())) == LEVELS
    assert [path.name for path in tmp_path.glob("*.nc")] == ["scripted.nc"]


# Damaged and foreign files.


def wrong_number(path):
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("errors", file.errors.replace("0.", "1.", 1))


DAMAGES = {
    "cut-off": lambda path: path.write_bytes(path.read_bytes()[:2000]),
    "cut-off-at-the-end": lambda path: path.write_bytes(path.read_bytes()[:-3]),
    "empty": lambda path: path.write_bytes(b""),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
}


@pytest.mark.parametrize("damage", [*DAMAGES.values(), wrong_number], ids=[*DAMAGES, "wrong-number"])
def test_a_damaged_run_is_set_aside_named_and_solved_again(tmp_path, caplog, damage):
    declared = study()
    first = judged_once(declared, tmp_path)
    path = Results(tmp_path).run(tasks_of(declared, plan(tmp_path))[1].key)
    damage(path)
    bad = path.read_bytes()
    (tmp_path / "scripted.nc").unlink()
    entry = judged_once(declared, tmp_path)
    assert (entry.solved, entry.reused, entry.findings) == (1, LEVELS - 1, first.findings)
    assert path.with_name(f"{path.name}.damaged").read_bytes() == bad
    assert caplog.messages == [f"'{path}' is damaged: it is set aside as '{path.name}.damaged'."]
    evaluation.read_run(path, path.stem)


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
@pytest.mark.parametrize("name", ["scripted.nc", "verdicts.json"])
def test_a_damaged_study_or_list_of_verdicts_is_set_aside_named_and_written_again(tmp_path, caplog, damage, name):
    first, path = judged_once(study(), tmp_path), tmp_path / name
    sound = path.read_bytes()
    damage(path)
    bad = path.read_bytes()
    entry = judged_once(study(), tmp_path)
    assert (entry.solved, entry.reused, entry.findings) == (0, LEVELS, first.findings)
    if bad != sound:  # a list of verdicts may be shorter than where it is cut off
        assert path.with_name(f"{name}.damaged").read_bytes() == bad
        assert caplog.messages == [f"'{path}' is damaged: it is set aside as '{name}.damaged'."]
    assert gate(tmp_path / "scripted.nc", plan(tmp_path).baseline) == first.findings
    assert read_verdicts(Results(tmp_path))["scripted"].findings == first.findings


def test_a_foreign_run_file_is_named_and_not_changed(tmp_path):
    declared = study()
    path = Results(tmp_path).run(tasks_of(declared, plan(tmp_path))[1].key)
    path.parent.mkdir()
    path.write_text("notes")
    for reuse in (True, False):
        with pytest.raises(ResultsError, match=path.name):
            judged_once(declared, tmp_path, reuse=reuse)
        assert path.read_text() == "notes"


def test_a_run_that_is_to_be_shown_and_of_which_too_little_was_kept_is_solved_again(tmp_path):
    declared = study()
    judged_once(declared, tmp_path)
    case, series = next(declared.series())
    coarse = Refinement(series.refinement.label, series.refinement.levels[:2], 2)
    changed = dataclasses.replace(case, series=(dataclasses.replace(series, refinement=coarse, criteria=series.criteria),))
    entry = judged_once(dataclasses.replace(declared, cases=(changed,)), tmp_path)
    assert (entry.solved, entry.reused) == (1, 1)
    assert judged_once(dataclasses.replace(declared, title="t"), tmp_path).solved == 0, "more was kept than is needed"


def test_a_foreign_study_file_is_named_before_anything_is_solved(tmp_path, journal):
    (tmp_path / "scripted.nc").write_text("my notes")
    with pytest.raises(ResultsError, match=r"scripted\.nc' is not a readable netCDF file"):
        judged_once(study(Scripted(journal=str(journal))), tmp_path)
    assert (tmp_path / "scripted.nc").read_text() == "my notes"
    assert journal.read_text() == ""


@pytest.mark.parametrize(
    "text",
    [
        "notes",
        "[]",
        "{}",
        '{"studies": 3}',
        '{"studies": {"scripted": 3}}',
        '{"studies": {"scripted": {"inputs": ""}}}',
        '{"studies": {"scripted": {"inputs": "", "findings": [{"verdict": "MAYBE"}]}}}',
        '{"studies": {"scripted": {"inputs": "", "findings": [{"verdict": "PASS"}]}}}',
        '{"studies": {"scripted": {"inputs": "", "findings": ["PASS"]}}}',
    ],
)
def test_corrupt_verdicts_are_named_and_not_changed(tmp_path, journal, text):
    (tmp_path / "verdicts.json").write_text(text)
    with pytest.raises(ResultsError, match=r"verdicts\.json' is not a list of mpmverify verdicts: delete it and run again"):
        judged_once(study(Scripted(journal=str(journal))), tmp_path)
    assert (tmp_path / "verdicts.json").read_text() == text
    assert journal.read_text() == ""


@pytest.mark.parametrize("under", ["file", "proc"])
def test_a_results_folder_that_cannot_be_written_is_named(tmp_path, under):
    (tmp_path / "file").write_text("")
    path = {"file": tmp_path / "file" / "results", "proc": Path("/proc/results")}[under]
    with pytest.raises(ResultsError, match=f"cannot write results to '{path}' .*: choose another folder with --out"):
        judged_once(study(), path)


# Declarations.


def test_progress_counts_every_run_once(tmp_path):
    calls = []
    list(run([study(), study(Scripted("raises"), name="other")], plan(tmp_path), lambda *call: calls.append(call)))
    assert calls == [(name, k, LEVELS) for name in ("scripted", "other") for k in (1, 2, 3)]


def test_the_cheapest_study_is_judged_first_and_its_longest_run_is_solved_first(tmp_path, journal):
    costly, cheap = study(Scripted(), Scripted("unstable"), name="costly"), study(Scripted(journal=str(journal)), name="cheap")
    told = []
    told.extend(
        f"{judged.study} is judged" for judged in run([costly, cheap], plan(tmp_path), lambda name, *_: told.append(name))
    )
    assert told == ["cheap"] * LEVELS + ["cheap is judged"] + ["costly"] * 2 * LEVELS + ["costly is judged"]
    sizes = [float(line.split()[1]) for line in journal.read_text().splitlines()]
    assert sizes == sorted(sizes)
    assert len(sizes) == LEVELS


def test_studies_are_judged_in_a_process_of_their_own_while_others_are_solved_and_the_last_one_here():
    processes = []

    def calls():
        yield partial(os.getpid), True
        until = time.monotonic() + 120
        while not processes:
            assert time.monotonic() < until, "nothing was judged meanwhile"
            time.sleep(0.01)
            yield None, True
        yield partial(os.getpid), False

    for process in runner._beside(calls()):
        processes.append(process)  # noqa: PERF402 - `calls` waits for the first one
    assert processes[0] != os.getpid() == processes[-1]


def refuses(_):
    raise ResultsError("the disk is full")


def dies_elsewhere(parent):
    if os.getpid() != parent:
        os._exit(3)
    return "judged here"


def raises_elsewhere(parent):
    if os.getpid() != parent:
        raise MemoryError
    return "judged here"


def test_an_error_of_judging_in_a_process_of_its_own_is_raised():
    with pytest.raises(ResultsError, match="the disk is full"):
        list(runner._beside([(partial(refuses, 0), True), (None, True), (None, False)]))


@pytest.mark.parametrize("judge", [dies_elsewhere, raises_elsewhere])
def test_what_a_process_fails_to_judge_is_judged_here(judge):
    assert list(runner._beside([(partial(judge, os.getpid()), True), (None, False)])) == ["judged here"]


def touch(path, show=None):
    path.touch()


def test_what_stops_the_runs_loses_no_study_that_was_finished(tmp_path):
    def stopped():
        yield partial(touch, tmp_path / "first"), True
        yield partial(touch, tmp_path / "second"), True
        raise UsageError("the third solver cannot take its problem")

    with pytest.raises(UsageError, match="third solver"):
        list(runner._beside(stopped()))
    assert {path.name for path in tmp_path.iterdir()} == {"first", "second"}


@dataclasses.dataclass(frozen=True)
class Refusing(Scripted):
    """Solver that cannot take the problem."""

    def solve(self, problem, discretisation):
        raise UsageError("solver 'refusing' cannot solve this")


def test_a_usage_error_of_a_later_study_in_a_worker_leaves_the_verdicts_of_the_first(tmp_path):
    chosen = plan(tmp_path, jobs=1)
    with pytest.raises(UsageError, match="cannot solve this"):
        list(run([study(), study(Scripted("nan"), Refusing(), name="costlier")], chosen))
    assert list(read_verdicts(chosen.results)) == ["scripted"]


def test_the_seconds_of_a_study_are_those_of_its_runs(tmp_path):
    slow = study(Scripted("dawdles"))
    assert judged_once(slow, tmp_path).seconds > 0.3 * LEVELS
    assert judged_once(slow, tmp_path).seconds == 0.0, "all of it was at hand"


def test_one_run_per_series_is_shown_and_it_has_few_points(tmp_path):
    tasks = tasks_of(study(Scripted(), Scripted("unstable"), levels=6), plan(tmp_path))
    shown = {task.solver.name: task.discretisation.h for task in tasks if task.shown}
    assert shown == {"scripted-good": 1 / 128, "scripted-unstable": 1 / 128}
    assert sum(task.shown for task in tasks) == 2


def test_the_keys_of_runs_are_distinct(tmp_path):
    tasks = tasks_of(study(Scripted(), Scripted("unstable")), plan(tmp_path))
    assert len({task.key for task in tasks}) == len(tasks)
    assert {len(task.key) for task in tasks} == {24}
    assert [tasks[0].key] == run_keys(tasks[0].problem, tasks[0].solver, [tasks[0].discretisation], tasks[0].criteria)


@dataclasses.dataclass(frozen=True)
class Nested(Scripted):
    title: str = "a/b"

    @property
    def name(self):
        return self.title


def test_declarations_that_cannot_be_stored_are_refused():
    with pytest.raises(UsageError, match=r"declares hill / scripted-good / nu_C=0\.5 twice"):
        study(Scripted(), Scripted())
    with pytest.raises(UsageError, match="has two solvers with the name 'same': rename one"):
        Study(
            "s",
            "t",
            "u",
            tuple(
                Case(name, advection(Gaussian()), (Series(Nested(title="same", order=order), ladder(), ()),), "u")
                for name, order in (("one", 1.0), ("two", 2.0))
            ),
        )
    for name in ("a/b", "", ".hidden"):
        with pytest.raises(UsageError, match="cannot name a file: use a name without '/'"):
            study(Nested(title=name))
        with pytest.raises(UsageError, match="cannot name a file: use a name without '/'"):
            study(name=name)


@pytest.mark.parametrize(
    ("levels", "quick"), [((), 0), ((), 1), ((Discretisation(0.5, 0.5),), -1), ((Discretisation(0.5, 0.5),), 2)]
)
def test_a_ladder_with_an_impossible_quick_tier_is_refused(levels, quick):
    with pytest.raises(UsageError, match=r"ladder 'l' has \d levels: let the quick tier run 0 to \d, not"):
        Refinement("l", levels, quick)


def test_a_tier_has_the_series_that_have_levels_in_it():
    """A study without runs would have no verdict that could fail."""
    level = Discretisation(0.5, 0.5)
    both, late = (Series(Scripted(), Refinement(label, (level,), quick), ()) for label, quick in (("both", 1), ("late", 0)))
    hill = advection(Gaussian(0.5, 0.1))
    cases = tuple(Case(name, hill, series, "u") for name, series in (("a", (both, late)), ("b", (late,))))
    declared = Study("s", "t", "u", cases)
    assert declared.in_tier("full") == declared
    assert [(case.name, series.refinement.label) for case, series in declared.in_tier("quick").series()] == [("a", "both")]
    with pytest.raises(UsageError, match="no series in the quick tier: run the full tier"):
        Study("s", "t", "u", cases[1:]).in_tier("quick")


def test_a_restricted_study_has_the_named_solvers_and_one_courant_number():
    declared = Study(
        "s", "t", "u",
        (
            Case("hill", advection(Gaussian()), tuple(Series(Scripted(), halving(1, 8, quick=2, full=3, courant=c), ()) for c in (0.5, 0.25)), "u"),
            Case("step", advection(Step()), (Series(Scripted("nan"), ladder(), ()),), "u"),
        ),
    )  # fmt: skip
    assert declared.restricted() == declared
    assert declared.restricted(tuple(declared.solvers())) == declared, "a restriction to all solvers is none"
    alone = declared.restricted(("scripted-nan",))
    assert tuple(alone.solvers()) == ("scripted-nan",)
    assert [case.name for case in alone.cases] == ["step"]
    assert alone.restricted_to == "scripted-nan"
    assert alone.restricted(courant=0.125).restricted_to == "Courant number 0.125"
    assert declared.restricted(("scripted-nan",), 0.125).restricted_to == "scripted-nan; Courant number 0.125"
    assert alone.restricted(("scripted-nan",)) == alone
    slow = declared.restricted(courant=0.125)
    assert {level.courant for _, series in slow.series() for level in series.refinement.levels} == {0.125}
    assert [len(case.series) for case in slow.cases] == [1, 1], "ladders that become equal are merged"
    assert [level.h for level in slow.cases[0].series[0].refinement.levels] == [1 / 8, 1 / 16, 1 / 32]


# Processes.


def test_one_and_two_processes_give_the_same_study(tmp_path):
    declared = study(Scripted(), Scripted("raises", below=0.04), Scripted("nan", below=0.1))
    inline, parallel = (judged_once(declared, tmp_path / str(jobs), jobs=jobs) for jobs in (0, 2))
    assert parallel.findings == inline.findings
    assert (parallel.solved, parallel.reused) == (inline.solved, inline.reused)
    here, there = (tree_of(tmp_path / str(jobs) / "scripted.nc") for jobs in (0, 2))
    assert here.groups == there.groups
    for group in here.groups:
        one, other = (tree[group].to_dataset(inherit=False).drop_vars("seconds", errors="ignore") for tree in (here, there))
        assert one.equals(other)
    differing = {name for name in here.attrs if here.attrs[name] != there.attrs[name]}
    assert differing <= {"date_created", "history", "checksum", "run_started"}
    for path in (tmp_path / "0" / "runs").iterdir():
        key = path.stem
        mine, theirs = (evaluation.read_run(Results(tmp_path / str(jobs)).run(key), key).solution for jobs in (0, 2))
        for name, values in mine.arrays().items():
            np.testing.assert_array_equal(values, theirs.arrays()[name])


def test_a_series_without_a_finished_run_does_not_affect_another_of_its_solver(tmp_path):
    solver = Scripted("raises", below=0.05)
    coarse = halving(1.0, 8, quick=2, full=2, courant=0.5)
    fine = halving(1.0, 32, quick=1, full=1, courant=0.4)
    series = tuple(Series(solver, refinement, SECOND_ORDER[1:]) for refinement in (coarse, fine))
    declared = Study("scripted", "Scripted", "One good series.", (Case("hill", advection(Gaussian(width=0.2)), series, "u"),))
    entry = judged_once(declared, tmp_path)
    assert verdicts(entry) == [Verdict.PASS, Verdict.ERROR]
    assert tree_of(Results(tmp_path).study("scripted"))["scripted-raises/histories"].sizes["shown"] == 1


@dataclasses.dataclass(frozen=True)
class Mine(Order):
    """A criterion of somebody's own."""


def named_as_a_shipped_one():
    return dataclasses.make_dataclass("Order", [], bases=(Order,), frozen=True)


@pytest.mark.parametrize("kind", [Mine, named_as_a_shipped_one()], ids=["Mine", "Order"])
def test_a_criterion_that_the_file_would_not_give_back_is_refused_before_anything_is_solved(tmp_path, kind):
    """The gate would judge the stored study by another criterion of that name, or by none."""
    declared = study(criteria=(kind("u", "L2", 1.9, 2.1, "made so"),))
    with pytest.raises(UsageError, match=f"the criterion '{kind.__name__}' of scripted/hill .* cannot be stored"):
        list(run([declared], plan(tmp_path / "results")))
    assert not (tmp_path / "results").exists()


# Killed processes.


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that share the scripted solvers")
@pytest.mark.parametrize("renamed", [False, True], ids=["before", "after"])
@pytest.mark.parametrize("file", range(1, LEVELS + 3))
def test_a_killed_run_loses_nothing_that_was_finished(tmp_path, file, renamed):
    """The process is killed when it renames one of its files: those of the runs, of the study, of the verdicts."""
    rename, calls = Path.replace, []

    def killing(temporary, target):
        calls.append(target)
        if len(calls) < file or renamed:
            rename(temporary, target)
        if len(calls) == file:
            os.kill(os.getpid(), signal.SIGKILL)

    child = os.fork()
    if not child:
        Path.replace = killing
        judged_once(study(), tmp_path)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == signal.SIGKILL
    finished = files(tmp_path / "runs")
    whole = {name: content for name, content in finished.items() if not name.startswith(".")}
    assert len(whole) == min(LEVELS, file if renamed else file - 1)
    entry = judged_once(study(), tmp_path)
    assert (entry.solved, entry.reused) == (LEVELS - len(whole), len(whole))
    assert whole.items() <= files(tmp_path / "runs").items()
    assert entry.findings == judged_once(study(), tmp_path / "undisturbed").findings
    assert set(leftovers(Results(tmp_path))) == {path for path in tmp_path.rglob(".*") if path.is_file()}, "the half of a file"


def test_a_run_that_died_after_it_wrote_its_file_is_no_error_for_ever(tmp_path, monkeypatch):
    """A process may be killed between its file and its answer, and a run that is solved anew may die beside an older file."""
    (good,) = run([study()], plan(tmp_path))
    with monkeypatch.context() as patch:
        patch.setattr(evaluation, "_solved", lambda task: evaluation.failed(task, Status.CRASHED, "killed"))
        (died,) = run([study()], plan(tmp_path, reuse=False))
    assert {finding.verdict for finding in died.findings} == {Verdict.ERROR}
    (again,) = run([study()], plan(tmp_path))
    assert (again.findings, again.solved) == (good.findings, 0)
