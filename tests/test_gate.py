"""Verdicts of every criterion on examples: PASS, FAIL, INCONCLUSIVE and ERROR, in any order of levels; the exit status of several."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from series_evidence import (
    DECAY,
    DESIGN_DT,
    DESIGN_H,
    DISPERSION,
    ERROR,
    FAIL,
    FRONT,
    GREW,
    INCONCLUSIVE,
    LIGHT,
    LIMIT,
    LOSSLESS,
    OFF,
    ONES,
    ORDER,
    PASS,
    PATCH,
    PHASE,
    PUBLISHED,
    SEPARATED,
    STALL,
    SUMS,
    UNSTABLE,
    H,
    falling,
    limits,
    measured,
    over_design,
    series,
    verdict,
)

from mpmverify.convergence.verdict import Verdict, exit_status, worst
from mpmverify.criteria import (
    CRITERIA,
    Amplification,
    AmplitudeDecay,
    Balance,
    EnergyConserved,
    EnergyDecays,
    EnergyDrift,
    Exact,
    ExactTotal,
    Order,
    PhaseError,
    Published,
    Separated,
    Size,
    Stall,
)
from mpmverify.criteria.evidence import Evidence
from mpmverify.judgement.findings import Finding, judge_criterion

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


def test_a_failed_order_says_how_large_the_error_of_the_finest_level_is_and_from_when_on_it_shows():
    onset = np.linspace(0.5, 0.25, len(H))
    said = judge_criterion(ORDER, series(3 * H, metrics={"onset_u": onset}, reference=4.0))[1]
    assert said.endswith(f"; at h={H[-1]:g} the error is {0.75 * H[-1]:.2g} of the field, and shows from t = 0.25 s on")
    assert judge_criterion(ORDER, series(3 * H))[1].endswith(f"; at h={H[-1]:g} the error is {3 * H[-1]:.2g} of the field")
    assert "of the field" not in judge_criterion(ORDER, series(3 * H**2, metrics={"onset_u": onset}))[1]
