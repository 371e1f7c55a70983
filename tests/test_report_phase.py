"""Phase and amplitude over time: right for waves whose phase and amplitude are known, silent on every other motion."""

import math
from pathlib import Path

import numpy as np
import pytest
from faulty_solvers import plan
from hypothesis import given
from hypothesis import strategies as st

from mpmverify import studies
from mpmverify.execution.runner import run
from mpmverify.reports.phase import OUTPUTS, REST, motion, motions
from mpmverify.reports.reader import read
from mpmverify.reports.record import Profile, Series

LENGTH, SPEED, MODULUS, DENSITY = 2.0, 3.0, 18.0, 2.0
X = np.linspace(0, LENGTH, 41)
TIME = np.linspace(0, 1.9, 17)
OMEGA = 2 * math.pi * SPEED / LENGTH
Fields = dict[str, np.ndarray]
KINDS = ("standing", "to the right", "to the left")


def wave(kind: str, frequency: float = OMEGA, ahead: float = 0.0, amplitude: float = 1.0, time: np.ndarray = TIME) -> Fields:
    """Return the fields of a harmonic wave of length `LENGTH`, `ahead` in phase [rad]."""
    k, turned = 2 * math.pi / LENGTH, (frequency * time + ahead)[:, None]
    if kind == "standing":
        d, v, s = (
            np.sin(k * X) * np.sin(turned),
            frequency * np.sin(k * X) * np.cos(turned),
            MODULUS * k * np.cos(k * X) * np.sin(turned),
        )
    else:
        sign = 1 if kind == "to the right" else -1
        angle = k * X - sign * turned
        d, v, s = np.cos(angle), sign * frequency * np.sin(angle), -MODULUS * k * np.sin(angle)
    return {"displacement": amplitude * d, "velocity": amplitude * v, "stress": amplitude * s}


def profile(exact: Fields, fields: Fields, names: tuple[str, ...], time: np.ndarray = TIME) -> Profile:
    kept = [{name: of[name] for name in names} for of in (fields, exact)]
    return Profile(0.1, time, X, *kept, dict.fromkeys(names, "1"))


pairs = st.sampled_from([("displacement", "velocity"), ("stress", "velocity"), ("displacement", "velocity", "stress")])


@given(st.sampled_from(KINDS), pairs, st.floats(-3, 3), st.floats(0.1, 1.9), st.floats(0, 6))
def test_phase_and_amplitude_of_a_wave_are_exact(
    kind: str, names: tuple[str, ...], ahead: float, amplitude: float, start: float
) -> None:
    time = start + TIME**1.2
    exact, numerical = wave(kind, time=time), wave(kind, ahead=ahead, amplitude=amplitude, time=time)
    found = motion(profile(exact, numerical, names, time))
    assert found is not None
    np.testing.assert_allclose(found.phase, ahead, atol=1e-9)
    np.testing.assert_allclose(found.amplitude, amplitude, rtol=1e-9)


@given(st.sampled_from(KINDS), pairs, st.floats(-0.05, 0.05), st.floats(0.5, 1.5))
def test_the_phase_of_a_wave_that_is_too_fast_grows_with_time(
    kind: str, names: tuple[str, ...], epsilon: float, amplitude: float
) -> None:
    """The velocity, larger by 1 + epsilon at the same displacement, puts the phase off by no more than atan((1 + epsilon) tan(psi)) - psi."""
    numerical = wave(kind, OMEGA * (1 + epsilon), amplitude=amplitude)
    found = motion(profile(wave(kind), numerical, names))
    assert found is not None
    assert np.abs(found.phase - epsilon * OMEGA * TIME).max() <= math.asin(abs(epsilon) / (2 + epsilon)) + 1e-9
    assert np.abs(found.amplitude / amplitude - 1).max() <= abs(epsilon) + 1e-9


def test_a_phase_beyond_half_a_turn_is_continuous() -> None:
    found = motion(profile(wave("standing"), wave("standing", 1.2 * OMEGA), ("displacement", "velocity")))
    assert found is not None
    assert found.phase[-1] == pytest.approx(0.2 * OMEGA * TIME[-1], abs=0.15)
    assert found.phase[-1] > math.pi


@pytest.mark.parametrize("names", [("displacement", "velocity"), ("stress", "velocity")])
def test_the_sign_is_right_where_a_period_has_fewer_than_two_outputs(names: tuple[str, str]) -> None:
    time = np.arange(12) * 0.8 * 2 * math.pi / OMEGA
    found = motion(profile(wave("standing", time=time), wave("standing", ahead=0.1, time=time), names, time))
    assert found is not None
    np.testing.assert_allclose(found.phase, 0.1)


def beat() -> Fields:
    one, other = wave("standing"), wave("standing", 1.5 * OMEGA)
    return {name: one[name] + 0.01 * other[name] for name in one}


def stretch() -> Fields:
    ones = np.ones_like(X)
    return {
        "displacement": TIME[:, None] * X,
        "velocity": ones[:, None].T * X + 0 * TIME[:, None],
        "stress": TIME[:, None] * ones,
    }


def pulse() -> Fields:
    d = np.exp(-(((X - 0.5 - 0.5 * TIME[:, None]) / 0.2) ** 2))
    return {"displacement": d, "velocity": 0.5 * d, "stress": d}


def rest() -> Fields:
    return {name: 0 * values for name, values in beat().items()}


def lost() -> Fields:
    return {name: values * np.nan for name, values in beat().items()}


@pytest.mark.parametrize("exact", [beat, stretch, pulse, rest, lost])
@pytest.mark.parametrize("names", [("displacement", "velocity"), ("stress", "velocity")])
def test_a_motion_without_a_single_frequency_has_no_phase(exact, names: tuple[str, str]) -> None:
    assert motion(profile(exact(), exact(), names)) is None


def test_too_little_to_tell_has_no_phase() -> None:
    exact = wave("standing")
    for names in ((), ("velocity",), ("displacement",), ("displacement", "stress")):
        assert motion(profile(exact, exact, names)) is None
    few, short = TIME[: OUTPUTS - 1], np.linspace(0, 0.02 * 2 * math.pi / OMEGA, 17)
    for time in (few, short):
        exact = wave("standing", time=time)
        assert motion(profile(exact, exact, ("displacement", "velocity"), time)) is None


def test_a_solution_that_is_zero_has_no_phase() -> None:
    exact = wave("standing")
    assert motion(profile(exact, {name: 0 * values for name, values in exact.items()}, ("displacement", "velocity"))) is None


def test_an_unstable_mode_has_no_phase() -> None:
    exact = wave("standing")
    grown = {name: values * (-1.1) ** np.arange(len(TIME))[:, None] for name, values in exact.items()}
    assert motion(profile(exact, grown, ("displacement", "velocity"))) is None


def test_a_motion_that_leaves_the_mode_has_no_phase_from_then_on() -> None:
    exact = wave("standing")
    other = np.sin(math.pi * X / LENGTH) * np.where(TIME[9] == TIME, 2 * REST, 0.5 * REST)[:, None]
    noisy = {"displacement": exact["displacement"] + other, "velocity": exact["velocity"]}
    found = motion(profile(exact, noisy, ("displacement", "velocity")))
    assert found is not None
    assert np.isfinite(found.phase).tolist() == np.isfinite(found.amplitude).tolist() == [True] * 9 + [False] * 8
    broken = {name: np.where(TIME[:, None] > TIME[OUTPUTS - 2], np.nan, values) for name, values in exact.items()}
    assert motion(profile(exact, broken, ("displacement", "velocity"))) is None


def test_the_charts_are_in_degrees_and_relative() -> None:
    shown = profile(wave("standing"), wave("standing", ahead=0.1, amplitude=0.9), ("displacement", "velocity"))
    phase, amplitude = motions(Series("case", "solver", "Scheme", "ladder", "h", {}, (), {}, {}, (), profile=shown))
    assert (phase.units, amplitude.units) == ("degree", "1")
    np.testing.assert_allclose(phase.curves["phase error"], math.degrees(0.1))
    np.testing.assert_allclose(amplitude.curves["amplitude error"], -0.1)
    assert list(motions(Series("case", "solver", "Scheme", "ladder", "h", {}, (), {}, {}, ()))) == []


def test_the_phase_grows_by_the_frequency_that_the_dispersion_study_measures(tmp_path: Path) -> None:
    """The study measures the frequency from the factor of one time step, this from outputs over several periods."""
    declared = studies.get("dispersion").restricted(("tg-lumped", "tg-consistent-3"), None)
    list(run([declared], plan(tmp_path)))
    speed = {case.name: case.problem.problem.material.wave_speed for case in declared.cases}
    errors = {}
    for series in read(tmp_path / "dispersion.nc").series:
        if "relative_frequency_stress" in series.metrics and series.profile:
            found = motion(series.profile)
            assert found is not None
            k = [level.h for level in series.levels].index(series.profile.h)
            wavenumber = series.metrics["phase_angle_stress"][k] / series.profile.h
            grown = np.polyfit(found.time, found.phase, 1)[0] / (speed[series.case] * wavenumber)
            errors[series.solver] = series.metrics["relative_frequency_stress"][k] - 1
            assert grown == pytest.approx(errors[series.solver], rel=1e-3)
    assert errors["tg-lumped"] < 0 < errors["tg-consistent-3"]
