"""A study of one's own: `mpmverify run my_study.py`."""

from mpmverify.criteria import Order, Size
from mpmverify.exact.vortex import generalised_vortex
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.study import Case, Series, Study, halving

CRITERIA = (
    Order("displacement", "L2-max", 1.7, 2.3, "second order: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360"),
    Size("displacement", "L2-max", 0.0, 0.03, "measured with a right solver, 0.022, and a margin", h=3.0 / 96),  # h in m
)
LEVELS = halving(3.0, 24, quick=3, full=4, courant=0.2, ppc=2)  # box of 3 m; 24, 48, 96 cells, and 192 in the full tier
SOLVERS = (
    MaterialPoint("MUSL", basis="quadratic", formulation="total"),
    MaterialPoint("USL", basis="quadratic", formulation="total"),
)
PROBLEM = generalised_vortex(0.5)  # closed form, with its body force and its material; mpmverify.exact has more

STUDY = Study(
    name="my-study",
    title="Vortex of half a radian",
    summary="A ring whose circles turn by an angle that depends on the radius.",
    cases=(Case("0.5 rad", PROBLEM, tuple(Series(solver, LEVELS, CRITERIA) for solver in SOLVERS), shown="displacement"),),
)
