"""A ring that expands and contracts: free surfaces that cut cells, and gaps that open between particles."""

from mpmverify.criteria import Size
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.ring import expanding_ring
from mpmverify.problem import Discretisation
from mpmverify.solvers.mpm import APIC, MaterialPoint
from mpmverify.study import Case, Refinement, Series, Study, ladder_label

from . import variants as v

COURANT, PPC = 0.3, 2
CELLS, FINE = (16, 32, 48, 64, 96, 128), (32, 48, 64, 96, 128)
"""Cells on a side of the box; the ring is 1.6 cells thick on the coarsest level."""


def _ladder(cells: tuple[int, ...], quick: int) -> Refinement:
    levels = tuple(Discretisation(2.0 / count, COURANT, PPC) for count in cells)
    return Refinement(ladder_label(COURANT, PPC), levels, quick)


def _series(solver: MaterialPoint, expected: tuple[Criterion, ...], cells: tuple[int, ...], quick: int) -> Series:
    return Series(solver, _ladder(cells, quick), (*expected, v.MOMENTUM, v.MASS))


SURFACE_SOURCE = (
    "own measurement: the strain of particles in cells that a free surface cuts has an error that does not fall, in a layer of a cell, and "
    "from 64 cells on the stress falls at the order 1/2 or less; as yet at second order on 16 to 48 cells"
)
HAT_SOURCE = f"between 3/2 and 2, since the centre of the lumped mass of a cut cell is O(h) from its node; {v.MPM_SOURCE}"
LINEAR = (
    *v.orders("L2-max", 1.8, 2.2, v.MPM_SOURCE, "displacement"),
    *v.orders("L2-max", 1.4, 2.2, HAT_SOURCE, "velocity"),
    *v.orders("L2-max", 0.9, 1.25, f"approached from above; {v.STRESS_SOURCE}", "stress"),
)
QUADRATIC: tuple[Criterion, ...] = (
    *v.orders("L2-max", 1.8, 2.2, v.AFFINE_SOURCE, "displacement", "velocity"),
    Size("stress", "L2-max", 0.003, 0.1, SURFACE_SOURCE),
)
CROSSING = v.stalls(v.CROSSING_SOURCE, displacement=(0.22, 0.97), velocity=(0.19, 0.65), stress=(0.35, 0.95))
SATURATION = v.stalls(v.SATURATION_SOURCE, displacement=(0.0045, 0.013), velocity=(0.008, 0.019), stress=(0.03, 0.07))


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
                _series(MaterialPoint(formulation="total"), LINEAR, CELLS, 4),
                _series(MaterialPoint("MUSL", APIC, "quadratic", "total"), QUADRATIC, CELLS, 4),
                _series(MaterialPoint(), CROSSING, CELLS, 4),
                _series(MaterialPoint("MUSL", APIC, "quadratic"), SATURATION, FINE, 4),
            ),
            shown="displacement",
            ladder=_ladder((16, 24, 32, 40, 48, 64), 6),
            margin=0.3,
        ),
    ),
)
