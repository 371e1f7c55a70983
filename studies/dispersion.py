"""One mode of a bar on grids of different resolution: the frequency of every scheme against its own dispersion relation."""

import math
from typing import Literal

from mpmverify.criteria import Dispersion, Size, Unstable
from mpmverify.exact import VerificationProblem
from mpmverify.exact.dispersion import mode_error
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Discretisation
from mpmverify.solution import Solver
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import MaterialPoint
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Refinement, Series, Study, ladder_label

CELLS = (5, 6, 8, 12, 16, 24, 48)
"""Cells on two wavelengths: k h from 0.8 pi down to pi/12."""
LENGTH, WAVES = 2.0, 2
WAVENUMBER = WAVES * 2 * math.pi / LENGTH
BOUND = 1e-10
"""Bound of the frequency error. Round-off, e/(omega dt)^3 summed over some hundred steps, gives 5e-11 for the longest wave."""

FEM_SOURCE = (
    "4 sin^2(omega dt/2) = q/(1 + beta q), q = 4 nu_C^2 sin^2(k h/2)/m: Hughes (1987), The Finite Element Method, section 9.1; "
    "Belytschko and Mullen (1978)"
)
TG_SOURCE = "the conjugate of the amplification factor of each characteristic: Donea (1984), doi:10.1002/nme.1620200108"
MPM_SOURCE = (
    "von Neumann analysis at frozen positions, own derivation: 4 sin^2(omega dt/2) = nu_C^2 A D for USF and MUSL, trace "
    "2 - nu_C^2 D and determinant 1 - nu_C^2 D (1 - A) for USL; on the schedules Bardenhagen (2002), doi:10.1006/jcph.2002.7103"
)

SIZE_SOURCE = (
    "the largest |z^n - exp(i n omega dt)| of the scheme's dispersion relation; of a standing wave the part at the output times, up to a "
    "tenth less; the stress of linear elements is constant in each, which adds k h/sqrt(12)"
)

UNSTABLE = "A stability limit that differs from theory, and an instability that the solver does not report."
EXCESS = 1.1
"""Courant number of a run that must be unstable, as a multiple of the stability limit."""
LIMIT_SOURCE = (
    "von Neumann analysis: 4 sin^2(omega dt/2) = 4 where the fastest mode of FEM, and of USF and MUSL with FLIP, comes to its limit; "
    "nu_C^2 = min 4/[D (2 - A)] for USL; |G| = 1 for Taylor-Galerkin; sources as of the dispersion relations"
)


def _ladder(courant: float, ppc: int = 1) -> Refinement:
    levels = tuple(Discretisation(h=LENGTH / cells, courant=courant, ppc=ppc) for cells in CELLS)
    return Refinement(ladder_label(courant, ppc), levels, quick=len(levels))


def _series(case: VerificationProblem, solver: Solver, source: str, courant: float, ppc: int = 1) -> Series:
    """Return a series judged by the frequency, and by the size of the errors that follows from it: a frequency has no amplitude."""
    ladder = _ladder(courant, ppc)
    finest, c = ladder.levels[-1], case.problem.material.wave_speed
    steps, dt = finest.time_steps(case.problem)
    error = mode_error(solver.name, WAVENUMBER * finest.h, c * dt / finest.h, steps, ppc)
    in_a_cell = WAVENUMBER * finest.h / math.sqrt(12) if isinstance(solver, FiniteElement) else 0.0
    quantities = ("velocity",) if isinstance(solver, TaylorGalerkin) else ("displacement", "velocity")
    sizes = (Size(quantity, "L2-max", 0.9 * error, 1.05 * error, SIZE_SOURCE) for quantity in quantities)
    stress = Size("stress", "L2-max", 0.9 * error, 1.05 * math.hypot(error, in_a_cell), SIZE_SOURCE)
    return Series(solver, ladder, (Dispersion(solver.name, "stress", WAVENUMBER, BOUND, source), *sizes, stress))


def _unstable(solver: Solver, limit: float, cells: int = 9) -> Series:
    """Return a series above the stability limit, on a number of cells for which the mode of the problem is unstable."""
    level = Discretisation(h=LENGTH / cells, courant=EXCESS * limit)
    return Series(solver, Refinement(f"{EXCESS:g} limits", (level,), quick=1), (Unstable(limit, LIMIT_SOURCE),))


def _bar(mode: int, ends: Literal["fixed-fixed", "periodic"]) -> VerificationProblem:
    """Return about four periods with an output at every step; no field is near zero at the end, and no parameter of the bar is 1."""
    bar = {"length": LENGTH, "youngs_modulus": 9.0, "density": 4.0, "v0": 1e-3}
    exposes = "Numerical frequency and damping of a mode as functions of its resolution."
    return axial_vibration(mode, ends, **bar, periods=4.1, outputs=4096, exposes=exposes)


def _particles(schedule: str, basis: str = "linear") -> MaterialPoint:
    return MaterialPoint(schedule, basis=basis, formulation="total")


RING, FIXED = _bar(WAVES, "periodic"), _bar(2 * WAVES, "fixed-fixed")

STUDY = Study(
    name="dispersion",
    title="Dispersion of a mode",
    summary="A mode of a bar oscillates for about four periods, on grids of different resolution. Every step multiplies it by one "
    "complex number, known for every scheme: its argument is omega(kh) dt, its modulus the damping. Above the Courant number at which "
    "the modulus exceeds 1, a run must end as unstable.",
    cases=(
        Case(
            "ring",
            RING,
            (
                _series(RING, TaylorGalerkin(passes=1), TG_SOURCE, 0.7),
                _series(RING, TaylorGalerkin(passes=3), TG_SOURCE, 0.4),
                _series(RING, _particles("MUSL"), MPM_SOURCE, 0.6, 2),
                # Clamped splines have another relation at their ends: the ring alone shows that of the quadratic ones.
                _series(RING, _particles("USF", "quadratic"), MPM_SOURCE, 0.6),
                _series(RING, _particles("USL", "quadratic"), MPM_SOURCE, 0.3, 2),
            ),
            shown="stress",
        ),
        Case(
            "fixed-fixed",
            FIXED,
            (
                _series(FIXED, FiniteElement(1, "lumped", "central-differences"), FEM_SOURCE, 0.7),
                _series(FIXED, FiniteElement(1, "consistent", "central-differences"), FEM_SOURCE, 0.5),
                _series(FIXED, FiniteElement(1, "lumped", "newmark"), FEM_SOURCE, 1.0),
                _series(FIXED, FiniteElement(1, "consistent", "newmark"), FEM_SOURCE, 1.0),
                *(_series(FIXED, _particles(schedule), MPM_SOURCE, 0.6, ppc) for schedule in ("USF", "MUSL") for ppc in (1, 2)),
                # With one particle per cell the shortest of these waves are overdamped.
                *(_series(FIXED, _particles("USL"), MPM_SOURCE, 0.3, ppc) for ppc in (2, 3)),
            ),
            shown="stress",
        ),
        Case(
            "beyond-the-limit",
            axial_vibration(8, length=LENGTH, youngs_modulus=9.0, density=4.0, v0=1e-3, periods=40, exposes=UNSTABLE),
            (
                _unstable(TaylorGalerkin(passes=1), 1.0),
                _unstable(FiniteElement(1, "lumped", "central-differences"), 1.0),
                _unstable(FiniteElement(1, "consistent", "central-differences"), 1 / math.sqrt(3)),
                _unstable(_particles("USL"), 1 / math.sqrt(2)),
                *(_unstable(_particles(schedule), 2.0, cells=16) for schedule in ("USF", "MUSL")),
            ),
            shown="stress",
        ),
    ),
)
