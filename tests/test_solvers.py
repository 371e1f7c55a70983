"""Every solver value of the studies has its declared orders and invariants, and keeps the contract of `mpmverify.solution`."""

import dataclasses
import functools
import math
import pickle
import re
from collections.abc import Iterator

import numpy as np
import pytest
from arrays import assert_close

from mpmverify import studies
from mpmverify.adapters.bisection import Bisection
from mpmverify.convergence import Convergence, analyse
from mpmverify.criteria import Balance
from mpmverify.criteria.criterion import Setting
from mpmverify.criteria.norms import NORMS, errors
from mpmverify.errors import UsageError
from mpmverify.exact import ExactSolution, VerificationProblem
from mpmverify.exact.advection import Gaussian, advection
from mpmverify.exact.elastic_bar import StepLoad, elastic_bar
from mpmverify.exact.manufactured import manufactured
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import (
    UNITS,
    Absorbing,
    Array,
    BoundaryCondition,
    Constant,
    Discretisation,
    LinearElastic,
    NeoHookean,
    Outflow,
    Periodic,
    Problem,
    Traction,
    Velocity,
    output_steps,
)
from mpmverify.solution import ADVICE, Solution, Solver, Status
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.solvers.textbook import Textbook
from mpmverify.studies import variants

SOLVERS: tuple[Solver, ...] = tuple(
    dict.fromkeys(
        (
            *variants.TAYLOR_GALERKIN,
            *variants.FEM_P1,
            *variants.FEM_P2,
            *variants.MPM,
            *(
                series.solver
                for name in studies.NAMES
                for _, series in studies.get(name).in_tier("quick").series()
                if not isinstance(series.solver, Bisection)
            ),
        )
    )
)
UPDATED = tuple(s for s in SOLVERS if isinstance(s, MaterialPoint) and s.formulation == "updated")
every_solver = pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: solver.name)
every_updated = pytest.mark.parametrize("solver", UPDATED, ids=lambda solver: solver.name)


# Problems that every bar solver takes. The bar does not start at the origin, and Poisson's ratio is not zero.

BAR = LinearElastic(youngs_modulus=2.0, density=3.0, poissons_ratio=0.2)
LOWER, UPPER = -0.7, 0.5
LENGTH = UPPER - LOWER
PULL = 1e-4
"""Traction [Pa], small enough for small strains: Young's modulus is 2 Pa."""
END_TIME = 1.7


def swing(X: Array) -> Array:
    """Initial velocity, zero at the fixed end [m/s]."""
    return PULL * np.sin(3 * (X - LOWER))


def drift(X: Array, t: Array) -> Array:
    """Body force [m/s^2]."""
    return PULL * np.cos(2 * X[None]) * np.exp(-t[:, None, None])


def lift(X: Array, t: Array) -> Array:
    """Uniform body force [m/s^2]."""
    return np.full((len(t), len(X), 1), PULL)


def bar(left: BoundaryCondition, right: BoundaryCondition, **choices: object) -> Problem:
    # The choices are fields of a problem, each of a type of its own.
    return Problem("bar", (LOWER,), (UPPER,), BAR, {"x-": left, "x+": right}, END_TIME, **choices)


PULLED = bar(Velocity(), Traction(Constant(PULL)), initial={"velocity": swing}, body_force=drift, outputs=8)
FREE = bar(Traction(), Traction(Constant(PULL)), body_force=lift, outputs=400)
LEVEL = Discretisation(h=LENGTH / 24, courant=0.2, ppc=2)


@functools.cache
def pulled(solver: Solver) -> Solution:
    solution = solver.solve(PULLED, LEVEL)
    assert solution.outcome.completed, str(solution.outcome)
    return solution


# Orders


def vibration_with_poissons_ratio(nu: float) -> VerificationProblem:
    """Axial vibration at a thousandth of the published strain, with E chosen to keep the constrained modulus for any nu."""
    vibration = axial_vibration(v0=1e-4)
    law = vibration.problem.material
    assert isinstance(law, LinearElastic)
    constrained = (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    material = LinearElastic(law.youngs_modulus / constrained, law.density, nu)
    return dataclasses.replace(vibration, problem=dataclasses.replace(vibration.problem, material=material))


VIBRATION = vibration_with_poissons_ratio(0.25)
FINITE_STRAIN = manufactured(0.05, poissons_ratio=0.3)
Ladder = tuple[VerificationProblem, tuple[int, ...], float]
"""Smooth problem, numbers of cells and Courant number."""


def ladders(solver: Solver) -> tuple[Ladder, ...]:
    if isinstance(solver, TaylorGalerkin):
        return (VIBRATION, (32, 64, 128, 256), 0.5), (advection(Gaussian()), (64, 128, 256, 512), 0.5)
    if isinstance(solver, FiniteElement):
        vibration = (VIBRATION, (16, 32, 64, 128), 0.25)
        return (vibration,) if solver.integrator == "newmark" else (vibration, (FINITE_STRAIN, (16, 32, 64, 128), 0.2))
    assert isinstance(solver, MaterialPoint | Textbook)
    vibration = (VIBRATION, (32, 64, 128, 256), 0.4)
    # PIC reaches its order late on the forced problem: its smoothing is large compared with the solution that the force keeps up.
    damped = solver.transfer == "PIC" if isinstance(solver, Textbook) else solver.transfer.flip == 0
    if solver.formulation == "updated" or damped:
        return (vibration,)
    return vibration, (FINITE_STRAIN, (16, 32, 64, 128), 0.2)


def measured_orders(solver: Solver, ladder: Ladder) -> dict[str, Convergence]:
    verification, cells, courant = ladder
    (length,) = verification.problem.lengths
    relative: dict[str, list[float]] = {}
    for n in cells:
        solution = solver.solve(verification.problem, Discretisation(length / n, courant, ppc=2))
        assert solution.outcome.completed, str(solution.outcome)
        assert set(solution.fields) <= set(solver.orders), "an order is declared for every field"
        for quantity, (error, size) in errors(solution, verification.exact).items():
            k = NORMS.index("L2-max")
            relative.setdefault(quantity, []).append(error[k] / size[k])
    h = [length / n for n in cells]
    return {quantity: analyse(h, series) for quantity, series in relative.items()}


@every_solver
def test_declared_orders_are_measured(solver: Solver) -> None:
    measured = set()
    for ladder in ladders(solver):
        for quantity, series in measured_orders(solver, ladder).items():
            assert series.fit is not None
            assert series.floor is None
            assert series.kept.sum() >= 3
            coarse = getattr(solver, "coarse_orders", solver.orders)
            low, high = sorted((solver.orders[quantity], coarse[quantity]))
            assert low - 0.15 <= series.fit.order <= high + 0.15, f"{quantity} on {ladder[0].problem.name}: {series}"
            measured.add(quantity)
    assert measured == set(solver.orders), "every declared order is measured"


@every_solver
def test_poissons_ratio_enters_through_the_constrained_modulus_alone(solver: Solver) -> None:
    slender, wide = (
        solver.solve(vibration_with_poissons_ratio(nu).problem, Discretisation(25 / 32, 0.2, 2)) for nu in (0.0, 0.4)
    )
    for quantity, field in slender.fields.items():
        assert_close(wide.fields[quantity], field, abs=1e-11 * np.abs(field).max(), said=quantity)


# Invariants


@every_solver
def test_declared_invariants_are_kept_to_round_off(solver: Solver) -> None:
    assert solver.conserves <= {"mass", "momentum"}
    assert ("momentum" in solver.conserves) == ("tls" not in solver.name), "fits in the cells do not keep it"
    source_terms = {"mass": "", "momentum": "impulse"}
    solution, setting = pulled(solver), Setting(VerificationProblem(PULLED, ExactSolution({}, ""), "", ()), LEVEL)
    assert np.ptp(solution.histories["impulse"]) > 0.1 * PULL * END_TIME
    for stock in solver.conserves:
        (defect,) = Balance(stock, source_terms[stock], "").measure(solution, setting).values()
        assert defect < 1e-12, stock


@every_solver
def test_a_free_bar_gains_the_momentum_of_its_forces(solver: Solver) -> None:
    history = solver.solve(FREE, LEVEL).histories
    expected = (PULL + BAR.density * LENGTH * PULL) * history["time"]
    round_off = 1e-12 if "momentum" in solver.conserves else 1e-4  # fits in the cells are off by 6e-5 here
    assert_close(history["momentum"], expected, abs=round_off * expected[-1])
    assert_close(history["impulse"], expected, abs=1e-12 * expected[-1])
    assert_close(history["mass"], BAR.density * LENGTH, rel=1e-13)


@every_solver
def test_histories_start_with_the_initial_state(solver: Solver) -> None:
    history = pulled(solver).histories
    assert {history[name][0] for name in ("time", "impulse", "external_work") if name in history} == {0}
    # int rho v0 and int rho v0^2/2; solvers sum over particles or nodes, hence the tolerance
    angle = 3 * LENGTH
    momentum = BAR.density * PULL * (1 - math.cos(angle)) / 3
    kinetic = BAR.density * PULL**2 / 4 * (LENGTH - math.sin(2 * angle) / 6)
    assert history["momentum"][0] == pytest.approx(momentum, rel=5e-3)
    assert history["kinetic_energy"][0] == pytest.approx(kinetic, rel=5e-3)


# Weights and samples


@every_solver
def test_weights_sum_to_the_measure_of_the_body(solver: Solver) -> None:
    solution = pulled(solver)
    assert np.all(solution.weight > 0)
    sums = solution.weight.sum(axis=1)
    assert sums[0] == pytest.approx(LENGTH, rel=1e-14)
    if solver not in UPDATED and not isinstance(solver, Textbook):
        assert sums == pytest.approx(LENGTH, rel=1e-14)


@every_updated
def test_updated_volumes_sum_to_the_current_length(solver: Solver) -> None:
    """The sum of V0 F is the distance from the outer edge of the first particle to that of the last."""
    solution = pulled(solver)
    x, w = solution.position[:, :, 0], solution.weight
    between_edges = x[:, -1] + w[:, -1] / 2 - (x[:, 0] - w[:, 0] / 2)
    elongation = np.abs(between_edges - LENGTH).max()
    assert elongation > 0.5 * PULL * LENGTH / BAR.youngs_modulus
    assert w.sum(axis=1) == pytest.approx(between_edges, abs=0.02 * elongation)


@every_updated
def test_updated_volumes_between_fixed_ends_miss_the_length_at_second_order_in_the_amplitude(solver: Solver) -> None:
    """Particles that have moved no longer integrate the gradient of a nodal field exactly."""
    defect = []
    for v0 in (1e-2, 1e-3):
        solution = solver.solve(axial_vibration(v0=v0).problem, Discretisation(25 / 24, 0.2, 2))
        defect.append(np.abs(solution.weight.sum(axis=1) / 25 - 1).max())
    strain = 1e-3  # v0/c of the first run
    assert defect[0] < 50 * strain**2
    assert defect[1] < 0.02 * defect[0] or defect[1] < 1e-13


@every_solver
def test_arrays_are_finite_float64_of_the_declared_shapes(solver: Solver) -> None:
    solution = pulled(solver)
    T, P = len(solution.time), len(solution.reference)
    steps, dt = LEVEL.time_steps(PULLED)
    shapes = {
        "time": (solution.time, (T,)),
        "reference": (solution.reference, (P, 1)),
        "position": (solution.position, (T, P, 1)),
        "weight": (solution.weight, (T, P)),
        **{quantity: (field, (T, P, 1)) for quantity, field in solution.fields.items()},
        **{f"history {name}": (history, (steps + 1,)) for name, history in solution.histories.items()},
    }
    for name, (array, shape) in shapes.items():
        assert array.shape == shape, name
        assert array.dtype == np.float64, name
        assert np.all(np.isfinite(array)), name
    assert solution.dt == dt
    assert set(solution.fields) <= set(UNITS)
    energies = {"kinetic_energy"} if isinstance(solver, Textbook) else {"kinetic_energy", "strain_energy", "external_work"}
    energies |= {"dissipated_energy"} if isinstance(solver, MaterialPoint) else set()
    assert set(solution.histories) == {"time", "mass", "momentum", "impulse"} | energies
    assert np.all((solution.reference > LOWER) & (solution.reference < UPPER))
    assert len(np.unique(solution.reference)) == P
    assert np.array_equal(solution.position[0], solution.reference)
    displacement = solution.fields.get("displacement", np.zeros((T, P, 1)))
    assert_close(solution.position, solution.reference + displacement, abs=1e-15)


# Times and work


@every_solver
@pytest.mark.parametrize(("outputs", "courant"), [(8, 0.2), (7, 0.23), (32, 0.2), (1, 0.2), (10_000, 0.2)])
def test_outputs_fall_on_the_steps_that_the_problem_asks_for(solver: Solver, outputs: int, courant: float) -> None:
    problem, level = dataclasses.replace(PULLED, outputs=outputs), dataclasses.replace(LEVEL, courant=courant)
    solution = solver.solve(problem, level)
    steps, dt = level.time_steps(problem)
    assert solution.time == pytest.approx(output_steps(steps, outputs) * dt, rel=1e-14)
    assert solution.time[0] == 0
    assert abs(solution.time[-1] - END_TIME) <= math.ulp(END_TIME)
    history = solution.histories["time"]
    assert history == pytest.approx(np.arange(steps + 1) * dt, rel=1e-14)
    assert np.array_equal(history[output_steps(steps, outputs)], solution.time)


@every_solver
def test_work_counts_steps_and_points(solver: Solver) -> None:
    solution = pulled(solver)
    steps, _ = LEVEL.time_steps(PULLED)
    (cells,) = LEVEL.cells(PULLED)
    points = cells * LEVEL.ppc if isinstance(solver, MaterialPoint | Textbook) else cells
    assert solution.work.steps == steps > 0
    assert solution.work.point_steps == steps * points
    assert 0 <= solution.work.seconds < 60


# Values


def test_names_are_unique() -> None:
    assert len({solver.name for solver in SOLVERS}) == len(SOLVERS)


@every_solver
def test_a_name_is_valid_for_a_netcdf_group_and_a_file(solver: Solver) -> None:
    assert re.fullmatch(r"[A-Za-z0-9]([A-Za-z0-9_.-]*[A-Za-z0-9])?", solver.name)


@every_solver
def test_a_solver_is_a_frozen_value(solver: Solver) -> None:
    again = pickle.loads(pickle.dumps(solver))
    assert again == solver
    assert hash(again) == hash(solver)
    assert again.name == solver.name
    # A solver is a frozen dataclass, which the protocol `Solver` cannot express.
    for field in dataclasses.fields(solver):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(solver, field.name, getattr(solver, field.name))


def arrays(solution: Solution) -> Iterator[tuple[str, Array]]:
    for name in ("time", "reference", "position", "weight"):
        yield name, getattr(solution, name)
    yield from solution.fields.items()
    yield from solution.histories.items()


@every_solver
def test_results_are_deterministic_bit_for_bit(solver: Solver) -> None:
    again = pickle.loads(pickle.dumps(solver)).solve(PULLED, LEVEL)
    for (name, first), (_, second) in zip(arrays(pulled(solver)), arrays(again), strict=True):
        assert first.tobytes() == second.tobytes(), name
    assert (again.dt, again.outcome) == (pulled(solver).dt, pulled(solver).outcome)


@every_solver
def test_a_result_does_not_depend_on_earlier_runs(solver: Solver) -> None:
    """A run in between, even an unstable one, changes no bit of the next result."""
    first = solver.solve(FREE, LEVEL)
    solver.solve(PULLED, dataclasses.replace(LEVEL, courant=5.0))
    for (name, before), (_, after) in zip(arrays(first), arrays(solver.solve(FREE, LEVEL)), strict=True):
        assert before.tobytes() == after.tobytes(), name


# Failed runs and refused problems


@every_solver
@pytest.mark.parametrize("courant", [5.0, 20.0])
def test_far_above_the_stability_limit_the_outcome_has_advice(solver: Solver, courant: float) -> None:
    problem, level = elastic_bar(StepLoad()).problem, Discretisation(1 / 64, courant, 2)
    solution = solver.solve(problem, level)
    steps, _ = level.time_steps(problem)
    for name, array in arrays(solution):
        assert np.all(np.isfinite(array)), name
    if isinstance(solver, FiniteElement) and solver.integrator == "newmark":
        assert solution.outcome.completed, "the average acceleration is stable at any step"
        return
    assert solution.outcome.status in (Status.UNSTABLE, Status.NON_FINITE, Status.LEFT_GRID)
    assert ADVICE[solution.outcome.status] in str(solution.outcome)
    assert re.search(rf"step \d+ of {steps}", solution.outcome.detail)
    T, made = len(solution.time), len(solution.histories["time"]) - 1
    planned = output_steps(steps, problem.outputs)
    assert 1 <= T == np.sum(planned <= made), "the outputs before the failure are returned"
    assert solution.work.steps <= steps
    for field in (solution.position, solution.weight, *solution.fields.values()):
        assert len(field) == T


@dataclasses.dataclass(frozen=True)
class Foreign(LinearElastic):
    """Material that no solver supports."""


ELASTIC_ENDS: dict[str, BoundaryCondition] = {"x-": Velocity(), "x+": Traction()}
REFUSED = {
    "unknown material": Problem("of-a-foreign-material", (0.0,), (1.0,), Foreign(1.0, 1.0), ELASTIC_ENDS, 1.0),
    "outflow of a bar": Problem(
        "leaking-bar", (0.0,), (1.0,), LinearElastic(1.0, 1.0), {"x-": Velocity(), "x+": Outflow()}, 1.0
    ),
    "half periodic": Problem(
        "half-joined-bar", (0.0,), (1.0,), LinearElastic(1.0, 1.0), {"x-": Velocity(), "x+": Periodic()}, 1.0
    ),
    "two dimensions": Problem(
        "square",
        (0.0, 0.0),
        (1.0, 1.0),
        LinearElastic(1.0, 1.0),
        {"x-": Velocity(), "x+": Velocity(), "y-": Velocity(), "y+": Velocity()},
        1.0,
    ),
    "displacement without stress": Problem(
        "displaced-bar", (0.0,), (1.0,), LinearElastic(1.0, 1.0), ELASTIC_ENDS, 1.0, {"displacement": swing}
    ),
}
"""Problems that no solver takes, except that finite elements take the displacement, and material points take two dimensions."""


@every_solver
@pytest.mark.parametrize("problem", REFUSED.values(), ids=REFUSED)
def test_a_problem_that_the_solver_cannot_take_is_refused(solver: Solver, problem: Problem) -> None:
    if problem.name == "square" and isinstance(solver, MaterialPoint | Textbook):
        problem = dataclasses.replace(problem, boundary=problem.boundary | {"y+": Absorbing()})
    if problem.name == "displaced-bar" and isinstance(solver, FiniteElement):
        problem = dataclasses.replace(problem, name="stressed-bar", initial={"stress": swing})
    assert_refused(solver, problem)


TRANSPORT = advection(Gaussian()).problem
NEO_HOOKEAN = Problem("neo-hookean-bar", (0.0,), (1.0,), NeoHookean(1.0, 1.0), ELASTIC_ENDS, 1.0)
ABSORBED = Problem("absorbing-bar", (0.0,), (1.0,), LinearElastic(1.0, 1.0), {"x-": Velocity(), "x+": Absorbing()}, 1.0)


@every_solver
def test_materials_and_conditions_of_other_solvers_are_refused(solver: Solver) -> None:
    if isinstance(solver, TaylorGalerkin):
        assert_refused(solver, NEO_HOOKEAN)
        return
    assert_refused(solver, TRANSPORT)
    assert_refused(solver, ABSORBED)
    if isinstance(solver, FiniteElement) and solver.integrator == "newmark":
        assert_refused(solver, NEO_HOOKEAN)


def assert_refused(solver: Solver, problem: Problem) -> None:
    level = Discretisation(problem.lengths[0] / 8, 0.2, 2)
    with pytest.raises(UsageError) as refusal:
        solver.solve(problem, level)
    assert repr(solver.name) in str(refusal.value)
    assert repr(problem.name) in str(refusal.value)
    assert "it takes" in str(refusal.value)


@every_solver
def test_a_cell_size_that_does_not_divide_the_body_is_refused(solver: Solver) -> None:
    with pytest.raises(UsageError, match=rf"'{PULLED.name}'.*does not divide"):
        solver.solve(PULLED, Discretisation(LENGTH / 24.5, 0.2, 2))
