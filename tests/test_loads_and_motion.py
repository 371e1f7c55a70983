"""The studies of loads, supports and moving bodies see solvers that are wrong: a right solver whose problem or solution is changed."""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mpmverify import studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import ExactTotal
from mpmverify.criteria.criterion import Setting
from mpmverify.errors import UsageError
from mpmverify.execution.verify import verify
from mpmverify.problem import Block, Bodies, Constant, Fixed, Traction, Velocity
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.mpm.layout import place_particles
from mpmverify.solvers.mpm.solver import MANY
from mpmverify.study import Refinement

LOADS, BODIES = "loads-and-supports", "moving-bodies"


def same(value):
    return value


@dataclasses.dataclass(frozen=True)
class Changed:
    """A solver that gets a changed problem, or returns a changed solution."""

    solver: Any
    of_problem: Callable[[Any], Any] = same
    of_solution: Callable[[Any], Any] = same

    name, orders, conserves = "changed", {}, frozenset()

    def solve(self, problem, discretisation):
        return self.of_solution(runs(self.solver, self.of_problem, problem, discretisation))


MADE: dict[Any, Any] = {}


def runs(solver, change, problem, at):
    """Solution of a changed problem, made once."""
    key = solver.name, problem.name, change, at
    if key not in MADE:
        MADE[key] = solver.solve(change(problem), at)
    return MADE[key]


def particles(problem, level):
    return len(place_particles(problem, level)[0])


def series(study, case, solver):
    """Criteria of a declared series, and the levels of its quick tier that one thread solves."""
    (declared,) = (entry for of, entry in studies.get(study).series() if (of.name, entry.solver) == (case, solver))
    (problem,) = (of.problem.problem for of in studies.get(study).cases if of.name == case)
    levels = tuple(level for level in declared.refinement.tier("quick") if particles(problem, level) < MANY)
    ladder = Refinement(declared.refinement.label, levels, len(levels))
    return {"study": studies.get(study), "case": case, "refinement": ladder, "criteria": declared.criteria}


SERIES = {
    "block": (MaterialPoint("USL"), LOADS, "block, plane"),
    "layer": (MaterialPoint("USL"), LOADS, "layer, plane"),
    "blocks": (MaterialPoint(), BODIES, "blocks, plane"),
    "square": (MaterialPoint(formulation="total"), BODIES, "square"),
}


def verdicts(name, **changes):
    solver, study, case = SERIES[name]
    findings = verify(Changed(solver, **changes), **series(study, case, solver))
    return {finding.criterion: finding.verdict for finding in findings}


@pytest.mark.parametrize("name", SERIES)
def test_a_right_solver_passes(name):
    assert set(verdicts(name).values()) == {Verdict.PASS}


def with_faces(problem, **changed):
    return dataclasses.replace(problem, boundary=dict(problem.boundary) | changed)


def scaled(face, factor, problem):
    load = problem.boundary[face].value
    return with_faces(problem, **{face: Traction(dataclasses.replace(load, amplitude=factor * load.amplitude))})


def rollers(problem):
    held = {face: Velocity(Constant(0.0)) for face, condition in problem.boundary.items() if condition == Fixed()}
    return with_faces(problem, **held)


def larger(problem):
    (block,) = problem.shape.bodies
    return dataclasses.replace(problem, shape=Block((0.25, *block.lower[1:]), block.upper))


def one_velocity(problem):
    return dataclasses.replace(problem, initial={"velocity": lambda X: np.tile([0.9, -0.15], (len(X), 1))})


def one_body(problem):
    return dataclasses.replace(problem, shape=Bodies(problem.shape.bodies[:1]))


def exchanged(problem):
    return dataclasses.replace(problem, body_force=lambda X, t: problem.body_force(X, t)[..., ::-1])


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("block", lambda problem: scaled("x+", 2.0, problem)),
        ("block", lambda problem: scaled("y-", -1.0, problem)),
        ("block", larger),
        ("layer", rollers),
        ("blocks", one_velocity),
        ("blocks", one_body),
        ("square", exchanged),
    ],
)
def test_a_solver_of_another_problem_fails(name, change):
    assert {Verdict.FAIL, Verdict.ERROR} & set(verdicts(name, of_problem=change).values())


def with_fields(**changes):
    def change(solution):
        fields = {name: changes.get(name, changes.get("every", same))(values) for name, values in solution.fields.items()}
        return dataclasses.replace(solution, fields=fields, position=solution.reference + fields["displacement"])

    return change


USELESS = {
    "zero": with_fields(every=lambda values: 0 * values),
    "constant in time": with_fields(every=lambda values: np.repeat(values[:1], len(values), axis=0)),
    "never moves": with_fields(displacement=lambda values: 0 * values, velocity=lambda values: 0 * values),
    "displacement x 1000": with_fields(displacement=lambda values: 1000 * values),
    "velocity reversed": with_fields(velocity=lambda values: -values),
    "stress x 2": with_fields(stress=lambda values: 2 * values),
    "axes exchanged": with_fields(displacement=lambda values: values[..., ::-1], velocity=lambda values: values[..., ::-1]),
}


@pytest.mark.parametrize("change", USELESS)
@pytest.mark.parametrize("name", SERIES)
def test_a_solver_that_returns_something_else_fails(name, change):
    if (name, change) == ("blocks", "stress x 2"):
        pytest.skip("twice a stress of zero is zero")
    assert Verdict.FAIL in verdicts(name, of_solution=USELESS[change]).values()


@pytest.mark.parametrize("stock", ["momentum_x", "momentum_y", "angular_momentum"])
def test_a_total_that_is_off_by_a_billionth_at_one_step_fails(stock):
    def change(solution):
        values = solution.histories[stock].copy()
        values[3] *= 1 + 1e-9
        return dataclasses.replace(solution, histories=dict(solution.histories) | {stock: values})

    found = verdicts("blocks", of_solution=change)
    assert found[f"{stock.removesuffix('_x').removesuffix('_y')} exact to 1e-12"] is Verdict.FAIL


def test_a_total_that_the_problem_does_not_know_or_that_is_zero_is_refused():
    solver, study, case = SERIES["square"]
    ((of, entry),) = ((c, s) for c, s in studies.get(study).series() if (c.name, s.solver) == (case, solver))
    at = entry.refinement.levels[0]
    for totals in ({}, {"momentum": lambda t: np.zeros((len(t), 2))}):
        exact = dataclasses.replace(of.problem.exact, totals=totals)
        setting = Setting(dataclasses.replace(of.problem, exact=exact), at)
        with pytest.raises(UsageError, match=r"the exact momentum of 'drifting-waves-2d-0.03' is unknown or zero throughout"):
            ExactTotal("momentum", "").measure(runs(solver, same, of.problem.problem, at), setting)


def test_the_quick_tier_has_a_level_that_several_threads_share():
    (declared,) = (
        entry
        for case, entry in studies.get(LOADS).series()
        if (case.name, entry.solver) == ("layer, plane", MaterialPoint("USL"))
    )
    (problem,) = (case.problem.problem for case in studies.get(LOADS).cases if case.name == "layer, plane")
    counts = [particles(problem, level) for level in declared.refinement.tier("quick")]
    assert counts[-1] >= MANY > counts[-2]
