"""Stability limits of the material point method, measured by bisection and compared with von Neumann analysis."""

from mpmverify.adapters.bisection import Bisection
from mpmverify.criteria import StabilityLimit
from mpmverify.exact.ring_modes import ring_modes
from mpmverify.solvers.mpm import FLIP, PIC, MaterialPoint, Transfer, fmpm, xpic
from mpmverify.study import Case, Series, Study, in_particles

CELLS, LENGTH = 40, 2.0
UNSTABLE_COURANT = 4.0
"""Courant number at which every scheme is unstable."""
SCHEMES: tuple[tuple[str, Transfer], ...] = (
    ("USF", FLIP),
    ("USL", FLIP),
    ("MUSL", FLIP),
    ("USL", PIC),
    ("USL", xpic(2)),
    ("USL", fmpm(2)),
    ("USL", fmpm(4)),
)
SOURCE = (
    "von Neumann analysis at frozen positions, own derivation: nu_C^2 = min over theta of 4/[D (2 - A)] for USL with FLIP, 4/(A D) for "
    "USF and MUSL, 2 (1 + R A)/(R D) for FMPM(k); on the schedules Bardenhagen (2002), doi:10.1006/jcph.2002.7103"
)
BOUND = 0.01


def _case(basis: str) -> Case:
    solvers = [MaterialPoint(schedule, transfer, basis, "total") for schedule, transfer in SCHEMES]
    ladder = in_particles(LENGTH, CELLS, courant=UNSTABLE_COURANT, ppc=(1, 2, 4))
    series = tuple(Series(Bisection(s), ladder, (StabilityLimit(s.name, BOUND, SOURCE),)) for s in solvers)
    return Case(basis, ring_modes(CELLS, length=LENGTH), series, shown="stress")


STUDY = Study(
    name="mpm-stability",
    title="Limits of stability of the material point method",
    summary="A periodic bar starts with a standing wave of every wavelength that its grid resolves. Bisection finds the largest Courant "
    "number at which no wave grows, for every schedule, transfer and basis; it is compared with the limit of von Neumann analysis.",
    cases=tuple(_case(basis) for basis in ("linear", "quadratic", "cubic")),
)
