"""Series that must never pass: not finite, stagnant, implausible, at a floor, too short, incomplete, not measured."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from series_evidence import (
    DECAY,
    DISPERSION,
    ERROR,
    FAIL,
    FRONT,
    INCONCLUSIVE,
    LIGHT,
    METRICS,
    ORDER,
    PASS,
    PHASE,
    PUBLISHED,
    SUMS,
    H,
    measured,
    series,
    verdict,
)

from mpmverify.convergence import PLAUSIBLE
from mpmverify.criteria import (
    Amplification,
    Balance,
    EnergyConserved,
    EnergyDecays,
    EnergyDrift,
    Exact,
    ExactTotal,
    Order,
    Stall,
)
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.norms import NORMS
from mpmverify.judgement.findings import judge_criterion

# Series that must never pass.

CLEAN = dataclasses.replace(
    series(3 * H**2),
    metrics={name: np.full(5, 0.5 if name in ("amplification_modes", "phase_angle_u") else 1e-15) for name in METRICS}
    | {"phase_error_u": -3 * H**2, "amplitude_decay_u": 3 * H**3},
)
JUDGED_BY = {
    "error": (ORDER, Stall("u", "L2", 3.0, 0, 9, ""), Exact("u", "L2", 1.0, ""), PUBLISHED),
    "momentum_defect": (Balance("momentum", "impulse", ""),),
    "mass_defect": (Balance("mass", "", ""),),
    "momentum_error": (ExactTotal("momentum", ""),),
    "mass_sum_defect": (SUMS,),
    "momentum_sum_defect": (SUMS,),
    "energy_drift": (EnergyDrift(1.8, ""), EnergyConserved("")),
    "energy_rise": (EnergyDecays(""),),
    "amplification_defect": (Amplification(1, 1e-12, ""),),
    "amplification_modes": (Amplification(1, 1e-12, ""),),
    "dispersion_defect_u": (DISPERSION,),
    "phase_angle_u": (DISPERSION,),
    "phase_error_u": (PHASE,),
    "amplitude_decay_u": (DECAY,),
    "front_lag_u": (FRONT,),
    "theoretical_front_lag_u": (FRONT,),
}
JUDGED_BY["reference"] = JUDGED_BY["error"]


@pytest.mark.parametrize(("what", "criterion"), [(what, c) for what, several in JUDGED_BY.items() for c in several])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("levels", [{0}, {2}, {4}, {1, 3}, {0, 1, 2, 3, 4}])
def test_a_non_finite_value_is_an_error_where_a_finite_one_passes(what, criterion, bad, levels):
    assert verdict(criterion, CLEAN) is PASS
    values = {"error": CLEAN.error["u"], "reference": CLEAN.reference["u"]}.get(what, CLEAN.metrics.get(what)).copy()
    values[sorted(levels)] = bad
    poisoned = {
        "error": {"error": {"u": values}},
        "reference": {"reference": {"u": values}},
    }.get(what, {"metrics": {**CLEAN.metrics, what: values}})
    assert verdict(criterion, dataclasses.replace(CLEAN, **poisoned)) is ERROR


ANY_ERROR = st.one_of(st.floats(0, 1e6), st.sampled_from([0.0, 1e-15, 1e-12, 1e-3, 1.0, math.inf, math.nan]))


@settings(max_examples=100)
@given(st.lists(ANY_ERROR, min_size=1, max_size=6), st.floats(0.3, 4), st.floats(0.05, 0.5))
def test_a_pass_needs_three_converging_levels(error, centre, half_width):
    evidence = series(error, 0.5 ** np.arange(len(error)))
    criterion = Order("u", "L2", centre - half_width, centre + half_width, "")
    if verdict(criterion, evidence) is PASS:
        usable = np.array(error)[np.array(error) > 1e-12]
        assert np.all(np.isfinite(error))
        assert len(usable) >= 3
        assert usable[-1] < usable[0]
        slope = np.polyfit(-np.arange(len(usable)), np.log2(usable), 1)[0]
        assert slope > 0.25


@LIGHT
@given(
    st.sampled_from(["negative", "stagnant", "implausible"]),
    st.floats(0, 1),
    st.sampled_from([(-math.inf, math.inf), (-5, 90), (-5, 1), (10, 90), (0, 0.25), (math.nan, math.nan), (-5, math.nan)]),
    st.integers(3, 8),
)
def test_implausible_orders_pass_in_no_band(kind, position, band, levels):
    low, high = {"negative": (-4, -0.01), "stagnant": (-0.2, 0.2), "implausible": (PLAUSIBLE + 0.1, 76)}[kind]
    rate = low + position * (high - low)
    h = 1.05 ** -np.arange(float(levels))
    assert verdict(Order("u", "L2", *band, ""), series(0.5 * h**rate, h)) is not PASS


@pytest.mark.parametrize("band", [(math.nan, math.nan), (1.8, math.nan), (math.nan, 2.2)])
def test_a_band_with_nan_is_inconclusive(band):
    assert verdict(Order("u", "L2", *band, ""), series(3 * H**2)) is INCONCLUSIVE
    assert verdict(EnergyDrift(math.nan, ""), measured(energy_drift=1e-2 * H**2)) is INCONCLUSIVE


@LIGHT
@given(st.floats(PLAUSIBLE + 0.1, 76), st.integers(4, 8))
def test_an_implausible_order_of_the_energy_drift_does_not_pass(rate, levels):
    h = 1.03 ** -np.arange(float(levels))
    assert verdict(EnergyDrift(1.8, ""), series(h, h, dt=h, metrics={"energy_drift": 0.1 * h**rate})) is not PASS


@LIGHT
@given(st.floats(1, 3), st.floats(0.02, 30), st.integers(4, 8))
def test_a_series_at_a_floor_does_not_pass(order, share, levels):
    """The floor is at least half of the finest error; the rest of the error converges at the expected order."""
    h = 0.5 ** np.arange(float(levels))
    error = 1e-4 * (1 + share / (1 + share) * (h / h[-1]) ** order)
    assert verdict(Order("u", "L2", order - 0.2, order + 0.2, ""), series(error, h)) is not PASS


@LIGHT
@given(
    st.sampled_from([0.0, 1e-16, 1e-13]),
    st.integers(1, 3),
    st.floats(0.3, 4),
    st.integers(3, 6),
)
def test_additional_levels_at_round_off_do_not_make_a_pass_and_are_named(error, extra, order, levels):
    h = 0.5 ** np.arange(float(levels + extra))
    clean = h[:levels] ** order
    for criterion in (Order("u", "L2", order - 0.1, order + 0.1, ""), Order("u", "L2", order + 0.3, order + 0.5, "")):
        before, _ = judge_criterion(criterion, series(clean, h[:levels]))
        after, reason = judge_criterion(criterion, series(np.append(clean, np.full(extra, error)), h))
        assert after is not PASS
        assert after is FAIL or before is not FAIL
        assert all(f"h={size:g}: at round-off" in reason for size in h[levels:])


@LIGHT
@given(st.sampled_from([ORDER, Stall("u", "L2", 0.5, 0, 9, ""), PUBLISHED, EnergyDrift(1.8, "")]), st.integers(1, 2))
def test_an_order_needs_three_levels(criterion, levels):
    h = H[:levels]
    error = np.full(levels, 0.1) if isinstance(criterion, Stall) else 3 * h**2
    assert verdict(criterion, series(error, h, metrics={"energy_drift": h**2})) is INCONCLUSIVE


@pytest.mark.parametrize("criterion", [c for several in JUDGED_BY.values() for c in several])
def test_an_incomplete_run_is_an_error_before_any_number_is_judged(criterion):
    outcomes = ("completed", "unstable: the energy grew", "completed", "timed out", "completed")
    found, reason = judge_criterion(criterion, dataclasses.replace(CLEAN, outcomes=outcomes))
    assert found is ERROR
    assert "h=0.0625: unstable: the energy grew" in reason
    assert "timed out" in reason


@pytest.mark.parametrize("criterion", [c for several in JUDGED_BY.values() for c in several])
def test_a_missing_measurement_is_an_error_and_is_named(criterion):
    found, reason = judge_criterion(criterion, dataclasses.replace(CLEAN, error={}, reference={}, metrics={}))
    assert found is ERROR
    assert "was not measured" in reason


@pytest.mark.parametrize("criterion", [c for several in JUDGED_BY.values() for c in several])
def test_a_series_without_levels_is_an_error(criterion):
    empty = np.zeros(0)
    table = np.zeros((0, len(NORMS)))
    nothing = Evidence(empty, empty, empty, empty, (), {"u": table}, {"u": table}, dict.fromkeys(METRICS, empty))
    assert judge_criterion(criterion, nothing)[0] is ERROR
