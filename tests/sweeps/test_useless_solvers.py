"""Solvers that do nothing useful, or are wrong by a factor: every set of criteria that the studies declare fails them.

Each level is solved once by a right solver, whose solution is then changed. For criteria on a limit of a scheme, which its own solution
meets, the right solver is one that converges on the same case.
"""

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mpmverify import studies
from mpmverify.adapters.bisection import Bisection
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria.criterion import Criterion, OnLimits
from mpmverify.criteria.evidence import SeriesId, evidence_of
from mpmverify.exact import ExactSolution
from mpmverify.execution.evaluation import Task, level_of, measure
from mpmverify.execution.verify import verify
from mpmverify.judgement.judging import judge
from mpmverify.problem import Discretisation, Problem, output_steps
from mpmverify.solution import Solution, Solver, Work
from mpmverify.study import Case, Series

LEVELS = 4
"""Levels of a ladder in h that are solved, the coarsest ones of the quick tier; other ladders and designs are solved whole.

The finest ones are solved for what passes on the coarsest, where the error of a right solver may be as large.
"""
FACTORS = {
    "displacement times 1000": ("displacement", 1000.0),
    "velocity of the other sign": ("velocity", -1.0),
    "stress times 2": ("stress", 2.0),
}
STARTED, RATE = "histories as they start", 1.01


def still(s: Solution, exact: ExactSolution) -> Solution:
    """A body, or a profile, that never moves."""
    fields = {name: values * 0 if name != "u" else values[:1] + 0 * values for name, values in s.fields.items()}
    histories = {name: values if name in ("time", "mass") else 0 * values for name, values in s.histories.items()}
    return replace(s, position=s.reference + 0 * s.position, fields=fields, histories=histories)


def nothing(s: Solution, exact: ExactSolution) -> Solution:
    """Zero everywhere, with histories that are right."""
    return replace(s, position=s.reference + 0 * s.position, fields={name: 0 * values for name, values in s.fields.items()})


def constant(s: Solution, exact: ExactSolution) -> Solution:
    """Constant in time."""
    fields = {name: values[:1] + 0 * values for name, values in s.fields.items()}
    histories = {name: values if name == "time" else values[:1] + 0 * values for name, values in s.histories.items()}
    return replace(s, position=s.position[:1] + 0 * s.position, fields=fields, histories=histories)


def fast(s: Solution, exact: ExactSolution) -> Solution:
    """Right but for time, which runs 1 % too fast."""
    fields = dict(s.fields)
    for name in fields.keys() & exact.fields.keys():
        fields[name] = fields[name] + exact.fields[name](s.reference, RATE * s.time) - exact.fields[name](s.reference, s.time)
    return replace(s, fields=fields)


def scaled(quantity: str, factor: float, s: Solution, exact: ExactSolution) -> Solution | None:
    if quantity in s.fields and quantity in exact.fields and not np.any(exact.fields[quantity](s.reference, s.time)):
        return None  # a factor of nothing is no fault
    return replace(s, fields=dict(s.fields) | {quantity: factor * s.fields[quantity]}) if quantity in s.fields else None


Change = Callable[[Solution, ExactSolution], Solution | None]
CHANGES: dict[str, Change] = {
    "never moves": still,
    "zero everywhere": nothing,
    "constant in time": constant,
    "time times 1.01": fast,
}
CHANGES |= {name: functools.partial(scaled, *factor) for name, factor in FACTORS.items()}


@dataclass(frozen=True)
class CriterionSet:
    """Criteria of a series, and the right solver that is judged by them."""

    study: str
    case: Case
    series: Series
    right: Solver

    def __str__(self) -> str:
        return f"{self.study}-{self.case.name}-{self.series.solver.name}-{self.series.refinement.label}"

    @property
    def ladders(self) -> tuple[tuple[Discretisation, ...], ...]:
        levels = self.series.refinement.tier("quick")
        in_h = len({level.h for level in levels}) == len(levels)
        return (levels[:LEVELS], levels[-LEVELS:]) if in_h and len(levels) > LEVELS else (levels,)

    def solved(self, levels: tuple[Discretisation, ...]) -> tuple[tuple[Task, Solution], ...]:
        tasks = [
            Task(Path(), self.study, k, self.case.name, "", self.case.problem, self.right, level, self.series.criteria, str(k))
            for k, level in enumerate(levels)
        ]
        return tuple((task, self.right.solve(self.case.problem.problem, task.discretisation)) for task in tasks)

    def verdicts(self, solutions: tuple[tuple[Task, Solution], ...]) -> list[str]:
        series = SeriesId(self.case.name, self.right.name, "")
        evidence = evidence_of([level_of(task, measure(task, solution)) for task, solution in solutions])
        return [
            f"{f.verdict} {f.criterion}: {f.reason}"
            for f in judge(self.study, {series: self.series.criteria}, {series: evidence}).findings
        ]


def limited(criteria: tuple[Criterion, ...]) -> bool:
    return any(getattr(criterion, "marker", "") == OnLimits.marker for criterion in criteria)


def criterion_sets() -> Iterator[CriterionSet]:
    """Every different set of criteria of each case that judges fields; the first series that declares it stands for it."""
    for name in studies.NAMES:
        for case in studies.get(name).in_tier("quick").cases:
            right = [series.solver for series in case.series if not limited(series.criteria)]
            different: dict[Any, Series] = {}
            for series in case.series:
                different.setdefault((series.criteria, series.refinement.axis), series)
            for series in different.values() if right else ():
                yield CriterionSet(name, case, series, right[0] if limited(series.criteria) else series.solver)


def same(changed: Solution, right: Solution) -> bool:
    """Whether a change is none, as of a body at rest that is constant in time."""
    return all(np.allclose(changed.fields[name], values, rtol=1e-9, atol=1e-13) for name, values in right.fields.items())


@pytest.mark.parametrize("declared", list(criterion_sets()), ids=str)
def test_every_set_of_criteria_fails_useless_solvers_and_those_that_are_wrong_by_a_factor(declared: CriterionSet) -> None:
    passed: dict[str, list[str]] = {name: [] for name in CHANGES}
    for levels in declared.ladders:
        solutions = declared.solved(levels) if passed else ()
        found = {}
        for name in passed:
            changed = tuple((task, CHANGES[name](solution, declared.case.problem.exact)) for task, solution in solutions)
            if all(
                solution is not None and not same(solution, s) for (_, solution), (_, s) in zip(changed, solutions, strict=True)
            ):
                found[name] = declared.verdicts(changed)
        passed = {name: verdicts for name, verdicts in found.items() if not any(v.startswith(Verdict.FAIL) for v in verdicts)}
    assert not passed


@dataclass(frozen=True)
class Still:
    """Solver of a bar that never moves."""

    name = "still"
    orders = {"displacement": 2.0}  # noqa: RUF012 - as plain as its author would write it
    conserves = frozenset({"momentum"})

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        (cells,), (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
        X = problem.lower[0] + discretisation.h * (np.arange(cells)[:, None] + 0.5)
        time, shown = dt * np.arange(steps + 1), output_steps(steps, problem.outputs)
        zero = np.zeros((len(shown), cells, 1))
        fields = {"displacement": zero, "velocity": zero, "stress": zero}
        zeros = dict.fromkeys(("momentum", "impulse", "kinetic_energy", "strain_energy", "external_work"), 0 * time)
        weight = np.full((len(shown), cells), discretisation.h)
        return Solution(time[shown], dt, X, X + zero, weight, fields, zeros | {"time": time}, Work(steps, steps * cells))


@pytest.mark.parametrize(("study", "case"), [("dispersion", "beyond-the-limit"), ("mpm-stability", "linear")])
def test_a_body_that_never_moves_is_not_unstable_and_has_no_limit_of_stability(study: str, case: str) -> None:
    declared = studies.get(study)
    series = next(c for c in declared.cases if c.name == case).series[0]
    solver = Bisection(Still()) if isinstance(series.solver, Bisection) else Still()
    found = verify(solver, declared, case, refinement=series.refinement, criteria=series.criteria)
    assert {finding.verdict for finding in found} == {Verdict.FAIL}, found
