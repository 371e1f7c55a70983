"""Verdicts of every criterion: PASS, FAIL, INCONCLUSIVE and ERROR on examples, and conditions under which nothing may pass."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence import PLAUSIBLE
from mpmverify.convergence.verdict import Verdict, exit_status, worst
from mpmverify.criteria import (
    CRITERIA,
    Amplification,
    AmplitudeDecay,
    Balance,
    Dispersion,
    EnergyConserved,
    EnergyDecays,
    EnergyDrift,
    Exact,
    ExactTotal,
    FieldSums,
    FrontPosition,
    Order,
    PhaseError,
    Published,
    Reproduced,
    Separated,
    Size,
    StabilityLimit,
    Stall,
    Unstable,
)
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.norms import NORMS
from mpmverify.errors import UsageError
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.exact.amplification import two_step_taylor_galerkin
from mpmverify.judgement.findings import Finding, judge_criterion
from mpmverify.problem import Discretisation, LinearElastic, Periodic, Problem, Traction, Transport
from mpmverify.solution import Outcome, Solution, Status, Work

LIGHT = settings(max_examples=25)
H = 0.5 ** np.arange(3.0, 8.0)
PASS, INCONCLUSIVE, FAIL, ERROR = Verdict.PASS, Verdict.INCONCLUSIVE, Verdict.FAIL, Verdict.ERROR
STALL = Stall("u", "L2", 0.5, 0.05, 20.0, "theory")
ORDER = Order("u", "L2", 1.8, 2.2, "theory")
PATCH = Reproduced("stress", 7.0, 1e-12, "theory")
OFF = Reproduced("stress", 7.0, 0.4, "theory", low=0.2, inside=0.5)
PUBLISHED = Published("u", "L2", tuple((float(h), float(f"{3 * h**2:.2e}")) for h in H), 3, "paper")
DISPERSION = Dispersion("tg-lumped", "u", 2.0, 1e-10, "theory")
PHASE = PhaseError("u", 2, 0.2, "theory", "tg-consistent-3", 72.0)  # at nu_C = 1/2 the wave is ahead by theta^2/24
DECAY = AmplitudeDecay("u", 3, 0.2, "theory", "tg-lumped", 64.0)  # at nu_C = 1/2 it loses 3/64 nu_C theta^4 in each step
LOSSLESS = AmplitudeDecay("u", 3, 0.2, "theory", "fem-p1-lumped-cd", 1.0)  # central differences lose nothing
FRONT = FrontPosition("u", "tg-lumped", 0.1, "theory")
SUMS = FieldSums(("mass", "momentum"), "theory")
UNSTABLE, GREW = Unstable(0.4, "theory"), ("unstable; at step 3 of 9; the solution grew",)
LIMIT = StabilityLimit("mpm-tl-linear-usl-flip", 0.01, "theory")
SEPARATED = Separated("u", "L2", (("h", 1.8, 2.2), ("dt", 0.8, 1.2)), "theory")
DESIGN_H, DESIGN_DT = (grid.ravel() for grid in np.meshgrid(H[:4], H[:4] / 2, indexing="ij"))
METRICS = (
    "momentum_defect",
    "mass_defect",
    "momentum_error",
    "mass_sum_defect",
    "momentum_sum_defect",
    "energy_drift",
    "energy_rise",
    "amplification_defect",
    "amplification_modes",
    *DISPERSION.metrics,
    *FRONT.metrics,
)


def series(error, h=H, *, reference=1.0, outcomes=None, quantity="u", metrics=None, **columns) -> Evidence:
    """Evidence with the same error in every norm."""
    error, h = np.asarray(error, dtype=float), np.asarray(h, dtype=float)
    table = np.repeat(error[:, None], len(NORMS), axis=1)
    size = np.broadcast_to(np.asarray(reference, dtype=float), h.shape)[:, None] * np.ones(len(NORMS))
    values = {name: np.asarray(value, dtype=float) for name, value in (metrics or {}).items()}
    one = np.ones(len(h))
    columns = {"dt": h / 2, "courant": one / 2, "ppc": one.astype(int)} | columns
    outcomes = ("completed",) * len(h) if outcomes is None else outcomes
    return Evidence(h, outcomes=outcomes, error={quantity: table}, reference={quantity: size}, metrics=values, **columns)


def limits(ratio) -> dict[str, np.ndarray]:
    """Metrics of a stability limit at a given ratio to the theoretical limit sqrt(1/2)."""
    theory = np.full(len(H), math.sqrt(0.5))
    return {"stability_limit": ratio * theory, "theoretical_stability_limit": theory}


def over_design(error, **columns) -> Evidence:
    return series(error, DESIGN_H, **({"dt": DESIGN_DT} | columns))


def falling(*orders) -> Evidence:
    """Evidence with the given observed orders, on halved sizes."""
    steps = np.arange(len(orders) + 1.0)
    return series(0.1 * 0.5 ** np.cumsum([0.0, *orders]), 0.5**steps)


def measured(**metrics) -> Evidence:
    return series(H**2, metrics=metrics)


def verdict(criterion, evidence) -> Verdict:
    found, reason = judge_criterion(criterion, evidence)
    assert reason
    return found


# Examples: criterion, evidence, expected verdict.

ONES = np.ones(5)
EXAMPLES = [
    (ORDER, series(3 * H**2), PASS),
    (ORDER, series(3 * H**2 * (1 + 3 * H)), PASS),
    (ORDER, series(3 * H), FAIL),
    (ORDER, series(3 * H**3), FAIL),
    (ORDER, series(3 * H**-2), FAIL),
    (ORDER, series(np.full(5, 0.1)), FAIL),
    (ORDER, series(1e-3 + 3 * H**4), FAIL),
    (ORDER, series(0.1 * 2.0 ** (-76 * np.arange(5.0) / 10)), FAIL),
    (ORDER, series(3 * H**2 * [1, 1, 1, 1, 1e4]), FAIL),
    (ORDER, series(3 * H**2 * [1, 1.4, 0.8, 1.5, 0.9]), INCONCLUSIVE),
    (ORDER, series(3 * H**1.8 * [1, 1.02, 0.99, 1.01, 1]), INCONCLUSIVE),
    (ORDER, series(3 * H**2 * [1, 1, 1, 1, 0]), INCONCLUSIVE),
    (ORDER, falling(2.1, 2.08, 2.0, 1.85, 1.7), FAIL),
    (ORDER, falling(2.1, 2.08, 1.9, 1.85, 1.82), INCONCLUSIVE),
    (ORDER, falling(2.1, 2.08, 2.0, 1.95, 1.93), PASS),
    (ORDER, series(3 * H[:2] ** 2, H[:2]), INCONCLUSIVE),
    (ORDER, series([0.1], [0.1]), INCONCLUSIVE),
    (ORDER, series(np.full(5, 1e-15)), INCONCLUSIVE),
    (ORDER, series(np.zeros(5)), INCONCLUSIVE),
    (ORDER, series([0.1, 1e-6, 1e-14, 1e-15, 0]), INCONCLUSIVE),
    (ORDER, series(3 * H**2 * [1, 1, np.nan, 1, 1]), ERROR),
    (STALL, series(0.1 + 3 * H**4), PASS),
    (STALL, series(0.1 / H), PASS),
    (STALL, series(0.04 + 3 * H**4), FAIL),
    (STALL, series(50 + 3 * H**4), FAIL),
    (STALL, series(0.1 + 3 * H**4, reference=1e-3), FAIL),
    (Stall("u", "L2", 0.5, 0.2, 0.9, "theory"), series(ONES), FAIL),
    (Size("u", "L2", 0.1, 0.2, "theory"), series(0.15 * ONES), PASS),
    (Size("u", "L2", 0.1, 0.2, "theory"), series(np.where(H.min() == H, 0.15, 3.0)), PASS),
    (Size("u", "L2", 0.1, 0.2, "theory"), series(np.where(H.min() == H, 0.3, 0.15)), FAIL),
    (Size("u", "L2", 0.1, 0.2, "theory"), series(0.09 * ONES), FAIL),
    (Size("u", "L2", 0.1, 0.2, "theory"), over_design(np.where(DESIGN_DT.max() == DESIGN_DT, 0.3, 0.15)), FAIL),
    (Size("u", "L2", 0.1, 0.2, "theory"), series(0.15 * ONES * [1, 1, np.nan, 1, 1]), ERROR),
    (STALL, series(3 * H**2), FAIL),
    (STALL, series(np.full(5, 1e-15)), FAIL),
    (STALL, series(np.zeros(5)), FAIL),
    (STALL, series([0.9, 0.8, 0.7, 0.3, 0.29]), INCONCLUSIVE),
    (STALL, series([0.1, 0.1], H[:2]), INCONCLUSIVE),
    (STALL, series([np.inf, 0.1, 0.1, 0.1, 0.1]), ERROR),
    (Exact("u", "L2", 1e-12, "theory"), series([1e-15], [0.1]), PASS),
    (Exact("u", "L2", 1e-12, "theory"), series(1e-15 * ONES), PASS),
    (Exact("u", "L2", 1e-12, "theory"), series([1e-15, 1e-15, 2e-12, 1e-15, 1e-15]), FAIL),
    (Exact("u", "L2", 1e-12, "theory"), series([1e-15, np.nan], H[:2]), ERROR),
    (Exact("u", "L2", 1e-12, "theory"), series([], []), ERROR),
    (PUBLISHED, series(3 * H**2), PASS),
    (PUBLISHED, series(3.05 * H**2), FAIL),
    (PUBLISHED, series(3 * H**2 * [1, 1, 1, 1, 1.05]), FAIL),
    (PUBLISHED, series(3 * H[:2] ** 2, H[:2]), INCONCLUSIVE),
    (PUBLISHED, series(3 * H**2, H * 1.01), INCONCLUSIVE),
    (PUBLISHED, series(3 * H**2 * [1, 1, 1, 1, np.nan]), ERROR),
    (ORDER, over_design(3 * DESIGN_H**2 + DESIGN_DT), INCONCLUSIVE),
    (ORDER, series(3 * H**2, 0.1 * ONES, dt=H), PASS),
    (ORDER, series(3 * H, 0.1 * ONES, dt=H), FAIL),
    (ORDER, series(3.0 * 2.0 ** (-2 * np.arange(5)), 0.1 * ONES, dt=0.1 * ONES, ppc=2 ** np.arange(5)), PASS),
    (ORDER, series(1e-3 + 3 * H**2, 0.1 * ONES, dt=H), FAIL),
    (STALL, over_design(3 * DESIGN_H**2 + DESIGN_DT), INCONCLUSIVE),
    (SEPARATED, over_design(3 * DESIGN_H**2 + DESIGN_DT), PASS),
    (SEPARATED, over_design(np.sqrt(9 * DESIGN_H**4 + DESIGN_DT**2)), PASS),
    (SEPARATED, over_design(3 * DESIGN_H**2 + 9 * DESIGN_DT**2), FAIL),
    (SEPARATED, over_design(DESIGN_H + DESIGN_DT), FAIL),
    (SEPARATED, over_design(3 * DESIGN_H), FAIL),
    (SEPARATED, over_design(3 * DESIGN_H**2), INCONCLUSIVE),
    (SEPARATED, over_design(3 * DESIGN_H**1.8 + DESIGN_DT**1.2), INCONCLUSIVE),
    (SEPARATED, over_design(3 * DESIGN_H**2 * np.tile([1, 1.3], 8)), INCONCLUSIVE),
    (SEPARATED, over_design(np.zeros(16)), INCONCLUSIVE),
    (SEPARATED, series(3 * H**2), INCONCLUSIVE),
    (SEPARATED, series([0.1], [0.1]), INCONCLUSIVE),
    (SEPARATED, over_design(np.where(DESIGN_H < 0.02, np.nan, DESIGN_H**2)), ERROR),
    (Balance("momentum", "impulse", "theory"), measured(momentum_defect=1e-15 * ONES), PASS),
    (Balance("momentum", "impulse", "theory"), measured(momentum_defect=1e-11 * ONES), FAIL),
    (Balance("momentum", "impulse", "theory"), measured(momentum_defect=[0, 0, 0, 0, np.nan]), ERROR),
    (Balance("momentum", "impulse", "theory"), measured(momentum_defect=[0, 0, 0, 0, -1]), ERROR),
    (Balance("momentum", "impulse", "theory"), measured(), ERROR),
    (ExactTotal("momentum", "theory"), measured(momentum_error=1e-15 * ONES), PASS),
    (ExactTotal("momentum", "theory"), measured(momentum_error=[0, 0, 0, 0, 1e-11]), FAIL),
    (ExactTotal("momentum", "theory"), measured(momentum_error=[0, 0, np.nan, 0, 0]), ERROR),
    (ExactTotal("momentum", "theory"), measured(), ERROR),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=1e-13 * ONES), PASS),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=1e-2 * H**2), PASS),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=1e-2 * H**3), PASS),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=1e-2 * H), FAIL),
    (EnergyDrift(0.7, "theory"), measured(energy_drift=1e-2 * ONES), FAIL),
    (EnergyDrift(0.7, "theory"), measured(energy_drift=1e-4 + 1e2 * H**4), FAIL),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=1e-2 * H**2 * [1, 1.4, 0.8, 1.5, 0.9]), INCONCLUSIVE),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=[1e-3, 1e-4, 1e-13, 0, 0]), INCONCLUSIVE),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=1e-2 * H**2 * [1, 1, 1, 1, 0]), INCONCLUSIVE),
    (EnergyDrift(1.8, "theory"), series(H, metrics={"energy_drift": 1e-2 * H**2}, dt=0.1 * ONES), INCONCLUSIVE),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=[1, 1, 1, np.inf, 1]), ERROR),
    (EnergyDrift(1.8, "theory"), measured(energy_drift=-1e-2 * ONES), ERROR),
    (EnergyDrift(1.8, "theory"), measured(), ERROR),
    (EnergyConserved("theory"), measured(energy_drift=1e-13 * ONES), PASS),
    (EnergyConserved("theory"), measured(energy_drift=1e-2 * H**2), FAIL),
    (EnergyConserved("theory"), measured(energy_drift=[0, 0, np.nan, 0, 0]), ERROR),
    (EnergyConserved("theory"), measured(), ERROR),
    (EnergyDecays("theory"), measured(energy_rise=[0, 1e-13, 0, 0, 0]), PASS),
    (EnergyDecays("theory"), measured(energy_rise=[0, 0, 0, 0, 1e-10]), FAIL),
    (EnergyDecays("theory"), measured(energy_rise=[0, 0, np.nan, 0, 0]), ERROR),
    (EnergyDecays("theory"), measured(), ERROR),
    (SUMS, measured(mass_sum_defect=0 * ONES, momentum_sum_defect=1e-14 * ONES), PASS),
    (SUMS, measured(mass_sum_defect=0 * ONES, momentum_sum_defect=[0, 0, 0, 0, 1e-11]), FAIL),
    (SUMS, measured(mass_sum_defect=ONES, momentum_sum_defect=0 * ONES), FAIL),
    (SUMS, measured(mass_sum_defect=0 * ONES, momentum_sum_defect=[0, 0, 0, 0, np.nan]), ERROR),
    (SUMS, measured(mass_sum_defect=0 * ONES), ERROR),
    (SUMS, measured(mass_sum_defect=0 * ONES, momentum_sum_lacks_velocity=ONES), ERROR),
    (
        SUMS,
        measured(mass_sum_defect=0 * ONES, momentum_sum_defect=0 * ONES, momentum_sum_lacks_history=[1, *4 * [np.nan]]),
        ERROR,
    ),
    (SUMS, measured(), ERROR),
    (LIMIT, series(ONES, courant=4 * ONES, metrics=limits(1.005)), PASS),
    (LIMIT, series(ONES, courant=4 * ONES, metrics=limits(1.02)), FAIL),
    (LIMIT, series(ONES, courant=4 * ONES, metrics=limits(np.nan)), ERROR),
    (LIMIT, series(ONES, courant=0.7 * ONES, metrics=limits(1.0)), ERROR),
    (UNSTABLE, series(ONES, outcomes=5 * GREW), PASS),
    (UNSTABLE, series(ONES), FAIL),
    (UNSTABLE, series(ONES, outcomes=(*4 * GREW, "completed")), FAIL),
    (UNSTABLE, series(ONES, outcomes=(*4 * GREW, "crashed; it raised")), ERROR),
    (UNSTABLE, series(ONES, outcomes=(*4 * GREW, "non-finite; at step 2 of 9")), ERROR),
    (UNSTABLE, series(ONES, outcomes=5 * GREW, courant=[0.5, 0.5, 0.4, 0.5, 0.5] * ONES), ERROR),
    (UNSTABLE, series(ONES, outcomes=5 * GREW, courant=np.nan * ONES), ERROR),
    (Amplification(1, 1e-12, "theory"), measured(amplification_defect=1e-14 * ONES, amplification_modes=ONES), PASS),
    (Amplification(1, 1e-12, "theory"), measured(amplification_defect=1e-3 * ONES, amplification_modes=ONES), FAIL),
    (Amplification(1, 1e-12, "theory"), measured(amplification_defect=0 * ONES, amplification_modes=0 * ONES), ERROR),
    (Amplification(1, 1e-12, "theory"), measured(amplification_defect=1e-14 * ONES), ERROR),
    (Amplification(1, 1e-12, "theory"), measured(), ERROR),
    (DISPERSION, measured(dispersion_defect_u=1e-13 * ONES, phase_angle_u=ONES), PASS),
    (DISPERSION, measured(dispersion_defect_u=1e-2 * ONES, phase_angle_u=ONES), FAIL),
    (DISPERSION, measured(dispersion_defect_u=[0, 0, 0, 0, 1e-9], phase_angle_u=ONES), FAIL),
    (DISPERSION, measured(dispersion_defect_u=[0, 0, 0, 0, np.nan], phase_angle_u=ONES), ERROR),
    (DISPERSION, measured(dispersion_defect_u=1e-13 * ONES, phase_angle_u=[1, 2, 3, 3.2, 1]), ERROR),
    (DISPERSION, measured(dispersion_defect_u=1e-13 * ONES), ERROR),
    (PHASE, measured(phase_error_u=-3 * H**2), PASS),
    (PHASE, measured(phase_error_u=-3 * H**2 * (1 + 3 * H**2)), PASS),
    (PHASE, measured(phase_error_u=3 * H**2), FAIL),
    (PHASE, measured(phase_error_u=-3.1 * H**2), FAIL),
    (PHASE, measured(phase_error_u=-3 * H), FAIL),
    (PHASE, measured(phase_error_u=-0.01 - 3 * H**2), FAIL),
    (PHASE, measured(phase_error_u=np.zeros(5)), FAIL),
    (PHASE, measured(phase_error_u=-3 * H**2 * [1, 1.4, 0.8, 1.5, 1.0]), INCONCLUSIVE),
    (PHASE, measured(phase_error_u=-3 * H**2 * [1, 1, 1, 1, np.nan]), ERROR),
    (PHASE, measured(), ERROR),
    (LOSSLESS, measured(amplitude_decay_u=1e-14 * ONES), PASS),
    (LOSSLESS, measured(amplitude_decay_u=3 * H**3), INCONCLUSIVE),
    (LOSSLESS, measured(amplitude_decay_u=3 * H), FAIL),
    (DECAY, measured(amplitude_decay_u=3 * H**3), PASS),
    (DECAY, measured(amplitude_decay_u=-3 * H**3), FAIL),
    (DECAY, measured(amplitude_decay_u=3 * H**2), FAIL),
    (DECAY, measured(amplitude_decay_u=3 * H**3 * [1, 1.4, 0.8, 1.5, 1.0]), INCONCLUSIVE),
    (DECAY, measured(amplitude_decay_u=[np.nan, 1, 1, 1, 1]), ERROR),
    (DECAY, measured(), ERROR),
    (FRONT, measured(front_lag_u=2.05 * ONES, theoretical_front_lag_u=2 * ONES), PASS),
    (FRONT, measured(front_lag_u=-2 * ONES, theoretical_front_lag_u=2 * ONES), FAIL),
    (FRONT, measured(front_lag_u=[2, 2, 2, 2, 2.2], theoretical_front_lag_u=2 * ONES), FAIL),
    (FRONT, measured(front_lag_u=[2, 2, 2, 2, np.nan], theoretical_front_lag_u=2 * ONES), ERROR),
    (FRONT, measured(front_lag_u=ONES), ERROR),
    (FRONT, measured(), ERROR),
    (PATCH, measured(stress_deviation=1e-13 * ONES), PASS),
    (PATCH, measured(stress_deviation=[1e-13, 0, 0, 0, 2e-12]), FAIL),
    (PATCH, measured(stress_deviation=[1e-13, 0, 0, 0, np.nan]), ERROR),
    (PATCH, measured(stress_deviation=[1e-13, 0, 0, 0, -np.inf]), ERROR),
    (PATCH, measured(), ERROR),
    (OFF, measured(**{"stress_deviation_0.5_inside": 0.3 * ONES}), PASS),
    (OFF, measured(**{"stress_deviation_0.5_inside": [0.3, 0.3, 0.3, 0.3, 0.1]}), FAIL),
    (OFF, measured(**{"stress_deviation_0.5_inside": [0.3, 0.3, 0.3, 0.3, 0.5]}), FAIL),
]


@pytest.mark.parametrize(("criterion", "evidence", "expected"), EXAMPLES)
def test_verdicts_of_the_examples(criterion, evidence, expected):
    assert verdict(criterion, evidence) is expected


@pytest.mark.parametrize(("criterion", "evidence", "expected"), EXAMPLES)
def test_criteria_read_back_from_json_give_the_same_verdict(criterion, evidence, expected):
    stored = json.loads(json.dumps({"type": type(criterion).__name__} | dataclasses.asdict(criterion)))
    again = CRITERIA[stored.pop("type")](**stored)
    assert again.title == criterion.title
    assert again.source == "theory" or isinstance(criterion, Published)
    assert judge_criterion(again, evidence) == judge_criterion(criterion, evidence)


def test_the_examples_cover_every_verdict_of_every_criterion():
    given_ = {(type(criterion), expected) for criterion, _, expected in EXAMPLES}
    for kind in CRITERIA.values():
        doubts = kind in (Order, Stall, Published, Separated, EnergyDrift, PhaseError, AmplitudeDecay)
        assert {v for k, v in given_ if k is kind} == {PASS, FAIL, ERROR} | ({INCONCLUSIVE} if doubts else set())


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


@LIGHT
@given(st.permutations(range(5)), st.sampled_from(EXAMPLES))
def test_verdicts_do_not_depend_on_the_order_of_levels(shuffled, example):
    criterion, evidence, expected = example
    if len(evidence.h) != 5:
        return
    k = list(shuffled)
    other = Evidence(
        *(getattr(evidence, name)[k] for name in ("h", "dt", "courant", "ppc")),
        evidence.outcomes,
        *({q: v[k] for q, v in getattr(evidence, name).items()} for name in ("error", "reference", "metrics")),
    )
    assert judge_criterion(criterion, other)[0] is expected


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


# Measurements on solutions.


def setting(problem, h=0.1, **fields) -> Setting:
    """Setting of a problem with the given exact fields."""
    return Setting(VerificationProblem(problem, ExactSolution(fields, ""), "", ()), Discretisation(h, COURANT))


COURANT = 0.5
BAR_PROBLEM = Problem("bar", (0.0,), (1.0,), LinearElastic(1.0, 2.0), {"x-": Traction(), "x+": Traction()}, 1.0)
BAR = setting(BAR_PROBLEM)
N = 11


def histories(**changed) -> Solution:
    """Solution with the histories of a mass on a spring with unit energy."""
    time = np.linspace(0, 1, N)
    table = {
        "time": time,
        "mass": np.full(N, 2.0),
        "momentum": 3 + 0.5 * time,
        "impulse": 0.5 * time,
        "kinetic_energy": np.cos(time) ** 2,
        "strain_energy": np.sin(time) ** 2,
        "external_work": np.zeros(N),
    } | changed
    table = {name: values for name, values in table.items() if values is not None}
    field = np.zeros((2, 1, 1))
    return Solution(np.array([0.0, 1.0]), 0.1, np.zeros((1, 1)), field, field[..., 0], {}, table, Work())


MOMENTUM, MASS, ENERGY = Balance("momentum", "impulse", ""), Balance("mass", "", ""), EnergyDrift(1.8, "")
RISE = EnergyDecays("")
ROUND_OFF = 1e-14


@pytest.mark.parametrize(
    ("criterion", "metric"),
    [(MOMENTUM, "momentum_defect"), (MASS, "mass_defect"), (ENERGY, "energy_drift"), (RISE, "energy_rise")],
)
def test_histories_that_balance_have_no_defect(criterion, metric):
    assert criterion.measure(histories(), BAR) == {metric: pytest.approx(0, abs=ROUND_OFF)}


@LIGHT
@given(st.floats(-1, 1).filter(lambda loss: abs(loss) > 1e-9), st.integers(0, N - 1))
def test_a_loss_at_any_time_is_measured_relative_to_its_scale(loss, when):
    kick = np.zeros(N)
    kick[when] = loss
    assert MASS.measure(histories(mass=2 + kick), BAR)["mass_defect"] == pytest.approx(abs(loss) / max(2, 2 + loss))
    momentum = MOMENTUM.measure(histories(momentum=histories().histories["momentum"] + kick), BAR)["momentum_defect"]
    assert abs(loss) / 5 < momentum < abs(loss) / 2.9
    drift = ENERGY.measure(histories(external_work=kick), BAR)["energy_drift"]
    assert drift == pytest.approx(abs(loss), rel=1e-6)
    rises = (loss < 0 and when > 0) or (loss > 0 and when < N - 1)
    assert RISE.measure(histories(external_work=kick), BAR)["energy_rise"] == pytest.approx(abs(loss) * rises, rel=1e-6)


def test_the_mass_of_a_body_is_compared_with_its_reference_density():
    assert MASS.measure(histories(mass=np.full(N, -2.0)), BAR)["mass_defect"] == pytest.approx(2)
    assert MASS.measure(histories(mass=np.full(N, 2.5)), BAR)["mass_defect"] == pytest.approx(0.2)


def test_the_momentum_defect_is_relative_to_the_particle_momenta_and_the_mass_defect_is_not():
    """Two particles fly apart at speed 100: the total momentum is zero to the round-off of their momenta, of any histories."""
    fast = {"momentum": np.zeros(N), "impulse": np.zeros(N)}
    slip = np.append(np.zeros(N - 1), 1e-11)
    apart = histories(**fast | {"momentum": slip, "kinetic_energy": None, "mass": None})
    points, time = np.array([[0.25], [0.75]]), np.array([0.0, 1.0])
    velocity = np.tile([[-100.0], [100.0]], (2, 1, 1))
    apart = dataclasses.replace(apart, time=time, reference=points, weight=np.full((2, 2), 0.5))
    for fields, position in (
        ({"velocity": velocity}, points[None] + 0 * velocity),
        ({}, points + time[:, None, None] * velocity),
    ):
        moved = dataclasses.replace(apart, fields=fields, position=position)
        scale = BAR.problem.problem.material.density * 100
        assert MOMENTUM.measure(moved, BAR)["momentum_defect"] == pytest.approx(1e-11 / scale)
    assert MASS.measure(histories(**fast | {"mass": 2 + slip}), BAR)["mass_defect"] == pytest.approx(0.5e-11, rel=1e-4)


@LIGHT
@given(
    st.sampled_from([(MOMENTUM, "momentum"), (MOMENTUM, "impulse")])
    | st.sampled_from([(MASS, "mass"), (ENERGY, "kinetic_energy"), (ENERGY, "strain_energy"), (ENERGY, "external_work")]),
    st.sampled_from([np.nan, np.inf]),
    st.integers(0, N - 1),
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_a_non_finite_history_gives_a_non_finite_metric(which, bad, when):
    criterion, name = which
    values = histories().histories[name].copy()
    values[when] = bad
    (metric,) = criterion.measure(histories(**{name: values}), BAR).values()
    assert not math.isfinite(metric)


@pytest.mark.parametrize(
    ("criterion", "missing"),
    [
        (MOMENTUM, ("momentum", "impulse")),
        (MASS, ("mass",)),
        *((c, ("kinetic_energy", "strain_energy", "external_work")) for c in (ENERGY, RISE)),
    ],
)
def test_missing_and_zero_histories_are_not_measured(criterion, missing):
    for name in missing:
        assert criterion.measure(histories(**{name: None}), BAR) == {}
    every = histories().histories
    zero = criterion.measure(histories(**{name: np.zeros(N) for name in every}), BAR)
    found, reason = judge_criterion(criterion, measured(**{name: value * ONES for name, value in zero.items()}))
    if criterion is not MASS:  # a body of mass zero is compared with the reference density
        assert found is ERROR
        assert f"zero throughout at h={H[0]:g}" in reason
    assert criterion.measure(histories(**{name: values[:1] for name, values in every.items()}), BAR) == {}


def test_momentum_is_measured_without_mass_and_energy():
    alone = histories(mass=None, kinetic_energy=None, momentum=np.linspace(1, 2, N))
    assert MOMENTUM.measure(alone, BAR) == {"momentum_defect": pytest.approx(0.25)}


def test_the_drift_of_an_energy_with_the_wrong_sign_is_positive():
    wrong = histories(strain_energy=-5 * np.sin(histories().histories["time"]) ** 2 - 2)
    assert ENERGY.measure(wrong, BAR)["energy_drift"] > 0.1


# Amplification.

CELLS, STEPS = 16, 12
LOOP = setting(Problem("loop", (0.0,), (1.0,), Transport(2.0), {"x-": Periodic(), "x+": Periodic()}, 1.0))


def carried(passes, *, steps=STEPS, lag=0) -> Solution:
    """Random data after steps of a scheme with the declared amplification factor; an output every fourth step."""
    start = np.random.default_rng(0).standard_normal(CELLS)
    dt = COURANT / CELLS / 2.0
    count = np.arange(0, steps + 1, 4)
    factor = two_step_taylor_galerkin(2 * np.pi * np.arange(CELLS // 2 + 1) / CELLS, COURANT, passes)
    u = np.fft.irfft(np.fft.rfft(start) * factor ** np.maximum(count - lag, 0)[:, None], CELLS, axis=1)
    x = np.arange(CELLS)[:, None] / CELLS
    weight = np.full((len(count), CELLS), 1 / CELLS)
    return Solution(count * dt, dt, x, np.broadcast_to(x, (len(count), CELLS, 1)), weight, {"u": u[..., None]}, {}, Work())


@pytest.mark.parametrize("passes", [1, 2, 5])
def test_every_mode_follows_its_amplification_factor(passes):
    found = Amplification(passes, 1e-12, "").measure(carried(passes), LOOP)
    assert found["amplification_defect"] < 1e-12
    assert found["amplification_modes"] == 1


def test_another_scheme_or_a_lag_of_one_step_gives_a_defect():
    criterion = Amplification(1, 1e-12, "")
    assert criterion.measure(carried(2), LOOP)["amplification_defect"] > 1e-2
    assert criterion.measure(carried(1, lag=1), LOOP)["amplification_defect"] > 1e-2


def test_amplification_needs_time_steps_a_nonzero_field_and_an_advection_problem():
    criterion, good = Amplification(1, 1e-12, ""), carried(1)
    assert criterion.measure(carried(1, steps=0), LOOP) == {}
    assert criterion.measure(dataclasses.replace(good, fields={}), LOOP) == {}
    zero = criterion.measure(dataclasses.replace(good, fields={"u": 0 * good.fields["u"]}), LOOP)
    found = judge_criterion(criterion, measured(**{name: value * ONES for name, value in zero.items()}))
    assert found == (FAIL, f"the profile is zero at the start at h={H[0]:g}")
    assert criterion.measure(good, BAR) == {}


@pytest.mark.parametrize("output", [0, 1, -1])
def test_amplification_of_a_non_finite_field_is_nan(output):
    good = carried(1)
    u = good.fields["u"].copy()
    u[output, 3] = np.nan
    found = Amplification(1, 1e-12, "").measure(dataclasses.replace(good, fields={"u": u}), LOOP)
    assert all(math.isnan(value) for value in found.values())


# Several verdicts.


@pytest.mark.parametrize(
    ("verdicts", "expected", "status", "strict"),
    [
        ([PASS], PASS, 0, 0),
        ([PASS, PASS], PASS, 0, 0),
        ([PASS, INCONCLUSIVE], INCONCLUSIVE, 0, 4),
        ([INCONCLUSIVE, FAIL, PASS], FAIL, 1, 1),
        ([FAIL] * 300, FAIL, 1, 1),
        ([FAIL, ERROR, PASS], ERROR, 3, 3),
        ([ERROR, INCONCLUSIVE], ERROR, 3, 3),
        ([], INCONCLUSIVE, 3, 3),
    ],
)
def test_the_worst_verdict_decides_the_exit_status(verdicts, expected, status, strict):
    assert worst(verdicts) is expected
    assert exit_status(verdicts) == status
    assert exit_status(verdicts, strict=True) == strict


@LIGHT
@given(st.lists(st.sampled_from(list(Verdict)), min_size=1), st.sampled_from(list(Verdict)))
def test_one_more_verdict_never_improves_the_worst(verdicts, another):
    order = list(Verdict)
    assert order.index(worst([*verdicts, another])) >= order.index(worst(verdicts))
    assert worst(verdicts) in verdicts


def test_a_finding_reads_as_one_sentence():
    finding = Finding("bar", "step", "tg", "nu_C=0.5", "verification", "order", FAIL, "order 1.0", "theory")
    assert str(finding) == "FAIL bar/step/tg (nu_C=0.5): order: order 1.0"
