"""The study of patch tests: its motions are solutions, its declared deviations follow from the basis, and all variants are in it."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline

from mpmverify import studies
from mpmverify.criteria import Balance, Reproduced
from mpmverify.criteria.criterion import Setting
from mpmverify.errors import UsageError
from mpmverify.exact.homogeneous import SHEARED, rotation, shear, stretch
from mpmverify.exact.rigid_motion import CELL, CLEAR, ON_EDGES, flight, parting
from mpmverify.exact.solution import VerificationProblem
from mpmverify.problem import Discretisation, LinearElastic, place_particles
from mpmverify.solution import Solution, Work
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.mpm.basis import BASES

STUDY = studies.get("patch-tests")
PROBLEMS = [
    *(flight(d, gravity=g, joined=joined) for d in (1, 2, 3) for g in (0.0, 8.0) for joined in (False, True)),
    *(flight(2, LinearElastic, moving=False, gravity=8.0, beside=CLEAR), flight(1, moving=False)),
    flight(3, moving=False, gravity=8.0, beside=ON_EDGES, steps=2),
    *(make(d) for d in (1, 2, 3) for make in (parting, shear, stretch)),
    *(rotation(d) for d in (2, 3)),
]


def fields(problem: VerificationProblem, times):
    """Points in the body (P, d), and u, v, F - I and sigma there (T, P, ...)."""
    X, _ = place_particles(problem.problem, Discretisation(CELL, 0.5, 1))
    X = X[:: max(1, len(X) // 60)]
    return X, {quantity: field(X, times) for quantity, field in problem.exact.fields.items()}


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.problem.name)
def test_the_fields_of_a_motion_belong_together(problem):
    """V = u_t and F - I = du/dX by differences, u_tt is the body force where the stress is uniform, and the start is that of the problem."""
    stated, step = problem.problem, 1e-4
    t = np.linspace(0.1, 0.9, 4) * stated.end_time
    dt = step * stated.end_time
    X, at = fields(problem, t)
    u = problem.exact.fields["displacement"]
    later, now, sooner = (u(X, t + k * dt) for k in (1, 0, -1))
    scale = np.abs(at["velocity"]).max() + 1e-30
    assert_allclose((later - sooner) / (2 * dt), at["velocity"], rtol=0, atol=1e-6 * scale)
    acceleration = (problem.exact.fields["velocity"](X, t + dt) - problem.exact.fields["velocity"](X, t - dt)) / (2 * dt)
    force = np.stack([stated.force(X, X + now[k], time) for k, time in enumerate(t)])
    assert_allclose(acceleration, force, rtol=0, atol=1e-6 * (np.abs(force).max() + scale))
    assert np.ptp(at["stress"], axis=1).max() <= 1e-14 * stated.material.youngs_modulus
    dimension = X.shape[1]
    for k in range(dimension):
        shift = np.eye(dimension)[k] * 1e-6
        slope = (u(X + shift, t) - u(X - shift, t)) / 2e-6
        assert_allclose(slope, at["displacement_gradient"].reshape(*slope.shape, dimension)[..., k], rtol=0, atol=1e-8)
    start = np.zeros(1)
    for quantity in ("displacement", "velocity", "stress"):
        assert_allclose(stated.initial_field(quantity, X), problem.exact.fields[quantity](X, start)[0], rtol=0, atol=1e-15)


def test_a_rotation_has_no_strain_and_keeps_lengths():
    X, at = fields(rotation(2), np.linspace(0, 0.25, 7))
    F = np.eye(2) + at["displacement_gradient"].reshape(7, len(X), 2, 2)
    assert_allclose(np.swapaxes(F, -1, -2) @ F, np.broadcast_to(np.eye(2), F.shape), rtol=0, atol=1e-14)
    assert np.linalg.det(F).min() > 0.99
    x = X + at["displacement"] - 0.5
    assert_allclose(np.linalg.norm(x, axis=-1), np.broadcast_to(np.linalg.norm(X - 0.5, axis=-1), x.shape[:2]), rtol=1e-13)
    with pytest.raises(UsageError, match="two or three dimensions"):
        rotation(1)


@pytest.mark.parametrize(("basis", "degree"), [("quadratic", 2), ("cubic", 3)])
def test_the_declared_strain_at_clamped_ends_is_that_of_centres_of_lumped_mass(basis, degree):
    """v_I is L times the centre of the mass of node I, with the functions of SciPy, two particles per cell, and held ends."""
    cells = 8
    knots = np.clip(np.arange(-degree, cells + degree + 1.0), 0, cells)
    x = (np.arange(2 * cells) + 0.5) / 2
    functions = BSpline(knots, np.eye(cells + degree), degree)
    N, dN = functions(x), functions(x, nu=1)
    centre = (N * x[:, None]).sum(axis=0) / N.sum(axis=0)
    centre[0], centre[-1] = 0, cells
    excess = np.abs(dN @ centre - 1).max()
    case = next(case for case in STUDY.cases if case.name == "clamped ends, 1D")
    bands = [c for s in case.series if s.solver.basis == basis for c in s.criteria]
    assert bands
    assert all(c.low < excess < c.bound and c.bound - c.low <= 0.0201 for c in bands)


def test_every_basis_transfer_schedule_and_formulation_translates():
    """All that exist in one dimension, but for fits, which take no free bodies."""
    solvers = next(case for case in STUDY.cases if case.name == "translation, 1D").series
    found = {(s.solver.basis, s.solver.schedule, s.solver.formulation) for s in solvers if isinstance(s.solver, MaterialPoint)}
    wanted = {
        (basis, schedule, formulation)
        for basis in BASES
        for schedule in ("USF", "USL", "MUSL")
        for formulation in ("updated", "total")
        if not BASES[basis].kind.fitted and not (schedule == "USF" and formulation == "updated" and BASES[basis].stretched)
    }
    assert found == wanted


def test_particles_begin_beside_and_come_to_lie_on_cell_edges():
    problem = flight(1)
    X, _ = place_particles(problem.problem, Discretisation(CELL, 0.5, 2))
    at = X + problem.exact.fields["displacement"](X, np.linspace(0, problem.problem.end_time, 25))
    from_edge = np.abs(at / CELL - np.round(at / CELL)).min(axis=(0, 2))
    assert (from_edge == 0).sum() >= 4
    assert ((from_edge > 0) & (from_edge < 1e-11)).sum() >= 8


def exact_solution(problem):
    """The closed form as a solution at three times, with the histories of its momentum."""
    X, V = place_particles(problem.problem, Discretisation(CELL, 0.5, 2))
    time = np.linspace(0, problem.problem.end_time, 3)
    fields = {name: problem.exact.fields[name](X, time) for name in ("displacement", "velocity", "stress")}
    momentum = np.einsum("p,tpi->ti", V, fields["velocity"])
    histories = {"time": time, "mass": np.full(3, V.sum())}
    for k, axis in enumerate("xyz"[: X.shape[1]]):
        histories |= {f"momentum_{axis}": momentum[:, k], f"impulse_{axis}": momentum[:, k] - momentum[0, k]}
    return Solution(time, time[1], X, X + fields["displacement"], np.tile(V, (3, 1)), fields, histories, Work())


def test_a_deviation_at_any_time_and_place_counts():
    problem = flight(2)
    setting, right = Setting(problem, Discretisation(CELL, 0.5, 2)), exact_solution(problem)
    for quantity in right.fields:
        criterion = Reproduced(quantity, 2.0, 1e-12, "")
        assert criterion.measure(right, setting) == {f"{quantity}_deviation": 0.0}
        for at in ((1, 5, 0), (1, 0, -1), (2, -1, 0), (0, 3, 1)):
            changed = right.fields[quantity].copy()
            changed[at] += 0.5
            wrong = dataclasses.replace(right, fields={**right.fields, quantity: changed})
            assert criterion.measure(wrong, setting)[f"{quantity}_deviation"] == pytest.approx(0.25)


def test_only_what_is_inside_is_compared():
    problem = shear(2)
    setting, right = Setting(problem, Discretisation(CELL, 0.5, 2)), exact_solution(problem)
    outside = (right.reference[:, 0] < 5 * CELL) | (right.reference[:, 1] > (2 * SHEARED[2] - 4) * CELL)
    stress = right.fields["stress"] + np.where(outside, 1.0, 0.0)[None, :, None]
    wrong = dataclasses.replace(right, fields={**right.fields, "stress": stress})
    assert Reproduced("stress", 1.0, 1e-12, "", inside=5 * CELL).measure(wrong, setting) == {
        "stress_deviation_0.3125_inside": 0.0
    }
    assert Reproduced("stress", 1.0, 1e-12, "").measure(wrong, setting) == {"stress_deviation": 1.0}


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_momentum_balances_along_every_axis(axis):
    problem = flight(3, gravity=8.0)
    setting, right = Setting(problem, Discretisation(CELL, 0.5, 2)), exact_solution(problem)
    balance = Balance("momentum", "impulse", "")
    assert balance.measure(right, setting)["momentum_defect"] < 1e-15
    lost = right.histories[f"momentum_{axis}"] - np.array([0.0, 1e-3, 0.0])
    wrong = dataclasses.replace(right, histories={**right.histories, f"momentum_{axis}": lost})
    assert balance.measure(wrong, setting)["momentum_defect"] > 1e-4
