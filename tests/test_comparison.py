"""Comparison of two results folders: every kind of change is reported once with its direction, and nothing else is."""

import dataclasses
import math
import re
import shutil
from collections import Counter

import netCDF4
import pytest
from click.testing import CliRunner
from faulty_solvers import SECOND_ORDER, Scripted, plan, study
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify import cli
from mpmverify.cli import comparison as display
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Balance, Order
from mpmverify.criteria.norms import NORMS
from mpmverify.dataset.files import Results
from mpmverify.dataset.tables import read_tables
from mpmverify.errors import ResultsError
from mpmverify.execution.gate import accept
from mpmverify.execution.runner import run
from mpmverify.judgement.baseline import NOISE, RELATIVE, Baseline
from mpmverify.judgement.change import Change, Direction, Kind
from mpmverify.judgement.comparison import SECONDS, SLOWER, Comparison, compare
from mpmverify.judgement.tables import PROVENANCE, Run, SeriesKey, Tables
from mpmverify.judgement.tables import Order as Fitted
from mpmverify.problem import Discretisation, Problem
from mpmverify.solution import Solution

LIGHT = settings(max_examples=60)
LEVELS = 3


@dataclasses.dataclass(frozen=True)
class CostlySolver(Scripted):
    """Solver with a given number of steps, time and factor of its error."""

    steps: int = 1
    seconds: float = 0.25
    factor: float = 1.0

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        good = super().solve(problem, discretisation)
        exact = good.fields["u"] - discretisation.h**self.order
        work = dataclasses.replace(good.work, steps=good.work.steps * self.steps, seconds=self.seconds)
        return dataclasses.replace(good, work=work, fields={"u": exact + self.factor * discretisation.h**self.order})


def stored(path, *declared, **choices) -> Tables:
    list(run(declared, plan(path, **choices)))
    return read_tables(Results(path).studies())


def counts(comparison: Comparison) -> Counter:
    return Counter((str(change.direction), str(change.kind)) for change in comparison.changes)


def mirrored(comparison: Comparison) -> Counter:
    return Counter(
        repr(dataclasses.replace(c, direction=c.direction.opposite, before=c.after, after=c.before)) for c in comparison.changes
    )


def listed(comparison: Comparison) -> Counter:
    return Counter(map(repr, comparison.changes))


NORMS_OF_U = LEVELS * len(NORMS)
UNFINISHED = Scripted("unstable", below=0.04)
"""Fails on the finest of its three levels; with `below` 0, a solver of the same name does not fail."""
FINISHED = dataclasses.replace(UNFINISHED, below=0.0)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        # First instead of second order: every error, the orders and the verdict are worse.
        (
            study(CostlySolver()),
            study(CostlySolver(order=1.0)),
            {("worse", "verdict"): 1, ("worse", "error"): NORMS_OF_U, ("worse", "order"): len(NORMS)},
        ),
        # A constant factor leaves the order unchanged.
        (study(CostlySolver()), study(CostlySolver(factor=1.02)), {("worse", "error"): NORMS_OF_U}),
        (study(CostlySolver()), study(CostlySolver(factor=1 + 0.5 * RELATIVE)), {}),
        # A failed run changes all verdicts on its series: two of verification, one of regression.
        (study(FINISHED), study(UNFINISHED), {("worse", "outcome"): 1, ("worse", "verdict"): 3}),
        # Changed steps are reported once, and point-steps not in addition.
        (study(CostlySolver()), study(CostlySolver(steps=3)), {("slower", "steps"): LEVELS}),
        (study(CostlySolver()), study(CostlySolver(seconds=0.5)), {("slower", "seconds"): 1}),
        (study(CostlySolver()), study(CostlySolver(seconds=0.25 * 1.2)), {}),
        (study(CostlySolver(seconds=SECONDS / 30)), study(CostlySolver(seconds=SECONDS / 6)), {}),
        (study(CostlySolver(seconds=SECONDS / 30)), study(CostlySolver(seconds=1.0)), {("slower", "seconds"): 1}),
        # Missing parts: only the largest missing part is reported.
        (study(CostlySolver(), FINISHED), study(CostlySolver()), {("lost", "solver"): 1}),
        (study(levels=4), study(), {("lost", "level"): 1}),
        (study(criteria=SECOND_ORDER), study(criteria=SECOND_ORDER[:1]), {("lost", "criterion"): 1}),
        # A changed band makes another criterion: the old one is lost and a new one appears.
        (
            study(criteria=(Order("u", "L2", 1.9, 2.1, "theory"),)),
            study(criteria=(Order("u", "L2", 1.0, 2.1, "theory"),)),
            {("lost", "criterion"): 1, ("new", "criterion"): 1},
        ),
        (study(), study().restricted(courant=0.25), {("lost", "ladder"): 1, ("new", "ladder"): 1}),
        (
            study(),
            dataclasses.replace(study(), cases=(dataclasses.replace(study().cases[0], name="other"),)),
            {("lost", "case"): 1, ("new", "case"): 1},
        ),
        (study(), study(name="another"), {("lost", "study"): 1, ("new", "study"): 1}),
    ],
)
def test_each_kind_of_change_is_counted_with_its_direction_both_ways(tmp_path, before, after, expected):
    a, b = stored(tmp_path / "a", before), stored(tmp_path / "b", after)
    there, back = compare(a, b), compare(b, a)
    assert counts(there) == expected
    assert listed(back) == mirrored(there)
    assert there.exit_status == any(direction in ("worse", "lost") for direction, _ in expected)
    assert compare(a, a).changes == compare(b, b).changes == ()


def test_a_series_of_the_baseline_that_was_not_run_is_lost_and_not_worse(tmp_path):
    whole, known = study(CostlySolver(), FINISHED), Baseline(tmp_path / "baseline.json")
    stored(tmp_path, whole)
    accept(known, Results(tmp_path).studies(), "the first")
    known.write()
    a = stored(tmp_path / "a", whole, baseline=known)
    b = stored(tmp_path / "b", whole.restricted((CostlySolver().name,)), baseline=known)
    assert counts(compare(a, b)) == {("lost", "solver"): 1}


def test_a_change_says_where_it_is_and_how_large(tmp_path):
    a, b = stored(tmp_path / "a", study(CostlySolver())), stored(tmp_path / "b", study(CostlySolver(factor=3.0)))
    for change in compare(a, b).changes:
        assert (change.study, change.case, change.solver) == ("scripted", "hill", "scripted-good")
        assert (change.refinement, change.name.split()[0]) == ("nu_C=0.5", "u")
        assert change.level in {f"h={1 / cells:g} nu_C=0.5 ppc=1" for cells in (8, 16, 32)}
        assert change.after == pytest.approx(3 * change.before)
        assert change.size == pytest.approx(math.log(3))


def test_regression_verdicts_of_a_study_are_grouped(tmp_path):
    """Accepting a baseline improves the regression verdicts of all series; they are displayed as one change."""
    a = stored(tmp_path / "a", study(CostlySolver(), FINISHED))
    keys = [key for key in a.verdicts if key[1].startswith("regression")]
    assert len(keys) == 2
    b = dataclasses.replace(a, verdicts=dict(a.verdicts) | dict.fromkeys(keys, Verdict.PASS))
    comparison = compare(a, b)
    assert counts(comparison) == {("better", "verdict"): 2}
    assert [count for _, count in comparison.grouped()] == [2]


# Properties over tables of all kinds.


SERIES = st.builds(SeriesKey, st.sampled_from("st"), st.sampled_from("cd"), st.sampled_from("xy"), st.sampled_from("r"))
RUNS = st.builds(
    Run,
    st.sampled_from(["completed", "completed", "unstable", "timed out"]),
    st.integers(0, 3),
    st.integers(0, 3),
    st.sampled_from([0.0, 0.001, 0.008, 0.0125, 0.01, 1.0, 1.25, 1.26, 3.0]),
)
NUMBERS = st.sampled_from([0.0, 1e-13, 2e-11, 1.0, 1.0099, 1.01, 1.0101, 1.0102, 5.0, math.nan, math.inf])
INTERVALS = st.tuples(st.sampled_from([1.0, 1.5, 2.0, 2.2]), st.sampled_from([0.0, 0.1, 0.3, math.inf]))
PAST = st.fixed_dictionaries({name: st.sampled_from(["one, two 1", "one, two 2"]) for name in PROVENANCE})


@st.composite
def tables(draw) -> Tables:
    runs = draw(st.dictionaries(st.tuples(SERIES, st.sampled_from(["h=1", "h=2"])), RUNS, max_size=8))
    errors = {
        (*key, name): (draw(NUMBERS), draw(st.sampled_from([0.0, 1.0])))
        for key, of in runs.items()
        if of.outcome == "completed"
        for name in draw(st.sets(st.sampled_from(["u L2", "v L2"])))
    }
    series = sorted({key for key, _ in runs})
    orders = {
        (key, "u L2"): Fitted(p, p - by, p + by, frozenset(level for of, level in runs if of == key))
        for key in series
        for p, by in [draw(INTERVALS)]
    }
    verdicts = {
        (key, name): draw(st.sampled_from(list(Verdict))) for key in series for name in draw(st.sets(st.sampled_from("kl")))
    }
    return Tables({key.study: draw(PAST) for key in series}, runs, errors, orders, verdicts)


@LIGHT
@given(tables(), tables())
def test_swapping_the_folders_only_swaps_the_directions(a, b):
    there, back = compare(a, b), compare(b, a)
    assert listed(back) == mirrored(there)
    assert (there.before, there.after, there.compared) == (back.after, back.before, back.compared)


@LIGHT
@given(tables())
def test_a_folder_compared_with_itself_shows_no_difference(a):
    comparison = compare(a, a)
    assert comparison.changes == ()
    assert comparison.exit_status == 0
    assert comparison.compared["runs"] == len(a.runs)


@LIGHT
@given(tables(), tables())
def test_missing_entries_are_reported_once_by_the_largest_missing_part(a, b):
    lost = [c for c in compare(a, b).changes if c.direction is Direction.LOST and c.kind not in (Kind.CRITERION, Kind.NORM)]
    for series, level in a.runs:
        of = dataclasses.asdict(Change(Direction.LOST, Kind.LEVEL, *series, level))
        covering = [c for c in lost if all(getattr(c, n) in ("", of[n]) for n in (*SeriesKey._fields, "level"))]
        assert bool(covering) is ((series, level) not in b.runs)
    for change in lost:
        parts = [n for n in (*SeriesKey._fields, "level") if getattr(change, n)]
        assert not [key for key in b.runs if all({**key[0]._asdict(), "level": key[1]}[n] == getattr(change, n) for n in parts)]


@LIGHT
@given(tables(), tables())
def test_changes_are_sorted_worst_first_and_non_finite_errors_are_worse(a, b):
    comparison = compare(a, b)
    order = list(Direction)
    ranks = [order.index(change.direction) for change in comparison.changes]
    assert ranks == sorted(ranks)
    assert sum(count for _, count in comparison.grouped()) == len(comparison.changes)
    for change in comparison.changes:
        if change.kind is Kind.ERROR and not math.isfinite(change.after):
            assert change.direction is Direction.WORSE
            assert math.isfinite(change.before)


@LIGHT
@given(st.floats(1, 3), st.floats(0.001, 0.5), st.floats(1, 3), st.floats(0.001, 0.5), st.booleans(), st.booleans())
def test_an_order_changes_if_an_error_changed_and_intervals_over_the_same_levels_do_not_overlap(
    p, by, q, about, alike, changed
):
    series, name = SeriesKey("s", "c", "x", "r"), "u L2"

    def folder(order, width, error, levels):
        runs = {(series, level): Run("completed", 1, 1, 1.0) for level in levels}
        fit = Fitted(order, order - width, order + width, frozenset(levels))
        return Tables({}, runs, {(series, "h=1", name): (error, 1.0)}, {(series, name): fit}, {})

    before = folder(p, by, 0.1, ("h=1", "h=2"))
    after = folder(q, about, 0.2 if changed else 0.1, ("h=1", "h=2") if alike else ("h=1", "h=2", "h=4"))
    orders = [change for change in compare(before, after).changes if change.kind is Kind.ORDER]
    apart = p + by < q - about or q + about < p - by
    assert len(orders) == (apart and alike and changed)
    for change in orders:
        assert change.direction is (Direction.BETTER if q > p else Direction.WORSE)
        assert change.size == pytest.approx(abs(p - q))


@LIGHT
@given(st.floats(0, 1), st.floats(0, 1), st.sampled_from([0.0, 1.0, 1e6]))
def test_errors_are_compared_by_the_rule_of_the_regression_gate(then, now, size):
    key = (SeriesKey("s", "c", "x", "r"), "h=1")
    before, after = (
        Tables({}, {key: Run("completed", 1, 1, 1.0)}, {(*key, "u L2"): (error, size)}, {}, {}) for error in (then, now)
    )
    changes = compare(before, after).changes
    noise = NOISE * (size or 1.0)
    assert bool(changes) is (max(then, now) > min(then, now) * (1 + RELATIVE) + noise)
    assert {change.direction for change in changes} <= {Direction.WORSE if now > then else Direction.BETTER}


def with_error(error, size):
    key = (SeriesKey("s", "c", "x", "r"), "h=1")
    return Tables({}, {key: Run("completed", 1, 1, 1.0)}, {(*key, "u L2"): (error, size)}, {}, {})


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_non_finite_error_is_worse_than_every_finite_one(bad):
    there = compare(with_error(1e9, 1.0), with_error(bad, 1.0))
    assert counts(there) == {("worse", "error"): 1}
    assert there.exit_status == 1
    assert counts(compare(with_error(bad, 1.0), with_error(1e9, 1.0))) == {("better", "error"): 1}
    assert compare(with_error(bad, 1.0), with_error(math.nan, 1.0)).changes == ()


def test_an_incomplete_run_is_not_faster():
    key = (SeriesKey("s", "c", "x", "r"), "h=1")
    before, after = (Tables({}, {key: of}, {}, {}, {}) for of in (Run("completed", 9, 9, 9.0), Run("unstable", 1, 1, 1.0)))
    assert counts(compare(before, after)) == {("worse", "outcome"): 1}


def test_round_off_is_relative_to_the_larger_exact_norm():
    small, large = with_error(0.0, 1e-3), with_error(5e-8, 1e4)
    assert compare(small, large).changes == compare(large, small).changes == ()


@given(st.lists(st.floats(1, 100), min_size=1, max_size=9), st.floats(0.1, 10))
def test_a_solver_is_slower_if_all_seconds_grow_beyond_the_ratio(seconds, ratio):
    def timed(by):
        series = SeriesKey("s", "c", "x", "r")
        return Tables({}, {(series, f"h={k}"): Run("completed", 1, 1, s * by) for k, s in enumerate(seconds)}, {}, {}, {})

    directions = [change.direction for change in compare(timed(1.0), timed(ratio)).changes]
    if ratio > SLOWER * 1.001:
        assert directions == [Direction.SLOWER]
    elif ratio < 0.999 / SLOWER:
        assert directions == [Direction.FASTER]
    elif 1.001 / SLOWER < ratio < 0.999 * SLOWER:
        assert directions == []


def test_a_few_disturbed_runs_do_not_make_a_solver_slower():
    series = SeriesKey("s", "c", "x", "r")
    calm = {(series, f"h={k}"): Run("completed", 1, 1, 1.0) for k in range(4)}
    disturbed = calm | {(series, f"h={k}"): Run("completed", 1, 1, 60.0) for k in range(2)}
    assert compare(Tables({}, calm, {}, {}, {}), Tables({}, disturbed, {}, {}, {})).changes == ()


# Cautions.


def past(**changes):
    return {
        "s": dict.fromkeys(PROVENANCE, "x")
        | {"commit_state": "clean", "versions": "python 3.11, numpy 2.0", "tier": "quick"}
        | changes
    }


@pytest.mark.parametrize(
    ("before", "after", "caution"),
    [
        (past(), past(), ""),
        (past(commit="a"), past(commit="b"), ""),
        (past(), past(commit_state="dirty"), "B was made with uncommitted changes"),
        (past(commit_state="dirty"), past(), "A was made with uncommitted changes"),
        (past(tier="quick"), past(tier="full"), "the tiers differ (quick and full)"),
        (
            past(),
            past(versions="python 3.11, numpy 2.1"),
            "the libraries or machines differ (numpy 2.0 -> numpy 2.1): seconds are not",
        ),
        (past(), past(platform="Windows"), "the platforms differ (x -> Windows): seconds are not comparable"),
        (past(), past() | {"t": past(commit="c")["s"]}, "B holds studies of 2 commits"),
    ],
)
def test_cautions_say_what_limits_the_comparison(before, after, caution):
    sentences = compare(Tables(before, {}, {}, {}, {}), Tables(after, {}, {}, {}, {})).cautions
    assert len(sentences) == bool(caution)
    assert all(sentence.startswith(caution) for sentence in sentences)


# Command line.


def call(*arguments):
    return CliRunner().invoke(cli.cli, [str(argument) for argument in arguments])


@pytest.fixture
def two(tmp_path):
    """Two results folders; in the second, every error is larger."""
    stored(tmp_path / "a", study(CostlySolver()))
    stored(tmp_path / "b", study(CostlySolver(factor=2.0)))
    return tmp_path / "a", tmp_path / "b"


def test_the_command_lists_worse_errors_and_exits_with_1(two):
    result = call("compare", *two)
    assert result.exit_code == 1
    assert re.search(r"WORSE\W+error\W+scripted / hill", result.output)
    assert f"{NORMS_OF_U} worse: 3 verdicts, {NORMS_OF_U} errors, 4 orders, 3 runs compared." in result.output
    assert result.output.count("WORSE") == 1, "errors of one series are read as one"
    assert "+100 %" in result.output
    assert call("compare", *reversed(two)).exit_code == 0
    assert call("compare", *two, "--explain").output.count("WORSE") == NORMS_OF_U


def test_comparing_with_a_copy_shows_no_change_and_writes_nothing(two, tmp_path):
    shutil.copytree(two[0], tmp_path / "copy")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    result = call("compare", two[0], tmp_path / "copy")
    assert result.exit_code == 0
    assert f"Nothing changed: 3 verdicts, {NORMS_OF_U} errors, 4 orders, 3 runs compared." in result.output
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def cut(path):
    path.write_bytes(path.read_bytes()[:1000])


def foreign(path):
    path.unlink()
    with netCDF4.Dataset(path, "w") as file:
        file.title = "not ours"


def older(path):
    with netCDF4.Dataset(path, "a") as file:
        file.mpmverify_schema = 2


def unjudged(path):
    with netCDF4.Dataset(path, "a") as file:
        file["scripted-good"].renameVariable("verdict_verdict", "opinion")


def renamed(path):
    with netCDF4.Dataset(path, "a") as file:
        file.id = "other"


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize(
    ("damage", "part"),
    [
        (cut, "is damaged: run `mpmverify run` again"),
        (foreign, "is not an mpmverify study file"),
        (older, "has schema 2 and this version reads"),
        (unjudged, "is damaged"),
        (renamed, "contains the study 'other': rename it to 'other.nc', or move it away"),
    ],
)
def test_a_file_that_cannot_be_compared_is_named_in_one_sentence(two, side, damage, part):
    damage(two[side] / "scripted.nc")
    result = call("compare", *two)
    assert result.exit_code == 2
    assert len(result.stderr.strip().splitlines()) == 1
    assert f"'{two[side] / 'scripted.nc'}' {part}" in result.stderr
    with pytest.raises(ResultsError):
        read_tables([two[side] / "scripted.nc"])


def test_two_different_folders_with_results_are_required(two, tmp_path):
    for arguments, part in (
        ([two[0], two[0]], "A and B are both"),
        ([two[0], two[1] / ".." / "a"], "A and B are both"),
        ([two[0], tmp_path / "none"], f"no results in '{tmp_path / 'none'}'"),
        ([tmp_path / "none", two[0]], f"no results in '{tmp_path / 'none'}'"),
        ([two[0]], "Missing argument 'B'"),
    ):
        result = call("compare", *arguments)
        assert result.exit_code == 2
        assert len(result.stderr.strip().splitlines()) == 1
        assert part in result.stderr


@pytest.mark.parametrize(
    ("factor", "shown"), [(1.02, "+2 %"), (0.5, "-50 %"), (9.99, "+899 %"), (10.0, "x 10"), (2e4, "x 2e+04"), (0.0, "-100 %")]
)
def test_the_size_of_a_change_has_a_sign(capsys, factor, shown):
    def folder(error):
        key = (SeriesKey("s", "c", "x", "r"), "h=1")
        return Tables(past(), {key: Run("completed", 1, 1, 1.0)}, {(*key, "u L2"): (error, 1.0)}, {}, {})

    display.show_comparison(compare(folder(0.1), folder(0.1 * factor)))
    assert re.search(rf"│ {re.escape(shown)} *│", capsys.readouterr().out)


def test_the_list_of_changes_is_truncated_with_a_note(capsys):
    def folder(verdict):
        keys = [(SeriesKey("s[b]", "c", f"solver {k}", "r"), "verification: [/] order") for k in range(40)]
        runs = {(series, "h=1"): Run("completed", 1, 1, 1.0) for series, _ in keys}
        return Tables(past(), runs, {}, {}, dict.fromkeys(keys, verdict))

    better = compare(folder(Verdict.FAIL), folder(Verdict.PASS))
    display.show_comparison(better)
    shown = capsys.readouterr().out
    assert shown.count("BETTER") == display.LISTED_CHANGES
    assert f"and {40 - display.LISTED_CHANGES} more: --explain shows all" in shown
    assert "s[b] / c / solver 0 (r)" in shown, "text is not taken for markup"
    assert "40 better: 40 verdicts, 0 errors, 0 orders, 40 runs compared." in shown
    display.show_comparison(better, explain=True)
    assert capsys.readouterr().out.count("BETTER") == 40


def test_a_lost_conservation_property_is_worse(tmp_path):
    """A verdict can change although no error does."""
    criteria = (Balance("mass", "", "made so"),)
    a = stored(tmp_path / "a", study(CostlySolver(), criteria=criteria))
    b = stored(tmp_path / "b", study(Leaking(), criteria=criteria))
    assert counts(compare(a, b)) == {("worse", "verdict"): 1}


@dataclasses.dataclass(frozen=True)
class Leaking(CostlySolver):
    """Solver that loses mass over time."""

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        good = super().solve(problem, discretisation)
        time = good.histories["time"]
        return dataclasses.replace(good, histories=dict(good.histories) | {"mass": 1 - 0.1 * time / time[-1]})


@pytest.mark.parametrize("bands", [(1.9, 2.9), (2.9, 1.9)])
def test_the_worst_verdict_of_criteria_with_the_same_title_is_compared(tmp_path, monkeypatch, bands):
    criteria = tuple(Order("u", "L2", low, low + 0.2, "made so") for low in bands)
    monkeypatch.setattr(Order, "title", "twice")
    tables = stored(tmp_path, study(CostlySolver(), criteria=criteria))
    assert [verdict for (_, title), verdict in tables.verdicts.items() if title == "verification: twice"] == [Verdict.FAIL]
