"""Evidence: relative errors, the sizes and outcomes that a reason names, and published values."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from series_evidence import (
    DESIGN_H,
    ERROR,
    FAIL,
    LIGHT,
    ONES,
    ORDER,
    PASS,
    PUBLISHED,
    SEPARATED,
    H,
    over_design,
    series,
    verdict,
)

from mpmverify.criteria import (
    EnergyDrift,
    Published,
    Separated,
)
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import UsageError
from mpmverify.judgement.findings import judge_criterion
from mpmverify.solution import Outcome, Status

# Evidence.


@LIGHT
@given(st.lists(st.floats(1e-6, 1e6), min_size=3, max_size=3), st.lists(st.floats(1e-6, 1e6), min_size=3, max_size=3))
def test_errors_are_relative_to_the_exact_norm_and_absolute_where_it_vanishes(error, size):
    size = [size[0], 0.0, size[2]]
    found = series(error, H[:3], reference=size).relative("u", "L2")
    np.testing.assert_allclose(found, [error[0] / size[0], error[1], error[2] / size[2]])


def test_each_norm_and_quantity_is_judged_separately():
    table = np.ones((5, len(NORMS)))
    table[:, NORMS.index("L2")] = H**2
    evidence = dataclasses.replace(series(H), error={"u": table, "v": np.ones((5, len(NORMS)))})
    assert verdict(ORDER, evidence) is PASS
    assert verdict(dataclasses.replace(ORDER, norm="L1"), evidence) is FAIL
    assert verdict(dataclasses.replace(ORDER, quantity="v"), dataclasses.replace(evidence, reference={"v": table})) is FAIL


def test_the_order_of_energy_drift_is_in_dt_and_not_in_h():
    evidence = series(H, dt=H**2, metrics={"energy_drift": 1e-2 * H**2})
    assert verdict(EnergyDrift(1.8, ""), evidence) is FAIL
    assert verdict(EnergyDrift(0.8, ""), evidence) is PASS


@pytest.mark.parametrize(
    ("columns", "note"),
    [
        ({}, "h and dt together: min(p, q)"),
        ({"dt": H**1.5}, "h and dt together: min(p, 1.5 q)"),
        ({"dt": 0.1 * ONES, "ppc": 2 ** np.arange(5)}, "h and 1/ppc together: the least of their orders"),
        ({"dt": 0.1 * ONES}, ""),
    ],
)
def test_the_reason_explains_the_order_of_a_combined_refinement(columns, note):
    reason = judge_criterion(ORDER, series(3 * H**2, **columns))[1]
    assert reason.endswith(note) if note else "together" not in reason


def test_levels_of_a_design_are_named_by_all_their_parameters():
    outcomes = ("completed",) * 15 + ("unstable",)
    assert judge_criterion(SEPARATED, over_design(DESIGN_H, outcomes=outcomes)) == (
        ERROR,
        "h=0.015625 nu_C=0.5 ppc=1: unstable",
    )
    assert judge_criterion(ORDER, series(3 * H, outcomes=("completed",) * 4 + ("unstable",))) == (
        ERROR,
        "h=0.0078125: unstable",
    )


@pytest.mark.parametrize(
    ("outcomes", "reason"),
    [
        (["crashed; X"] * 5, "every level: crashed; X"),
        (["crashed; X"] * 4 + ["completed"], "h=0.125 to h=0.015625: crashed; X"),
        (["crashed; X"] * 4 + ["timed out"], "h=0.125 to h=0.015625: crashed; X; h=0.0078125: timed out"),
        (["X", "completed", "X", "X", "Y"], "h=0.125, h=0.03125 to h=0.015625: X; h=0.0078125: Y"),
        (["completed", "X", "Y", "X", "completed"], "h=0.0625, h=0.015625: X; h=0.03125: Y"),
        (
            ["completed"] * 3 + [str(Outcome(Status.LEFT_GRID, f"at step {n}")) for n in (3, 5)],
            "h=0.015625: left the grid; at step 3; h=0.0078125: left the grid; at step 5; "
            "a particle left the background grid: enlarge the domain or lower the load, unless a face or an unstable run drives it out",
        ),
        (
            ["completed"] * 3 + [str(Outcome(Status.LEFT_GRID, f"at step {n}", "move the face by less")) for n in (3, 5)],
            "h=0.015625: left the grid; at step 3; h=0.0078125: left the grid; at step 5; move the face by less",
        ),
    ],
)
def test_levels_with_the_same_outcome_share_one_sentence(outcomes, reason):
    assert judge_criterion(ORDER, series(3 * H**2, outcomes=tuple(outcomes))) == (ERROR, reason)
    assert judge_criterion(ORDER, series([1.0], [0.5], outcomes=("crashed; X",))) == (ERROR, "h=0.5: crashed; X")


@LIGHT
@given(st.lists(st.sampled_from(["completed", "crashed", "timed out"]), min_size=1, max_size=5))
def test_the_reason_contains_every_failed_outcome_once(outcomes):
    seen = series(3 * H[: len(outcomes)] ** 2, H[: len(outcomes)], outcomes=tuple(outcomes))
    assert bool(seen.incomplete) == (set(outcomes) != {"completed"})
    for outcome in ("completed", "crashed", "timed out"):
        assert seen.incomplete.count(outcome) == (outcome in outcomes and outcome != "completed")


def test_a_dropped_level_is_named_by_its_refined_size():
    error = 3 * H**2 * [1, 1, 1, 1, 1e-12]
    assert "without dt=0.0078125: at round-off" in judge_criterion(ORDER, series(error, 0.1 * ONES, dt=H))[1]


@pytest.mark.parametrize("choices", [("u", "L1", (("h", 1, 2),), ""), ("u", "L2", (), ""), ("u", "L2", (("ppc", 1, 2),), "")])
def test_an_invalid_separation_is_refused(choices):
    with pytest.raises(UsageError):
        Separated(*choices)


def test_published_errors_are_absolute():
    assert verdict(PUBLISHED, series(3 * H**2, reference=1e3)) is PASS


@pytest.mark.parametrize("digits", [1, 2, 3, 4])
def test_published_errors_must_agree_to_half_a_unit_of_the_last_digit(digits):
    values = ((0.5, 4.4712e-3), (0.25, 1.1334e-3), (0.125, 9.9999e-4))
    theirs = np.array([value for _, value in values])
    unit = np.array([1e-3, 1e-3, 1e-4]) * 10.0 ** (1 - digits)
    criterion = Published("u", "L2", values, digits, "")
    assert verdict(criterion, series(theirs + 0.49 * unit, H[:3] * 4)) is PASS
    assert verdict(criterion, series(theirs - unit * [0.49, 0.49, 0.51], H[:3] * 4)) is FAIL


def test_all_levels_with_a_published_size_are_compared():
    h = np.append(H, H[0])
    assert verdict(PUBLISHED, series(np.append(3 * H**2, 3 * H[0] ** 2), h)) is PASS
    assert verdict(PUBLISHED, series(np.append(3 * H**2, 1.0), h)) is FAIL
    assert verdict(PUBLISHED, series(np.insert(3 * H**2, 0, 1.0), np.insert(H, 0, H[0]))) is FAIL
