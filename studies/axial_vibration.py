"""Axial vibration of a fixed bar in its first mode, with all solvers."""

from mpmverify.criteria import EnergyConserved, EnergyDecays, EnergyDrift, Order
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.vibration import axial_vibration
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import PIC, MaterialPoint, fmpm, xpic
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Series, Study, halving

from . import variants as v

LENGTH = 25.0
STRANGERS = halving(LENGTH, 16, quick=5, full=6, courant=0.25, ppc=2)
TG_SOURCE = (
    "second order on smooth data: Mabssout and Pastor (2003), A Taylor-Galerkin algorithm for shock wave propagation and strain "
    "localization failure of viscoplastic continua, CMAME 192, 955-971"
)

CONTRACTION = (
    "|G| <= 1 for every mode, Donea (1984), doi:10.1002/nme.1620200108, also with the reflecting ends of a fixed bar: no step increases "
    "the energy"
)


def _converges(solver: Solver) -> tuple[Criterion, ...]:
    """Return the criteria on orders and energy of a solver that can converge to the exact solution."""
    if isinstance(solver, TaylorGalerkin):
        return (
            Order("stress", "L2-max", 1.85, 2.15, TG_SOURCE),
            Order("velocity", "L2-max", 1.85, 2.15, TG_SOURCE),
            EnergyDrift(1.8, f"|G|^2 = 1 - O(theta^4) a step, hence O(h^3) at a fixed time; {TG_SOURCE}"),
            EnergyDecays(CONTRACTION),
        )
    if isinstance(solver, FiniteElement):
        p = solver.degree
        return (
            *v.orders("L2-max", p + 0.85, p + 1.15, v.FEM_SOURCE, "displacement", "velocity"),
            Order("stress", "L2-max", p - 0.1, p + 0.15, v.FEM_SOURCE),
            EnergyConserved("the average acceleration rule conserves the energy of a linear system: Hughes (1987), chapter 9")
            if solver.integrator == "newmark"
            else EnergyDrift(1.8, "central differences conserve the energy up to O(dt^2): Hughes (1987), chapter 9"),
        )
    assert isinstance(solver, MaterialPoint)
    if solver.transfer == PIC:
        return (
            *v.orders("L2-max", 0.85, 1.1, v.PIC_SOURCE, "displacement", "velocity", "stress"),
            EnergyDrift(0.7, v.PIC_SOURCE),
        )
    if 0 < solver.transfer.flip < 1:
        return (
            *v.orders("L2-max", 0.9, 2.1, v.BLEND_SOURCE, "displacement", "velocity"),
            Order("stress", "L2-max", 0.9, 1.1, v.STRESS_SOURCE),
            EnergyDrift(0.7, v.PIC_SOURCE),
        )
    fields = (
        (
            Order("velocity", "L2-max", 1.85, 2.15, v.MPM_SOURCE),
            Order("stress", "L2-max", 0.9, 1.1, v.STRESS_SOURCE),
        )
        if solver.basis in ("linear", "tls-linear")
        else v.orders("L2-max", 1.4, 2.15, v.SPLINE_SOURCE, "velocity", "stress")
    )
    # What a series of two terms, or a fit, takes out is of third order in dt, which on these levels changes to second order and in sign.
    drift = (v.drift(solver),) if solver.transfer.terms == 1 and solver not in FITTED else ()
    return (Order("displacement", "L2-max", 1.85, 2.15, v.MPM_SOURCE), *fields, *drift)


def _literature(solver: Solver) -> tuple[Criterion, ...]:
    if isinstance(solver, MaterialPoint) and solver.formulation == "updated":
        return CROSSING if solver.basis == "linear" else GEOMETRIC
    return _converges(solver)


CROSSING = v.stalls(v.CROSSING_SOURCE, displacement=(0.08, 0.65), velocity=(0.08, 0.6), stress=(0.18, 0.75))
GEOMETRIC = v.stalls(v.GEOMETRIC_SOURCE, displacement=(0.0027, 0.006), velocity=(0.005, 0.0125), stress=(0.0055, 0.013))
LINEAR: tuple[Solver, ...] = (*v.TAYLOR_GALERKIN, *v.FEM_P1, *v.FEM_P2)
TOTAL: tuple[Solver, ...] = tuple(solver for solver in v.MPM if solver.formulation == "total")
FITTED: tuple[Solver, ...] = tuple(MaterialPoint("USL", basis=basis) for basis in ("tls-linear", "tls-quadratic"))
"""Fits in the cells add momentum, so that they do not promise to keep it."""
SERIES_OF_TWO = tuple(MaterialPoint("USL", transfer, formulation="total") for transfer in (xpic(2), fmpm(2)))
STALLED: tuple[Solver, ...] = (
    MaterialPoint("USL"),
    MaterialPoint("MUSL"),
    MaterialPoint("USL", basis="quadratic"),
    MaterialPoint("MUSL", basis="quadratic"),
)

STUDY = Study(
    name="axial-vibration",
    title="Axial vibration of a bar",
    summary="A bar fixed at both ends starts with the velocity of its first mode. At the amplitude of the literature particles "
    "cross cells, and an updated Lagrangian code leaves the linear solution; at a thousandth of it every solver must converge.",
    cases=(
        Case(
            "literature",
            axial_vibration(v0=0.1),
            tuple(
                Series(s, v.ladder(s, LENGTH), (*_literature(s), v.MOMENTUM, v.sums(s))) for s in (*LINEAR, *TOTAL, *STALLED)
            ),
            shown="displacement",
            ladder=STRANGERS,
        ),
        Case(
            "small-strain",
            axial_vibration(v0=1e-4),
            tuple(
                Series(s, v.ladder(s, LENGTH), (*_converges(s), v.MOMENTUM, v.MASS, v.sums(s)))
                for s in (*v.MPM, *SERIES_OF_TWO)
            )
            + tuple(Series(s, v.ladder(s, LENGTH), (*_converges(s), v.MASS, v.sums(s))) for s in FITTED),
            shown="displacement",
            ladder=STRANGERS,
        ),
    ),
)
