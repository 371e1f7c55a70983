"""The generalised vortex: shear and rotation of arbitrary size at constant volume."""

from mpmverify.criteria import Order, Stall
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.vortex import generalised_vortex
from mpmverify.problem import Discretisation
from mpmverify.solvers.mpm import APIC, MaterialPoint
from mpmverify.study import Case, Refinement, Series, Study, ladder_label

from . import variants as v

PPC = 2
LARGE_SHEAR_COURANT = 0.2
"""Courant number by the wave speed of the undeformed body; at a shear of 6 the fastest wave is six times as fast in material
coordinates."""


def _series(solver: MaterialPoint, expected: Criterion, cells: tuple[int, ...], quick: int, courant: float = 0.3) -> Series:
    levels = tuple(Discretisation(3.0 / count, courant, PPC) for count in cells)
    return Series(solver, Refinement(ladder_label(courant, PPC), levels, quick), (expected, v.MOMENTUM, v.MASS))


def _order(source: str) -> Order:
    return Order("displacement", "L2-max", 1.8, 2.2, source)


def _stall(source: str) -> Stall:
    return Stall("displacement", "L2-max", 0.5, source)


STUDY = Study(
    name="generalised-vortex",
    title="Generalised vortex",
    summary="A body force rotates each circle of a ring by an angle that depends on its radius, at constant volume; at an angle of 1 rad "
    "the shear is 6. There the total Lagrangian formulation converges at second order with quadratic B-splines. In the updated "
    "Lagrangian formulation neighbouring particles would separate by more than a cell, so it is judged at 0.05 rad: it converges at "
    "second order with quadratic B-splines, and does not converge with linear functions.",
    cases=(
        Case(
            "1 rad",
            generalised_vortex(1.0, outputs=64),
            (
                _series(
                    MaterialPoint("MUSL", APIC, "quadratic", "total"),
                    _order(v.AFFINE_SOURCE),
                    (64, 80, 96, 128),
                    3,
                    courant=LARGE_SHEAR_COURANT,
                ),
            ),
            shown="displacement",
        ),
        Case(
            "0.05 rad",
            generalised_vortex(0.05, outputs=64),
            (
                _series(MaterialPoint(formulation="total"), _order(v.MPM_SOURCE), (24, 32, 40, 48, 64, 96, 128), 5),
                _series(MaterialPoint(), _stall(v.CROSSING_SOURCE), (32, 48, 64, 80, 96, 128), 4),
                _series(MaterialPoint("MUSL", APIC, "quadratic"), _order(v.AFFINE_SOURCE), (40, 48, 64, 96, 128), 4),
            ),
            shown="displacement",
        ),
    ),
)
