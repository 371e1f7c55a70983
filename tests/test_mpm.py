"""The explicit one-dimensional material point method: orders, conservation, stability, outcomes."""

import itertools
from dataclasses import replace

import numba
import numpy as np
import pytest
from arrays import assert_close
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.errors import UsageError
from mpmverify.exact.elastic_bar import SmoothPulse, StepLoad, elastic_bar
from mpmverify.exact.manufactured import manufactured
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import (
    Absorbing,
    Block,
    Constant,
    Discretisation,
    LinearElastic,
    NeoHookean,
    Periodic,
    Problem,
    Traction,
    Transport,
    Velocity,
)
from mpmverify.problem.particles import place_particles
from mpmverify.solution import Status
from mpmverify.solvers.mpm import AFLIP, APIC, FLIP, GAUSS, PIC, TPIC, MaterialPoint, Transfer, blend, fmpm, order, solver, xpic
from mpmverify.solvers.mpm.transfers import TRANSFERS

FIXED, FREE = Velocity(), Traction()
VARIANTS = [
    MaterialPoint(schedule, transfer, basis, formulation)
    for schedule, transfer, basis, formulation in itertools.product(
        ("USF", "USL", "MUSL"), (*TRANSFERS, blend(0.95)), ("linear", "quadratic", "cubic"), ("updated", "total")
    )
]
frozen_functions = pytest.mark.parametrize(
    "variant", [variant for variant in VARIANTS if variant.formulation == "total"], ids=lambda variant: variant.name
)
by_name = pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)


def bar(material=None, left=FIXED, right=FIXED, end_time=1.0, velocity=None, cells=10, **choices):
    initial = {} if velocity is None else {"velocity": velocity}
    material = LinearElastic(1.0, 1.0) if material is None else material
    return Problem("bar", (0.0,), (float(cells),), material, {"x-": left, "x+": right}, end_time, initial, **choices)


def errors(verification, variant, discretisation, quantity="displacement"):
    """Norms sqrt(sum V e^2) at the output times (T,)."""
    solution = variant.solve(verification.problem, discretisation)
    assert solution.outcome.completed, str(solution.outcome)
    error = solution.fields[quantity] - verification.exact.fields[quantity](solution.reference, solution.time)
    return np.sqrt((solution.weight * error[..., 0] ** 2).sum(axis=1))


def series(verification, variant, cells, courant=0.2, ppc=2, quantity="displacement"):
    (length,) = verification.problem.lengths
    return np.array([errors(verification, variant, Discretisation(length / n, courant, ppc), quantity).max() for n in cells])


def orders(values):
    return np.log2(values[:-1] / values[1:])


# Accuracy


def test_published_total_lagrangian_errors():
    variant = MaterialPoint(formulation="total", body_force_at="nodes")
    found = series(manufactured(0.05, outputs=2000), variant, (8, 16, 32, 64, 128))
    assert found == pytest.approx([4.471e-3, 1.133e-3, 2.842e-4, 7.110e-5, 1.779e-5], rel=1e-3)


@pytest.mark.parametrize("basis", ["linear", "quadratic"])
@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
@pytest.mark.parametrize("problem", [manufactured(1e-4), axial_vibration(v0=1e-4)], ids=["manufactured", "vibration"])
def test_flip_has_its_formal_orders_without_cell_crossing(problem, schedule, formulation, basis):
    variant = MaterialPoint(schedule, FLIP, basis, formulation)
    for quantity, formal in variant.orders.items():
        margin = 0.1 if formal == 2 else 0.55
        assert np.all(orders(series(problem, variant, (16, 32, 64), quantity=quantity)) > formal - 0.1), quantity
        assert np.all(orders(series(problem, variant, (16, 32, 64), quantity=quantity)) < formal + margin), quantity


def test_the_gradient_of_the_hat_is_second_order_in_the_middle_of_the_cell():
    found = series(axial_vibration(v0=1e-4), MaterialPoint(), (16, 32, 64), ppc=1, quantity="stress")
    assert orders(found) == pytest.approx(2, abs=0.05)


@pytest.mark.parametrize("formulation", ["updated", "total"])
def test_pic_damps_at_first_order(formulation):
    found = series(axial_vibration(v0=1e-4), MaterialPoint(transfer=PIC, formulation=formulation), (64, 128, 256))
    assert orders(found) == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
@pytest.mark.parametrize("transfer", [xpic(2), xpic(3), fmpm(2), fmpm(3)], ids=lambda transfer: transfer.name)
def test_xpic_and_fmpm_from_order_2_have_no_damping_of_first_order(transfer, schedule):
    variant = MaterialPoint(schedule, transfer, formulation="total")
    for quantity in ("displacement", "velocity"):
        found = series(axial_vibration(v0=1e-4), variant, (32, 64, 128), quantity=quantity)
        assert np.all(orders(found) > 1.85), quantity


@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
@pytest.mark.parametrize("basis", ["linear", "quadratic"])
def test_the_orders_of_aflip(basis, schedule):
    variant = MaterialPoint(schedule, AFLIP, basis)
    for quantity, formal in variant.orders.items():
        found = orders(series(axial_vibration(v0=1e-4), variant, (16, 32, 64), quantity=quantity))
        assert np.all((found > formal - 0.1) & (found < formal + 0.5)), quantity


@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
def test_xpic_and_fmpm_of_order_1_are_pic(schedule):
    problem, at = axial_vibration(v0=1e-2).problem, Discretisation(25 / 16, 0.3, 2)
    expected = MaterialPoint(schedule, PIC).solve(problem, at).arrays()
    for transfer in (xpic(1), fmpm(1)):
        found = MaterialPoint(schedule, transfer).solve(problem, at).arrays()
        assert all(np.array_equal(found[name], values) for name, values in expected.items())


@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
@pytest.mark.parametrize("transfer", [xpic(3), fmpm(3)], ids=lambda transfer: transfer.name)
@pytest.mark.parametrize("basis", ["linear", "quadratic"])
def test_what_a_held_node_takes_from_a_series_is_impulse(basis, transfer, schedule):
    problem = axial_vibration(3, "fixed-free", v0=1e-2).problem
    found = MaterialPoint(schedule, transfer, basis, "total").solve(problem, Discretisation(25 / 16, 0.3, 2)).histories
    scale = np.sqrt(2 * found["mass"] * found["kinetic_energy"]).max()
    assert np.abs(found["impulse"]).max() > 0.01 * scale
    assert_close(found["momentum"] - found["momentum"][0], found["impulse"], abs=1e-13 * scale)


@pytest.mark.parametrize(("make", "order"), [(xpic, 0), (fmpm, 0), (fmpm, 1.5)])
def test_an_order_of_xpic_or_fmpm_below_1_is_refused(make, order):
    with pytest.raises(UsageError, match="one term or more"):
        make(order)
    with pytest.raises(UsageError, match="between 0"):
        Transfer("mine", 2.0)


def test_crossing_stalls_the_updated_hat_but_neither_the_spline_nor_the_total_lagrangian():
    problem, cells = manufactured(0.05), (8, 16, 32, 64)
    assert np.all(orders(series(problem, MaterialPoint(), cells)) < 0.5)
    assert np.all(orders(series(problem, MaterialPoint(basis="quadratic"), cells[:3], ppc=4)) > 1.75)
    for basis in ("linear", "quadratic"):
        assert np.all(orders(series(problem, MaterialPoint(basis=basis, formulation="total"), cells)) > 1.85)


def test_with_cell_crossing_cpgimp_is_of_second_order_and_ugimp_is_not():
    """The domains of uGIMP keep their size, so that in a stretched body they leave gaps or overlap."""
    problem, cells = manufactured(0.05), (8, 16, 32)
    for basis in ("cpgimp", "cpdi"):
        assert np.all(orders(series(problem, MaterialPoint("USL", basis=basis), cells)) > 1.9)
    assert np.all(orders(series(problem, MaterialPoint("USL", basis="ugimp"), cells)) < 1.8)


def test_the_gradients_of_moving_least_squares_are_first_order_where_functions_are_not_symmetric():
    found = series(manufactured(1e-4), MaterialPoint("USL", basis="mls-quadratic", formulation="total"), (16, 32, 64))
    assert np.all((orders(found) > 0.9) & (orders(found) < 1.4))


@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize("basis", ["linear", "quadratic"])
def test_a_pulse_of_traction_converges_at_second_order(basis, formulation):
    pulse = elastic_bar(SmoothPulse(1e-6, 0.9, 0.15))
    found = series(pulse, MaterialPoint(basis=basis, formulation=formulation), (32, 64, 128), 0.5)
    assert np.all(orders(found) > 1.85)


@frozen_functions
def test_the_leapfrog_makes_free_fall_exact(variant):
    falling = bar(left=FREE, right=FREE, body_force=lambda X, t: np.full((len(t), len(X), 1), 0.3))
    solution = variant.solve(falling, Discretisation(1.0, 0.2, 2))
    t = np.broadcast_to(solution.time[:, None, None], solution.position.shape)
    assert_close(solution.fields["displacement"], 0.15 * t**2, abs=1e-15)
    assert_close(solution.fields["velocity"], 0.3 * t, abs=1e-15)


@pytest.mark.parametrize(
    "variant", [MaterialPoint(), MaterialPoint("USF", basis="quadratic", formulation="total")], ids=lambda v: v.name
)
def test_a_step_of_traction_swings_the_end_to_twice_its_static_displacement(variant):
    p0 = 1e-6
    verification = elastic_bar(StepLoad(p0), end_time=4.0)
    problem = replace(verification.problem, outputs=400)
    end = variant.solve(problem, Discretisation(1 / 200, 0.5)).fields["displacement"][:, -1, 0]
    assert end.max() == pytest.approx(2 * p0, rel=0.01)
    assert np.argmax(end) == pytest.approx(200, abs=4)
    assert abs(end[-1]) < 0.05 * p0


# Conservation


velocities = st.lists(st.floats(-0.05, 0.05), min_size=20, max_size=20).map(np.array)
ends = st.sampled_from(
    [FIXED, FREE, Traction(Constant(-0.01)), Velocity(Constant(0.01)), Velocity(SmoothPulse(0.02, 1.0, 0.16))]
)


@pytest.mark.parametrize("basis", ["linear", "quadratic", "cubic"])
@pytest.mark.parametrize("transfer", [FLIP, APIC, TPIC], ids=lambda transfer: transfer.name)
@settings(max_examples=14)
@given(st.data(), velocities, ends, ends, st.booleans())
def test_mass_and_momentum_are_kept_to_round_off(basis, transfer, data, start, left, right, pulled):
    """By all variants that share the compiled loop of a basis and a transfer; `test_mpm_conservation` has affine ones of other laws."""
    variant = data.draw(st.sampled_from([v for v in VARIANTS if (v.basis, v.transfer.affine) == (basis, transfer.affine)]))
    laws = [LinearElastic(1.0, 1.0)] if transfer.affine else [LinearElastic(1.0, 1.0), NeoHookean(1.0, 1.0, 0.2)]
    material = data.draw(st.sampled_from(laws))
    problem = bar(
        material,
        left,
        right,
        3.0,
        lambda X: start[:, None],
        body_force=(lambda X, t: 0.01 * np.cos(X + t[:, None, None])) if pulled else None,
    )
    solution = variant.solve(problem, Discretisation(1.0, 0.4, 2))
    history = solution.histories
    assert_close(history["mass"], 10, rel=1e-14)
    scale = max(0.1, np.abs(history["momentum"]).max())
    assert_close(history["momentum"] - history["momentum"][0], history["impulse"], abs=1e-12 * scale)
    assert all(np.isfinite(values).all() for values in (*history.values(), *solution.fields.values()))


@pytest.mark.parametrize(
    "moved", [Traction(SmoothPulse(1e-3, 2.0, 0.3)), Velocity(SmoothPulse(1e-3, 2.0, 0.3))], ids=["force", "wall"]
)
def test_energy_balances_the_work_of_loads_and_walls_at_second_order(moved):
    def imbalance(h):
        history = MaterialPoint(formulation="total").solve(bar(right=moved, end_time=8.0), Discretisation(h, 0.25, 2)).histories
        energy = history["kinetic_energy"] + history["strain_energy"]
        return np.abs(energy - history["external_work"]).max() / energy.max()

    assert imbalance(1 / 32) < 0.02
    assert np.log2(imbalance(1 / 16) / imbalance(1 / 32)) > 1.7


def test_usf_and_musl_coincide_on_frozen_functions_and_usl_dissipates():
    random = np.random.default_rng(1).normal(size=(20, 1)) * 1e-3
    problem = bar(velocity=lambda X: random, end_time=40.0)
    found = {
        schedule: MaterialPoint(schedule, formulation="total").solve(problem, Discretisation(1.0, 0.3, 2))
        for schedule in ("USF", "USL", "MUSL")
    }
    for quantity in ("displacement", "velocity", "stress"):
        assert_close(found["USF"].fields[quantity], found["MUSL"].fields[quantity], abs=1e-14)
    energy = {name: s.histories["kinetic_energy"] + s.histories["strain_energy"] for name, s in found.items()}
    # Half of the kinetic energy of random particle velocities is invisible to the grid and stays.
    assert energy["USL"][-1] < 0.9 * energy["MUSL"][-1]
    assert energy["MUSL"][-1] == pytest.approx(energy["MUSL"][len(energy["MUSL"]) // 2], rel=0.1)


@pytest.mark.parametrize(("schedule", "limit"), [("USL", 0.5**0.5), ("USF", 2.0), ("MUSL", 2.0)])
def test_the_stability_limit_of_one_centred_particle_per_cell_is_that_of_von_neumann(schedule, limit):
    cells, steps = 100, 2000
    random = np.random.default_rng(2).normal(size=(cells, 1)) * 1e-3

    def status(courant):
        problem = bar(velocity=lambda X: random, end_time=steps * courant, cells=cells)
        return MaterialPoint(schedule, formulation="total").solve(problem, Discretisation(1.0, courant, 1)).outcome.status

    assert status(0.99 * limit) is Status.COMPLETED
    assert status(1.03 * limit) is Status.UNSTABLE


@frozen_functions
def test_a_body_between_walls_that_move_with_it_stays_unstressed(variant):
    moving = Velocity(Constant(0.25))
    problem = bar(left=moving, right=moving, velocity=lambda X: np.full_like(X, 0.25))
    solution = variant.solve(problem, Discretisation(1.0, 0.5, 2))
    assert_close(solution.fields["displacement"][-1], 0.25, rel=1e-13)
    assert_close(solution.fields["stress"], 0, abs=1e-14)


# Outcomes


@by_name
def test_nothing_happens_to_a_bar_at_rest(variant):
    solution = variant.solve(bar(), Discretisation(1.0, 0.5, 3))
    assert solution.outcome.completed
    assert not any(field.any() for field in solution.fields.values())
    assert_close(solution.weight.sum(axis=1), 10, rel=1e-6)
    assert solution.work.point_steps == solution.work.steps * 30 == 60
    assert solution.time[-1] == solution.histories["time"][-1] == 1.0


def test_a_particle_that_leaves_the_grid_ends_the_run():
    problem = bar(left=FREE, right=FREE, velocity=lambda X: np.ones_like(X), end_time=2.0, outputs=1000)
    solution = MaterialPoint().solve(problem, Discretisation(1.0, 0.1, 2))
    assert solution.outcome.status is Status.LEFT_GRID
    assert solution.outcome.detail == "at step 3 of 20"
    assert "enlarge the domain" in str(solution.outcome)
    assert len(solution.time) == len(solution.histories["momentum"]) == 3
    assert np.isfinite(solution.position).all()


@pytest.mark.parametrize("v", [0.25, -0.25])
@pytest.mark.parametrize("moving", ["x- and x+", "x-", "x+"])
def test_a_body_that_a_face_carries_off_the_grid_is_not_told_to_enlarge_the_domain(moving, v):
    left, right = (Velocity(Constant(v)) if face in moving else FREE for face in ("x-", "x+"))
    problem = bar(left=left, right=right, velocity=lambda X: np.full_like(X, v), end_time=4.0)
    outcome = MaterialPoint().solve(problem, Discretisation(1.0, 0.5, 2)).outcome
    assert outcome.status is Status.LEFT_GRID
    assert f"the motion of {moving} carried a particle off" in outcome.advice
    assert "the faces of a larger domain move as well" in str(outcome)
    assert "enlarge the domain" not in str(outcome)
    assert MaterialPoint(formulation="total").solve(problem, Discretisation(1.0, 0.5, 2)).outcome.completed, "what it advises"


def test_a_body_that_leaves_a_moving_face_behind_is_told_to_enlarge_the_domain():
    problem = bar(left=Velocity(Constant(0.01)), right=FREE, velocity=lambda X: np.ones_like(X), end_time=2.0)
    outcome = MaterialPoint().solve(problem, Discretisation(1.0, 0.1, 2)).outcome
    assert (outcome.status, outcome.advice) == (Status.LEFT_GRID, "")


def swinging(courant, velocity, schedule="USL"):
    """Outcome of a free block that swings and crosses cells."""
    problem = bar(left=FREE, right=FREE, velocity=velocity, end_time=15.0, cells=20, shape=Block((3.0,), (13.0,)))
    return MaterialPoint(schedule).solve(problem, Discretisation(1.0, courant, 2)).outcome


@pytest.mark.parametrize(("courant", "amplitude"), [(0.4, 0.15), (0.3, 0.35), (0.8, 0.25)])
def test_a_node_of_small_mass_is_not_told_to_lower_the_courant_number(courant, amplitude):
    """Below the limit of full cells USL turns a particle inside out beside a node of small mass; MUSL and USF, as advised, do not."""

    def mode(X):
        return amplitude * np.sin(np.pi * (X - 3) / 10)

    outcome = swinging(courant, mode)
    assert outcome.status is Status.NON_FINITE
    assert "of the largest nodal mass" in outcome.advice
    assert "take the schedule MUSL or USF" in outcome.advice
    assert "Courant" not in str(outcome)
    assert swinging(courant, mode, "MUSL").completed
    assert swinging(courant, mode, "USF").completed


def test_a_time_step_above_the_limit_is_told_to_lower_the_courant_number():
    random = np.random.default_rng(0).normal(size=(20, 1)) * 1e-2
    for courant in (1.5, 4.0):
        outcome = swinging(courant, lambda X: random)
        assert not outcome.completed
        assert "lower the Courant number" in str(outcome)


@frozen_functions
def test_a_diverging_run_is_an_outcome(variant):
    random = np.random.default_rng(3).normal(size=(20, 1)) * 1e-3
    problem = bar(velocity=lambda X: random, end_time=2000.0)
    solution = variant.solve(problem, Discretisation(1.0, 4.0, 2))
    assert solution.outcome.status is Status.UNSTABLE
    assert " of 500" in solution.outcome.detail
    assert all(np.isfinite(field).all() for field in (*solution.fields.values(), *solution.histories.values()))


def test_a_body_that_turns_inside_out_ends_the_run():
    problem = bar(NeoHookean(1.0, 1.0), right=FREE, velocity=lambda X: np.full_like(X, -50.0), end_time=5.0)
    solution = MaterialPoint(formulation="total").solve(problem, Discretisation(1.0, 0.5, 2))
    assert solution.outcome.status is Status.NON_FINITE
    assert "deformation gradient" in solution.outcome.detail


def test_a_field_that_is_not_a_number_ends_the_run():
    solution = MaterialPoint().solve(bar(velocity=lambda X: X * np.nan), Discretisation(1.0, 0.5))
    assert solution.outcome.status is Status.NON_FINITE
    assert len(solution.time) == 0


def test_blocks_of_body_force_do_not_change_the_result(monkeypatch):
    problem, discretisation = manufactured(0.05).problem, Discretisation(1 / 16, 0.3, 2)
    whole = MaterialPoint().solve(problem, discretisation)
    monkeypatch.setattr(solver, "BLOCK", 200)
    parts = MaterialPoint().solve(problem, discretisation)
    assert np.array_equal(whole.fields["stress"], parts.fields["stress"])
    assert all(np.array_equal(whole.histories[name], parts.histories[name]) for name in whole.histories)


def test_energy_from_a_late_load_does_not_count_as_instability():
    late = Traction(SmoothPulse(1e-3, 5.0, 0.05))
    assert MaterialPoint(formulation="total").solve(bar(right=late, end_time=9.0), Discretisation(1.0, 0.5)).outcome.completed


# Names and misuse


def test_names_are_made_of_the_choices_and_unique():
    assert MaterialPoint().name == "mpm-ul-linear-musl-flip"
    assert MaterialPoint("USL", PIC, "quadratic", "total").name == "mpm-tl-quadratic-usl-pic"
    assert MaterialPoint("USF", blend(0.95), "linear", "total", "nodes").name == "mpm-tl-linear-usf-blend95-nodalforce"
    assert len({variant.name for variant in VARIANTS}) == len(VARIANTS)


@pytest.mark.parametrize(
    "choice",
    [
        {"schedule": "usl"},
        {"transfer": "FLIP"},
        {"basis": "quartic"},
        {"formulation": "eulerian"},
        {"body_force_at": "cells"},
        {"body_force_at": "nodes"},
        {"basis": "cpdi", "transfer": APIC},
        {"basis": "ugimp", "layout": GAUSS},
        {"basis": "cpgimp", "schedule": "USF"},
    ],
    ids=str,
)
def test_a_choice_that_does_not_exist_raises(choice):
    with pytest.raises(UsageError):
        MaterialPoint(**choice)


@pytest.mark.parametrize(
    ("problem", "takes"),
    [
        (bar(Transport(1.0)), "viscoelastic"),
        (bar(right=Absorbing()), "tractions"),
        (replace(bar(), initial={"displacement": np.ones_like}), "undeformed"),
        (replace(bar(), initial={"stress": np.ones_like}), "undeformed"),
    ],
)
def test_a_problem_that_the_solver_cannot_take_raises(problem, takes):
    with pytest.raises(UsageError, match=takes):
        MaterialPoint().solve(problem, Discretisation(1.0, 0.5))


# Places of the particles.


@given(st.floats(1e-6, 0.499), st.integers(0, 2**32), st.integers(1, 4))
def test_jitter_moves_particles_by_no_more_than_it_says_and_by_its_seed_alone(jitter, seed, ppc):
    level = Discretisation(1.0, 0.5, ppc)
    still, moved, again = (
        place_particles(bar(), at)[0]
        for at in (level, replace(level, jitter=jitter, seed=seed), replace(level, jitter=jitter, seed=seed))
    )
    assert np.array_equal(moved, again)
    assert 0 < np.abs(moved - still).max() <= jitter / ppc * (1 + 1e-12)
    assert np.array_equal(np.floor(moved), np.floor(still))
    other = place_particles(bar(), replace(level, jitter=jitter, seed=seed + 1))[0]
    assert not np.array_equal(other, moved)


@pytest.mark.parametrize(
    ("choices", "said"), [({"jitter": 0.5}, "jitter"), ({"jitter": -0.1}, "jitter"), ({"seed": 3}, "needs a jitter")]
)
def test_a_jitter_that_would_leave_the_cell_and_a_seed_without_one_are_refused(choices, said):
    with pytest.raises(UsageError, match=said):
        Discretisation(1.0, 0.5, **choices)


# Strips and threads.


class Swirl:
    """Velocities that carry particles across cells and strips."""

    def __call__(self, X):
        x, y = 2 * np.pi * X.T
        return 0.2 * np.stack([np.sin(x / 2) * np.cos(y), np.sin(y / 2) * np.cos(x)], axis=1)


def square(velocity, condition=FIXED):
    conditions = dict.fromkeys(("x-", "x+", "y-", "y+"), condition)
    return Problem("square", (0.0, 0.0), (1.0, 1.0), NeoHookean(1.0, 1.0), conditions, 0.5, {"velocity": velocity})


@pytest.mark.parametrize("many", [np.inf, 0], ids=["serial", "threads"])
def test_a_failure_in_a_strip_is_the_outcome(many, monkeypatch):
    monkeypatch.setattr(solver, "MANY", many)
    outcome = MaterialPoint("MUSL").solve(square(lambda X: 100 * Swirl()(X)), Discretisation(1 / 40, 0.3, 2)).outcome
    assert outcome.detail.endswith("a particle's deformation gradient reached zero")


@pytest.mark.parametrize("many", [np.inf, 0], ids=["serial", "threads"])
@pytest.mark.parametrize("condition", [FIXED, Periodic()], ids=lambda condition: type(condition).__name__)
def test_particles_that_stay_near_their_strip_are_not_sorted_at_every_step(condition, many, monkeypatch):
    taken = []
    monkeypatch.setattr(solver, "MANY", many)
    monkeypatch.setattr(solver, "strips", lambda *at: taken.append(order.strips(*at)) or taken[-1])
    body = square(lambda X: 0.05 * np.sin(2 * np.pi * (X[:, ::-1] + X)), condition)
    solution = MaterialPoint("MUSL").solve(body, Discretisation(1 / 40, 0.3, 2))
    assert solution.outcome.completed
    assert taken[0].sorting[1] == (1 + solution.work.steps // order.INTERVAL if many == 0 else 0), "one strip needs no sorting"


@pytest.mark.parametrize(("schedule", "basis"), [("USF", "linear"), ("MUSL", "linear"), ("MUSL", "tls-linear")])
def test_the_number_of_threads_does_not_change_a_digit(schedule, basis, monkeypatch):
    body = square(Swirl())
    level, variant = Discretisation(1 / 40, 0.3, 3 if basis == "tls-linear" else 2), MaterialPoint(schedule, basis=basis)
    monkeypatch.setattr(solver, "MANY", np.inf)
    serial = variant.solve(body, level)
    assert serial.outcome.completed
    assert np.abs(serial.fields["displacement"]).max() > level.h, "particles cross cells"
    monkeypatch.setattr(solver, "MANY", 0)
    all_threads = numba.config.NUMBA_NUM_THREADS
    try:
        numba.set_num_threads(1)
        one = variant.solve(body, level)
        numba.set_num_threads(all_threads)
        several = variant.solve(body, level)
    finally:
        numba.set_num_threads(all_threads)
    for name, values in one.arrays().items():
        assert np.array_equal(several.arrays()[name], values), name
        # Compiled for threads or not, sums and products are contracted as the compiler likes; momenta add up to nothing, but for that.
        size = 0.1 if "momentum" in name else np.abs(values).max()
        assert_close(values, serial.arrays()[name], abs=1e-11 * size, said=name)


# Histories


@pytest.mark.parametrize("every", [3, 7, 1000])
@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
def test_histories_of_every_few_steps_are_those_of_all_and_hold_the_first_and_the_last(schedule, every):
    problem = replace(axial_vibration(v0=1e-2).problem, material=LinearElastic(1.0, 1.0))
    level, each = Discretisation(problem.lengths[0] / 10, 0.3, 2), MaterialPoint(schedule)
    full, some = each.solve(problem, level), replace(each, record_every=every).solve(problem, level)
    steps = full.work.steps
    kept = sorted({*range(0, steps + 1, every), steps})
    assert full.histories.keys() == some.histories.keys()
    for name, values in full.histories.items():
        assert np.array_equal(some.histories[name], values[kept]), name
    for name, values in full.fields.items():
        assert np.array_equal(some.fields[name], values), name


def test_a_failed_run_keeps_its_earlier_records():
    problem = replace(axial_vibration(v0=1e-2).problem, end_time=200.0)
    for formulation, status in (("updated", Status.NON_FINITE), ("total", Status.UNSTABLE)):
        variant = MaterialPoint("USL", formulation=formulation, record_every=50)
        solution = variant.solve(problem, Discretisation(problem.lengths[0] / 10, 1.3, 2))
        assert solution.outcome.status is status
        assert np.isfinite(solution.histories["kinetic_energy"]).all()
        assert (np.diff(solution.histories["time"]) > 0).all()


@pytest.mark.parametrize("every", [0, -1, 2.0, "all"])
def test_an_invalid_record_every_is_refused(every):
    with pytest.raises(UsageError, match="every"):
        MaterialPoint(record_every=every)
