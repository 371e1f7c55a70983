"""scikit-fem on the bench: of the orders of theory, and momentum balances; a wrong modulus and a late start do not pass."""

import pytest
import scikit_fem_waves
from page_of_codes import agree
from scikit_fem_study import STUDY, expected, problem
from scikit_fem_waves import ScikitFem
from skfem.models.elasticity import linear_elasticity

from mpmverify.convergence.verdict import Verdict
from mpmverify.errors import UsageError
from mpmverify.execution.verify import verify as verified
from mpmverify.problem import Discretisation

SERIES = {f"{case.name}-{series.solver.name}": (case, series) for case, series in STUDY.series()}


@pytest.mark.parametrize("name", SERIES)
def test_every_order_is_that_of_theory_and_momentum_balances(name, verify):
    case, series = SERIES[name]
    findings = verify(series.solver, STUDY, case.name, refinement=series.refinement, criteria=series.criteria)
    agree(case.name, series.solver.name, findings)


def test_the_constant_of_plane_stress_in_place_of_that_of_plane_strain_fails(monkeypatch):
    case, series = SERIES["plane-waves, box-scikit-fem-P1-lumped"]
    plane_stress = lambda lam, mu: linear_elasticity(2 * lam * mu / (lam + 2 * mu), mu)  # noqa: E731 - one formula
    monkeypatch.setattr(scikit_fem_waves, "linear_elasticity", plane_stress)
    found = verified(series.solver, STUDY, case.name, refinement=series.refinement, criteria=expected(1)[:3])
    assert {finding.verdict for finding in found} == {Verdict.FAIL}


def test_what_it_declares_holds_on_the_ladder_of_a_shipped_case(verify):
    verify(ScikitFem("line"), study="axial-vibration", case="literature")


def test_another_problem_is_refused_in_a_sentence():
    with pytest.raises(UsageError, match="linear elastic boxes in 2D"):
        ScikitFem("P1").solve(problem("axial-vibration", "literature").problem, Discretisation(1.0, 0.5))
