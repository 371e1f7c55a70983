"""Every shipped solver passes `verify` by its defaults on every case on which its study expects that it converges.

And `check` finds nothing wrong with it there.
"""

from collections.abc import Iterator
from typing import Any

import pytest

from mpmverify import studies
from mpmverify.adapters.check import check
from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Order, Separated
from mpmverify.execution.verify import verify
from mpmverify.solution import Solver


def converging() -> Iterator[Any]:
    """Every shipped solver on every case on which its study expects that it converges."""
    for name in studies.NAMES:
        for case in studies.get(name).in_tier("quick").cases:
            solvers = [s.solver for s in case.series if any(isinstance(c, Order | Separated) for c in s.criteria)]
            for solver in dict.fromkeys(solvers):
                yield pytest.param(name, case.name, solver, id=f"{name}-{case.name}-{solver.name}")


@pytest.mark.parametrize(("study", "case", "solver"), list(converging()))
def test_every_shipped_solver_passes_by_the_defaults_where_its_study_expects_that_it_converges(
    study: str, case: str, solver: Solver
) -> None:
    found = verify(solver, studies.get(study), case)
    assert {finding.verdict for finding in found} == {Verdict.PASS}, [str(finding) for finding in found]


@pytest.mark.parametrize(("study", "case", "solver"), list(converging()))
def test_nothing_is_found_in_a_shipped_solver(study: str, case: str, solver: Solver) -> None:
    (where,) = (one for one in studies.get(study).cases if one.name == case)
    assert check(solver, where) == []
