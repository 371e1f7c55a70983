"""Separation of the errors of cell size, time step and particle spacing by small designs."""

from mpmverify.criteria import Separated, Size
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.vibration import axial_vibration
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Refinement, Series, Study, design, halving, in_particles, in_time

from . import variants as v

LENGTH = 25.0
SECOND = (1.85, 2.15)
THIRD = (2.85, 3.15)

NEWMARK = (
    "the frequency of a mode is off by +(beta h)^2/24 with consistent and by -(beta h)^2/24 with lumped mass, and by "
    "-(omega dt)^2/12 for average acceleration, so that the two cancel or add: Hughes (1987), The Finite Element Method, "
    f"chapter 9; {v.FEM_SOURCE}"
)
DONEA = "phase 1 - (1 - nu_C^2)(beta h)^2/6 of lumped mass, thus h^2 less dt^2: Donea (1984), doi:10.1002/nme.1620200108"
QUADRATURE = (
    "von Neumann analysis at frozen positions: 4 sin^2(omega dt/2) = nu_C^2 A D with D = theta^2 (1 - theta^2/12) of the hat and the "
    "mean A = 1 - theta^2 (1/6 + 1/(12 ppc^2)) over particles, which the midpoint rule takes to second order of their spacing: the "
    "phase is off by -theta^2/8 - theta^2/(24 ppc^2) + nu_C^2 theta^2/24; Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360"
)


def _separated(quantity: str, source: str, **bands: tuple[float, float]) -> Separated:
    sizes = {"h": "h", "dt": "dt", "ppc": "1/ppc", "spacing": "h/ppc"}
    return Separated(quantity, "L2", tuple((sizes[name], *band) for name, band in bands.items()), source)


SIZE_SOURCE = (
    "own estimate: phase errors of (k h)^2/24 to (k h)^2/6 and the gradient of linear elements, (k h)/sqrt(12), add up to less, and to more "
    "than a third of it where they are judged"
)


def _series(solver: Solver, refinement: Refinement, *criteria: Separated) -> Series:
    """Return a series; the size of its errors is judged in every field, since sources of error are judged relative to one another."""
    quantities = ("velocity", "stress") if isinstance(solver, TaylorGalerkin) else ("displacement", "velocity", "stress")
    sizes: list[Criterion] = [Size(quantity, "L2-max", 0.0, 0.05, SIZE_SOURCE) for quantity in quantities]
    return Series(solver, refinement, (*criteria, *sizes, v.MOMENTUM))


STRANGERS = halving(LENGTH, 16, quick=5, full=5, courant=0.4, ppc=2)
P1 = design(LENGTH, cells=(32, 48, 96), courant=(2, 1, 0.5, 0.25))
P2 = design(LENGTH, cells=(24, 36, 72), courant=(0.08, 0.04, 0.02, 0.01))
EXPLICIT = design(LENGTH, cells=(48, 72, 96, 144), courant=(0.32, 0.24, 0.16, 0.08))
PARTICLES = design(LENGTH, cells=(24, 36, 72), courant=(0.5, 0.35, 0.25, 0.12), ppc=(2,))

STUDY = Study(
    name="error-sources",
    title="Sources of error",
    summary="The first mode of a fixed bar at small strain. The effects of cell size, time step and particle spacing on the phase are "
    "known in closed form. Each is varied independently of the others. A ladder at a fixed Courant number does not do that: it measures "
    "only the lowest of the orders.",
    cases=(
        Case(
            "h-and-dt",
            axial_vibration(v0=1e-4),
            (
                *(
                    _series(
                        FiniteElement(1, mass, "newmark"),
                        P1,
                        _separated("displacement", NEWMARK, h=SECOND, dt=SECOND),
                        _separated("velocity", NEWMARK, h=SECOND, dt=SECOND),
                    )
                    for mass in ("consistent", "lumped")
                ),
                _series(
                    FiniteElement(2, "consistent", "newmark"),
                    P2,
                    _separated("displacement", NEWMARK, h=THIRD, dt=SECOND),
                    _separated("stress", NEWMARK, h=SECOND, dt=SECOND),
                ),
                _series(
                    TaylorGalerkin(passes=1),
                    EXPLICIT,
                    _separated("velocity", DONEA, h=SECOND, dt=SECOND),
                    _separated("stress", DONEA, h=SECOND, dt=SECOND),
                ),
                _series(
                    MaterialPoint("MUSL"),
                    PARTICLES,
                    _separated("displacement", QUADRATURE, h=SECOND, dt=SECOND),
                    _separated("velocity", QUADRATURE, h=SECOND, dt=SECOND),
                ),
            ),
            shown="displacement",
            ladder=STRANGERS,
        ),
        Case(
            "particles",
            axial_vibration(v0=1e-4),
            (
                _series(
                    MaterialPoint("MUSL"),
                    design(LENGTH, cells=(24, 36, 54), courant=(0.6, 0.4, 0.2), ppc=(1, 2, 3)),
                    _separated("displacement", QUADRATURE, h=SECOND, dt=SECOND, spacing=SECOND),
                ),
                _series(
                    MaterialPoint("USL"),
                    design(LENGTH, cells=(24, 36, 72), courant=(0.04,), ppc=(1, 2, 3)),
                    _separated("displacement", QUADRATURE, h=SECOND, spacing=SECOND),
                    _separated("velocity", QUADRATURE, h=SECOND, spacing=SECOND),
                ),
            ),
            shown="displacement",
            ladder=STRANGERS,
        ),
        Case(
            "one-at-a-time",
            axial_vibration(v0=1e-4),
            (
                _series(
                    FiniteElement(1, "lumped", "newmark"),
                    in_time(LENGTH, 64, quick=7, full=7, courant=8),
                    _separated("displacement", NEWMARK, dt=SECOND),
                ),
                _series(
                    MaterialPoint("MUSL"),
                    in_particles(LENGTH, 32, courant=0.05, ppc=(1, 2, 3, 4, 6, 8)),
                    _separated("displacement", QUADRATURE, ppc=SECOND),
                    _separated("velocity", QUADRATURE, ppc=SECOND),
                ),
            ),
            shown="displacement",
            ladder=STRANGERS,
        ),
    ),
)
