"""The driven bar: a moved end, a loaded end, a body force, and no parameter value for which a term vanishes."""

from mpmverify.criteria import EnergyDrift, Order
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.driven_bar import driven_bar
from mpmverify.exact.open_bar import open_bar
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Series, Study, halving

from . import variants as v

LENGTH = 1.6
STRANGERS = halving(LENGTH, 16, quick=5, full=6, courant=0.25, ppc=2)
TG_SOURCE = "second order on smooth data: Donea (1984), doi:10.1002/nme.1620200108"
SOLVERS: tuple[Solver, ...] = (*v.TAYLOR_GALERKIN, *v.MPM_FLIP, *v.FEM_P1, *v.FEM_P2)

ACCELERATED: tuple[Solver, ...] = (
    v.TAYLOR_GALERKIN[0],
    *(solver for solver in v.MPM_FLIP if solver.basis == "linear"),
    v.FEM_P1[0],
    v.FEM_P1[2],
)
"""Solvers whose first time step differs from the following ones, so that an initial acceleration tests it."""


def _criteria(solver: Solver) -> tuple[Criterion, ...]:
    if isinstance(solver, TaylorGalerkin):
        return (
            Order("stress", "L2-max", 1.85, 2.15, TG_SOURCE),
            Order("velocity", "L2-max", 1.85, 2.15, TG_SOURCE),
            EnergyDrift(1.8, TG_SOURCE),
        )
    if isinstance(solver, FiniteElement):
        p = solver.degree
        return (
            *v.orders("L2-max", p + 0.85, p + 1.15, v.FEM_SOURCE, "displacement", "velocity"),
            Order("stress", "L2-max", p - 0.1, p + 0.15, v.FEM_SOURCE),
            EnergyDrift(
                1.8, "Newmark's family keeps the energy less the work of loads and ends up to O(dt^2): Hughes (1987), chapter 9"
            ),
        )
    assert isinstance(solver, MaterialPoint)
    low, high = (0.9, 1.1) if solver.basis == "linear" else (1.4, 2.15)
    return (
        Order("displacement", "L2-max", 1.85, 2.15, v.MPM_SOURCE),
        Order("velocity", "L2-max", 1.4, 2.15, v.END_SOURCE if solver.basis == "linear" else v.SPLINE_SOURCE),
        Order("stress", "L2-max", low, high, v.STRESS_SOURCE if solver.basis == "linear" else v.SPLINE_SOURCE),
        v.drift(solver),
    )


STUDY = Study(
    name="driven-bar",
    title="Driven bar",
    summary="A linear elastic bar with a Poisson's ratio, away from the origin, moved at one end and loaded at the other, under "
    "a body force that makes a standing wave exact: no term of a scheme vanishes or cancels. Then the same bar with an acceleration "
    "at the start, and one with an end that lets waves out.",
    cases=(
        *(
            Case(
                name,
                driven_bar(loaded),
                tuple(Series(s, v.ladder(s, LENGTH), (*_criteria(s), v.MOMENTUM, v.MASS, v.sums(s))) for s in SOLVERS),
                shown="displacement",
                ladder=STRANGERS,
            )
            for name, loaded in (("loaded-right", "x+"), ("loaded-left", "x-"))
        ),
        Case(
            "accelerated",
            driven_bar(start=0.6),
            tuple(Series(s, v.ladder(s, LENGTH), (*_criteria(s), v.MOMENTUM, v.MASS, v.sums(s))) for s in ACCELERATED),
            shown="displacement",
            ladder=STRANGERS,
        ),
        Case(
            "open-left",
            open_bar(),
            tuple(
                Series(s, halving(LENGTH, 48, quick=5, full=6, courant=0.5), (*_criteria(s), v.MOMENTUM, v.MASS, v.sums(s)))
                for s in v.TAYLOR_GALERKIN
            ),
            shown="stress",
        ),
    ),
)
