"""Manufactured motions of large amplitude: Steffen's bar, and axis-aligned displacement of a square and a cube."""

from mpmverify.criteria import Size, Stall
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.axis_aligned import axis_aligned
from mpmverify.exact.steffen import steffen
from mpmverify.problem import Discretisation
from mpmverify.solution import Solver
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint, Transfer
from mpmverify.solvers.textbook import Textbook
from mpmverify.study import Case, Refinement, Series, Study, halving, ladder_label

from . import variants as v

LINEAR = MaterialPoint("MUSL", formulation="total")
QUADRATIC = MaterialPoint("USF", FLIP, "quadratic", "total")
AFFINE = MaterialPoint("USL", APIC, "quadratic", "total")
UPDATED = MaterialPoint("USL")
COURANT, PPC = 0.3, 2
DOMAIN_SOURCE = (
    "particles whose domains follow the deformation leave no gaps along the axes: second order at a fixed number of them per cell; "
    "Wallstedt and Guilkey (2008), doi:10.1016/j.jcp.2008.07.019 (cpGIMP); Sadeghirad, Brannon and Burghardt (2011), "
    "doi:10.1002/nme.3110 (CPDI)"
)
GAPS_SOURCE = (
    "undeformed particle domains separate and overlap as the bar deforms, an error that does not fall at a fixed number of particles "
    "per cell; Wallstedt and Guilkey (2008), doi:10.1016/j.jcp.2008.07.019"
)
CUBIC_SOURCE = (
    "the error of the quadrature falls with the smoothness of the spline, so that four particles per cell carry cubic B-splines "
    "through every level here: Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360"
)
ENDS_SOURCE = (
    "own measurement: over two particles per cell the quadrature of the second function of a clamped cubic spline is off by 9 % of the "
    "stress at rest already, and once they move the end cells come apart; a property of the basis and the quadrature"
)
CUBIC_ENDS_SOURCE = (
    "own derivation: in the end cells the quadrature does not balance a constant stress, a strain error of O(1) over a length O(h), which "
    "shows from 64 cells on"
)
LEAST_SQUARES_SOURCE = (
    "first order, own derivation: the gradients of moving least squares over B-splines are exact for a linear field, off by O(h) of its "
    "curvature, and do not balance a constant stress in the end cells, a strain off by O(1) over O(h)"
)


CROSSED_SOURCE = (
    "by own measurement from second order on coarse levels to the first on fine ones: the force of the hat's gradient, constant in a cell, "
    "changes where a particle's domain leaves one, and FLIP keeps the change in the velocity"
)
STRESS = v.orders("L2-max", 0.9, 1.2, v.STRESS_SOURCE, "stress")
HAT = (*v.orders("L2-max", 1.8, 2.2, v.MPM_SOURCE, "displacement", "velocity"), *STRESS)
CUBE_SOURCE = "own measurement, to a tenth: larger than the error of a phase that is wrong by 1 %, which an order does not tell on so few cells"
CUBE: tuple[Criterion, ...] = (*HAT, Size("displacement", "L2-max", 0.047, 0.06, CUBE_SOURCE, 1.0 / 12))
SPLINE = (
    *v.orders("L2-max", 1.8, 2.2, v.MPM_SOURCE, "displacement"),
    *v.orders("L2-max", 1.4, 2.15, v.SPLINE_SOURCE, "velocity", "stress"),
)
APIC_SPLINE = v.orders("L2-max", 1.7, 2.2, v.AFFINE_SOURCE, "displacement", "velocity", "stress")
DOMAINS: tuple[Criterion, ...] = (
    *v.orders("L2-max", 1.8, 2.2, DOMAIN_SOURCE, "displacement"),
    Size("velocity", "L2-max", 0.002, 0.0045, CROSSED_SOURCE, 1.0 / 128),
    Size("stress", "L2-max", 0.0009, 0.0027, CROSSED_SOURCE, 1.0 / 128),
)
CUBIC: tuple[Criterion, ...] = (
    *v.orders("L2-max", 1.8, 2.2, CUBIC_SOURCE, "displacement"),
    *v.orders("L2-max", 0.85, 2.15, f"first order in the end; {CUBIC_ENDS_SOURCE}", "velocity"),
    Size("stress", "L2-max", 0.004, 0.1, f"order 1/2 in the end; {CUBIC_ENDS_SOURCE}"),
)
MLS = (
    *v.orders("L2-max", 0.9, 1.2, LEAST_SQUARES_SOURCE, "displacement"),
    *v.orders(
        "L2-max",
        0.5,
        1.5,
        f"{LEAST_SQUARES_SOURCE}; levels scatter by a factor of 1.5 with the positions in the end cells",
        "velocity",
    ),
    *v.orders("L2-max", 0.4, 0.65, f"half an order less; {LEAST_SQUARES_SOURCE}", "stress"),
)


def _series(solver: Solver, expected: tuple[Criterion, ...], *cells: int) -> Series:
    """Return a series on these numbers of cells along an axis; the last one is of the full tier, save where the scheme stalls."""
    levels = tuple(Discretisation(1.0 / count, COURANT, PPC) for count in cells)
    quick = len(cells) - (not isinstance(expected[0], Stall))
    return Series(solver, Refinement(ladder_label(COURANT, PPC), levels, quick), (*expected, v.MOMENTUM, v.MASS))


def _on(basis: str, expected: tuple[Criterion, ...], first: int = 16, ppc: int = PPC, transfer: Transfer = FLIP) -> Series:
    """Return a series of the updated Lagrangian formulation with a basis, on levels so fine that particles cross cells."""
    ladder = halving(1.0, first, quick=4, full=4 if isinstance(expected[0], Stall) else 5, courant=COURANT, ppc=ppc)
    return Series(MaterialPoint("USL", transfer, basis), ladder, (*expected, v.MOMENTUM, v.MASS))


BASES = (
    _on("cpgimp", DOMAINS),
    _on("cpdi", DOMAINS),
    _on("ugimp", v.stalls(GAPS_SOURCE, displacement=(0.015, 0.065), velocity=(0.055, 0.14), stress=(0.05, 0.14)), first=32),
    _on(
        "quadratic",
        v.stalls(v.SATURATION_SOURCE, displacement=(0.02, 0.09), velocity=(0.075, 0.18), stress=(0.055, 0.13)),
        first=32,
    ),
    _on(
        "quadratic",
        v.stalls(v.SATURATION_SOURCE, displacement=(0.014, 0.06), velocity=(0.03, 0.11), stress=(0.05, 0.12)),
        first=32,
        transfer=APIC,
    ),
    _on("cubic", v.stalls(ENDS_SOURCE, displacement=(1.5, 3.5), velocity=(2.0, 4.5), stress=(1.25, 2.8))),
    _on("cubic", CUBIC, ppc=4),
    _on("mls-quadratic", MLS, first=32, ppc=4),
)
STALLED_BAR = v.stalls(v.CROSSING_SOURCE, displacement=(0.25, 0.95), velocity=(0.44, 1.5), stress=(0.3, 0.88))
STALLED_SQUARE = v.stalls(v.CROSSING_SOURCE, displacement=(0.3, 0.97), velocity=(0.25, 0.92), stress=(0.27, 0.8))


STUDY = Study(
    name="large-deformation",
    title="Large deformation in one, two and three dimensions",
    summary="Standing waves of finite amplitude, exact under a body force, in Steffen's bar and along each axis of a square and a cube. "
    "Particles cross cells. The total Lagrangian formulation converges at second order. The updated Lagrangian formulation stalls with "
    "linear functions, and on finer levels with quadratic B-splines and with undeformed particle domains (uGIMP). With deforming "
    "particle domains (cpGIMP, CPDI) it converges.",
    cases=(
        Case(
            "bar",
            steffen(),
            (
                _series(LINEAR, HAT, 16, 32, 64, 128, 256),
                _series(QUADRATIC, SPLINE, 16, 32, 64, 128, 256),
                _series(UPDATED, STALLED_BAR, 8, 16, 32, 64),
                _series(Textbook(formulation="total"), HAT, 16, 32, 64, 128, 256),
            ),
            shown="displacement",
        ),
        Case("bases", steffen(), BASES, shown="displacement", ladder=halving(1.0, 32, quick=4, full=4, courant=COURANT, ppc=4)),
        Case(
            "square",
            axis_aligned(2),
            (
                _series(LINEAR, HAT, 8, 16, 32, 64, 128),
                _series(AFFINE, APIC_SPLINE, 8, 16, 32, 64, 128),
                _series(UPDATED, STALLED_SQUARE, 8, 16, 32, 64),
                _series(Textbook(formulation="total"), HAT, 12, 16, 20, 24, 32),
            ),
            shown="displacement",
            ladder=_series(LINEAR, STALLED_SQUARE, 16, 24, 32, 48).refinement,
        ),
        Case("cube", axis_aligned(3), (_series(LINEAR, CUBE, 6, 8, 10, 12, 16),), shown="displacement"),
    ),
)
