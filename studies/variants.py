"""Solvers, ladders, criteria and sources that several studies share."""

from itertools import product

from mpmverify.criteria import Balance, EnergyDrift, FieldSums, Order, Stall
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import PIC, MaterialPoint, blend
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Refinement, halving

TAYLOR_GALERKIN = (TaylorGalerkin(passes=1), TaylorGalerkin(passes=3))

FEM_P1 = (
    FiniteElement(1, "lumped", "central-differences"),
    FiniteElement(1, "consistent", "central-differences"),
    FiniteElement(1, "consistent", "newmark"),
)
FEM_P2 = (
    FiniteElement(2, "lumped", "central-differences"),
    FiniteElement(2, "consistent", "central-differences"),
    FiniteElement(2, "consistent", "newmark"),
)
FEM_EXPLICIT = tuple(solver for solver in FEM_P1 + FEM_P2 if solver.integrator == "central-differences")

MPM_FLIP = tuple(
    MaterialPoint(schedule, basis=basis, formulation=formulation)
    for formulation, basis, schedule in product(("updated", "total"), ("linear", "quadratic"), ("USF", "USL", "MUSL"))
)
MPM_DAMPED = tuple(
    MaterialPoint(transfer=transfer, formulation=formulation)
    for formulation in ("updated", "total")
    for transfer in (blend(0.95), PIC)
)
MPM = MPM_FLIP + MPM_DAMPED


def ladder(solver: Solver, length: float) -> Refinement:
    """Return a ladder, for a bar of this length [m], in the asymptotic range of smooth fields.

    For quadratic elements, of third order in h, nu_C falls as h^(1/2), so that the second-order error in dt does not dominate.
    """
    if isinstance(solver, MaterialPoint):
        return halving(length, 16, quick=5, full=6, courant=0.4, ppc=2)
    if isinstance(solver, FiniteElement) and solver.degree == 2:
        return halving(length, 8, quick=5, full=6, courant=0.25, courant_power=0.5)
    return halving(length, 16, quick=5, full=6, courant=0.5)


MOMENTUM = Balance(
    "momentum",
    "impulse",
    "internal forces of a basis that is a partition of unity sum to zero; external forces add their impulse",
)
MASS = Balance("mass", "", "the mass of every particle, and the integral of the reference density, are constant")


def orders(norm: str, low: float, high: float, source: str, *quantities: str) -> tuple[Order, ...]:
    """Return the criterion of one band of orders on several quantities."""
    return tuple(Order(quantity, norm, low, high, source) for quantity in quantities)


def stalls(source: str, **sizes: tuple[float, float]) -> tuple[Stall, ...]:
    """Return the criteria on fields that stall, each with the accepted sizes of its error at the two finest levels."""
    return tuple(Stall(quantity, "L2-max", 0.5, low, high, f"{source}; {SIZES}") for quantity, (low, high) in sizes.items())


SIZES = "size of the error by own measurement, within a factor of about 1.5"
SUMS_SOURCE = "the quadrature of the scheme and the quadrature over the samples give the same values of these sums"


def sums(solver: Solver) -> FieldSums:
    """Return the criterion on the histories that the samples of a solver reproduce exactly; `FieldSums` gives the reasons."""
    if isinstance(solver, TaylorGalerkin):
        return FieldSums(("mass", "momentum"), SUMS_SOURCE)
    if isinstance(solver, FiniteElement) and solver.mass == "lumped":
        return FieldSums(("mass", "momentum", "strain_energy"), SUMS_SOURCE)
    return FieldSums(("mass", "momentum", "kinetic_energy", "strain_energy"), SUMS_SOURCE)


FEM_SOURCE = (
    "orders p + 1 of displacement and p of stress in L2 for elements of degree p: Strang and Fix (1973), An Analysis of the "
    "Finite Element Method, chapters 1 and 7"
)
MPM_SOURCE = (
    "second order of explicit MPM before particles cross cells: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360; "
    "Wallstedt and Guilkey (2008), doi:10.1016/j.jcp.2008.07.019"
)
AFFINE_SOURCE = (
    "second order in space and, where dt follows h, a damping of second order: the affine velocity keeps what PIC smooths at first "
    "order; Jiang, Schroeder and Teran (2017), doi:10.1016/j.jcp.2017.02.050"
)
START_SOURCE = (
    "between 3/2 and 2, own derivation: second order inside, but particles start without an affine velocity, which changes the nodal "
    "velocity by O(h) over a length of O(h) at a surface or a held end, and hence velocity and stress by O(h^(3/2)) in L2; "
    f"{AFFINE_SOURCE}"
)
STRESS_SOURCE = "first order of the gradient of a linear basis away from the middle of a cell; " + MPM_SOURCE
SPLINE_SOURCE = (
    "between 3/2 and 2, own derivation: second order inside, but the lumped mass of the clamped quadratic spline is off its node by "
    "O(h) in the two functions at each end, an error of O(h) in the stress, and in the velocity to which FLIP adds the acceleration, over "
    f"a length of O(h) and hence of O(h^(3/2)) in L2, which fine levels come to; {MPM_SOURCE}"
)
END_SOURCE = (
    "between 3/2 and 2, own derivation: second order inside, but the lumped mass of the hat at a moved or loaded end is off its node by "
    "O(h), and FLIP adds an acceleration that is off by O(h) to the velocities in the end cell, O(h^(3/2)) in L2 where the acceleration "
    f"has a slope there; {MPM_SOURCE}"
)
PIC_SOURCE = (
    "first order: every PIC transfer smooths the velocity over a distance of h, a diffusion of order h^2/dt ~ h; "
    "Brackbill and Ruppel (1986), doi:10.1016/0021-9991(86)90211-1"
)
BLEND_SOURCE = f"between the second order of FLIP on coarse levels and the first of PIC on fine ones; {PIC_SOURCE}"
ENERGY_SOURCE = (
    "2 in dt, own von Neumann analysis at frozen positions: USF and MUSL with FLIP are leapfrogs, which keep the energy of synchronous "
    "values up to O(dt^2); USL also dissipates the fraction nu_C^2 D (1 - A) = O((k h)^4) of a mode's energy in every step, O(h^3) at a "
    "fixed time; "
    "that USL dissipates, and USF does not: Bardenhagen (2002), doi:10.1006/jcph.2002.7103"
)


def drift(solver: MaterialPoint) -> EnergyDrift:
    """Return the criterion on the energy of a transfer without damping.

    On these levels the order of USL with quadratic splines goes from three to two: the second order of the leapfrog comes to dominate.
    """
    return EnergyDrift(1.5 if (solver.schedule, solver.basis) == ("USL", "quadratic") else 1.8, ENERGY_SOURCE)


CROSSING_SOURCE = (
    "the linear basis stalls or diverges at fixed particles per cell once particles cross cells; quadratic B-splines do not "
    "until their smaller quadrature error shows: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360"
)
SATURATION_SOURCE = (
    "the quadrature of quadratic B-splines over moved particles has an error that does not fall at a fixed number of them per cell, and "
    "ends the convergence: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360; in the ring gaps open between particles: Wallstedt "
    "and Guilkey (2008), doi:10.1016/j.jcp.2008.07.019"
)
GEOMETRIC_SOURCE = (
    "the closed form is linear, an updated Lagrangian code is not: at a strain amplitude of 1 % it converges to another "
    "solution, 1 % away within a factor of order one"
)
