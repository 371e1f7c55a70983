"""What must hold of scikit-fem on the bench: `mpmverify run tests/adapters/scikit_fem_study.py`."""

from scikit_fem_waves import ScikitFem

from mpmverify import studies
from mpmverify.criteria import Balance, Order
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact import VerificationProblem
from mpmverify.problem import Discretisation
from mpmverify.study import Case, Refinement, Series, Study

THEORY = (
    "orders p + 1 of displacement and p of stress in L2 for elements of degree p: Strang and Fix (1973), An Analysis of the Finite Element "
    "Method; Newmark's rule with gamma = 1/2 is of second order: Hughes (1987), The Finite Element Method, chapter 9"
)
START = (
    "between p and p + 1, own derivation: the interpolant is O(h^p) from the elliptic projection in energy, and what lies between them swings "
    "freely with a velocity of that size"
)
BALANCE = "the forces of a partition of unity sum to zero, and reactions add their impulse"


def expected(p: int, velocity: Order | None = None) -> tuple[Criterion, ...]:
    return (
        Order("displacement", "L2-max", p + 0.85, p + 1.15, THEORY),
        velocity or Order("velocity", "L2-max", p + 0.85, p + 1.15, THEORY),
        Order("stress", "L2-max", p - 0.15, p + 0.15, THEORY),
        Balance("mass", "", BALANCE),
        Balance("momentum", "impulse", BALANCE),
    )


def problem(study: str, case: str) -> VerificationProblem:
    """Return the problem of a case of a shipped study."""
    (found,) = (one.problem for one in studies.get(study).cases if one.name == case)
    return found


def series(element: str, lumped: bool, length: float, *cells: int) -> Series:
    """Return a series of elements of degree one, with dt proportional to h."""
    levels = tuple(Discretisation(length / n, 0.3) for n in cells)
    return Series(ScikitFem(element, lumped), Refinement("nu_C=0.3", levels, len(levels)), expected(1))


def quadratic(*, projected: bool) -> Series:
    """Return a series of degree two, with dt proportional to h^(3/2) and small: the error in time must not hide that in space."""
    levels = tuple(Discretisation(1 / n, 0.1 * (8 / n) ** 0.5) for n in (8, 10, 12, 16, 20, 24))
    velocity = None if projected else Order("velocity", "L2-max", 1.85, 2.85, START)
    solver = ScikitFem("P2", lumped=False, projected=projected)
    return Series(solver, Refinement("nu_C=0.1, nu_C ~ h^0.5", levels, len(levels)), expected(2, velocity))


STUDY = Study(
    name="scikit-fem",
    title="scikit-fem as a code for elastic waves",
    summary="Standing waves in a bar, between slip walls and in a free square, by scikit-fem with lumped and consistent masses.",
    cases=(
        Case(
            "axial-vibration, literature",
            problem("axial-vibration", "literature"),
            tuple(series("line", lumped, 25.0, 16, 32, 64, 128) for lumped in (True, False)),
            shown="displacement",
        ),
        Case(
            "plane-waves, box",
            problem("plane-waves", "box"),
            (
                *(series(element, True, 1.0, 12, 16, 24, 32) for element in ("P1", "Q1")),
                quadratic(projected=False),
                quadratic(projected=True),
            ),
            shown="displacement",
        ),
        Case(
            "plane-waves, free",
            problem("plane-waves", "free"),
            (series("Q1", True, 1.5, 12, 16, 24, 32), series("P1", False, 1.5, 12, 16, 24, 32)),
            shown="displacement",
        ),
    ),
)
