"""The solvers that the README and the handbook show: they pass, with a fault they do not, and the picture says so."""

import own_solver_picture as picture
import pytest
from handbook import FOLDER, file, text

from mpmverify import studies
from mpmverify.execution.verify import verify
from mpmverify.problem import Discretisation

LEAPFROG = file("test_leapfrog.py")
COARSE = tuple(Discretisation(3.0 / cells, 0.2, 2) for cells in (32, 40, 48))


@pytest.mark.parametrize("column", picture.COLUMNS, ids=lambda column: column[0])
def test_the_picture_and_the_page_say_the_verdict_that_the_solver_gets(column):
    title, right, wrong = column
    verdict, reason = picture.judged(picture.solver(right, wrong))
    caption = picture.caption(verdict, reason)
    assert f"{title}: {caption}" in picture.PICTURE.read_text(encoding="utf-8")
    if wrong:
        (row,) = (line for line in text(FOLDER / "own-solver.md").splitlines() if f"`{wrong}`" in line)
        assert f"| {caption.partition(' [')[0].replace('  ', ', ')}" in row


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("right", "wrong"), [("(F - F_T)", "(F - F_T.swapaxes(1, 2))"), ("P[:, :, 1]", "P[:, 1]"), ("axis=2", "axis=1")]
)
def test_a_stress_or_gradient_with_its_indices_exchanged_is_an_error(right, wrong):
    assert picture.judged(picture.solver(right, wrong), COARSE)[0] == "ERROR"


def test_the_vortex_does_not_see_a_wrong_lame_constant():
    """As the page says: otherwise it would have to name another fault."""
    wrong = picture.solver("law.lame_lambda * np.log(J)", "law.youngs_modulus * np.log(J)")
    levels = tuple(Discretisation(3.0 / cells, 0.2, 2) for cells in (48, 64, 80))
    assert picture.judged(wrong, levels)[0] == "PASS"


def test_own_solvers_are_short():
    assert len([line for line in file("test_own_mpm.py").splitlines() if line]) <= 45
    assert len(LEAPFROG.splitlines()) <= 40


@pytest.mark.parametrize(
    ("right", "wrong", "verdict"),
    [
        ("bend / 2", "bend / 2", "PASS"),
        ("dt / discretisation.h) ** 2", "dt / discretisation.h) ** 2 * 1.01", "FAIL"),
        ("bend if n", "bend / 2 if n", "FAIL"),
        ("gained = dt", "gained = 0.99 * dt", "FAIL"),
        ('"displacement": 2}', '"displacement": 3}', "FAIL"),
        ("reference=x,", "reference=x * np.nan,", "ERROR"),
    ],
)
def test_a_fault_in_the_leapfrog_does_not_pass(right, wrong, verdict):
    assert LEAPFROG.count(right) == 1
    names: dict = {}
    exec(LEAPFROG.replace(right, wrong), names)
    found: list = []
    names["test_leapfrog"](lambda solver, study, case: found.extend(verify(solver, studies.get(study), case)))
    assert [finding.verdict for finding in found] == [verdict]
