"""What must hold of finite elements in warp on the bench, in either precision: `mpmverify run tests/adapters/warp_study.py`."""

from warp_fem import WarpFem

from mpmverify import studies
from mpmverify.criteria import Balance, Order
from mpmverify.criteria.criterion import Criterion
from mpmverify.problem import Discretisation
from mpmverify.study import Case, Refinement, Series, Study

THEORY = (
    "orders 2 of displacement and 1 of stress in L2 for linear elements: Strang and Fix (1973), An Analysis of the Finite Element Method; "
    "central differences are of second order: Hughes (1987), The Finite Element Method, chapter 9"
)
BALANCE = "the forces of a triangle sum to zero, and reactions add their impulse"
SINGLE = 1e-6
"""Bound on the defect of the momentum in single precision, some roundings of 6e-8."""


def expected(solver: WarpFem) -> tuple[Criterion, ...]:
    return (
        Order("displacement", "L2-max", 1.85, 2.15, THEORY),
        Order("velocity", "L2-max", 1.85, 2.15, THEORY),
        Order("stress", "L2-max", 0.85, 1.15, THEORY),
        Balance("mass", "", BALANCE),
        Balance("momentum", "impulse", BALANCE, bound=SINGLE if solver.single else 1e-12),
    )


def case(study: str, name: str, *cells: int) -> Case:
    """Return a case of a shipped study with warp in both precisions."""
    (shipped,) = (one for one in studies.get(study).cases if one.name == name)
    levels = tuple(Discretisation(1 / n, 0.3) for n in cells)
    series = (Series(s, Refinement("nu_C=0.3", levels, len(levels)), expected(s)) for s in (WarpFem(), WarpFem(single=True)))
    return Case(f"{study}, {name}", shipped.problem, tuple(series), shown="displacement")


STUDY = Study(
    name="warp-fem",
    title="Finite elements in warp",
    summary="Small waves between rollers, and manufactured motions at strains of 16 % and 25 %, by linear triangles in single and in double "
    "precision. The unknown is the displacement, of which single precision keeps seven digits however small it is.",
    cases=(
        case("plane-waves", "box", 12, 16, 24, 32),
        case("plane-waves", "neo-hookean", 12, 16, 24, 32),
        case("large-deformation", "square", 16, 24, 32, 48),
    ),
)
