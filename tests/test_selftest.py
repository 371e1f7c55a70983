"""The self-test: faults by rule, trials, fates, stored results, and the output of the command."""

import ast
import dataclasses
import math
import multiprocessing.util
import subprocess
import sys
import tempfile
from collections import Counter

import netCDF4
import numpy as np
import pytest
from click.testing import CliRunner
from faulty_solvers import transported
from lone_tasks import double, why
from planted import SOURCES

from mpmverify import studies
from mpmverify.cli import cli
from mpmverify.dataset.files import Results
from mpmverify.dataset.selftest import read_selftest, write_selftest
from mpmverify.errors import DamagedError, ResultsError, UsageError
from mpmverify.exact.advection import Gaussian, advection
from mpmverify.execution.runner import Plan, run
from mpmverify.judgement.baseline import Baseline, read_baseline
from mpmverify.judgement.kill_table import Fate, PlantedFault, Rate, Rates, SelfTest, StudyKills, UnmodifiedRun
from mpmverify.problem import Discretisation
from mpmverify.selftest import processes, session
from mpmverify.selftest.fault_judge import CONTRACT, FaultJudge, deviation
from mpmverify.selftest.faults import Edit, Fault, passage
from mpmverify.selftest.named import HISTORIC, NAMED
from mpmverify.selftest.processes import each_alone
from mpmverify.selftest.reach import lines_run, reaches
from mpmverify.selftest.rules import RULES, faults, sampled
from mpmverify.selftest.survivors import EXPLAINED
from mpmverify.selftest.trials import TRIALS, Trial, merged
from mpmverify.selftest.unmodified import jittered, settings
from mpmverify.solution import Outcome, Status

TOY = '''
from typing import NamedTuple


class Nodes(NamedTuple):
    mass: Array
    momentum: Array


def spread(nodes: Nodes, a: float, b: float, dt: float) -> None:
    """Return a + b."""
    require(a > b, "a + b")
    for side in range(2):
        nodes.mass[side] = 0.0
    for i in range(3):
        nodes.momentum[i, 0] += 0.5 * dt * a - b
        nodes.mass[i] = -a
    if a < b:
        raise ValueError(f"{a + b}")
    spread(nodes, a, b, dt)


def name() -> str:
    return "a" + "b"
'''
EXPECTED = {
    "operator": {"nodes.momentum[i, 0] -= 0.5 * dt * a - b", "nodes.momentum[i, 0] += 0.5 * dt * a + b"},
    "index": {"nodes.mass[side + 1] = 0.0", "nodes.momentum[i, -1] += 0.5 * dt * a - b", "nodes.mass[i - 1] = -a"},
    "factor": {"nodes.momentum[i, 0] += 1 * dt * a - b"},
    "sign": {"nodes.mass[i] = a", "nodes.mass[i] = -(-a)"},
    "time-step": {"nodes.momentum[i, 0] += 0.5 * a - b", "nodes.momentum[i, 0] += 0.5 * (dt / 2) * a - b", "spread(nodes, a, b, (dt / 2))"},
    "term": {"nodes.momentum[i, 0] += (0.5 * dt * a)", "nodes.momentum[i, 0] += -(b)"},
    "assignment": {"pass"},
    "stale-array": {"pass"},
    "comparison": {"if a > b:"},
    "arguments": {"spread(nodes, b, a, dt)", "spread(nodes, a, dt, b)"},
    "transposed": {"nodes.momentum[0, i] += 0.5 * dt * a - b"},
    "wrong-array": {"nodes.mass[i, 0] += 0.5 * dt * a - b", "nodes.momentum[i] = -a", "nodes.momentum[side] = 0.0"},
    "boundary": {"pass", "for side in range(1):"},
}  # fmt: skip


@pytest.fixture
def toy(tmp_path):
    """Sources of one family of one file."""
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "kernel.py").write_text(TOY, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def by_rule():
    return [fault for family in TRIALS for fault in faults(SOURCES, family)]


# Faults by rule.


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_makes_the_expected_faults_in_numerical_code_only(rule, toy):
    found = {passage(fault, toy).after for fault in faults(toy, "toy") if fault.rule == rule}
    assert EXPECTED[rule] <= found
    # No fault in a call of `require`, a message, a docstring, an exception, or a function that describes the solver.
    assert not any(word in text for text in found for word in ("require", "Return", "raise", "return"))


def test_branches_of_other_dimensions_are_skipped_in_one_dimension(toy):
    path = toy / "toy" / "vectors.py"
    path.write_text(
        "def trace(A):\n    if len(A) == 1:\n        return 2 * A[0]\n    return A[0] + A[1]\n"
        "def size(A):\n    n = 0\n    if len(A) == 1:\n        n = 3 * n\n    elif len(A) == 3:\n        n = 5 * n\n    return 7 * n\n",
        encoding="utf-8",
    )
    found = {flag: {passage(fault, toy).before for fault in faults(toy, "toy", one_dimensional=flag)} for flag in (False, True)}
    dropped = {"return A[0] + A[1]", "elif len(A) == 3:", "n = 5 * n"}
    assert found[False] - found[True] == dropped
    assert found[True] < found[False]
    assert {"return 2 * A[0]", "n = 3 * n", "return 7 * n"} < found[True]


def test_the_boundary_rule_finds_loops_over_boundary_tables(toy):
    (toy / "toy" / "grid.py").write_text(
        "def hold(faces, begin, end):\n    for k in range(faces.held.shape[0]):\n        print(k)\n"
        "    for n in range(begin, end):\n        print(n)\n",
        encoding="utf-8",
    )
    (toy / "toy" / "traced.py").write_text(
        "def hold(faces, begin, end):\n    with for_range(0, faces.held.shape[0]) as k:\n        print(k)\n"
        "    with for_range(begin, end) as n:\n        print(n)\n",
        encoding="utf-8",
    )
    found = [
        fault.edits[0].new for fault in faults(toy, "toy") if fault.rule == "boundary" and "kernel" not in fault.edits[0].file
    ]
    assert found == [
        "    pass",
        "    for k in range(min(1, faces.held.shape[0])):",
        "    pass",
        "    with for_range(1, faces.held.shape[0]) as k:",
    ]


def test_the_time_step_rule_finds_the_time_step_in_a_record(toy):
    (toy / "toy" / "grid.py").write_text("def move(x, v, step):\n    return x + step.dt * v\n", encoding="utf-8")
    found = {fault.edits[0].new for fault in faults(toy, "toy") if fault.rule == "time-step" and "grid" in fault.edits[0].file}
    assert found == {"    return x + v", "    return x + (step.dt / 2) * v"}


def test_arguments_without_annotation_are_not_swapped(toy):
    (toy / "toy" / "grid.py").write_text(
        "def place(axis, x: float, scale: float):\n    return x\n\n\ndef local(a, b):\n    return place(a, b, a)\n",
        encoding="utf-8",
    )
    found = [fault.edits[0].new for fault in faults(toy, "toy") if fault.rule == "arguments" and "grid" in fault.edits[0].file]
    assert found == ["    return place(a, a, b)"]


def test_every_patch_changes_exactly_one_passage(by_rule):
    texts = {file: (SOURCES / file).read_text(encoding="utf-8") for file in {fault.edits[0].file for fault in by_rule}}
    for fault in by_rule:
        (edit,) = fault.edits
        text = texts[edit.file]
        begin, patched = edit.begin(text), edit.applied(text)
        assert patched != text
        assert patched[:begin] == text[:begin]
        assert patched[begin + len(edit.new) :] == text[begin + len(edit.old) :]
    assert len({fault.id for fault in by_rule}) == len(by_rule)


def test_every_planted_fault_is_valid_python(by_rule):
    for fault in (*NAMED, *sampled(by_rule, session.FAULTS_PER_RULE)):
        for text in fault.planted(SOURCES).values():
            ast.parse(text)


def test_the_sample_is_large_and_spread_over_families_and_rules(by_rule):
    sample = sampled(by_rule, session.FAULTS_PER_RULE)
    assert len(sample) >= 120
    count = Counter((fault.family, fault.rule) for fault in sample)
    assert max(count.values()) == session.FAULTS_PER_RULE
    assert {rule for _, rule in count} == set(RULES)
    assert all(len({rule for member, rule in count if member == family}) >= len(RULES) - 1 for family in TRIALS)


def test_the_sample_is_the_same_when_other_parts_of_a_file_change(toy):
    before = {fault.id for fault in sampled(faults(toy, "toy"), 2)}
    path = toy / "toy" / "kernel.py"
    path.write_text("import numpy as np\n" + TOY.replace('"a" + "b"', '"a" + "c"'), encoding="utf-8")
    assert {fault.id for fault in sampled(faults(toy, "toy"), 2)} == before


def test_a_named_fault_that_no_longer_fits_its_source_is_refused(toy):
    with pytest.raises(UsageError, match="0 times, not 1"):
        Fault("toy", "named", "absent passage", (Edit("toy/kernel.py", "no such passage", ""),)).planted(toy)


def test_named_faults_are_at_least_25_with_unique_names_and_ids():
    assert len(NAMED) >= 25
    assert set(HISTORIC) <= set(NAMED)
    assert len({(fault.family, fault.name) for fault in NAMED}) == len({fault.id for fault in NAMED}) == len(NAMED)


def test_every_explanation_belongs_to_an_existing_fault(by_rule):
    assert set(EXPLAINED) <= {fault.id for fault in (*NAMED, *by_rule)}


# Trials.


def test_every_trial_is_a_series_of_a_study():
    for family, trials in TRIALS.items():
        for trial in trials:
            study = trial.of(studies.get)
            assert {type(s.solver).__module__.split(".")[-2] for _, s in study.series()} == {family}
            assert study in merged([study])
    with pytest.raises(UsageError, match="does not run 'nobody'"):
        Trial("advection", "step", "nobody").of(studies.get)


def test_merged_trials_keep_every_series():
    trials = [trial.of(studies.get) for declared in TRIALS.values() for trial in declared]
    together = merged(trials)
    assert len({study.name for study in together}) == len(together)
    assert sum(len(list(study.series())) for study in together) == sum(len(list(study.series())) for study in trials)


def test_settings_differ_and_vary_processes_threads_and_seeds():
    chosen = settings(50)
    assert len({(s.jobs, s.threads, s.seed) for s in chosen if s.jitter}) == 25
    assert {s.jobs for s in chosen} == {1, 2, 3}
    assert {s.threads for s in chosen} == {1, 2, 4}


def test_jitter_moves_particles_except_under_a_dispersion_criterion():
    for declared in (Trial("dispersion", "fixed-fixed", "mpm-tl-linear-usl-flip"), TRIALS["mpm"][0]):
        study = declared.of(studies.get)
        (before, *_), (after, *_) = (list(entry.series()) for entry in (study, jittered(study, settings(2)[1])))
        moved = [level.jitter > 0 for level in after[1].refinement.levels]
        assert set(moved) == {declared.study != "dispersion"}
        assert after[1].criteria == before[1].criteria


# Fates.


def test_deviation_scales_cancelling_momenta_by_energy_and_is_infinite_for_different_shapes():
    theirs = transported(advection(Gaussian()).problem, Discretisation(0.125, 0.5), 0.0)
    assert deviation(theirs, theirs) == 0
    size = np.abs(theirs.fields["u"]).max()
    moved = dataclasses.replace(theirs, fields={"u": theirs.fields["u"] + 1e-6 * size})
    assert deviation(moved, theirs) == pytest.approx(1e-6)
    assert math.isinf(deviation(dataclasses.replace(theirs, fields={"u": theirs.fields["u"][:, 1:]}), theirs))
    assert math.isinf(deviation(dataclasses.replace(theirs, dt=1.0), theirs))
    unstable = dataclasses.replace(theirs, outcome=Outcome(Status.UNSTABLE, "at step 3"))
    later = dataclasses.replace(moved, outcome=Outcome(Status.UNSTABLE, "at step 4"), fields={"u": 9 * theirs.fields["u"][1:]})
    assert deviation(unstable, later) == 0
    assert math.isinf(deviation(unstable, theirs))
    assert math.isinf(deviation(theirs, unstable))
    # A total momentum that cancels to 1e-17 is scaled by sqrt(2 m E), not by itself.
    ones = np.ones(len(theirs.histories["time"]))
    history = dict(theirs.histories) | {"momentum": 1e-17 * ones, "kinetic_energy": 2 * ones}
    one = dataclasses.replace(theirs, histories=history)
    two = dataclasses.replace(theirs, histories=history | {"momentum": 3e-17 * ones})
    assert deviation(two, one) == pytest.approx(1e-17)


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """Results of the faults of `FATES` in the cheapest trial, by name."""
    folder = tmp_path_factory.mktemp("judge")
    trial = Trial("gehojerez-deck", "deck", "tg-lumped").of(studies.get)
    none = Baseline(folder / "none.json")
    assert list(run([trial], Plan(Results(folder), none, jobs=0)))
    judge = FaultJudge(SOURCES, (trial,), none, folder, folder, (lines_run(trial, SOURCES, folder),))
    return {name: judge.judge(Fault("taylor_galerkin", "named", "a fault", (edit,))) for name, (edit, _) in FATES.items()}


def test_a_fault_is_tried_where_its_statement_runs():
    """A statement of several lines runs where one of its lines does; a function that numba compiles, and a file, run where they are used."""
    line = (SOURCES / "mpm" / "hyperelastic.py").read_text(encoding="utf-8").split("def yeoh_energy")[0].count("\n") + 4
    inside = Fault("mpm", "named", "inside", (Edit("mpm/hyperelastic.py", "x * (second + third * x))", "x * second)"),))
    assert reaches({"mpm/hyperelastic.py": frozenset({line - 1, line, line + 1})}, inside, SOURCES)
    assert not reaches({"mpm/hyperelastic.py": frozenset({1, line - 30})}, inside, SOURCES)
    assert not reaches({"mpm/grid.py": frozenset(range(1, 300))}, inside, SOURCES)
    header = Fault(
        "mpm", "named", "header", (Edit("mpm/hyperelastic.py", "def yeoh_energy(lame: float", "def yeoh_energy(shear: float"),)
    )
    assert reaches({"mpm/hyperelastic.py": frozenset({line})}, header, SOURCES)


TG, TG_SOLVER = "taylor_galerkin/kernel.py", "taylor_galerkin/solver.py"
FATES = {
    "killed": (Edit(TG, "return U_k - 0.5 * dt", "return U_k - dt"), Fate.KILLED),
    "broken": (Edit(TG_SOLVER, "h = problem.lengths[0] / elements", "h = problem.lengths[1] / elements"), Fate.BROKEN),
    "invalid-solution": (
        Edit(TG_SOLVER, "weight=np.full((kept, elements), h)", "weight=np.full((kept, elements), 2 * h)"),
        Fate.KILLED,
    ),
    "equivalent": (Edit(TG, "0.5 * dt * (dot(A_k, slope) - S_k)", "dt * (dot(A_k, slope) - S_k) / 2"), Fate.EQUIVALENT),
    "not-exercised": (Edit(TG_SOLVER, "[[1.0, nZ], [0.5, 0.5 / nZ],", "[[1.0, nZ], [0.5, 0.7 / nZ],"), Fate.NOT_EXERCISED),
    "survived": (
        Edit(TG_SOLVER, '"strain_energy": 0.5 * square[:, 0]', '"strain_energy": 0.4 * square[:, 0]'),
        Fate.SURVIVED,
    ),
}


@pytest.mark.parametrize("name", FATES)
def test_the_fate_of_a_fault(name, judged):
    result, fate = judged[name], FATES[name][1]
    assert result.fate is fate, result
    assert (result.finding is not None) == (fate in (Fate.KILLED, Fate.BROKEN))
    assert (result.deviation > 1e-11) == (fate is Fate.SURVIVED)


def test_every_study_is_tried_after_a_kill_and_a_study_that_passes_is_named(tmp_path):
    """The strain energy that the deck survives is caught by the bar; with `every_study`, a fault that one kills runs the other."""
    deck = Trial("gehojerez-deck", "deck", "tg-lumped").of(studies.get)
    bar = Trial("driven-bar", "loaded-right", "tg-lumped").of(studies.get)
    none = Baseline(tmp_path / "none.json")
    assert len(list(run([deck, bar], Plan(Results(tmp_path), none, jobs=0)))) == 2
    lines = tuple(lines_run(trial, SOURCES, tmp_path) for trial in (deck, bar))
    survived = Fault("taylor_galerkin", "named", "survived", (FATES["survived"][0],))
    killed = Fault("taylor_galerkin", "named", "killed", (FATES["killed"][0],))
    judge = FaultJudge(SOURCES, (deck, bar), none, tmp_path, tmp_path, lines, every_study=True)
    energy, step = judge.judge(survived), judge.judge(killed)
    first = dataclasses.replace(judge, every_study=False).judge(killed)
    assert (energy.fate, energy.killed_by, energy.passed) == (Fate.KILLED, ("driven-bar",), ("gehojerez-deck",))
    assert (step.killed_by, step.passed, step.trials) == (("gehojerez-deck", "driven-bar"), (), 2)
    assert (first.killed_by, first.passed, first.trials) == (("gehojerez-deck",), (), 1)


def test_the_table_of_studies_counts_the_faults_that_one_study_alone_kills():
    killers = (("a", "b"), ("a,b", ""), ("", "a"), ("b", ""))
    rows = tuple(dataclasses.replace(FAULT, id=str(k), killed_by=by, passed=no) for k, (by, no) in enumerate(killers))
    test = SelfTest("quick", 99, rows, (RUN,), RATES, every_study=True)
    assert test.studies() == (StudyKills("a", killed=2, alone=1, ran=3), StudyKills("b", killed=2, alone=1, ran=3))
    assert dataclasses.replace(test, every_study=False).studies() == ()


def test_an_invalid_solution_is_killed_by_the_contract_and_a_solver_that_raises_does_not_run(judged):
    invalid, broken = judged["invalid-solution"], judged["broken"]
    assert (invalid.fate, invalid.finding.criterion) == (Fate.KILLED, CONTRACT)
    assert "weights sum to" in invalid.finding.reason
    assert broken.fate is Fate.BROKEN
    assert broken.finding.criterion != CONTRACT


def test_a_process_that_dies_or_hangs_takes_no_other_task_with_it():
    done = dict(each_alone(double, (1, 2, 3, 4, 6), 2, 2.0, why, ["mpmverify.errors"]))
    died, hung = "the process died with exit status 7", "no result within 2 s of processor time"
    assert done == {1: 2, 2: 4, 3: (died, False), 4: (hung, False), 6: 12}


def test_a_process_that_is_not_let_run_is_undecided(monkeypatch):
    monkeypatch.setattr(processes, "PATIENCE", 2)
    assert dict(each_alone(double, (5,), 1, 1.0, why, ["mpmverify.errors"])) == {5: ("no result within 2 s", True)}


ALONE = """
import math
from mpmverify.selftest.processes import each_alone

if __name__ == "__main__":
    print(*dict(each_alone(math.sqrt, (4.0,), 1, 60.0, lambda reason, undecided: reason, ["mpmverify.errors"])).values())
"""


def test_processes_import_what_is_installed_and_not_what_lies_in_the_working_folder(tmp_path):
    checkout, script = tmp_path / "checkout", tmp_path / "alone.py"
    (checkout / "mpmverify").mkdir(parents=True)
    (checkout / "mpmverify" / "__init__.py").write_text("raise RuntimeError('from the working folder')", encoding="utf-8")
    script.write_text(ALONE, encoding="utf-8")
    done = subprocess.run([sys.executable, script], cwd=checkout, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("2.0\n", "")


# Stored results.


FAULT = PlantedFault("mpm/term/1", "mpm", "term", "a term", "mpm/constitution.py", 3, "a + b", "a", Fate.KILLED, verdict="FAIL")
RUN = UnmodifiedRun(2, 4, 1e-4, 3, "PASS", 63)
RATE = Rate("clean", "inside", 10_000, 9_599, 301, 1, 99)
RATES = Rates((RATE,), (RATE,), (dataclasses.replace(RATE, wrong_pass=9_000),))


def self_test(*fates: Fate, runs: tuple[UnmodifiedRun, ...] = (RUN,), explanation: str = "", rates: Rates = RATES) -> SelfTest:
    rows = (dataclasses.replace(FAULT, id=str(k), fate=fate, explanation=explanation) for k, fate in enumerate(fates))
    return SelfTest("quick", 99, tuple(rows), runs, rates)


def test_a_self_test_reads_back_as_it_was_written(tmp_path):
    test = self_test(*Fate)
    write_selftest(tmp_path / "selftest.nc", test)
    assert read_selftest(tmp_path / "selftest.nc") == test
    with netCDF4.Dataset(tmp_path / "selftest.nc", "a") as file:
        file["runs/seed"][0] = 7
    with pytest.raises(DamagedError, match="selftest"):
        read_selftest(tmp_path / "selftest.nc")
    (tmp_path / "foreign.nc").write_text("no netCDF", encoding="utf-8")
    with pytest.raises(ResultsError, match=r"foreign\.nc"):
        write_selftest(tmp_path / "foreign.nc", test)


def test_a_self_test_passes_only_without_unexplained_survivors_and_false_alarms():
    assert self_test(Fate.KILLED, Fate.EQUIVALENT).passed
    assert not self_test(Fate.KILLED, Fate.SURVIVED).passed
    assert self_test(Fate.KILLED, Fate.SURVIVED, explanation="a driven bar would kill it").passed
    assert not self_test(Fate.KILLED, runs=(RUN, dataclasses.replace(RUN, verdict="FAIL"))).passed
    assert not self_test().passed
    assert not self_test(Fate.KILLED, runs=()).passed
    assert not self_test(Fate.KILLED, Fate.UNDECIDED).passed
    assert not self_test(Fate.BROKEN, Fate.EQUIVALENT).passed


@pytest.mark.parametrize("wrong", [{"wrong_pass": 10}, {"wrong_fail": 100}, {"series": 0, "wrong_pass": 0, "wrong_fail": 0}])
@pytest.mark.parametrize("subject", ["series", "designs"])
def test_a_self_test_fails_if_the_judge_is_wrong_too_often_or_was_not_measured(wrong, subject):
    rates = dataclasses.replace(RATES, **{subject: (dataclasses.replace(RATE, **wrong),)})
    assert not self_test(Fate.KILLED, rates=rates).passed
    assert not self_test(Fate.KILLED, rates=dataclasses.replace(RATES, **{subject: ()})).passed


def test_the_kill_table_counts_every_fault_once():
    table = self_test(*Fate, Fate.KILLED).table()
    assert {rule: sum(fates.values()) for rule, fates in table.items()} == {"term": len(Fate) + 1}
    assert table["term"][Fate.KILLED] == 2


# The session and the command.


@pytest.fixture(scope="module")
def small():
    """A self-test of one cheap family, two faults and one unmodified run."""
    named = tuple(Fault("taylor_galerkin", "named", name, (FATES[name][0],)) for name in ("killed", "equivalent"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session, "TRIALS", {"taylor_galerkin": (Trial("gehojerez-deck", "deck", "tg-lumped"),)})
        patch.setattr(session, "NAMED", named)
        patch.setattr(session, "UNMODIFIED_RUNS", {"quick": 1, "full": 1})
        patch.setattr(session, "RANDOM_SERIES", {"quick": 245, "full": 245})
        yield


def invoke(*arguments: str, status: int) -> str:
    result = CliRunner().invoke(cli, ["selftest", *arguments])
    assert result.exit_code == status, result.output
    return result.output


@pytest.fixture(scope="module")
def tested(small, tmp_path_factory):
    """Folder of the small self-test, and what the command printed."""
    folder = tmp_path_factory.mktemp("self-test")
    return folder, invoke("--out", str(folder), "--jobs", "2", "--explain", status=0)


def test_the_command_prints_the_kill_table_and_reuses_stored_results(tested, monkeypatch):
    folder, output = tested
    assert "0 unexplained survivors" in output
    assert "0 false alarms" in output
    assert "245 random series of known truth: 0.00% passed wrongly" in output
    assert "equivalent" in output
    page = (folder / "report" / "trust.html").read_text(encoding="utf-8")
    assert "1 of 1 planted faults that change results were caught" in " ".join(page.split()).replace('<span class="of">', "")
    assert 'href="trust.html"' in (folder / "report" / "index.html").read_text(encoding="utf-8")
    monkeypatch.setattr(session, "each_alone", lambda work, tasks, *_: iter(()) if not tasks else pytest.fail("judged again"))
    monkeypatch.setattr(session, "unmodified", lambda *_: pytest.fail("run again"))
    invoke("--out", str(folder), status=0)


def test_the_command_fails_on_a_survivor_and_on_a_false_alarm(tested, tmp_path, monkeypatch):
    survivor = Fault("taylor_galerkin", "named", "survivor", (FATES["survived"][0],))
    monkeypatch.setattr(session, "NAMED", (survivor,))
    assert "survivor" in invoke("--out", str(tested[0]), status=1)
    monkeypatch.setattr(session, "unmodified", lambda *_: dataclasses.replace(RUN, verdict="FAIL", reason="order 1"))
    output = invoke("--out", str(tmp_path), status=1)
    assert "false alarm" in output
    assert "order 1" in output


def test_a_fault_that_exceeds_its_time_limit_leaves_no_files(tested, tmp_path, monkeypatch):
    hung = Edit(TG_SOLVER, "MARGIN = 10.0", "while True:\n    pass\nMARGIN = 10.0")
    monkeypatch.setattr(session, "NAMED", (Fault("taylor_galerkin", "named", "hung", (hung,)),))
    multiprocessing.util.get_temp_dir()  # made once, before the change below: a socket path must be short
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    test = session.Session(Results(tested[0]), studies.get, SOURCES, read_baseline(studies.BASELINE), timeout=1.0).run()
    assert [(fault.fate, fault.reason) for fault in test.faults] == [(Fate.BROKEN, "no result within 1 s of processor time")]
    assert not list(tmp_path.iterdir())


def test_misuse_of_the_command_gives_one_sentence_and_status_2(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "choose another folder" in invoke("--out", str(tmp_path / "file"), status=2)
    assert "Traceback" not in invoke("--tier", "none", status=2)
