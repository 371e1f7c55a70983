"""Stability limits: the theory, the search by bisection, and the verdict on the limit found."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from mpmverify.adapters.bisection import Bisection
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import StabilityLimit
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.evidence import Evidence
from mpmverify.errors import UsageError
from mpmverify.exact.dispersion import symbols
from mpmverify.exact.ring_modes import ring_modes
from mpmverify.exact.stability import BASES, LIMITS, TRANSFERS, courant_limit, squared_limit
from mpmverify.judgement.findings import judge_criterion
from mpmverify.problem import Discretisation
from mpmverify.solution import Outcome, Solution, Status, Work
from mpmverify.solvers.mpm import FLIP, MaterialPoint, fmpm

SERIES = {
    (schedule, terms, full)
    for terms, full in TRANSFERS.values()
    for schedule in (("USL",) if terms else ("USF", "USL", "MUSL"))
}


def step(courant, A, D, schedule, terms, full):
    """Matrix of one step for nodal velocity w and strain measure e, as a product of the stages of the scheme."""
    kick, strain = np.array([[1.0, -(courant**2) * D], [0.0, 1.0]]), np.array([[1.0, 0.0], [1.0, 1.0]])
    if schedule != "USL":  # strain from the old velocity; A is the share of the kick that the grid gets back from the particles
        return np.array([[1.0, -A * courant**2 * D], [0.0, 1.0]]) @ strain
    if not terms:  # strain from the velocity after the kick; the particles return the share A of the kick
        back = np.array([[1.0, -A * courant**2 * D], [0.0, 1.0]])
        return np.array([back[0], (strain @ kick)[1]])
    R = sum((1 - A) ** j for j in range(terms))
    if full:  # the state is the velocity that the particles took; the grid gets the share A of it
        return strain @ np.diag([R, 1.0]) @ kick @ np.diag([A, 1.0])
    back = np.array([[R * A, -A * courant**2 * D], [0.0, 1.0]])
    return np.array([back[0], (strain @ kick)[1]])


@pytest.mark.parametrize("ppc", [1, 2, 3, 4])
@pytest.mark.parametrize("degree", BASES.values())
@pytest.mark.parametrize(("schedule", "terms", "full"), sorted(SERIES))
def test_a_mode_grows_above_its_limit_and_not_below(schedule, terms, full, degree, ppc):
    """Eigenvalues of the step matrix of a mode, slightly below and slightly above its limit."""
    for theta in np.random.default_rng(ppc).uniform(0.3, np.pi, 20):
        ((A,), (D,)) = symbols(np.array([theta]), ppc, degree)
        (limit,) = np.sqrt(squared_limit(np.array([theta]), ppc, schedule=schedule, degree=degree, terms=terms, full_mass=full))
        below, above = (
            np.abs(np.linalg.eigvals(step(factor * limit, A, D, schedule, terms, full))).max() for factor in (0.999, 1.001)
        )
        assert below < 1 + 1e-9 < above


def test_known_limits_of_the_linear_basis():
    """Linear basis, one particle in the middle of a cell: 1/sqrt(2) for USL, 2 for USF and MUSL."""
    assert courant_limit(1, schedule="USL", degree=1) == pytest.approx(math.sqrt(0.5), rel=1e-7)
    for schedule in ("USF", "MUSL"):
        assert courant_limit(1, schedule=schedule, degree=1) == pytest.approx(2, rel=1e-7)


def test_a_long_series_has_the_limit_of_the_full_mass_matrix():
    """R A -> 1: nu_C^2 = 4 A/D, the limit of the consistent mass matrix."""
    A, D = symbols(np.array([1.0]), 2, 1)
    (squared,) = squared_limit(np.array([1.0]), 2, schedule="USL", degree=1, terms=200)
    assert squared == pytest.approx(4 * A[0] / D[0], rel=1e-12)


@pytest.mark.parametrize("degree", BASES.values())
def test_symbols_reproduce_a_constant_and_a_linear_velocity(degree):
    """At theta = 0 the velocity is returned unchanged and its strain is zero; for small theta the strain grows as theta^2."""
    (again,), (strains,) = symbols(np.zeros(1), 3, degree)
    assert again == pytest.approx(1, abs=1e-14)
    assert strains == pytest.approx(0, abs=1e-14)
    _, (strains,) = symbols(np.array([1e-3]), 3, degree)
    assert strains == pytest.approx(1e-6, rel=1e-3)


# The ring.


def test_the_waves_of_the_ring_satisfy_the_wave_equation_and_the_initial_conditions():
    verification = ring_modes(12, length=3.0, youngs_modulus=5.0, density=2.0)
    problem, fields = verification.problem, verification.exact.fields
    X, t, e = np.linspace(0, 3, 31)[:, None], np.array([0.37]), 1e-4
    E, rho = problem.material.youngs_modulus, problem.material.density

    def slope(field, dx, dt):
        return (fields[field](X + dx, t + dt) - fields[field](X - dx, t - dt)) / (2 * e)

    strain, acceleration = slope("displacement", e, 0), slope("velocity", 0, e)
    size = np.abs(fields["stress"](X, t)).max()
    assert fields["stress"](X, t) == pytest.approx(E * strain, abs=1e-6 * size)
    assert fields["velocity"](X, t) == pytest.approx(slope("displacement", 0, e), abs=1e-6 * size)
    assert slope("stress", e, 0) == pytest.approx(rho * acceleration, abs=1e-5 * np.abs(acceleration).max())
    for name in ("displacement", "stress"):
        assert problem.initial[name](X) == pytest.approx(fields[name](X, np.zeros(1))[0], abs=1e-15)
        assert fields[name](X[:1], t) == pytest.approx(fields[name](X[-1:], t), abs=1e-12 * size)
    assert E * problem.initial["displacement_gradient"](X) == pytest.approx(problem.initial["stress"](X), abs=1e-15)
    assert np.abs(fields["velocity"](X, np.zeros(1))).max() == 0


def test_every_wave_of_the_ring_strains_the_middle_of_a_cell():
    """A particle there senses every wave, even the shortest."""
    problem = ring_modes(12).problem
    middles = (np.arange(12)[:, None] + 0.5) * problem.upper[0] / 12
    spectrum = np.abs(np.fft.rfft(problem.initial["displacement_gradient"](middles)[:, 0]))
    assert spectrum[1:].min() > 0.4 * spectrum[1:].max()
    with pytest.raises(UsageError, match="even"):
        ring_modes(7)


# The search.


@dataclass(frozen=True)
class Limited:
    """A solver that is stable up to a Courant number; instability shows in its status or in its energy."""

    limit: float
    says: str = "status"

    name = "limited"
    orders = {}  # noqa: RUF012 - as plain as its author would write it
    conserves = frozenset()

    def solve(self, problem, discretisation):
        stable = discretisation.courant <= self.limit
        _, dt = discretisation.time_steps(problem)
        status = Status.COMPLETED if stable or self.says != "status" else Status.UNSTABLE
        if self.says == "crash":
            status = Status.CRASHED
        energy = np.array([1.0, 1.0 if stable else math.nan if self.says == "nan" else 1e3])
        histories = {"time": np.array([0, problem.end_time]), "kinetic_energy": 0 * energy, "strain_energy": energy}
        point = np.zeros((1, 1))
        return Solution(np.zeros(1), dt, point, point[None], point, {}, histories, Work(), Outcome(status))


RING = ring_modes(4, crossings=2500)


def limit_of(solver, courant=4.0, **choices):
    found = Bisection(solver, **choices).solve(RING.problem, Discretisation(RING.problem.upper[0] / 4, courant))
    return found, found.dt * RING.problem.material.wave_speed / (RING.problem.upper[0] / 4)


@pytest.mark.parametrize("says", ["status", "energy", "nan"])
@pytest.mark.parametrize("limit", [0.011, 0.3, 0.9999, 1.0, 3.99])
def test_bisection_finds_the_limit(limit, says):
    found, courant = limit_of(Limited(limit, says))
    assert found.outcome.completed
    assert courant == pytest.approx(limit, rel=2e-3)
    assert courant <= limit


def test_a_solver_that_is_stable_on_its_level_is_not_refined():
    found, courant = limit_of(Limited(9.0))
    assert found.outcome.completed
    assert courant == pytest.approx(4, rel=2e-3)


def test_a_solver_that_is_never_stable_is_reported_unstable():
    found, _ = limit_of(Limited(1e-9))
    assert found.outcome.status is Status.UNSTABLE
    assert "still" in found.outcome.detail


def test_the_search_reports_a_crash():
    found, _ = limit_of(Limited(0.5, "crash"))
    assert found.outcome.status is Status.CRASHED


# The verdict.


def evidence(measured, ppc, courant=4.0):
    n = len(ppc)
    theory = np.array([LIMITS["mpm-tl-linear-usl-flip"](count) for count in ppc])
    metrics = {"stability_limit": theory * np.array(measured), "theoretical_stability_limit": theory}
    return Evidence(np.full(n, 0.1), np.full(n, 0.01), np.full(n, courant), np.array(ppc), ("completed",) * n, metrics=metrics)


CRITERION = StabilityLimit("mpm-tl-linear-usl-flip", 0.01, "theory")


@pytest.mark.parametrize(
    ("measured", "courant", "verdict"),
    [
        ([1.0, 1.009], 4.0, Verdict.PASS),
        ([1.0, 0.991], 4.0, Verdict.PASS),
        ([1.0, 1.011], 4.0, Verdict.FAIL),
        ([0.989, 1.0], 4.0, Verdict.FAIL),
        ([1.0, math.nan], 4.0, Verdict.ERROR),
        ([1.0, 1.0], 0.75, Verdict.ERROR),
    ],
)
def test_deviations_of_the_limit_in_both_directions_are_judged(measured, courant, verdict):
    assert judge_criterion(CRITERION, evidence(measured, [1, 2], courant))[0] is verdict


def test_a_scheme_without_a_known_limit_is_refused():
    with pytest.raises(UsageError, match="stability limit of 'mine' is unknown"):
        StabilityLimit("mine", 0.01, "theory")


@dataclass(frozen=True)
class Hasty:
    """A material point solver that uses another time step than it reports, as if a factor was forgotten."""

    solver: MaterialPoint
    factor: float

    @property
    def name(self):
        return f"hasty-{self.solver.name}"

    orders = {}  # noqa: RUF012 - as plain as its author would write it
    conserves = frozenset()

    def solve(self, problem, discretisation):
        found = self.solver.solve(problem, replace(discretisation, courant=self.factor * discretisation.courant))
        return replace(found, dt=found.dt / self.factor)


@pytest.mark.parametrize("factor", [1.0, 0.9, 1.1])
@pytest.mark.parametrize(
    "solver", [MaterialPoint("USL", FLIP, formulation="total"), MaterialPoint("USL", fmpm(2), formulation="total")]
)
def test_a_solver_with_a_wrong_time_step_fails(solver, factor):
    verification, at = ring_modes(40), Discretisation(2.0 / 40, 4.0, 2)
    criterion = StabilityLimit(solver.name, 0.01, "theory")
    solution = Bisection(Hasty(solver, factor)).solve(verification.problem, at)
    metrics = {name: np.array([value]) for name, value in criterion.measure(solution, Setting(verification, at)).items()}
    told = Evidence(np.array([at.h]), np.array([solution.dt]), np.array([4.0]), np.array([2]), ("completed",), metrics=metrics)
    assert judge_criterion(criterion, told)[0] is (Verdict.PASS if factor == 1 else Verdict.FAIL)
