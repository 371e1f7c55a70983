"""Loads and supports: tractions on parts of faces, against the momentum that they give, and clamped faces."""

from mpmverify.criteria import ExactTotal, Order, Size
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.clamped_shear import clamped_shear
from mpmverify.exact.pushed_block import pushed_block
from mpmverify.exact.regularity import expected_order
from mpmverify.problem import Discretisation
from mpmverify.solvers.mpm import APIC, MaterialPoint
from mpmverify.study import Case, Refinement, Series, Study, ladder_label

from . import variants as v

BOX, LAYER = 1.5, 1.0
"""Sides of the boxes that the cells divide [m]."""
MARGIN = 0.15
"""Accepted difference from the order at a front."""
LOAD_SOURCE = "Newton's second law: the momentum of a free body is the traction times the loaded area, integrated over time"
FRONT_SOURCE = (
    "a scheme of second order on data with s derivatives in L1 has the order (s - 1/2) 2/3 in L2: Brenner, Thomee and Wahlbin (1975), "
    "doi:10.1007/BFb0068125; at the front of a ramp s = 2 for velocity and stress, and 3 for the displacement"
)
ROWS_SOURCE = f"rows of particles along the faces stay uniform, so that passing cells along them adds no error; {v.MPM_SOURCE}"


def _series(
    solver: MaterialPoint, side: float, cells: tuple[int, ...], quick: int, courant: float, ppc: int, *criteria: Criterion
) -> Series:
    levels = tuple(Discretisation(side / count, courant, ppc) for count in cells)
    return Series(solver, Refinement(ladder_label(courant, ppc), levels, quick), (*criteria, v.MOMENTUM, v.MASS))


def _at_front(quantity: str, margin: float = MARGIN) -> Order:
    order = expected_order(2.0, 3.0 if quantity == "displacement" else 2.0, "L2")
    return Order(quantity, "L2", round(order - margin, 3), round(order + margin, 3), FRONT_SOURCE)


MOMENTUM = ExactTotal("momentum", LOAD_SOURCE)
PLANE = (24, 36, 48, 72, 96, 144)
FRONTS = _at_front("displacement"), _at_front("velocity")
COARSE_FRONTS = _at_front("displacement", 0.2), _at_front("velocity", 0.2)
"""In space, where levels are so coarse that orders scatter more."""
SECOND = tuple(Order(quantity, "L2-max", 1.8, 2.2, ROWS_SOURCE) for quantity in ("displacement", "velocity"))
STARTED = SECOND[0], *(Order(quantity, "L2-max", 1.35, 2.15, v.START_SOURCE) for quantity in ("velocity", "stress"))
STRESS = Order("stress", "L2-max", 0.9, 1.2, v.STRESS_SOURCE)
DOMAINS_SOURCE = (
    "own measurement: the domain of a particle at the surface reaches a node outside the body, or does not by round-off, and that node has "
    "so little mass that the stress there is off by O(1) in either case, in a layer of O(h); random places of the particles change the "
    "errors by a third"
)
DOMAINS = tuple(
    Size(quantity, "L2-max", low, high, DOMAINS_SOURCE, BOX / 96)
    for quantity, low, high in (("displacement", 0.0025, 0.0055), ("velocity", 0.006, 0.0115), ("stress", 0.1, 0.17))
)
SIZE_SOURCE = "own measurement, to a tenth, on levels too coarse for the order at the front"
SIZE = Size("stress", "L2", 0.0135, 0.0167, SIZE_SOURCE, BOX / 48)
CLAMPED_STRESS = Size("stress", "L2-max", 0.0045, 0.0056, SIZE_SOURCE, LAYER / 32)
SPEED = Size("velocity", "L2", 0.0081, 0.01, SIZE_SOURCE, BOX / PLANE[4])


STUDY = Study(
    name="loads-and-supports",
    title="Loads on parts of faces, and clamped faces",
    summary="A free block gets a growing load on one side across each axis, which is a part of a face of its box: its momentum is that of "
    "the loads to round-off after every step, and a plane wave runs from each side. So it is with a block whose other ends are joined, and "
    "with two blocks on one face. A layer swings freely between two clamped faces, "
    "with so large a shear that its particles pass the joined ends along them; a face that holds the normal component alone would "
    "let it slip.",
    cases=(
        Case(
            "block, plane",
            pushed_block(2),
            (
                _series(MaterialPoint("USL"), BOX, PLANE, 5, 0.4, 2, MOMENTUM, *FRONTS, _at_front("stress")),
                _series(
                    MaterialPoint("MUSL", formulation="total"),
                    BOX,
                    PLANE,
                    5,
                    0.4,
                    2,
                    MOMENTUM,
                    FRONTS[0],
                    SPEED,
                    _at_front("stress"),
                ),
                _series(MaterialPoint("USL", APIC, "quadratic"), BOX, PLANE, 5, 0.4, 2, MOMENTUM, *FRONTS, _at_front("stress")),
                _series(MaterialPoint("USL", basis="ugimp"), BOX, PLANE, 5, 0.4, 2, MOMENTUM, *DOMAINS),
            ),
            shown="displacement",
        ),
        *(
            Case(
                f"block, {arrangement}",
                pushed_block(2, arrangement),
                (_series(MaterialPoint("USL"), BOX, PLANE, 5, 0.4, 2, MOMENTUM, *FRONTS, _at_front("stress")),),
                shown="displacement",
            )
            for arrangement in ("joined", "pair")
        ),
        Case(
            "block, space",
            pushed_block(3),
            (
                _series(
                    MaterialPoint("USL", formulation="total"),
                    BOX,
                    (12, 18, 24, 36, 48, 72),
                    5,
                    0.6,
                    1,
                    MOMENTUM,
                    *COARSE_FRONTS,
                    SIZE,
                ),
            ),
            shown="displacement",
            # So few cells that orders are not yet those of fine levels.
            margin=0.4,
        ),
        Case(
            "layer, plane",
            clamped_shear(2),
            (
                # From 56 cells on there are so many particles that several threads share them.
                _series(MaterialPoint("USL"), LAYER, (14, 20, 28, 40, 56, 80), 5, 0.5, 4, *SECOND, STRESS),
            ),
            shown="displacement",
        ),
        Case(
            "layer, splines",
            # So many outputs that one of them shows the largest error of the start.
            clamped_shear(2, outputs=40),
            (
                _series(
                    MaterialPoint("MUSL", APIC, "quadratic"),
                    LAYER,
                    (8, 12, 16, 24, 32, 48),
                    5,
                    0.3,
                    2,
                    *STARTED,
                    CLAMPED_STRESS,
                ),
            ),
            shown="displacement",
            margin=0.5,  # by the start, see START_SOURCE
        ),
        Case(
            "layer, space",
            clamped_shear(3),
            (_series(MaterialPoint("USL"), LAYER, (6, 8, 12, 16, 24), 4, 0.4, 2, *SECOND, STRESS),),
            shown="displacement",
        ),
    ),
)
