"""Manufactured motions of large amplitude: Steffen's bar, and a square and a cube that move along their axes."""

from mpmverify.criteria import Order, Stall
from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.steffen import steffen
from mpmverify.gate import Criterion
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint
from mpmverify.study import Case, Series, Study, halving

from . import variants as v

LINEAR = MaterialPoint("MUSL", formulation="total")
QUADRATIC = MaterialPoint("USF", FLIP, "quadratic", "total")
AFFINE = MaterialPoint("USL", APIC, "quadratic", "total")
UPDATED = MaterialPoint("USL")


def _series(solver: MaterialPoint, first: int, levels: int) -> Series:
    source = v.AFFINE_SOURCE if solver.transfer is APIC else v.MPM_SOURCE
    expected: Criterion = Order("displacement", "L2-max", 1.8, 2.2, source)
    if solver.formulation == "updated":
        expected = Stall("displacement", "L2-max", 0.5, v.CROSSING_SOURCE)
    ladder = halving(1.0, first, quick=levels, full=levels + 1, courant=0.3, ppc=2)
    return Series(solver, ladder, (expected, v.MOMENTUM, v.MASS))


STUDY = Study(
    name="large-deformation",
    title="Large deformation in one, two and three dimensions",
    summary="Body forces make standing waves of finite amplitude exact, in Steffen's bar, and in a square and a cube whose points move "
    "along every axis in a phase of its own. Particles cross cells: the total Lagrangian formulation converges at second order, and "
    "the updated Lagrangian linear basis stalls.",
    cases=(
        Case("bar", steffen(), tuple(_series(s, 8, 4) for s in (LINEAR, QUADRATIC, UPDATED)), shown="displacement"),
        Case("square", axis_aligned(2), tuple(_series(s, 8, 4) for s in (LINEAR, AFFINE, UPDATED)), shown="displacement"),
        Case("cube", axis_aligned(3), (_series(LINEAR, 4, 3),), shown="displacement"),
    ),
)
