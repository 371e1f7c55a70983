"""What the wave criteria measure on solutions: delays, decays and lags that were put in, and nothing where there is no wave."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.criteria import AmplitudeDecay, Dispersion, FrontPosition, PhaseError
from mpmverify.criteria.criterion import Setting
from mpmverify.errors import UsageError
from mpmverify.exact.advection import Gaussian, Step, advection
from mpmverify.exact.dispersion import RELATIONS
from mpmverify.exact.elastic_bar import StepLoad, elastic_bar
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Discretisation
from mpmverify.solution import Solution, Work

LIGHT = settings(max_examples=25)
CELLS = 200
PHASE, DECAY = PhaseError("u", 2, 0.2, "", "tg-lumped", 1.0), AmplitudeDecay("u", 3, 0.2, "", "tg-lumped", 1.0)
FRONT = FrontPosition("u", "tg-lumped", 0.1, "")


def late(verification, quantity, *, delay=0.0, gain=1.0, filtered=1.0, seed=None):
    """Solution of two outputs that is exact at first and late and damped at last; seen through a filter of all its samples."""
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
def test_a_late_pulse_has_its_delay_for_phase_error(share, gain, velocity, seed):
    problem = advection(Gaussian(), velocity=velocity)
    delay = share * problem.problem.end_time
    for solution in (late(problem, "u", delay=delay, gain=gain), late(problem, "u", delay=delay, gain=gain, seed=seed)):
        assert PHASE.measure(solution, setting(problem)) == {"phase_error_u": pytest.approx(share, abs=1e-9)}


@LIGHT
@given(st.floats(0.1, 2), st.floats(-0.2, 0.2), st.floats(0.5, 1))
def test_decay_is_free_of_delay_and_of_how_samples_are_taken(gain, delay, filtered):
    problem = advection(Gaussian())
    solution = late(problem, "u", delay=delay, gain=gain, filtered=filtered)
    assert DECAY.measure(solution, setting(problem)) == {"amplitude_decay_u": pytest.approx(1 - gain, abs=1e-9)}


@LIGHT
@given(st.floats(-0.1, 0.1), st.sampled_from(["right", "left", "reflected"]), st.integers(0, 99))
def test_a_late_front_lags_by_what_it_has_not_travelled(delay, kind, seed):
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


def without_samples(solution, value):
    (quantity,) = solution.fields
    fields = {quantity: np.full_like(solution.fields[quantity], value)}
    return dataclasses.replace(solution, fields=fields)


@pytest.mark.parametrize("criterion", [PHASE, DECAY, FRONT])
@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_nothing_and_what_is_not_finite_have_no_error_that_is_a_number(criterion, value):
    problem = advection(Step() if criterion is FRONT else Gaussian())
    found = criterion.measure(without_samples(late(problem, "u"), value), setting(problem))
    assert not math.isfinite(found[criterion.metrics[0] if criterion is FRONT else criterion.metric])


@pytest.mark.parametrize("criterion", [PHASE, DECAY, FRONT])
def test_an_absent_quantity_is_not_measured(criterion):
    problem = advection(Gaussian())
    assert dataclasses.replace(criterion, quantity="stress").measure(late(problem, "u"), setting(problem)) == {}
    assert criterion.measure(dataclasses.replace(late(problem, "u"), fields={}), setting(problem)) == {}


def test_a_bar_at_rest_at_first_has_no_decay_that_is_a_number():
    problem = elastic_bar(StepLoad())
    (decay,) = dataclasses.replace(DECAY, quantity="stress").measure(late(problem, "stress"), setting(problem)).values()
    assert math.isnan(decay)


# Dispersion.

RING = axial_vibration(2, "periodic", length=2.0, youngs_modulus=9.0, density=4.0)
K, STEPS, H = 2 * math.pi, 40, 0.2


def oscillating(scheme, *, courant=0.4, ppc=2, every=1, factor=1.0):
    """Mode that obeys a scheme's relation, but for a factor of its frequency."""
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
def test_a_mode_that_obeys_the_relation_has_no_defect_and_every_other_has(scheme):
    found = dispersion(scheme).measure(oscillating(scheme), LEVEL)
    assert found["dispersion_defect_stress"] < 1e-12
    assert found["phase_angle_stress"] == pytest.approx(K * H)
    assert found["relative_frequency_stress"] == pytest.approx(found["theoretical_frequency_stress"])
    assert found["relative_frequency_stress"] == pytest.approx(1, abs=0.4)
    slow = dispersion(scheme).measure(oscillating(scheme, factor=0.99), LEVEL)
    assert slow["dispersion_defect_stress"] == pytest.approx(0.01)
    for other in RELATIONS:
        if RELATIONS[other](np.ones(1), 0.4, 2) == RELATIONS[scheme](np.ones(1), 0.4, 2):
            continue  # USF and MUSL, updated and total
        assert dispersion(other).measure(oscillating(scheme), LEVEL)["dispersion_defect_stress"] > 1e-4


def test_steps_that_are_not_returned_are_not_guessed():
    assert dispersion("tg-lumped").measure(oscillating("tg-lumped", every=2), LEVEL) == {}


def test_particles_per_cell_belong_to_the_relation():
    scheme = "mpm-tl-linear-usl-flip"
    other = dataclasses.replace(LEVEL, discretisation=Discretisation(H, 0.4, 3))
    assert dispersion(scheme).measure(oscillating(scheme), other)["dispersion_defect_stress"] > 1e-3


@pytest.mark.parametrize("value", [0.0, 1.0, np.nan, np.inf])
def test_what_does_not_oscillate_has_a_defect_that_is_no_number(value):
    found = dispersion("tg-lumped").measure(without_samples(oscillating("tg-lumped"), value), LEVEL)
    assert math.isnan(found["dispersion_defect_stress"])


def test_an_unknown_relation_is_named():
    with pytest.raises(UsageError, match="'tg-upwind' is unknown: choose from"):
        dispersion("tg-upwind")
    for criterion in (PHASE, DECAY, FRONT):
        with pytest.raises(UsageError, match="'tg-upwind' is unknown: choose from"):
            dataclasses.replace(criterion, relation="tg-upwind")
