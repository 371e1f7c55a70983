"""Exact values of the GeHoJerez deck at the element midpoints, and the same values from the deck's own scheme."""

import numpy as np
import pytest

from mpmverify.exact.deck import deck

DECKS = [{}, {"length": 5.0, "h": 0.25}, {"length": 5.0, "h": 0.25, "steps": 90}, {"length": 3.0, "h": 0.5, "steps": 40}]
every_deck = pytest.mark.parametrize("options", DECKS)


def midpoint_histories(verification):
    """Return stress and velocity (steps, elements) at the midpoint of every element at every multiple of dt = h/c."""
    problem, fields = verification.problem, verification.exact.fields
    dt, L = problem.end_time / problem.outputs, problem.upper[0]
    elements = round(L / (dt * problem.material.wave_speed))
    x = (np.arange(elements)[:, None] + 0.5) * L / elements
    t = np.arange(problem.outputs + 1) * dt
    return fields["stress"](x, t)[..., 0], fields["velocity"](x, t)[..., 0]


def test_the_defaults_are_those_of_the_notes():
    problem = deck().problem
    assert problem.lengths == (8.0,)
    assert problem.material.wave_speed == 1.0
    assert (problem.end_time, problem.outputs) == (24.0, 24)


@every_deck
def test_a_pulse_of_height_one_quarter_travels_unchanged(options):
    stress, velocity = midpoint_histories(deck(**options))
    steps, elements = stress.shape
    for k in range(1, min(steps, elements)):
        expected = np.zeros(elements)
        expected[k - 1 : k + 1] = 0.25
        assert np.allclose(stress[k], expected, rtol=0, atol=1e-13)
        assert np.allclose(velocity[k], -expected, rtol=0, atol=1e-13)


@every_deck
def test_stress_doubles_at_the_fixed_end(options):
    stress, velocity = midpoint_histories(deck(**options))
    steps, elements = stress.shape
    if steps > elements:
        assert np.isclose(stress[elements, -1], 0.5)
        assert np.isclose(velocity[elements, -1], 0, atol=1e-13)
    if steps > elements + 1:
        assert np.allclose(stress[elements + 1, -2:], 0.25)
        assert np.allclose(velocity[elements + 1, -2:], 0.25)


def test_velocity_doubles_and_stress_changes_sign_at_the_free_end():
    stress, velocity = midpoint_histories(deck())
    assert np.allclose(velocity[[0, 16], 0], [-0.5, 0.5])
    assert np.allclose(stress[[15, 16, 17], 0], [0.25, 0, -0.25], atol=1e-13)
    assert np.allclose(stress[24, -1], -0.5)
    assert np.allclose(velocity[24], 0, atol=1e-13)


@every_deck
def test_momentum_changes_by_the_impulse_of_the_fixed_end_and_energy_is_constant(options):
    verification = deck(**options)
    problem, fields = verification.problem, verification.exact.fields
    L, t = problem.upper[0], np.linspace(0, problem.end_time, problem.outputs * 40 + 1)
    x = (np.arange(4000)[:, None] + 0.5) * L / 4000
    velocity, stress = fields["velocity"](x, t[::200]), fields["stress"](x, t[::200])
    energy = (velocity**2 + stress**2).mean(axis=(1, 2)) * L / 2
    h = problem.end_time / problem.outputs
    assert np.allclose(energy, h / 6, rtol=1e-4)
    reaction = fields["stress"](np.array([[L]]), t)[:, 0, 0]
    impulse = np.concatenate([[0], np.cumsum((reaction[1:] + reaction[:-1]) / 2 * np.diff(t))])
    assert np.allclose(velocity.mean(axis=(1, 2)) * L, -h / 2 + impulse[::200], rtol=0, atol=1e-3 * h)


@every_deck
def test_lumped_taylor_galerkin_at_a_unit_courant_number_gives_the_same_values(options):
    """The scheme of the deck with E = rho = 1: half a step at the Gauss points, a lumped step at the nodes, then the end conditions."""
    exact_stress, exact_velocity = midpoint_histories(deck(**options))
    steps, elements = exact_stress.shape
    stress, velocity = np.zeros(elements + 1), np.zeros(elements + 1)
    mass = np.ones(elements + 1)
    mass[[0, -1]] = 0.5
    for step in range(steps):
        middle_stress = (stress[1:] + stress[:-1]) / 2 + np.diff(velocity) / 2
        middle_velocity = (velocity[1:] + velocity[:-1]) / 2 + np.diff(stress) / 2
        stress += np.diff(middle_velocity, prepend=velocity[0], append=0.0) / mass
        velocity += np.diff(middle_stress, prepend=0.0, append=stress[-1]) / mass
        if step == 0:
            velocity[0] = -1.0
        stress[0] = velocity[-1] = 0.0
        assert np.allclose((stress[1:] + stress[:-1]) / 2, exact_stress[step], rtol=0, atol=1e-12)
        assert np.allclose((velocity[1:] + velocity[:-1]) / 2, exact_velocity[step], rtol=0, atol=1e-12)
