"""What `verify` says by its defaults of solvers of any origin on the shipped problems: the right ones pass, and a body at rest fails."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from mpmverify import studies
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Order, Stall
from mpmverify.exact import VerificationProblem
from mpmverify.execution.verify import verify
from mpmverify.problem import Discretisation, Problem
from mpmverify.solution import Solution, Solver
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.study import Study

TOTAL = MaterialPoint("MUSL", formulation="total")
CASES = (("expanding-ring", "ring"), ("generalised-vortex", "0.05 rad"), ("large-deformation", "square"))


@dataclass(frozen=True)
class Changed:
    """A right solver in several dimensions whose solution is changed."""

    name: str = "changed"
    orders: ClassVar[Mapping[str, float]] = {"displacement": 2}
    conserves: frozenset[str] = frozenset()

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        return self.change(TOTAL.solve(problem, discretisation))

    def change(self, s: Solution) -> Solution:
        raise NotImplementedError


@dataclass(frozen=True)
class WithoutEnergy(Changed):
    """A right solver that returns no kinetic energy, which nobody asks for: its momentum balances."""

    conserves: frozenset[str] = frozenset({"mass", "momentum"})

    def change(self, s: Solution) -> Solution:
        return replace(s, histories={name: values for name, values in s.histories.items() if name != "kinetic_energy"})


@dataclass(frozen=True)
class WithoutVelocity(WithoutEnergy):
    """One that returns the displacement alone: the size of its momenta is taken from the positions."""

    def change(self, s: Solution) -> Solution:
        return replace(super().change(s), fields={"displacement": s.fields["displacement"]})


@dataclass(frozen=True)
class NeverMoves(Changed):
    """A body that stands still."""

    def change(self, s: Solution) -> Solution:
        return replace(s, position=0 * s.position + s.reference, fields={"displacement": 0 * s.fields["displacement"]})


def verdicts(solver: Solver, study: Study, case: str, **choices: Any) -> set[Verdict]:
    return {finding.verdict for finding in verify(solver, study, case, **choices)}


@pytest.mark.parametrize(("study", "case"), CASES)
def test_right_solvers_pass_whatever_else_they_return_and_a_body_at_rest_fails(study: str, case: str) -> None:
    declared = studies.get(study)
    assert verdicts(WithoutEnergy(), declared, case) == {Verdict.PASS}
    assert verdicts(NeverMoves(), declared, case) == {Verdict.FAIL}
    small = next(c for c in declared.cases if c.name == case).series[0].refinement
    coarse = replace(small, levels=small.levels[:1], quick=1)
    balances = [
        finding for finding in verify(WithoutVelocity(), declared, case, refinement=coarse) if "conserved" in finding.criterion
    ]
    assert [finding.verdict for finding in balances] == [Verdict.PASS] * 2


@pytest.mark.parametrize(("study", "case"), CASES)
def test_a_body_at_rest_fails_by_every_stall(study: str, case: str) -> None:
    chosen = next(c for c in studies.get(study).cases if c.name == case)
    stalled = [
        (s.refinement, c) for s in chosen.series for c in s.criteria if isinstance(c, Stall) and c.quantity == "displacement"
    ]
    assert stalled
    for refinement, criterion in stalled:
        (found,) = verify(NeverMoves(), studies.get(study), case, refinement=refinement, criteria=[criterion])
        assert found.verdict is Verdict.FAIL
        assert found.reason.endswith("at errors of 1 and 1, which are not of the size that is known of the scheme")


def sizes(problem: VerificationProblem) -> Iterator[tuple[str, float]]:
    """Size of every exact field at the final time, relative to that over the run."""
    stated = problem.problem
    count = 400 if stated.dimension == 1 else 12
    X = np.array(stated.lower) + (np.argwhere(np.ones((count,) * stated.dimension)) + 0.5) / count * np.array(stated.lengths)
    for quantity, field in problem.exact.fields.items():
        size = np.sqrt(np.sum(field(X, np.linspace(0, stated.end_time, 65)) ** 2, axis=(1, 2)))
        yield quantity, size[-1] / size.max()


@pytest.mark.parametrize("name", studies.NAMES)
def test_no_case_is_judged_at_a_time_at_which_its_field_vanishes(name: str) -> None:
    for case in studies.get(name).cases:
        if case.norm != "L2-max" and any(isinstance(c, Order) for series in case.series for c in series.criteria):
            assert all(share > 0.1 for _, share in sizes(case.problem)), case.name
