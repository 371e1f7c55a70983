"""Manufactured motions of large amplitude: Steffen's bar, and axis-aligned displacement of a square and a cube."""

from mpmverify.criteria import Order, Stall
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.steffen import steffen
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint, Transfer
from mpmverify.study import Case, Series, Study, halving

from . import variants as v

LINEAR = MaterialPoint("MUSL", formulation="total")
QUADRATIC = MaterialPoint("USF", FLIP, "quadratic", "total")
AFFINE = MaterialPoint("USL", APIC, "quadratic", "total")
UPDATED = MaterialPoint("USL")
DOMAIN_SOURCE = (
    "particles whose domains follow the deformation leave no gaps along the axes: second order at a fixed number of them per cell; "
    "Wallstedt and Guilkey (2008), doi:10.1016/j.jcp.2008.07.019 (cpGIMP); Sadeghirad, Brannon and Burghardt (2011), "
    "doi:10.1002/nme.3110 (CPDI)"
)
GAPS_SOURCE = (
    "undeformed particle domains separate and overlap as the bar deforms, an error that does not fall at a fixed number of particles "
    "per cell; Wallstedt and Guilkey (2008), doi:10.1016/j.jcp.2008.07.019"
)
CUBIC_SOURCE = (
    "the error of the quadrature falls with the smoothness of the spline, so that four particles per cell carry cubic B-splines "
    "through every level here: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360"
)
ENDS_SOURCE = (
    "own measurement: over two particles per cell the quadrature of the second function of a clamped cubic spline is off by 9 % of the "
    "stress at rest already, and once they move the end cells come apart; a property of the basis and the quadrature"
)
LEAST_SQUARES_SOURCE = (
    "first order, own derivation: the gradients of moving least squares over B-splines are exact for a linear field, off by O(h) of its "
    "curvature, and do not balance a constant stress in the end cells, a strain off by O(1) over O(h)"
)


def _order(low: float, high: float, source: str) -> Order:
    return Order("displacement", "L2-max", low, high, source)


def _stall(source: str) -> Stall:
    return Stall("displacement", "L2-max", 0.5, source)


def _series(solver: MaterialPoint, first: int, levels: int) -> Series:
    expected: Criterion = _order(1.8, 2.2, v.AFFINE_SOURCE if solver.transfer is APIC else v.MPM_SOURCE)
    if solver.formulation == "updated":
        expected = _stall(v.CROSSING_SOURCE)
    ladder = halving(1.0, first, quick=levels, full=levels + 1, courant=0.3, ppc=2)
    return Series(solver, ladder, (expected, v.MOMENTUM, v.MASS))


def _on(basis: str, expected: Criterion, first: int = 16, ppc: int = 2, transfer: Transfer = FLIP) -> Series:
    """Return a series of the updated Lagrangian formulation with a basis, on levels so fine that particles cross cells."""
    ladder = halving(1.0, first, quick=4, full=5, courant=0.3, ppc=ppc)
    return Series(MaterialPoint("USL", transfer, basis), ladder, (expected, v.MOMENTUM, v.MASS))


BASES = (
    _on("cpgimp", _order(1.8, 2.2, DOMAIN_SOURCE)),
    _on("cpdi", _order(1.8, 2.2, DOMAIN_SOURCE)),
    _on("ugimp", _stall(GAPS_SOURCE), first=32),
    _on("quadratic", _stall(v.SATURATION_SOURCE), first=32),
    _on("quadratic", _stall(v.SATURATION_SOURCE), first=32, transfer=APIC),
    _on("cubic", _stall(ENDS_SOURCE)),
    _on("cubic", _order(1.8, 2.2, CUBIC_SOURCE), ppc=4),
    _on("mls-quadratic", _order(0.9, 1.2, LEAST_SQUARES_SOURCE), first=32, ppc=4),
)


STUDY = Study(
    name="large-deformation",
    title="Large deformation in one, two and three dimensions",
    summary="Standing waves of finite amplitude, exact under a body force, in Steffen's bar and along each axis of a square and a cube. "
    "Particles cross cells. The total Lagrangian formulation converges at second order. The updated Lagrangian formulation stalls with "
    "linear functions, and on finer levels with quadratic B-splines and with undeformed particle domains (uGIMP). With deforming "
    "particle domains (cpGIMP, CPDI) it converges.",
    cases=(
        Case("bar", steffen(), tuple(_series(s, 8, 4) for s in (LINEAR, QUADRATIC, UPDATED)), shown="displacement"),
        Case("bases", steffen(), BASES, shown="displacement"),
        Case("square", axis_aligned(2), tuple(_series(s, 8, 4) for s in (LINEAR, AFFINE, UPDATED)), shown="displacement"),
        Case("cube", axis_aligned(3), (_series(LINEAR, 4, 3),), shown="displacement"),
    ),
)
