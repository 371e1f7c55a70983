"""Finite element reference: orders, exact discrete solutions, conservation, stability limits, failed runs, refused input."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from mpmverify.errors import UsageError
from mpmverify.problem import (
    Absorbing,
    Array,
    Block,
    Constant,
    Discretisation,
    LinearElastic,
    NeoHookean,
    Problem,
    Traction,
    Transport,
    Velocity,
)
from mpmverify.solution import Solution, Status
from mpmverify.solvers.fem import FiniteElement

BAR = LinearElastic(youngs_modulus=100.0, density=1.0)
C = BAR.wave_speed
L = 25.0
FIXED = {"x-": Velocity(), "x+": Velocity()}
SQUARE = {face: Traction() for face in ("x-", "x+", "y-", "y+")}
NEO = NeoHookean(youngs_modulus=100.0, density=1.0, poissons_ratio=0.2)
FREE = {"x-": Traction(), "x+": Traction()}
P1 = FiniteElement(1, "consistent")
P1_LUMPED = FiniteElement(1, "lumped")
P2 = FiniteElement(2, "consistent")
P2_LUMPED = FiniteElement(2, "lumped")
ALL = [
    FiniteElement(degree, mass, integrator)
    for degree in (1, 2)
    for mass in ("consistent", "lumped")
    for integrator in ("central-differences", "newmark")
]
EXPLICIT = [P1, P1_LUMPED, P2, P2_LUMPED]
LIMIT = {P1: 1 / math.sqrt(3), P1_LUMPED: 1.0, P2: 1 / math.sqrt(15), P2_LUMPED: 1 / math.sqrt(6)}


def named(solvers: list[FiniteElement]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("solver", solvers, ids=lambda solver: solver.name)


@dataclass(frozen=True)
class Pulse:
    """p(t) = p0 sin^4(pi t / t0) for 0 < t < t0, with three continuous derivatives, and its integral in closed form."""

    p0: float
    t0: float

    def __call__(self, t: Array) -> Array:
        return self.p0 * np.where((t > 0) & (t < self.t0), np.sin(np.pi * t / self.t0) ** 4, 0.0)

    def integral(self, t: Array) -> Array:
        s = np.clip(t / self.t0, 0, 1)
        return self.p0 * self.t0 * (3 * s / 8 - np.sin(2 * np.pi * s) / (4 * np.pi) + np.sin(4 * np.pi * s) / (32 * np.pi))


def l2(solution: Solution, exact: dict) -> dict[str, float]:
    """Largest L2 error over the outputs, by quantity."""
    X, t = solution.reference[:, 0], solution.time[:, None]
    return {
        quantity: float(np.sqrt((solution.weight * (solution.fields[quantity][..., 0] - form(X, t)) ** 2).sum(axis=1)).max())
        for quantity, form in exact.items()
    }


def orders(solver: FiniteElement, problem: Problem, exact: dict, cells: list[int], courant: float, rate: float = 0.0) -> dict:
    """Order between the two finest levels, dt proportional to h^(1 + rate)."""
    errors = []
    for count in cells:
        solution = solver.solve(problem, Discretisation(problem.lengths[0] / count, courant * (cells[0] / count) ** rate))
        assert solution.outcome.completed
        errors.append(l2(solution, exact))
    return {
        quantity: math.log(errors[-2][quantity] / errors[-1][quantity]) / math.log(cells[-1] / cells[-2]) for quantity in exact
    }


def vibration(mode: int = 1, periods: float = 1.46, boundary: dict | None = None) -> tuple[Problem, dict]:
    """Axial vibration between fixed ends: u = v0/(beta c) sin(beta c t) sin(beta x)."""
    v0, beta = 0.1, mode * np.pi / L
    initial = {"velocity": lambda X: v0 * np.sin(beta * X)}
    problem = Problem("vibration", (0.0,), (L,), BAR, boundary or FIXED, periods * 2 * L / (mode * C), initial)
    exact = {
        "displacement": lambda X, t: v0 / (beta * C) * np.sin(beta * C * t) * np.sin(beta * X),
        "velocity": lambda X, t: v0 * np.cos(beta * C * t) * np.sin(beta * X),
        "stress": lambda X, t: v0 * BAR.youngs_modulus / C * np.sin(beta * C * t) * np.cos(beta * X),
    }
    return problem, exact


def images(history: Pulse, sign: int) -> dict:
    """Bar fixed at x = 0, by images: at x = L a traction p(t) for sign -1, a velocity p(t)/(rho c) for sign +1."""
    z = BAR.density * C

    def total(p: Callable[[Array], Array], X: Array, t: Array, mirrored: int) -> Array:
        waves = ((p(t - (2 * n * L + L - X) / C), p(t - (2 * n * L + L + X) / C)) for n in range(4))
        return sum(
            (sign**n * (out + mirrored * back) for n, (out, back) in enumerate(waves)),
            np.zeros(np.broadcast_shapes(X.shape, t.shape)),
        )

    return {
        "displacement": lambda X, t: total(history.integral, X, t, -1) / z,
        "velocity": lambda X, t: total(history, X, t, -1) / z,
        "stress": lambda X, t: total(history, X, t, 1),
    }


def manufactured(G: float) -> tuple[Problem, dict]:
    """Manufactured neo-Hookean bar between fixed ends: u = G sin(pi X) sin(c pi t)."""
    law = NeoHookean(youngs_modulus=1e7, density=1000.0, poissons_ratio=0.3)
    lame, mu, c = law.lame_lambda, law.shear_modulus, law.wave_speed
    modulus = law.density * c**2

    def u(X: Array, t: Array) -> Array:
        return G * np.sin(np.pi * X) * np.sin(c * np.pi * t)

    def stretch(X: Array, t: Array) -> Array:
        return 1 + np.pi * G * np.cos(np.pi * X) * np.sin(c * np.pi * t)

    def body_force(points: Array, times: Array) -> Array:
        X, t = points[:, 0], times[:, None]
        f = stretch(X, t)
        b = np.pi**2 * u(X, t) / law.density * (lame * (1 - np.log(f)) / f**2 + mu * (1 + 1 / f**2) - modulus)
        return b[:, :, None]

    initial = {"velocity": lambda X: G * c * np.pi * np.sin(np.pi * X)}
    problem = Problem("manufactured", (0.0,), (1.0,), law, FIXED, 2.3 / c, initial, body_force, outputs=20)
    exact = {
        "displacement": u,
        "velocity": lambda X, t: G * c * np.pi * np.sin(np.pi * X) * np.cos(c * np.pi * t),
        "stress": lambda X, t: lame * np.log(stretch(X, t)) / stretch(X, t) + mu * (stretch(X, t) - 1 / stretch(X, t)),
    }
    return problem, exact


PULSE = Pulse(p0=1.0, t0=1.4 * L / C)
LOADED = Problem("pulse", (0.0,), (L,), BAR, {"x-": Velocity(), "x+": Traction(PULSE)}, 3.7 * L / C)
DRIVEN = Problem(
    "driven", (0.0,), (L,), BAR, {"x-": Velocity(), "x+": Velocity(Pulse(1.0 / (BAR.density * C), PULSE.t0))}, 3.7 * L / C
)


@named(ALL)
def test_declared_orders_hold_at_a_fixed_courant_number(solver: FiniteElement) -> None:
    problem, exact = vibration()
    measured = orders(solver, problem, exact, [32, 64, 128] if solver.degree == 1 else [24, 48, 96], 0.25)
    for quantity, order in solver.orders.items():
        assert measured[quantity] == pytest.approx(order, abs=0.06)


@named([solver for solver in ALL if solver.degree == 2])
@pytest.mark.parametrize(
    ("problem", "exact"),
    [vibration(), (LOADED, images(PULSE, -1)), (DRIVEN, images(PULSE, 1))],
    ids=["vibration", "traction", "velocity"],
)
def test_quadratic_elements_are_of_third_order_in_space(solver: FiniteElement, problem: Problem, exact: dict) -> None:
    measured = orders(solver, problem, exact, [32, 64, 128], 0.1, rate=0.5)
    for quantity, order in solver.space_orders.items():
        assert measured[quantity] == pytest.approx(order, abs=0.1)


@named([solver for solver in ALL if solver.degree == 1])
@pytest.mark.parametrize(
    ("problem", "exact"), [(LOADED, images(PULSE, -1)), (DRIVEN, images(PULSE, 1))], ids=["traction", "velocity"]
)
def test_linear_elements_are_of_second_order_for_a_pulse_from_an_end(
    solver: FiniteElement, problem: Problem, exact: dict
) -> None:
    measured = orders(solver, problem, exact, [64, 128, 256], 0.5)
    for quantity, order in solver.space_orders.items():
        assert measured[quantity] == pytest.approx(order, abs=0.1)


@named(EXPLICIT)
def test_declared_orders_hold_for_the_neo_hookean_bar(solver: FiniteElement) -> None:
    problem, exact = manufactured(G=0.05)
    measured = orders(solver, problem, exact, [16, 32, 64], 0.2, rate=0.5 if solver.degree == 2 else 0.0)
    for quantity, order in solver.space_orders.items():
        assert measured[quantity] == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("boundary", [FIXED, FREE, {"x-": Velocity(), "x+": Traction()}], ids=["fixed", "free", "fixed-free"])
@named([solver for solver in ALL if solver.integrator == "newmark"])
def test_average_acceleration_conserves_the_energy_of_an_unloaded_bar(solver: FiniteElement, boundary: dict) -> None:
    problem, _ = vibration(3, boundary=boundary)
    h = solver.solve(problem, Discretisation(L / 32, 0.7)).histories
    energy = h["kinetic_energy"] + h["strain_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)


@named([solver for solver in ALL if solver.integrator == "newmark"])
@pytest.mark.parametrize("problem", [LOADED, DRIVEN], ids=lambda problem: problem.name)
def test_average_acceleration_balances_energy_and_work_under_load(solver: FiniteElement, problem: Problem) -> None:
    h = solver.solve(problem, Discretisation(L / 32, 0.7)).histories
    energy = h["kinetic_energy"] + h["strain_energy"]
    assert energy.max() > 0
    np.testing.assert_allclose(energy, energy[0] + h["external_work"], atol=1e-12 * energy.max())


@named(EXPLICIT)
def test_the_energy_error_of_central_differences_is_of_second_order(solver: FiniteElement) -> None:
    problem, _ = manufactured(G=0.05)
    defects = []
    for courant in (0.2, 0.1):
        h = solver.solve(problem, Discretisation(1 / 16, courant)).histories
        defects.append(np.abs(np.diff(h["kinetic_energy"] + h["strain_energy"] - h["external_work"]).cumsum()).max())
    assert math.log2(defects[0] / defects[1]) == pytest.approx(2, abs=0.1)


@named(ALL)
@pytest.mark.parametrize("problem", [LOADED, DRIVEN, vibration(1, boundary=FREE)[0]], ids=lambda problem: problem.name)
def test_mass_is_constant_and_momentum_changes_by_the_impulse(solver: FiniteElement, problem: Problem) -> None:
    h = solver.solve(problem, Discretisation(L / 64, 0.25)).histories
    np.testing.assert_allclose(h["mass"], BAR.density * L, rtol=1e-13)
    scale = np.abs(h["momentum"]).max()
    assert scale > 0
    np.testing.assert_allclose(h["momentum"] - h["momentum"][0], h["impulse"], atol=1e-12 * scale)


@named(EXPLICIT)
def test_momentum_of_a_neo_hookean_bar_under_body_force_changes_by_the_impulse(solver: FiniteElement) -> None:
    h = solver.solve(manufactured(G=0.05)[0], Discretisation(1 / 32, 0.2)).histories
    np.testing.assert_allclose(h["momentum"] - h["momentum"][0], h["impulse"], atol=1e-12 * np.abs(h["momentum"]).max())


@pytest.mark.parametrize(
    ("solver", "law"),
    [*((solver, BAR) for solver in ALL), *((solver, NEO) for solver in EXPLICIT)],
    ids=lambda value: getattr(value, "name", type(value).__name__),
)
def test_patch_test_a_uniform_strain_stays_in_equilibrium(solver: FiniteElement, law: LinearElastic) -> None:
    strain, F = 0.1, 1.1
    stretched = law.lame_lambda * math.log(F) / F + law.shear_modulus * (F - 1 / F)
    p = stretched if isinstance(law, NeoHookean) else law.youngs_modulus * strain
    end = Traction(Constant(p))
    problem = Problem("patch", (1.0,), (3.0,), law, {"x-": end, "x+": end}, 1.0, {"displacement": lambda X: strain * X})
    solution = solver.solve(problem, Discretisation(0.25, 0.25))
    np.testing.assert_allclose(solution.fields["stress"], p, rtol=1e-12)
    np.testing.assert_allclose(solution.fields["velocity"], 0, atol=1e-11)
    np.testing.assert_allclose(solution.position, F * np.broadcast_to(solution.reference, solution.position.shape), rtol=1e-12)
    density = law.shear_modulus / 2 * (F * F - 1) - law.shear_modulus * math.log(F) + law.lame_lambda / 2 * math.log(F) ** 2
    energy = density if isinstance(law, NeoHookean) else p * strain / 2
    np.testing.assert_allclose(solution.histories["strain_energy"], 2 * energy, rtol=1e-11)


@named(ALL)
def test_a_free_bar_gains_the_momentum_of_its_end_loads(solver: FiniteElement) -> None:
    boundary = {"x-": Traction(Constant(0.5)), "x+": Traction(Constant(2.0))}
    problem = Problem("pulled", (0.0,), (L,), BAR, boundary, 5.0)
    h = solver.solve(problem, Discretisation(L / 16, 0.25)).histories
    np.testing.assert_allclose(h["momentum"], 1.5 * h["time"], atol=1e-11)


@pytest.mark.parametrize(("solver", "m"), [(P1_LUMPED, 0.0), (P1, 2 / 3)], ids=["lumped", "consistent"])
@pytest.mark.parametrize("mode", [1, 5, 15])
def test_linear_elements_obey_their_dispersion_relation(solver: FiniteElement, m: float, mode: int) -> None:
    """sin^2(omega dt/2) = nu_C^2 sin^2(theta/2) / (1 - m sin^2(theta/2)) for every standing wave of the mesh."""
    cells, courant = 16, 0.5
    h = L / cells
    problem = Problem(
        "mode", (0.0,), (L,), BAR, FIXED, 50 * courant * h / C, {"displacement": lambda X: np.sin(mode * np.pi * X / L)}
    )
    solution = solver.solve(problem, Discretisation(h, courant))
    s = math.sin(mode * math.pi / (2 * cells)) ** 2
    omega_dt = 2 * math.asin(courant * math.sqrt(s / (1 - m * s)))
    nodes = np.linspace(0, L, cells + 1)
    shape = np.interp(solution.reference[:, 0], nodes, np.sin(mode * np.pi * nodes / L))
    steps = solution.time / solution.dt
    np.testing.assert_allclose(solution.fields["displacement"][..., 0], np.cos(omega_dt * steps)[:, None] * shape, atol=1e-12)


def test_lumped_linear_elements_translate_exactly_at_courant_one() -> None:
    """For random data the nodes follow d'Alembert's solution, reflections at the fixed ends included."""
    cells = 20
    nodes = np.linspace(0, L, cells + 1)
    start = np.concatenate([[0], np.random.default_rng(1).standard_normal(cells - 1), [0]])
    problem = Problem(
        "shift", (0.0,), (L,), BAR, FIXED, 3 * L / C, {"displacement": lambda X: np.interp(X, nodes, start)}, outputs=60
    )
    solution = P1_LUMPED.solve(problem, Discretisation(L / cells, 1.0))
    odd = np.concatenate([start[:-1], -start[:0:-1]])
    for u, n in zip(solution.fields["displacement"][..., 0], np.round(solution.time / solution.dt).astype(int), strict=True):
        nodal = (np.roll(odd, n) + np.roll(odd, -n))[: cells + 1] / 2
        np.testing.assert_allclose(u, np.interp(solution.reference[:, 0], nodes, np.append(nodal[:-1], 0)), atol=1e-12)


@pytest.mark.parametrize("boundary", [FIXED, FREE], ids=["fixed", "free"])
@named(EXPLICIT)
def test_stability_limit(solver: FiniteElement, boundary: dict) -> None:
    rng, h = np.random.default_rng(2), L / 32
    problem = Problem(
        "noise", (0.0,), (L,), BAR, boundary, 800 * LIMIT[solver] * h / C, {"velocity": lambda X: rng.standard_normal(X.shape)}
    )
    stable = solver.solve(problem, Discretisation(h, 0.999 * LIMIT[solver]))
    assert stable.outcome.completed
    unstable = solver.solve(problem, Discretisation(h, 1.02 * LIMIT[solver]))
    assert unstable.outcome.status is Status.UNSTABLE
    made = len(unstable.histories["time"]) - 1
    assert unstable.outcome.detail.startswith(f"at step {made + 1} of ")
    assert unstable.work.steps == made
    assert unstable.time[-1] <= unstable.histories["time"][-1] < problem.end_time
    assert all(np.isfinite(values).all() for values in (*unstable.fields.values(), *unstable.histories.values()))


def test_average_acceleration_is_stable_at_any_step() -> None:
    problem, _ = vibration(boundary=FREE)
    assert FiniteElement(2, "consistent", "newmark").solve(problem, Discretisation(L / 32, 50.0)).outcome.completed


def test_growth_under_a_resonant_load_does_not_count_as_instability() -> None:
    @dataclass(frozen=True)
    class Beat:
        def __call__(self, t: Array) -> Array:
            return np.sign(np.sin(np.pi * C * t / (2 * L) + 1e-9))

        def integral(self, t: Array) -> Array:
            raise NotImplementedError

    problem = Problem("resonance", (0.0,), (L,), BAR, {"x-": Velocity(), "x+": Traction(Beat())}, 400 * L / C)
    solution = P1_LUMPED.solve(problem, Discretisation(L / 16, 0.999))
    assert solution.outcome.completed
    assert solution.histories["strain_energy"].max() > 1e3 * L / (2 * BAR.youngs_modulus)


@named(ALL)
def test_a_bar_at_rest_without_load_stays_at_rest(solver: FiniteElement) -> None:
    solution = solver.solve(Problem("rest", (0.0,), (L,), BAR, FIXED, 1.0), Discretisation(L / 4, 0.2))
    assert solution.outcome.completed
    assert not any(field.any() for field in solution.fields.values())


@named(EXPLICIT)
def test_a_large_rigid_displacement_does_not_count_as_instability(solver: FiniteElement) -> None:
    problem = Problem("shifted", (0.0,), (L,), BAR, FREE, 100.0, {"displacement": lambda X: np.full(X.shape, 1e6 / 3)})
    assert solver.solve(problem, Discretisation(L / 32, 0.2)).outcome.completed


@named(EXPLICIT)
def test_an_inverted_element_is_a_non_finite_outcome(solver: FiniteElement) -> None:
    initial = {"velocity": lambda X: -30.0 * np.sign(X - L / 2)}
    solution = solver.solve(Problem("crush", (0.0,), (L,), NEO, FREE, 2.0, initial), Discretisation(L / 33, 0.2))
    assert solution.outcome.status is Status.NON_FINITE
    assert "at step" in solution.outcome.detail
    assert "F <= 0" in solution.outcome.detail
    assert len(solution.time) >= 1


def test_nan_in_the_initial_data_is_a_non_finite_outcome() -> None:
    problem = Problem("nan", (0.0,), (L,), BAR, FREE, 1.0, {"velocity": lambda X: np.full(X.shape, np.nan)})
    solution = P1.solve(problem, Discretisation(L / 4, 0.2))
    assert solution.outcome.status is Status.NON_FINITE
    assert "at step 0 of" in solution.outcome.detail
    assert len(solution.time) == len(solution.histories["time"]) == solution.work.steps == 0


def test_shapes_weights_and_work_of_a_solution() -> None:
    problem, _ = manufactured(G=0.05)
    for solver, count in ((P1, 3), (P2, 4)):
        solution = solver.solve(problem, Discretisation(1 / 8, 0.2))
        T, P, N = *solution.weight.shape, solution.work.steps
        assert (problem.outputs + 1, 8 * count) == (T, P)
        assert solution.time[-1] == problem.end_time
        assert solution.position.shape == (T, P, 1)
        assert all(field.shape == (T, P, 1) for field in solution.fields.values())
        assert all(history.shape == (N + 1,) for history in solution.histories.values())
        np.testing.assert_allclose(solution.weight.sum(axis=1), 1.0, rtol=1e-14)
        assert solution.work.point_steps == 8 * N


def test_evaluating_the_body_force_in_blocks_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, _ = manufactured(G=0.05)
    whole = P2.solve(problem, Discretisation(1 / 8, 0.2))
    monkeypatch.setattr("mpmverify.solvers.fem.solver.BLOCK", 100)
    parts = P2.solve(problem, Discretisation(1 / 8, 0.2))
    np.testing.assert_allclose(parts.fields["stress"], whole.fields["stress"], rtol=1e-12, atol=1e-6)


def test_names_are_unique() -> None:
    assert len({solver.name for solver in ALL}) == len(ALL)
    assert P1_LUMPED.name == "fem-p1-lumped-cd"
    assert FiniteElement(2, integrator="newmark").name == "fem-p2-consistent-newmark"


@pytest.mark.parametrize(
    ("choice", "message"), [({"degree": 3}, "degree"), ({"mass": "diagonal"}, "mass"), ({"integrator": "euler"}, "integrator")]
)
def test_an_unknown_parameter_value_is_refused(choice: dict, message: str) -> None:
    with pytest.raises(UsageError, match=f"the {message} is one of"):
        FiniteElement(**choice)


@pytest.mark.parametrize(
    ("solver", "problem", "message"),
    [
        (P1, Problem("2D", (0.0, 0.0), (1.0, 1.0), BAR, SQUARE, 1.0), "one dimension"),
        (P1, Problem("part", (0.0,), (1.0,), BAR, FREE, 1.0, shape=Block((0.0,), (0.5,))), "from end to end"),
        (P1, Problem("carried", (0.0,), (1.0,), Transport(1.0), FREE, 1.0), "neo-Hookean bar"),
        (FiniteElement(1, "lumped", "newmark"), Problem("large", (0.0,), (1.0,), NEO, FREE, 1.0), "linear elastic bar"),
        (P2, Problem("open", (0.0,), (1.0,), BAR, {"x-": Absorbing(), "x+": Traction()}, 1.0), "fixed or driven end"),
        (P2, Problem("stressed", (0.0,), (1.0,), BAR, FREE, 1.0, {"stress": np.ones_like}), "initial stress only together"),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_a_problem_that_the_solver_cannot_take_is_refused(solver: FiniteElement, problem: Problem, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        solver.solve(problem, Discretisation(0.25, 0.5))


def test_an_initial_stress_of_zero_is_accepted() -> None:
    problem = Problem("calm", (0.0,), (1.0,), BAR, FREE, 0.1, {"stress": np.zeros_like})
    assert P1.solve(problem, Discretisation(0.25, 0.5)).outcome.completed
