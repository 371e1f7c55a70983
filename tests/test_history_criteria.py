"""Measurements on the histories of a solution, and of its amplification."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from series_evidence import (
    ERROR,
    FAIL,
    LIGHT,
    ONES,
    H,
    measured,
)

from mpmverify.criteria import (
    Amplification,
    Balance,
    EnergyConserved,
    EnergyDecays,
    EnergyDrift,
)
from mpmverify.criteria.criterion import Setting
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.exact.amplification import two_step_taylor_galerkin
from mpmverify.judgement.findings import judge_criterion
from mpmverify.problem import Constant, Discretisation, LinearElastic, Periodic, Problem, Traction, Transport
from mpmverify.solution import Solution, Work

# Measurements on solutions.


def setting(problem, h=0.1, **fields) -> Setting:
    """Setting of a problem with the given exact fields."""
    return Setting(VerificationProblem(problem, ExactSolution(fields, ""), "", ()), Discretisation(h, COURANT))


COURANT = 0.5
BAR_PROBLEM = Problem("bar", (0.0,), (1.0,), LinearElastic(1.0, 2.0), {"x-": Traction(), "x+": Traction()}, 1.0)
BAR = setting(BAR_PROBLEM)
PULLED = setting(dataclasses.replace(BAR_PROBLEM, boundary={"x-": Traction(), "x+": Traction(Constant(1.0))}))
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
    drift = ENERGY.measure(histories(external_work=kick), PULLED)["energy_drift"]
    assert drift == pytest.approx(abs(loss), rel=1e-6)
    rises = (loss < 0 and when > 0) or (loss > 0 and when < N - 1)
    assert RISE.measure(histories(external_work=kick), PULLED)["energy_rise"] == pytest.approx(abs(loss) * rises, rel=1e-6)


def test_where_no_load_does_work_a_loss_is_none():
    loss = np.linspace(0, 0.5, N)
    lossy = histories(strain_energy=histories().histories["strain_energy"] - loss, external_work=-loss)
    assert ENERGY.measure(lossy, BAR)["energy_drift"] == pytest.approx(0.5, rel=0.2)
    assert ENERGY.measure(lossy, PULLED)["energy_drift"] == pytest.approx(0, abs=ROUND_OFF)


@pytest.mark.parametrize("speed", [0.0, 3.0, np.nan])
def test_kinetic_energies_are_held_against_those_of_the_points(speed):
    """Half of density 2, volume 1 and speed 1 squared is 1 at the start; the energies at the end are 0.29 and 0.71."""
    moving = dataclasses.replace(
        histories(), weight=np.ones((2, 1)), fields={"velocity": np.array([1.0, np.cos(1.0)]).reshape(2, 1, 1)}
    )
    (drift,) = ENERGY.measure(moving, BAR).values()
    assert drift < ROUND_OFF
    other = dataclasses.replace(moving, fields={"velocity": np.full((2, 1, 1), speed)})
    for criterion in (ENERGY, RISE, EnergyConserved("")):
        assert len(criterion.measure(moving, BAR)) == 1
        found = {name: value * ONES for name, value in criterion.measure(other, BAR).items()}
        verdict, reason = judge_criterion(criterion, measured(**found))
        assert verdict is FAIL
        assert "over the sample points" in reason


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
    (metric,) = criterion.measure(histories(**{name: values}), PULLED).values()
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
