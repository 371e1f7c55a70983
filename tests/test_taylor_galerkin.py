"""Two-step Taylor-Galerkin: amplification factor, the GeHoJerez deck, d'Alembert's solution, conservation, stability."""

import dataclasses
import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from mpmverify.errors import UsageError
from mpmverify.problem import (
    Absorbing,
    Array,
    Block,
    BoundaryCondition,
    Constant,
    Discretisation,
    Inflow,
    LinearElastic,
    NeoHookean,
    Outflow,
    Periodic,
    Problem,
    Traction,
    Transport,
    Velocity,
)
from mpmverify.solution import Solution, Status
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.solvers.taylor_galerkin import solver as taylor_galerkin
from mpmverify.solvers.taylor_galerkin.kernel import march

BAR = LinearElastic(youngs_modulus=6.0, density=2.0, poissons_ratio=0.25)
C = BAR.wave_speed
Z = BAR.density * C
EVERY = 10**6
ENDS = [Traction(), Velocity(), Absorbing()]


@dataclass(frozen=True)
class Pulse:
    """Gaussian pulse in time, zero to round-off at t = 0."""

    size: float = 1.0
    centre: float = 1.0
    width: float = 0.15

    def __call__(self, t: Array) -> Array:
        return self.size * np.exp(-(((t - self.centre) / self.width) ** 2))

    def integral(self, t: Array) -> Array:
        raise NotImplementedError


def problem(material, left: BoundaryCondition, right: BoundaryCondition, end_time, initial=None, length=1.0, **rest) -> Problem:
    rest = {"outputs": EVERY} | rest
    return Problem("probe", (0.0,), (length,), material, {"x-": left, "x+": right}, end_time, initial or {}, **rest)


def nodal(values: Array, h: float) -> Callable[[Array], Array]:
    return lambda X: values[np.rint(X[:, 0] / h).astype(int)]


def order(error: Callable[[int], float], coarse: int = 60) -> float:
    return float(np.log2(error(2 * coarse) / error(4 * coarse)))


def rms(solution: Solution, quantity: str, exact: Array) -> float:
    assert solution.outcome.completed
    return float(np.sqrt(np.mean((solution.fields[quantity][..., 0] - exact) ** 2)))


def unbalanced(solution: Solution, total: str, gained: str) -> Array:
    history = solution.histories
    return history[total] - history[total][0] - history[gained]


@pytest.mark.parametrize("passes", [1, 2, 3, 7, 100])
@pytest.mark.parametrize("nu", [0.1, 0.5, 0.57, 1.0])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_every_fourier_mode_follows_the_amplification_factor(passes, nu, direction):
    n, a = 33, 2.5 * direction
    steps = 4 if passes == 1 or nu < 3**-0.5 else 1  # an unstable run would be stopped
    theta = 2 * np.pi * np.arange(n) / n
    m = 1 - (1 - np.cos(theta)) / 3
    consistent = m / (1 - (1 - m) ** passes) if passes < 100 else m
    effective = 1.0 if passes == 1 else consistent
    G = 1 - (1j * direction * nu * np.sin(theta) + nu**2 * (1 - np.cos(theta))) / effective

    impulse = nodal(np.eye(1, n)[0], 1 / n)
    case = problem(Transport(a), Periodic(), Periodic(), steps * nu / n / abs(a), {"u": impulse})
    solution = TaylorGalerkin(passes).solve(case, Discretisation(1 / n, nu))
    assert solution.work.steps == steps
    modes = np.fft.fft(solution.fields["u"][..., 0], axis=1)
    for step, mode in enumerate(modes):
        np.testing.assert_allclose(mode, G**step * modes[0], rtol=0, atol=1e-12 * max(1, np.abs(G).max() ** step))


def gehojerez_deck(elements: int, h: float, dt: float, steps: int) -> Array:
    """Gauss-point (stress, velocity) (steps + 1, 2, elements) of the deck of May 2019; E = rho = 1, no contour flux."""
    stress, velocity = np.zeros((2, elements + 1))
    lumped = np.full(elements + 1, h)
    lumped[[0, -1]] = h / 2
    result = [np.zeros((2, elements))]
    for step in range(1, steps + 1):
        half_stress = (stress[1:] + stress[:-1]) / 2 + dt / 2 * np.diff(velocity) / h
        half_velocity = (velocity[1:] + velocity[:-1]) / 2 + dt / 2 * np.diff(stress) / h
        stress = stress + dt * np.diff(half_velocity, prepend=0, append=0) / lumped
        velocity = velocity + dt * np.diff(half_stress, prepend=0, append=0) / lumped
        if step == 1:
            velocity[0] = -1
        else:
            stress[0] = 0
        velocity[-1] = 0
        result.append(np.array([(stress[1:] + stress[:-1]) / 2, (velocity[1:] + velocity[:-1]) / 2]))
    return np.array(result)


@pytest.mark.parametrize(("length", "elements", "dt"), [(8.0, 8, 1.0), (5.0, 20, 0.25)])
def test_the_gehojerez_deck_is_the_free_fixed_bar_with_one_moving_node(length, elements, dt):
    h, steps = length / elements, 25
    deck = gehojerez_deck(elements, h, dt, steps)
    initial_velocity = {"velocity": lambda X: -np.maximum(0, 1 - X / h)}
    case = problem(LinearElastic(1.0, 1.0), Traction(), Velocity(), (steps - 1) * dt, initial_velocity, length)
    solution = TaylorGalerkin().solve(case, Discretisation(h, 1.0))
    assert solution.dt == dt
    for component, quantity in enumerate(("stress", "velocity")):
        np.testing.assert_allclose(solution.fields[quantity][..., 0], deck[1:, component], rtol=0, atol=1e-12)
    stress = np.abs(deck[:, 0]).max(axis=1)
    assert set(np.round(stress[2:], 12)) == {0.0, 0.25, 0.5} if elements == 8 else set(np.round(stress[2:], 12)) >= {0.25, 0.5}


def test_reflecting_ends_are_mirrors_at_the_unit_courant_number():
    n = 12
    stress, velocity = np.random.default_rng(1).standard_normal((2, n + 1))
    velocity[0] = stress[n] = 0.0  # fixed at 0, free at L
    twice = np.concatenate([stress, -stress[-2::-1]]), np.concatenate([velocity, velocity[-2::-1]])
    four = np.concatenate([twice[0], twice[0][-2:0:-1]]), np.concatenate([twice[1], -twice[1][-2:0:-1]])

    def run(left, right, fields, length):
        initial = {"stress": nodal(fields[0], 1 / n), "velocity": nodal(fields[1], 1 / n)}
        return TaylorGalerkin().solve(problem(BAR, left, right, 3 / C, initial, length), Discretisation(1 / n, 1.0))

    bar, ring = run(Velocity(), Traction(), (stress, velocity), 1.0), run(Periodic(), Periodic(), four, 4.0)
    assert bar.outcome.completed
    for quantity in ("stress", "velocity"):
        np.testing.assert_allclose(bar.fields[quantity], ring.fields[quantity][:, :n], rtol=0, atol=1e-12)


def one_step(
    left: BoundaryCondition, right: BoundaryCondition, passes: int, nu: float, n: int, *, characteristic=False, scale=1.0
) -> Array:
    """Matrix (2 (n + 1), 2 (n + 1)) of one time step of the bar."""
    case = problem(BAR, left, right, 1.0)
    _, form = taylor_galerkin.first_order_form(case, "probe")
    bounded, (prescribed, incoming, correction, datum) = taylor_galerkin.boundary_terms(case, "probe", np.zeros(3))
    assert bounded
    faces = (prescribed, incoming, scale * (incoming if characteristic else correction), datum)
    mass = np.full(n + 1, 1 / n)
    mass[[0, -1]] /= 2
    columns = []
    for U in np.eye(2 * (n + 1)).reshape(-1, n + 1, 2):
        history = *np.zeros((3, 2, 2)), np.zeros(2), np.zeros((2, 2, 2))
        rest = (np.full(2, np.inf), np.full(2, -1), np.zeros((1, n, 2)), history)
        march(U, form, faces, np.zeros((2, n)), passes, mass, 1 / n, nu / n / C, 0, 1, *rest)
        columns.append(U.ravel())
    return np.array(columns).T


def largest_power(matrix: Array, steps: int) -> float:
    """Largest norm of a power, max_n ||G^n|| for n up to `steps`, in the norm in which sigma/Z and v have equal weight."""
    scale = np.tile([1 / Z, 1.0], len(matrix) // 2)
    matrix = scale[:, None] * matrix / scale
    power, largest = np.eye(len(matrix)), 0.0
    for _ in range(steps):
        power = matrix @ power
        largest = max(largest, float(np.linalg.norm(power, 2)))
    return largest


@pytest.mark.parametrize("passes", [1, 2, 3, 6, 20])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("n", [4, 5, 16])
def test_no_boundary_condition_amplifies_reflected_waves(passes, share, n):
    """The bar is stable up to the limit of the interior scheme, nu_C = 1 or 1/sqrt(3)."""
    nu = share * (1.0 if passes == 1 else 3**-0.5)
    for left, right in itertools.product(ENDS, repeat=2):
        assert largest_power(one_step(left, right, passes, nu, n), 300) < 6


def energy_norm(left: BoundaryCondition, right: BoundaryCondition, passes: int, nu: float, n: int, **otherwise) -> float:
    """Norm of one step in the energy of the lumped mass, restricted to states that satisfy the conditions at both ends."""
    mass = np.full(n + 1, 1.0)
    mass[[0, -1]] /= 2
    scale = (np.sqrt(mass)[:, None] * [1 / Z, 1.0]).ravel()
    matrix = scale[:, None] * one_step(left, right, passes, nu, n, **otherwise) / scale
    held = {2 * i + isinstance(end, Velocity) for i, end in ((0, left), (n, right))}
    return float(np.linalg.norm(matrix[:, [k for k in range(len(matrix)) if k not in held]], 2))


@pytest.mark.parametrize(("passes", "nu"), [(1, 0.3), (1, 0.7), (1, 1.0), (3, 0.3), (3, 0.4), (3, 0.5), (3, 0.55)])
@pytest.mark.parametrize("n", [4, 16])
def test_no_step_adds_energy_with_fixed_or_free_ends(passes, nu, n):
    for left, right in itertools.product((Velocity(), Traction()), repeat=2):
        assert energy_norm(left, right, passes, nu, n) <= 1 + 1e-14


def test_later_passes_without_the_correction_add_energy():
    assert energy_norm(Velocity(), Velocity(), 3, 0.5, 16, scale=0.0) > 1 + 1e-4


def test_at_the_stability_limit_growth_is_at_most_linear():
    """At nu_C = 1 with the lumped mass, the deviation of an end node from its datum changes sign at every step, undamped."""
    for left, right in itertools.product(ENDS, repeat=2):
        step = one_step(left, right, 1, 1.0, 8)
        assert largest_power(step, 400) < 2.1 * max(largest_power(step, 200), 2)


@pytest.mark.parametrize("otherwise", [{"characteristic": True}, {"scale": 0.0}])
def test_later_passes_with_another_correction_or_none_are_unstable(otherwise):
    assert largest_power(one_step(Velocity(), Traction(), 6, 0.99 * 3**-0.5, 4, **otherwise), 300) > 1e6


@pytest.mark.parametrize("normal", [-1, 1])
@pytest.mark.parametrize("courant", [0.3, 0.8])
def test_the_outgoing_characteristic_is_independent_of_the_boundary_condition(normal, courant):
    """After one lumped step sigma - n Z v of the end node is the same under every condition; sigma + n Z v is not."""
    n = 9
    stress, velocity = np.random.default_rng(n).standard_normal((2, n + 1))
    outgoing, incoming = [], []
    for condition in ENDS:
        step = one_step(*[Absorbing(), condition][::normal], 1, courant, n)
        after = (step @ np.stack([stress, velocity], axis=1).ravel()).reshape(n + 1, 2)[n if normal > 0 else 0]
        outgoing.append(after[0] - normal * Z * after[1])
        incoming.append(after[0] + normal * Z * after[1])
    assert np.ptp(outgoing) < 1e-13 * np.abs(outgoing).max()
    assert np.ptp(incoming) > 0.1


@pytest.mark.parametrize("passes", [1, 3])
@pytest.mark.parametrize(("left", "right"), list(itertools.product([Traction, Velocity, Absorbing], repeat=2)))
def test_the_change_of_momentum_is_the_impulse(passes, left, right):
    def end(kind, size):
        return kind() if kind is Absorbing else kind(Pulse(size, centre=0.2))

    rng = np.random.default_rng(3)
    n = 17
    initial = {quantity: nodal(rng.standard_normal(n + 1), 1 / n) for quantity in ("stress", "velocity")}

    def body_force(X, t):
        return np.cos(3 * t[:, None, None]) * (1 + X)

    case = problem(BAR, end(left, 2.0), end(right, -1.0), 1.3, initial, body_force=body_force)
    solution = TaylorGalerkin(passes).solve(case, Discretisation(1 / n, 0.5))
    assert solution.outcome.completed
    assert np.ptp(solution.histories["impulse"]) > 0.1
    assert np.abs(unbalanced(solution, "momentum", "impulse")).max() < 1e-13
    assert np.ptp(solution.histories["mass"]) == 0
    assert solution.histories["mass"][0] == pytest.approx(BAR.density)


def test_a_free_bar_gains_exactly_the_impulse_of_its_load():
    case = problem(BAR, Traction(Constant(-0.5)), Traction(Constant(2.0)), 1.7)
    histories = TaylorGalerkin().solve(case, Discretisation(1 / 30, 0.7)).histories
    np.testing.assert_allclose(histories["momentum"], 2.5 * histories["time"], rtol=0, atol=1e-13)


@pytest.mark.parametrize("passes", [1, 3])
@pytest.mark.parametrize("velocity", [1.5, -1.5])
def test_the_change_of_mass_is_the_inflow(passes, velocity):
    faces = [Inflow(Pulse(2.0, 0.3)), Outflow()][:: int(np.sign(velocity))]
    case = problem(Transport(velocity), *faces, 1.1, {"u": lambda X: np.sin(5 * X)})
    solution = TaylorGalerkin(passes).solve(case, Discretisation(1 / 40, 0.5))
    assert solution.outcome.completed
    assert np.ptp(solution.histories["inflow"]) > 0.1
    assert np.abs(unbalanced(solution, "mass", "inflow")).max() < 1e-13


@pytest.mark.parametrize("passes", [1, 3])
@pytest.mark.parametrize("velocity", [1.0, -1.0])
def test_advection_from_the_inflow_is_second_order(passes, velocity):
    pulse = Pulse(centre=0.7)

    def error(n):
        faces = [Inflow(pulse), Outflow()][:: int(velocity)]
        solution = TaylorGalerkin(passes).solve(problem(Transport(velocity), *faces, 2.5), Discretisation(1 / n, 0.45))
        way = solution.reference[:, 0] if velocity > 0 else 1 - solution.reference[:, 0]
        return rms(solution, "u", pulse(solution.time[:, None] - way))

    assert order(error) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("passes", [1, 3])
@pytest.mark.parametrize("drive", [Traction, Velocity])
@pytest.mark.parametrize(("left", "reflection"), [(Velocity(), 1.0), (Traction(), -1.0), (Absorbing(), 0.0)])
def test_a_pulse_in_a_bar_converges_to_dalembert_at_second_order(passes, drive, left, reflection):
    """Method of images: sigma = sum_n (r_L r_R)^n [q(t - (2nL+L-x)/c) + r_L q(t - (2nL+L+x)/c)].

    In rho c v the second term has the opposite sign.
    """
    pulse = Pulse(centre=0.6)
    amplitude, back = (1.0, -1.0) if drive is Traction else (Z, 1.0)

    def error(n, quantity):
        solution = TaylorGalerkin(passes).solve(problem(BAR, left, drive(pulse), 2.5), Discretisation(1 / n, 0.45))
        x, t = solution.reference[:, 0], solution.time[:, None]
        sign, scale = (1, 1) if quantity == "stress" else (-1, 1 / Z)
        exact = sum(
            (reflection * back) ** k * (pulse(t - (2 * k + 1 - x) / C) + sign * reflection * pulse(t - (2 * k + 1 + x) / C))
            for k in range(5)
        )
        return rms(solution, quantity, amplitude * scale * exact)

    for quantity in ("stress", "velocity"):
        assert order(lambda n, quantity=quantity: error(n, quantity)) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("ends", [(Velocity(), Traction(Pulse(centre=0.4))), (Traction(), Velocity(Pulse(centre=0.4)))])
def test_a_mirrored_problem_has_the_mirrored_solution(ends):
    def mirrored(end):
        return Velocity(Pulse(-1.0, 0.4)) if isinstance(end, Velocity) and isinstance(end.value, Pulse) else end

    there = TaylorGalerkin(3).solve(problem(BAR, *ends, 1.5), Discretisation(1 / 20, 0.5))
    back = TaylorGalerkin(3).solve(problem(BAR, *map(mirrored, ends[::-1]), 1.5), Discretisation(1 / 20, 0.5))
    for quantity, sign in (("stress", 1), ("velocity", -1)):
        assert np.abs(there.fields[quantity]).max() > 0.1
        np.testing.assert_allclose(there.fields[quantity], sign * back.fields[quantity][:, ::-1], rtol=0, atol=1e-13)


@pytest.mark.parametrize("passes", [1, 3])
def test_a_forced_bar_converges_at_second_order_and_balances_its_energy(passes):
    """Manufactured solution u = sin(pi X) (1 - cos(w t)) between fixed ends, with b = u_tt - c^2 u_xx."""
    w = 4.0

    def body_force(X, t):
        t = t[:, None, None]
        return np.sin(np.pi * X) * (w**2 * np.cos(w * t) + (C * np.pi) ** 2 * (1 - np.cos(w * t)))

    def solve(n):
        case = problem(BAR, Velocity(), Velocity(), 1.0, body_force=body_force)
        return TaylorGalerkin(passes).solve(case, Discretisation(1 / n, 0.5))

    def velocity_error(n):
        solution = solve(n)
        return rms(solution, "velocity", w * np.sin(np.pi * solution.reference[:, 0]) * np.sin(w * solution.time[:, None]))

    def stress_error(n):
        solution = solve(n)
        shape = BAR.density * C**2 * np.pi * np.cos(np.pi * solution.reference[:, 0])
        return rms(solution, "stress", shape * (1 - np.cos(w * solution.time[:, None])))

    def energy_error(n):
        history = solve(n).histories
        assert np.ptp(history["external_work"]) > 1
        return np.abs(history["kinetic_energy"] + history["strain_energy"] - history["external_work"]).max()

    assert order(velocity_error, 20) == pytest.approx(2, abs=0.1)
    assert order(stress_error, 20) == pytest.approx(2, abs=0.1)
    assert order(energy_error, 20) > 1.9


def test_evaluating_the_body_force_in_blocks_changes_nothing(monkeypatch):
    case = problem(BAR, Traction(), Velocity(), 1.0, body_force=lambda X, t: np.sin(t[:, None, None] + X))
    whole = TaylorGalerkin().solve(case, Discretisation(1 / 10, 0.5))
    monkeypatch.setattr(taylor_galerkin, "BLOCK", 70)
    pieces = TaylorGalerkin().solve(case, Discretisation(1 / 10, 0.5))
    np.testing.assert_array_equal(whole.fields["stress"], pieces.fields["stress"])
    np.testing.assert_array_equal(whole.histories["external_work"], pieces.histories["external_work"])


@pytest.mark.parametrize("end", [Traction, Velocity])
def test_the_external_work_of_an_end_load_balances_the_energy(end):
    def error(n):
        history = (
            TaylorGalerkin().solve(problem(BAR, Velocity(), end(Pulse(centre=0.5)), 1.5), Discretisation(1 / n, 0.8)).histories
        )
        assert np.ptp(history["external_work"]) > 0.01
        return np.abs(history["kinetic_energy"] + history["strain_energy"] - history["external_work"]).max()

    assert order(error) > 1.9


def test_a_step_load_travels_without_error_at_the_unit_courant_number():
    solution = TaylorGalerkin().solve(problem(BAR, Velocity(), Traction(Constant(3.0)), 5.5 / C), Discretisation(1 / 50, 1.0))
    x, t = solution.reference[:, 0], solution.time[:, None]
    exact = sum(
        (-1) ** k * 3.0 * (np.heaviside(C * t - (2 * k + 1 - x), 0.5) + np.heaviside(C * t - (2 * k + 1 + x), 0.5))
        for k in range(4)
    )
    wrong = np.abs(solution.fields["stress"][..., 0] - exact) > 1e-12
    assert wrong.sum(axis=1).max() <= 2  # the two elements beside the front, which lies on a node
    assert np.abs(exact).max() == 6.0
    early = slice(1, 50)
    behind_the_front = solution.fields["stress"][early, :, 0].mean(axis=1)
    np.testing.assert_allclose(behind_the_front, 3.0 * C * solution.time[early], rtol=1e-12)


@pytest.mark.parametrize("passes", [1, 3])
def test_an_absorbing_end_reflects_less_than_a_thousandth_of_a_pulse(passes):
    def shape(X):
        return np.exp(-(((X - 0.5) / 0.1) ** 2))

    for direction in (1, -1):
        initial = {"stress": shape, "velocity": lambda X, direction=direction: -direction * shape(X) / Z}
        at_ends = {}
        for end in (Absorbing(), Velocity()):
            case = problem(BAR, end, end, 1.0 / C, initial, outputs=1)
            at_ends[type(end)] = np.abs(
                TaylorGalerkin(passes).solve(case, Discretisation(1 / 100, 0.5)).fields["stress"][-1]
            ).max()
        assert at_ends[Absorbing] < 1e-3
        assert at_ends[Velocity] == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize(("passes", "limit"), [(1, 1.0), (3, 3**-0.5), (60, 3**-0.5)])
@pytest.mark.parametrize(("left", "right"), [*itertools.product(ENDS, repeat=2), (Periodic(), Periodic())])
def test_below_the_stability_limit_the_energy_does_not_grow(passes, limit, left, right):
    rng = np.random.default_rng(5)
    initial = {quantity: lambda X: rng.standard_normal(X.shape) for quantity in ("stress", "velocity")}
    case = problem(BAR, left, right, 20 / C, initial, outputs=1)
    solution = TaylorGalerkin(passes).solve(case, Discretisation(1 / 30, 0.98 * limit))
    assert solution.outcome.completed
    energy = solution.histories["kinetic_energy"] + solution.histories["strain_energy"]
    assert energy.max() <= 1.05 * energy[0]
    assert energy[-1] < 0.9 * energy[0]


@pytest.mark.parametrize(("passes", "limit"), [(1, 1.0), (60, 3**-0.5)])
@pytest.mark.parametrize(("left", "right"), [(Traction(), Velocity()), (Velocity(), Velocity()), (Periodic(), Periodic())])
def test_above_the_stability_limit_the_outcome_is_unstable_with_advice(passes, limit, left, right):
    rng = np.random.default_rng(5)
    initial = {quantity: lambda X: rng.standard_normal(X.shape) for quantity in ("stress", "velocity")}
    case = problem(BAR, left, right, 20 / C, initial)
    solution = TaylorGalerkin(passes).solve(case, Discretisation(1 / 30, 1.03 * limit))
    assert solution.outcome.status is Status.UNSTABLE
    assert "Courant" in str(solution.outcome)
    assert f"at step {solution.work.steps + 1} of " in solution.outcome.detail
    made = solution.work.steps + 1
    assert {len(history) for history in solution.histories.values()} == {made}
    assert len(solution.time) == len(solution.position) == len(solution.weight) == made
    for field in solution.fields.values():
        assert field.shape == (made, 30, 1)
        assert np.isfinite(field).all()


@pytest.mark.parametrize("courant", [2.0, 1e3])
def test_an_unstable_run_with_smooth_data_stops_long_before_overflow(courant):
    case = problem(Transport(1.0), Periodic(), Periodic(), 1e4, {"u": lambda X: np.sin(2 * np.pi * X)})
    solution = TaylorGalerkin().solve(case, Discretisation(1 / 20, courant))
    assert solution.outcome.status is Status.UNSTABLE
    assert np.abs(solution.fields["u"]).max() <= 10


def test_nan_in_boundary_or_initial_data_is_a_non_finite_outcome():
    case = problem(BAR, Velocity(), Traction(Constant(float("nan"))), 1.0)
    solution = TaylorGalerkin().solve(case, Discretisation(0.1, 0.5))
    assert solution.outcome.status is Status.NON_FINITE
    case = problem(Transport(1.0), Periodic(), Periodic(), 1.0, {"u": lambda X: np.where(X > 0.5, np.nan, 1.0)})
    assert TaylorGalerkin().solve(case, Discretisation(0.1, 0.5)).outcome.status is Status.NON_FINITE


@pytest.mark.parametrize("passes", [1, 3])
def test_neither_a_bar_at_rest_nor_one_pulled_steadily_counts_as_unstable(passes):
    rest = TaylorGalerkin(passes).solve(problem(BAR, Velocity(), Traction(), 5.0), Discretisation(0.05, 0.5))
    assert rest.outcome.completed
    assert not rest.fields["stress"].any()
    case = problem(BAR, Velocity(), Velocity(Constant(1.0)), 50.0, outputs=4)
    pulled = TaylorGalerkin(passes).solve(case, Discretisation(0.05, 0.5))
    assert pulled.outcome.completed
    np.testing.assert_allclose(pulled.fields["stress"][-1], BAR.density * C**2 * 50.0, rtol=0.02)


def test_the_sample_points_are_the_gauss_points():
    case = problem(BAR, Velocity(), Traction(), 1.0, {"velocity": lambda X: 3 * X - 1}, outputs=5)
    solution = TaylorGalerkin().solve(case, Discretisation(0.25, 0.5))
    np.testing.assert_allclose(solution.reference[:, 0], [0.125, 0.375, 0.625, 0.875])
    np.testing.assert_allclose(solution.weight.sum(axis=1), 1.0)
    np.testing.assert_array_equal(solution.position, np.broadcast_to(solution.reference, (6, 4, 1)))
    np.testing.assert_allclose(solution.time[[0, -1]], [0.0, 1.0])
    np.testing.assert_allclose(solution.fields["velocity"][0, 1:, 0], 3 * solution.reference[1:, 0] - 1)
    assert solution.work.point_steps == 4 * solution.work.steps
    assert solution.work.seconds > 0


def test_the_name_tells_the_number_of_passes():
    names = [TaylorGalerkin(passes).name for passes in (1, 2, 3)]
    assert names == ["tg-lumped", "tg-consistent-2", "tg-consistent-3"]
    assert TaylorGalerkin() == TaylorGalerkin(1)


@pytest.mark.parametrize(
    ("case", "remedy"),
    [
        (problem(NeoHookean(1.0, 1.0), Velocity(), Traction(), 1.0), "small strain"),
        (problem(BAR, Inflow(), Traction(), 1.0), "Traction, Velocity"),
        (problem(BAR, Periodic(), Traction(), 1.0), "Periodic on both"),
        (problem(BAR, Velocity(), Traction(), 1.0, {"displacement": lambda X: X}), "initial stress"),
        (problem(Transport(1.0), Outflow(), Inflow(), 1.0), "Inflow where"),
        (problem(Transport(-1.0), Inflow(), Outflow(), 1.0), "Inflow where"),
        (problem(Transport(1.0), Traction(), Outflow(), 1.0), "Inflow where"),
        (dataclasses.replace(problem(BAR, Velocity(), Traction(), 1.0), shape=Block((0.0,), (0.5,))), "from end to end"),
        (problem(Transport(0.0), Periodic(), Periodic(), 1.0), "other than zero"),
        (problem(Transport(1.0), Periodic(), Periodic(), 1.0, body_force=lambda X, t: t), "body force"),
        (Problem("square", (0, 0), (1, 1), BAR, dict.fromkeys(("x-", "x+", "y-", "y+"), Velocity()), 1.0), "one dimension"),
    ],
)
def test_a_problem_that_the_scheme_cannot_solve_is_refused(case, remedy):
    with pytest.raises(UsageError, match=remedy):
        TaylorGalerkin().solve(case, Discretisation(0.1, 0.5))


def test_zero_passes_are_refused():
    with pytest.raises(UsageError, match="at least one"):
        TaylorGalerkin(passes=0)
