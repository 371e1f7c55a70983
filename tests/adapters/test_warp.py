"""Finite elements in warp on the bench: of the orders of theory in single and in double precision."""

import pytest

pytest.importorskip("warp", reason="warp is not installed: pip install 'mpmverify[adapters]'", exc_type=ImportError)

from page_of_codes import agree
from warp_fem import WarpFem
from warp_study import BALANCE, STUDY

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import Balance
from mpmverify.execution.verify import verify as verified

SERIES = {f"{case.name}-{series.solver.name}": (case, series) for case, series in STUDY.series()}


@pytest.mark.parametrize("name", SERIES)
def test_every_order_is_that_of_theory_and_momentum_balances_to_its_precision(name, verify):
    case, series = SERIES[name]
    findings = verify(series.solver, STUDY, case.name, refinement=series.refinement, criteria=series.criteria)
    agree(case.name, series.solver.name, findings)


def test_single_precision_does_not_keep_momentum_to_the_round_off_of_double_precision():
    case, series = SERIES["plane-waves, box-warp-fem-single"]
    promise = [Balance("momentum", "impulse", BALANCE)]
    (found,) = verified(WarpFem(single=True), STUDY, case.name, refinement=series.refinement, criteria=promise)
    assert found.verdict is Verdict.FAIL
    assert "bound 1e-12" in found.reason


def test_the_double_precision_code_holds_what_it_declares_on_the_ladder_of_the_case(verify):
    verify(WarpFem(), study="large-deformation", case="square")
