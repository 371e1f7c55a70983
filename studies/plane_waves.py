"""P and S waves in two and three dimensions: small strain, plane stress, viscous laws, and every hyperelastic law."""

from mpmverify.criteria import EnergyDrift, Order, Size
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.expectations import MARGIN
from mpmverify.exact import VerificationProblem
from mpmverify.exact.clamped_layer import clamped_layer
from mpmverify.exact.lame_mode import lame_mode
from mpmverify.exact.periodic_waves import periodic_waves
from mpmverify.exact.slip_box import slip_box
from mpmverify.problem import Discretisation, LinearElastic, NeoHookean
from mpmverify.problem.material import (
    Hencky,
    KelvinVoigt,
    Maxwell,
    NeoHookeanSplit,
    PlaneStress,
    SaintVenantKirchhoff,
    Yeoh,
)
from mpmverify.solvers.mpm import APIC, MaterialPoint
from mpmverify.study import Case, Refinement, Series, Study, ladder_label

from . import variants as v

CONSTANTS = (7.0, 2.0, 0.3)
"""E [Pa], rho [kg/m^3] and nu of every body."""
ELASTIC = LinearElastic(*CONSTANTS)
VISCOUS = KelvinVoigt(*CONSTANTS, viscosity=0.3)
RELAXING = Maxwell(*CONSTANTS, relaxation_time=0.3)
FINITE = {
    "neo-hookean": NeoHookean(*CONSTANTS),
    "neo-hookean-split": NeoHookeanSplit(*CONSTANTS),
    "hencky": Hencky(*CONSTANTS),
    "saint-venant-kirchhoff": SaintVenantKirchhoff(*CONSTANTS),
    "yeoh": Yeoh(*CONSTANTS, second=-2.0, third=30.0),
}
"""Hyperelastic bodies by case."""
COARSE, FINE = (12, 16, 24, 32, 48), (24, 32, 40, 48, 64)
COARSE_CUBOID, CUBOID = (8, 10, 12, 14, 16), (10, 12, 14, 16, 20)
"""Cells on 1 m: of one particle per cell, of two along each axis, and in three dimensions. The quick tier leaves out the last."""

UPDATED, TOTAL = MaterialPoint("MUSL"), MaterialPoint("MUSL", formulation="total")
FIRST, LAST = MaterialPoint("USF"), MaterialPoint("USL", formulation="total")
FITTED = MaterialPoint("USL", basis="tls-linear")
AFFINE, AFFINE_UPDATED = MaterialPoint("MUSL", APIC, "quadratic", "total"), MaterialPoint("MUSL", APIC, "quadratic")

MIDDLE_SOURCE = f"second order of the gradient of a linear basis in the middle of a cell; {v.MPM_SOURCE}"
SURFACE_SOURCE = (
    "between 3/2 and 2, own derivation: the lumped mass of a free surface has its centre 3/8 of a cell inside, so that the velocity of "
    "the surface is off by O(h) where it varies along the normal, in a layer of O(h), and hence by O(h^(3/2)) in L2, which fine levels "
    f"come to; {v.MPM_SOURCE}"
)
VISCOUS_SOURCE = (
    "first order in dt, own derivation: the rate of strain that the viscous stress takes is half a step old; dt follows h^2 here, so that "
    "every order in h is two; on the rest "
)
VELOCITY = Order("velocity", "L2-max", 1.8, 2.2, v.MPM_SOURCE)
FREE = Order("velocity", "L2-max", 1.4, 2.2, SURFACE_SOURCE)
SIZE = Size(
    "displacement",
    "L2-max",
    0.0122,
    0.015,
    "own measurement, to a tenth: a time that runs 1 % too fast hides in the order of so few cells",
    1 / 32,
)
DRIFT, HEAT = EnergyDrift(1.8, v.ENERGY_SOURCE), EnergyDrift(0.8, VISCOUS_SOURCE + v.ENERGY_SOURCE)


def _criteria(solver: MaterialPoint, ppc: int, velocity: Order, drift: EnergyDrift) -> tuple[Criterion, ...]:
    if solver.transfer is APIC:
        affine = tuple(Order(field, "L2-max", 1.8, 2.2, v.AFFINE_SOURCE) for field in ("displacement", "velocity"))
        stress = Order("stress", "L2-max", 1.4, 2.2, v.SPLINE_SOURCE)
        return (*affine, stress, EnergyDrift(1.8, v.AFFINE_SOURCE), v.MOMENTUM, v.MASS)
    first_order = Order("stress", "L2-max", 0.9, 1.2, v.STRESS_SOURCE)
    stress = Order("stress", "L2-max", 1.8, 2.2, MIDDLE_SOURCE) if ppc == 1 else first_order
    momentum = (v.MOMENTUM,) if "momentum" in solver.conserves else ()  # fits in the cells do not keep it
    return (Order("displacement", "L2-max", 1.8, 2.2, v.MPM_SOURCE), velocity, stress, drift, *momentum, v.MASS)


def _on(
    solver: MaterialPoint,
    cells: tuple[int, ...] = COARSE,
    ppc: int = 1,
    *,
    courant: float = 0.3,
    power: int = 0,
    velocity: Order = VELOCITY,
    drift: EnergyDrift = DRIFT,
    further: tuple[Criterion, ...] = (),
) -> Series:
    """Return a series; `courant` is the Courant number of the coarsest level, from which it falls as h to some power."""
    levels = tuple(Discretisation(1 / count, courant * (cells[0] / count) ** power, ppc) for count in cells)
    label = ladder_label(courant, ppc) + (f", nu_C ~ h^{power}" if power else "")
    return Series(solver, Refinement(label, levels, len(levels) - 1), (*_criteria(solver, ppc, velocity, drift), *further))


def _case(
    name: str, problem: VerificationProblem, *series: Series, ladder: Refinement | None = None, margin: float = MARGIN
) -> Case:
    return Case(name, problem, series, shown="displacement", ladder=ladder, margin=margin)


STEPS = Refinement(ladder_label(0.05, 1), tuple(Discretisation(1 / count, 0.05) for count in (12, 16, 20, 24, 32)), 5)
"""Ladder in h with so small steps that what a viscous law is off by, of first order in dt, does not show."""


STUDY = Study(
    name="plane-waves",
    title="P and S waves in every material",
    summary="Superposed P and S modes swing in boxes between slip walls, between clamped faces, through joined ends and between free "
    "surfaces, in two and three dimensions, in plane strain and plane stress, in elastic and viscoelastic bodies. Bodies of every "
    "hyperelastic law follow such a motion at finite strain under a body force. All start strained and moving, with an acceleration.",
    cases=(
        _case("box", slip_box(ELASTIC), _on(UPDATED, FINE, 2), _on(FIRST), _on(LAST)),
        _case("plane-stress", slip_box(PlaneStress(*CONSTANTS)), _on(UPDATED)),
        _case("clamped", clamped_layer(ELASTIC, periods=0.8), _on(UPDATED, FINE), _on(LAST, FINE, 2), _on(FITTED, FINE)),
        _case("periodic", periodic_waves(ELASTIC), _on(UPDATED, FINE)),
        _case("free", lame_mode(ELASTIC, periods=0.8), _on(UPDATED, (16, 24, 32, 48, 64), 2, velocity=FREE)),
        _case("cuboid", slip_box(ELASTIC, 3, periods=0.8), _on(UPDATED, CUBOID)),
        _case(
            "clamped-cuboid",
            clamped_layer(ELASTIC, 3, periods=0.8),
            _on(LAST, (16, 20, 24, 32, 40), further=(SIZE,)),
            margin=0.2,
        ),
        _case(
            "kelvin-voigt",
            slip_box(VISCOUS),
            *(_on(s, courant=0.2, power=1, drift=HEAT) for s in (UPDATED, LAST)),
            ladder=STEPS,
            margin=0.2,
        ),
        _case("maxwell", slip_box(RELAXING), _on(UPDATED), _on(LAST)),
        *(
            _case(name, slip_box(law, strain=0.25, periods=0.7), _on(TOTAL, (16, 24, 32, 48, 64) if name == "yeoh" else COARSE))
            for name, law in FINITE.items()
        ),
        *(_case(f"{name}-bar", slip_box(law, 1, strain=0.25, periods=0.7), _on(TOTAL)) for name, law in FINITE.items()),
        _case("neo-hookean-updated", slip_box(FINITE["neo-hookean"], strain=0.002), _on(UPDATED)),
        _case(
            "neo-hookean-affine",
            slip_box(FINITE["neo-hookean"], strain=0.1, periods=0.7),
            _on(AFFINE, (8, *COARSE[:4]), 2),
            _on(AFFINE_UPDATED, (8, 12, 16, 20, 24), 2),
        ),
        *(
            _case(f"{name}-cuboid", slip_box(FINITE[name], 3, strain=0.2, periods=0.4), _on(TOTAL, cells))
            for name, cells in (("hencky", COARSE_CUBOID), ("neo-hookean-split", COARSE_CUBOID), ("yeoh", CUBOID))
        ),
    ),
)
