"""The regression gate: detects changes that leave orders unchanged, and validates its baseline file."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Order
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import ResultsError
from mpmverify.judgement.baseline import RELATIVE, Baseline, read_baseline, values_by_level
from mpmverify.judgement.findings import judge_criterion

LIGHT = settings(max_examples=25)
H = 0.5 ** np.arange(3.0, 7.0)
SERIES = ("bar", "tg", "step", "nu_C=0.5")
ACCEPTED = {"date": "2026-01-02", "commit": "abc", "reason": "first"}


def evidence(factor=1.0, *, h=H, quantities=("u", "v"), size=2.0, outcomes=None) -> Evidence:
    table = 0.1 * factor * (h**2)[:, None] * np.array([1.0, 1.5, 3.0, 2.0])
    return Evidence(
        h=h.copy(),
        dt=h / 2,
        courant=np.full(len(h), 0.5),
        ppc=np.full(len(h), 2),
        outcomes=("completed",) * len(h) if outcomes is None else outcomes,
        error={quantity: table.copy() for quantity in quantities},
        reference={quantity: np.full((len(h), len(NORMS)), size) for quantity in quantities},
    )


def with_error(value, level=2, norm=1, quantity="v", source=None) -> Evidence:
    source = evidence() if source is None else source
    table = source.error[quantity].copy()
    table[level, norm] = value
    return dataclasses.replace(source, error={**source.error, quantity: table})


def accepted(of: Evidence | None = None, path="unused") -> Baseline:
    baseline = Baseline(path, {}, [dict(ACCEPTED)])
    baseline.accept_series(*SERIES, evidence() if of is None else of)
    return baseline


def verdict(baseline: Baseline, seen: Evidence) -> Verdict:
    found, reason = baseline.judge(*SERIES, seen)
    assert reason
    return found


def test_accepted_errors_pass():
    found, reason = accepted().judge(*SERIES, evidence())
    assert found is Verdict.PASS
    assert f"{len(H) * 2 * len(NORMS)} values" in reason


def test_errors_larger_by_a_constant_factor_fail_although_the_order_is_unchanged():
    order = Order("u", "L2", 1.9, 2.1, "")
    reasons = [judge_criterion(order, evidence(factor))[1] for factor in (1, 1.05)]
    assert reasons[0] == reasons[1]
    assert judge_criterion(order, evidence(1.05))[0] is Verdict.PASS
    found, reason = accepted().judge(*SERIES, evidence(1.05))
    assert found is Verdict.FAIL
    assert "32 of 32 values rose" in reason


@LIGHT
@given(
    st.sampled_from([1 + 1.5 * RELATIVE, 1.05, 2.0, 1e6]),
    st.integers(0, len(H) - 1),
    st.sampled_from(range(len(NORMS))),
    st.sampled_from(["u", "v"]),
)
def test_one_larger_error_fails_and_is_named(factor, level, norm, quantity):
    now = factor * evidence().error[quantity][level, norm]
    found, reason = accepted().judge(*SERIES, with_error(now, level, norm, quantity))
    assert found is Verdict.FAIL
    assert reason.startswith(f"{quantity} {NORMS[norm]} at h={H[level]:g} ")
    assert "(1 of 32 values rose)" in reason


@LIGHT
@given(st.sampled_from([0.0, 0.5, 1 - 1.5 * RELATIVE]), st.integers(0, len(H) - 1))
def test_one_smaller_error_fails_until_accepted(factor, level):
    found, reason = accepted().judge(*SERIES, with_error(factor * evidence().error["v"][level, 1], level))
    assert found is Verdict.FAIL
    assert "(1 of 32 values fell): find out why, then accept the baseline" in reason


def test_a_smaller_error_does_not_outweigh_a_larger_one():
    seen = with_error(0.0, level=0)
    assert verdict(accepted(), with_error(1.0, level=3, source=seen)) is Verdict.FAIL


@LIGHT
@given(st.floats(1 - 0.5 * RELATIVE, 1 + 0.5 * RELATIVE))
def test_changes_below_the_tolerance_pass(factor):
    assert verdict(accepted(), evidence(factor)) is Verdict.PASS


@LIGHT
@given(st.floats(0, 9e-12), st.floats(0, 9e-12), st.sampled_from([0.0, 1e-3, 1.0, 1e6]))
def test_changes_within_round_off_of_the_exact_norm_pass(then, now, size):
    """Round-off is absolute if the exact norm is zero."""
    unit = size or 1.0
    baseline = accepted(with_error(then * unit, source=evidence(size=size)))
    assert verdict(baseline, with_error(now * unit, source=evidence(size=size))) is Verdict.PASS
    assert verdict(baseline, with_error(1e-9 * unit, source=evidence(size=size))) is Verdict.FAIL


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("level", range(len(H)))
@pytest.mark.parametrize("known", [True, False])
def test_a_non_finite_error_is_an_error_with_and_without_a_baseline(bad, level, known):
    baseline = accepted() if known else accepted(evidence(h=H[:1], quantities=("u",)))
    assert verdict(baseline, with_error(bad, level)) is Verdict.ERROR


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_non_finite_exact_norm_is_an_error(bad):
    seen = evidence(1.5)
    seen.reference["u"][1, 1] = bad
    assert verdict(accepted(), seen) is Verdict.ERROR


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_non_finite_baseline_is_an_error(bad):
    assert verdict(accepted(with_error(bad)), evidence(1.5)) is Verdict.ERROR


def test_an_incomplete_run_is_an_error_before_errors_are_compared():
    outcomes = ("completed", "completed", "timed out", "completed")
    found, reason = Baseline("unused").judge(*SERIES, evidence(outcomes=outcomes))
    assert found is Verdict.ERROR
    assert reason == "h=0.03125: timed out"


@pytest.mark.parametrize(
    ("known", "seen", "named"),
    [
        (evidence(h=H[:3]), evidence(), "h=0.015625"),
        (evidence(quantities=("u",)), evidence(), "v L1"),
        (evidence(), evidence(quantities=("u",)), "v L1"),
        (evidence(h=H / 2), evidence(h=H), "h=0.125"),
    ],
)
def test_levels_or_norms_that_one_side_lacks_are_named_and_inconclusive(known, seen, named):
    found, reason = accepted(known).judge(*SERIES, seen)
    assert found is Verdict.INCONCLUSIVE
    assert named in reason


@pytest.mark.parametrize("other", [("x", "tg", "step", "nu_C=0.5"), ("bar", "x", "step", "nu_C=0.5"), (*SERIES[:3], "x")])
def test_the_baseline_of_another_series_is_not_used(other):
    assert accepted().judge(*other, evidence())[0] is Verdict.INCONCLUSIVE
    assert Baseline("unused").judge(*SERIES, evidence())[0] is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("run", "restricted_to", "said"),
    [
        ([], "", "(2 of 2 series in all): run the whole study, or take out of the baseline what is gone for good"),
        ([("step", "other", "nu_C=0.5")], "", "(2 of 2 series in all): run the whole study, or"),
        ([("step", "tg", "nu_C=0.5")], "tg", "(1 of 2 series in all): the run was restricted to tg: run the whole study"),
        ([("step", "tg", "nu_C=0.5"), ("step", "zz", "nu_C=0.5"), ("new", "tg", "l")], "tg", ""),
    ],
)
def test_missing_series_give_one_inconclusive_finding(run, restricted_to, said):
    baseline = accepted()
    baseline.accept_series("bar", "zz", "step", "nu_C=0.5", evidence())
    baseline.accept_series("another", "tg", "step", "nu_C=0.5", evidence())
    found = baseline.missing_series("bar", run, restricted_to)
    if not said:
        assert found is None
        return
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.reason.startswith(f"in the baseline, but not in the results {said}")
    assert ("gone for good" in found.reason) == (not restricted_to), "a series that was left out on purpose is not gone"
    assert (found.case, found.solver, found.refinement) not in run
    assert baseline.missing_series("unknown", run, restricted_to) is None


def test_a_larger_error_fails_even_if_levels_are_missing():
    assert verdict(accepted(evidence(h=H[:2])), evidence(1.05)) is Verdict.FAIL


def test_fewer_levels_than_accepted_are_compared():
    assert verdict(accepted(), evidence(h=H[:2])) is Verdict.PASS
    assert verdict(accepted(), evidence(1.05, h=H[:2])) is Verdict.FAIL


@pytest.mark.parametrize("nothing", [evidence(quantities=()), evidence(h=H[:0])])
def test_no_errors_to_compare_is_inconclusive(nothing):
    assert verdict(accepted(nothing), nothing) is Verdict.INCONCLUSIVE


@pytest.mark.parametrize("column", ["h", "courant", "ppc"])
def test_level_names_depend_on_every_discretisation_parameter(column):
    seen = evidence()
    other = dataclasses.replace(seen, **{column: getattr(seen, column) * 3})
    assert not {name for name, _ in values_by_level(seen)} & {name for name, _ in values_by_level(other)}


def test_level_names_depend_on_jitter_and_seed_if_there_is_jitter():
    seen = evidence()
    none, one = np.zeros(len(seen.h)), np.ones(len(seen.h), dtype=int)
    names = [
        tuple(name for name, _ in values_by_level(dataclasses.replace(seen, jitter=jitter, seed=seed)))
        for jitter, seed in ((None, None), (none, 0 * one), (none + 1e-3, one), (none + 1e-3, 2 * one), (none + 2e-3, one))
    ]
    assert names[0] == names[1]
    assert len(set(names)) == 4


def test_a_baseline_copies_the_accepted_numbers():
    """If the baseline shared arrays with the evidence, later changes of the evidence would always pass."""
    seen = evidence()
    baseline = accepted(seen)
    assert verdict(baseline, seen) is Verdict.PASS
    for table in seen.error.values():
        table *= 1.05
    assert verdict(baseline, seen) is Verdict.FAIL


def test_judging_does_not_change_the_baseline():
    baseline = accepted()
    before = json.dumps(baseline.entries)
    for factor in (1.05, 0.5, 1.0):
        baseline.judge(*SERIES, evidence(factor))
        baseline.judge("new", *SERIES[1:], evidence(factor))
    assert json.dumps(baseline.entries) == before


def test_accepting_a_series_keeps_other_series_and_its_other_levels():
    baseline = accepted()
    baseline.accept_series(*SERIES[:3], "nu_C=0.9", evidence(7))
    baseline.accept_series(*SERIES, evidence(3, h=H[:1]))
    assert baseline.judge(*SERIES[:3], "nu_C=0.9", evidence(7))[0] is Verdict.PASS
    found, reason = baseline.judge(*SERIES, evidence(3))
    assert found is Verdict.FAIL
    assert "(24 of 32 values rose)" in reason


# Files.


@LIGHT
@given(factor=st.floats(1e-14, 1e3))
def test_a_baseline_is_read_back_unchanged(tmp_path_factory, factor):
    path = tmp_path_factory.mktemp("baseline") / "baseline.json"
    written = accepted(evidence(factor), path)
    written.write()
    read = read_baseline(path)
    assert (read.entries, read.accepted, read.source) == (written.entries, written.accepted, written.source)
    assert verdict(read, evidence(factor)) is Verdict.PASS
    before = path.read_bytes()
    read.write()
    assert path.read_bytes() == before


def test_the_source_gives_date_and_reason_of_the_last_acceptance(tmp_path):
    baseline = accepted()
    baseline.accepted.append({"date": "2026-03-04", "commit": "def", "reason": "a better integrator"})
    assert baseline.source == "baseline accepted on 2026-03-04: a better integrator"
    assert read_baseline(tmp_path / "none.json").source == "no baseline"
    assert read_baseline(tmp_path / "none.json").entries == {}


def nested(value) -> dict:
    return {"bar": {"tg": {"step | nu_C=0.5": {"h=1 nu_C=1 ppc=1": {"u L2": value}}}}}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "null",
        "[]",
        "3",
        '"errors"',
        "{}",
        '{"errors": {}}',
        '{"accepted": []}',
        '{"accepted": null, "errors": {}}',
        '{"accepted": 1, "errors": {}}',
        '{"accepted": ["who"], "errors": {}}',
        '{"accepted": [{"date": "today"}], "errors": {}}',
        '{"accepted": [], "errors": []}',
        '{"accepted": [], "errors": {"bar": 1}}',
        '{"accepted": [], "errors": {"bar": {"tg": {"step": [1, 2]}}}}',
        *(
            json.dumps({"accepted": [], "errors": nested(bad)})
            for bad in (math.nan, math.inf, -1.0, "1", None, [1.0], {"a": 1})
        ),
        json.dumps({"accepted": [], "errors": nested(0)}).replace("0", "1" + "0" * 400),
        b"\xff\xfe\x00",
    ],
)
def test_a_damaged_or_foreign_file_is_refused_by_name(tmp_path, text):
    path = tmp_path / "other.json"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ResultsError, match=r"other\.json"):
        read_baseline(path)


def test_a_baseline_cut_short_is_refused(tmp_path):
    path = tmp_path / "baseline.json"
    accepted(path=path).write()
    text = path.read_text()
    for end in range(0, len(text) - 3, 97):
        path.write_text(text[:end])
        with pytest.raises(ResultsError):
            read_baseline(path)


def test_an_error_of_reading_or_writing_names_the_option(tmp_path):
    for path in (tmp_path, tmp_path / "missing" / "baseline.json"):
        with pytest.raises(ResultsError, match="--baseline"):
            accepted(path=path).write()
    with pytest.raises(ResultsError, match="--baseline"):
        read_baseline(tmp_path)
