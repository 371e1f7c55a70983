"""What must hold of MLS-MPM in taichi on the bench, and its limits: `mpmverify run tests/adapters/taichi_study.py`."""

from taichi_mpm import TaichiMPM

from mpmverify import studies
from mpmverify.criteria import Order, Size, Stall
from mpmverify.criteria.criterion import Criterion
from mpmverify.problem import Discretisation
from mpmverify.study import Case, Refinement, Series, Study

SECOND = (
    "second order in space and, where dt follows h, a damping of second order: the affine velocity keeps what PIC smooths at first order: "
    "Jiang, Schroeder and Teran (2017), doi:10.1016/j.jcp.2017.02.050"
)
FIRST = (
    "first order, own derivation: the first step of the example applies the acceleration a of the start for dt and not for dt/2, which "
    "is a velocity off by a dt/2; on coarse levels the error of second order, of the other sign, hides a part of it"
)
SINGLE = (
    "own derivation: F = 1 + 1e-5 rounds off by 6e-8 in every step, which is 0.6 % of the strain, and finer levels have more steps; a float "
    "of single precision near 1 is a multiple of 1.2e-7"
)
UNSEEN = (
    f"the body starts without an acceleration along its motion, so that the first step is off by nothing that counts; {SECOND}"
)
QUADRATURE = (
    "the quadrature of quadratic B-splines over moved particles has an error that does not fall at a fixed number of them per cell: "
    "Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360; sizes by own measurement"
)


def orders(low: float, high: float, source: str) -> tuple[Criterion, ...]:
    return tuple(Order(quantity, "L2-max", low, high, source) for quantity in ("displacement", "stress"))


SHIPPED = ("plane-waves", "moving-bodies", "generalised-vortex", "expanding-ring")
CASES = {f"{study}/{case.name}": case for study in SHIPPED for case in studies.get(study).cases}


def judged(name: str, *series: tuple[TaichiMPM, tuple[int, ...], tuple[Criterion, ...]]) -> Case:
    """Return a case of a shipped study with other series: solver, cells along x, criteria."""
    shipped = CASES[name]
    level, side = shipped.ladder_in_h().levels[0], shipped.problem.problem.lengths[0]

    def one(solver: TaichiMPM, cells: tuple[int, ...], criteria: tuple[Criterion, ...]) -> Series:
        levels = tuple(Discretisation(side / n, level.courant, ppc=2) for n in cells)
        return Series(solver, Refinement(f"nu_C={level.courant:g}, 2 ppc", levels, len(levels)), criteria)

    return Case(
        name.replace("/", ", "), shipped.problem, tuple(one(*s) for s in series), shown="displacement", margin=shipped.margin
    )


DOUBLE, EXAMPLE, FLOAT = TaichiMPM(), TaichiMPM(centred=False), TaichiMPM(single=True)
STUDY = Study(
    name="taichi-mls-mpm",
    title="MLS-MPM in taichi",
    summary="Small waves through a box with joined ends, waves on a square that drifts through them, a vortex and an expanding ring. The "
    "example's first step makes it first order; with half of it, and in double precision, it is of second order until its quadrature "
    "stops it. Single precision holds no strain of 1e-5.",
    cases=(
        judged(
            "plane-waves/periodic",
            (DOUBLE, (12, 16, 20, 24), orders(1.8, 2.2, SECOND)),
            (FLOAT, (24, 32, 40, 48), (Stall("stress", "L2-max", 0.25, 0.1, 0.8, SINGLE),)),
        ),
        judged(
            "moving-bodies/square",
            (DOUBLE, (12, 16, 20, 24, 32), orders(1.8, 2.2, SECOND)),
            (EXAMPLE, (32, 40, 48, 64), orders(0.5, 1.15, FIRST)),
            (FLOAT, (12, 16, 20, 24, 32), orders(1.8, 2.2, SECOND)),
        ),
        judged(
            "generalised-vortex/0.05 rad",
            (
                DOUBLE,
                (40, 48, 64, 80),
                (Order("displacement", "L2-max", 1.7, 2.2, SECOND), Size("stress", "L2-max", 0.04, 0.07, QUADRATURE)),
            ),
            (EXAMPLE, (40, 48, 64, 80), (Order("displacement", "L2-max", 1.7, 2.2, UNSEEN),)),
        ),
        judged(
            "expanding-ring/ring",
            (
                DOUBLE,
                (48, 64, 96, 128),
                (
                    Stall("displacement", "L2-max", 0.5, 0.0035, 0.009, QUADRATURE),
                    Stall("stress", "L2-max", 0.5, 0.016, 0.04, QUADRATURE),
                ),
            ),
        ),
    ),
)
