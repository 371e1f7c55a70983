"""A ring that expands and contracts: free surfaces that cut cells, and gaps that open between particles."""

from mpmverify.criteria import Order, Stall
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.ring import expanding_ring
from mpmverify.problem import Discretisation
from mpmverify.solvers.mpm import APIC, MaterialPoint
from mpmverify.study import Case, Refinement, Series, Study, ladder_label

from . import variants as v

COURANT, PPC = 0.3, 2
CELLS, FINE = (16, 32, 48, 64, 96, 128), (32, 48, 64, 96, 128)
"""Cells on a side of the box; the ring is 1.6 cells thick on the coarsest level."""


def _series(solver: MaterialPoint, expected: Criterion, cells: tuple[int, ...], quick: int) -> Series:
    levels = tuple(Discretisation(2.0 / count, COURANT, PPC) for count in cells)
    return Series(solver, Refinement(ladder_label(COURANT, PPC), levels, quick), (expected, v.MOMENTUM, v.MASS))


def _order(source: str) -> Order:
    return Order("displacement", "L2-max", 1.8, 2.2, source)


def _stall(source: str) -> Stall:
    return Stall("displacement", "L2-max", 0.5, source)


STUDY = Study(
    name="expanding-ring",
    title="Expanding ring with free surfaces",
    summary="A body force makes a ring oscillate radially by several cells. Its free surfaces cut the cells at arbitrary positions; each "
    "particle has the exact area of its part of the ring. The total Lagrangian formulation converges at second order. The updated "
    "Lagrangian formulation does not converge with linear functions; with quadratic B-splines it converges until their quadrature "
    "error dominates.",
    cases=(
        Case(
            "ring",
            expanding_ring(outputs=64),
            (
                _series(MaterialPoint(formulation="total"), _order(v.MPM_SOURCE), CELLS, 4),
                _series(MaterialPoint("MUSL", APIC, "quadratic", "total"), _order(v.AFFINE_SOURCE), CELLS, 4),
                _series(MaterialPoint(), _stall(v.CROSSING_SOURCE), CELLS, 4),
                _series(MaterialPoint("MUSL", APIC, "quadratic"), _stall(v.SATURATION_SOURCE), FINE, 4),
            ),
            shown="displacement",
        ),
    ),
)
