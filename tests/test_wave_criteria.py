"""Measurements of the wave criteria: imposed delays, decays and lags are recovered, and NaN is returned where there is no wave."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import AmplitudeDecay, Dispersion, FrontPosition, PhaseError
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.metrics import Metrics
from mpmverify.errors import UsageError
from mpmverify.exact.advection import Gaussian, Step, advection
from mpmverify.exact.dispersion import RELATIONS
from mpmverify.exact.elastic_bar import StepLoad, elastic_bar
from mpmverify.exact.vibration import axial_vibration
from mpmverify.judgement.findings import judge_criterion
from mpmverify.problem import Discretisation
from mpmverify.solution import Solution, Work

LIGHT = settings(max_examples=25)
CELLS = 200
PHASE, DECAY = PhaseError("u", 2, 0.2, "", "tg-lumped", 1.0), AmplitudeDecay("u", 3, 0.2, "", "tg-lumped", 1.0)
FRONT = FrontPosition("u", "tg-lumped", 0.1, "")


def late(verification, quantity, *, delay=0.0, gain=1.0, filtered=1.0, seed=None):
    """Solution with two outputs: exact at first, delayed and scaled by `gain` at the final time; all samples times `filtered`."""
    problem = verification.problem
    x = (np.arange(CELLS) + 0.5)[:, None] / CELLS * problem.upper[0]
    weight = np.full(CELLS, problem.upper[0] / CELLS)
    if seed is not None:
        edges = np.sort(np.append(np.random.default_rng(seed).uniform(0, problem.upper[0], CELLS - 1), [0, problem.upper[0]]))
        x, weight = (edges[1:, None] + edges[:-1, None]) / 2, np.diff(edges)
    field, end = verification.exact.fields[quantity], problem.end_time
    values = filtered * np.concatenate([field(x, np.array([0.0])), gain * field(x, np.array([end - delay]))])
    position = np.broadcast_to(x, (2, CELLS, 1))
    weights = np.broadcast_to(weight, (2, CELLS))
    return Solution(np.array([0.0, end]), end, x, position, weights, {quantity: values}, {}, Work())


def setting(verification):
    return Setting(verification, Discretisation(1 / CELLS, 0.5))


@LIGHT
@given(st.floats(-0.1, 0.1), st.floats(0.1, 2), st.sampled_from([1.0, -2.0]), st.integers(0, 99))
def test_phase_error_is_the_relative_delay_of_a_pulse(share, gain, velocity, seed):
    problem = advection(Gaussian(), velocity=velocity)
    delay = share * problem.problem.end_time
    for solution in (late(problem, "u", delay=delay, gain=gain), late(problem, "u", delay=delay, gain=gain, seed=seed)):
        assert PHASE.measure(solution, setting(problem)) == {"phase_error_u": pytest.approx(share, abs=1e-9)}


@LIGHT
@given(st.floats(0.1, 2), st.floats(-0.2, 0.2), st.floats(0.5, 1))
def test_decay_does_not_depend_on_delay_and_filtering(gain, delay, filtered):
    problem = advection(Gaussian())
    solution = late(problem, "u", delay=delay, gain=gain, filtered=filtered)
    assert DECAY.measure(solution, setting(problem)) == {"amplitude_decay_u": pytest.approx(1 - gain, abs=1e-9)}


@LIGHT
@given(st.floats(-0.1, 0.1), st.sampled_from(["right", "left", "reflected"]), st.integers(0, 99))
def test_front_lag_is_the_distance_of_the_delay(delay, kind, seed):
    problem, quantity = {
        "right": (advection(Step()), "u"),
        "left": (advection(Step(0.75, 0.0, 1.0), velocity=-1.0), "u"),
        "reflected": (elastic_bar(StepLoad()), "stress"),
    }[kind]
    criterion = dataclasses.replace(FRONT, quantity=quantity)
    solution = late(problem, quantity, delay=delay, seed=seed)
    spacing = np.diff(solution.reference[:, 0]).max()
    lag, theory = criterion.measure(solution, setting(problem)).values()
    assert lag == pytest.approx(delay * CELLS, abs=spacing * CELLS)
    assert math.isfinite(theory)


def judged(criterion, measured) -> tuple[Verdict, str]:
    """Verdict on one level on which this was measured."""
    one = np.ones(1)
    metrics = Metrics({name: np.array([value]) for name, value in measured.items()})
    return judge_criterion(criterion, Evidence(0.2 * one, one, one, one.astype(int), ("completed",), metrics=metrics))


def with_constant(solution, value):
    (quantity,) = solution.fields
    fields = {quantity: np.full_like(solution.fields[quantity], value)}
    return dataclasses.replace(solution, fields=fields)


@pytest.mark.parametrize("criterion", [PHASE, DECAY, FRONT])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_non_finite_solutions_have_no_finite_error(criterion, value):
    problem = advection(Step() if criterion is FRONT else Gaussian())
    found = criterion.measure(with_constant(late(problem, "u"), value), setting(problem))
    assert not math.isfinite(found[criterion.metrics[0] if criterion is FRONT else criterion.metric])


@pytest.mark.parametrize(
    ("criterion", "sentence"),
    [(PHASE, "no wave of u is found"), (DECAY, "no wave of u is found"), (FRONT, "no front of u is found")],
)
def test_a_wave_that_is_not_found_is_a_failure_that_says_so_and_not_a_missing_field(criterion, sentence):
    problem = advection(Step() if criterion is FRONT else Gaussian())
    found = judged(criterion, criterion.measure(with_constant(late(problem, "u"), 0.0), setting(problem)))
    assert found == (Verdict.FAIL, f"{sentence} at h=0.2")


@pytest.mark.parametrize("criterion", [PHASE, DECAY, FRONT])
def test_an_absent_quantity_is_not_measured(criterion):
    problem = advection(Gaussian())
    assert dataclasses.replace(criterion, quantity="stress").measure(late(problem, "u"), setting(problem)) == {}
    assert criterion.measure(dataclasses.replace(late(problem, "u"), fields={}), setting(problem)) == {}


def test_a_bar_initially_at_rest_has_no_wave_that_decays():
    problem = elastic_bar(StepLoad())
    (name,) = dataclasses.replace(DECAY, quantity="stress").measure(late(problem, "stress"), setting(problem))
    assert name == "amplitude_decay_stress_absent"


# Dispersion.

RING = axial_vibration(2, "periodic", length=2.0, youngs_modulus=9.0, density=4.0)
K, STEPS, H = 2 * math.pi, 40, 0.2


def oscillating(scheme, *, courant=0.4, ppc=2, every=1, factor=1.0):
    """Mode that follows the dispersion relation of a scheme, with its complex frequency multiplied by a factor."""
    c = RING.problem.material.wave_speed
    dt = courant * H / c
    (z,) = RELATIONS[scheme](np.array([K * H]), courant, ppc)
    n = np.arange(0, STEPS + 1, every)
    x = (np.arange(10)[:, None] + 0.5) * H
    values = (np.exp(np.log(z) * factor * n).imag[:, None] * np.cos(K * x[:, 0]))[:, :, None]
    position, weight = np.broadcast_to(x, (len(n), 10, 1)), np.full((len(n), 10), H)
    return Solution(n * dt, dt, x, position, weight, {"stress": values}, {}, Work())


def dispersion(scheme):
    return Dispersion(scheme, "stress", K, 1e-10, "")


LEVEL = Setting(RING, Discretisation(H, 0.4, 2))


@pytest.mark.parametrize("scheme", RELATIONS)
def test_the_defect_vanishes_only_for_the_relation_of_the_scheme(scheme):
    found = dispersion(scheme).measure(oscillating(scheme), LEVEL)
    assert found["dispersion_defect_stress"] < 1e-12
    assert found["phase_angle_stress"] == pytest.approx(K * H)
    assert found["relative_frequency_stress"] == pytest.approx(found["theoretical_frequency_stress"])
    assert found["relative_frequency_stress"] == pytest.approx(1, abs=0.4)
    slow = dispersion(scheme).measure(oscillating(scheme, factor=0.99), LEVEL)
    assert slow["dispersion_defect_stress"] == pytest.approx(0.01)
    for other in RELATIONS:
        if RELATIONS[other](np.ones(1), 0.4, 2) == RELATIONS[scheme](np.ones(1), 0.4, 2):
            continue  # the same relation: USF and MUSL, updated and total Lagrangian
        assert dispersion(other).measure(oscillating(scheme), LEVEL)["dispersion_defect_stress"] > 1e-4


def test_dispersion_is_not_measured_without_every_step():
    assert dispersion("tg-lumped").measure(oscillating("tg-lumped", every=2), LEVEL) == {}


def test_the_relation_depends_on_the_particles_per_cell():
    scheme = "mpm-tl-linear-usl-flip"
    other = dataclasses.replace(LEVEL, discretisation=Discretisation(H, 0.4, 3))
    assert dispersion(scheme).measure(oscillating(scheme), other)["dispersion_defect_stress"] > 1e-3


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_the_defect_of_a_non_finite_field_is_nan(value):
    found = dispersion("tg-lumped").measure(with_constant(oscillating("tg-lumped"), value), LEVEL)
    assert math.isnan(found["dispersion_defect_stress"])


@pytest.mark.parametrize("value", [0.0, 1.0])
def test_a_mode_that_does_not_oscillate_is_a_failure_that_says_so(value):
    criterion = dispersion("tg-lumped")
    found = judged(criterion, criterion.measure(with_constant(oscillating("tg-lumped"), value), LEVEL))
    assert found == (Verdict.FAIL, "the mode of stress does not oscillate at h=0.2")


def test_an_unknown_relation_is_named():
    with pytest.raises(UsageError, match="'tg-upwind' is unknown: choose from"):
        dispersion("tg-upwind")
    for criterion in (PHASE, DECAY, FRONT):
        with pytest.raises(UsageError, match="'tg-upwind' is unknown: choose from"):
            dataclasses.replace(criterion, relation="tg-upwind")
