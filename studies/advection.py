"""Advection of a hill, a Gaussian, a step and a broad spectrum by two-step Taylor-Galerkin."""

from mpmverify.criteria import Amplification, AmplitudeDecay, Balance, FrontPosition, Order, PhaseError
from mpmverify.criteria.criterion import Criterion
from mpmverify.exact.advection import CosineHill, Gaussian, Step, advection
from mpmverify.exact.regularity import expected_order
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Series, Study, halving

LUMPED, CONSISTENT = TaylorGalerkin(passes=1), TaylorGalerkin(passes=3)
COURANT = {LUMPED: (0.3, 0.6, 0.9), CONSISTENT: (0.3, 0.4, 0.55)}
"""Courant numbers, below the stability limits 1 (lumped) and 1/sqrt(3) (consistent)."""

DONEA = "second order in h and dt on smooth data: Donea (1984), doi:10.1002/nme.1620200108"
BRENNER = (
    "order 2 s/3 in L2 for a second-order scheme on data with s derivatives in L2: Brenner, Thomee and Wahlbin (1975), "
    "Besov Spaces and Applications to Difference Methods for Initial Value Problems, doi:10.1007/BFb0068125"
)
MASS = Balance("mass", "inflow", "the scheme is in conservation form: the nodal residuals sum to the boundary flux")


STEP = (
    "own estimate from the leading errors, band set with the measured orders in view: "
    "order 5/8 in L1 for a jump: leading phase errors of second order smear the front over n^(1/3) cells after n steps, and the "
    "damping of fourth order lets the oscillations behind it reach back n^(1/2) cells; 1/2 where the damping vanishes, as it "
    "does for the consistent mass at nu_C = 1/sqrt(3), and up to 4/5 on coarse meshes where the consistent mass at a small nu_C "
    "has phase errors of fourth order still. Not a published figure; for the theory see " + BRENNER
)


LEADING = (
    "leading errors of the amplification factor; lumped mass: phase 1 - (1 - nu_C^2) theta^2/6, |G|^2 = 1 - nu_C^2 (1 - nu_C^2) "
    "theta^4/4; consistent: phase 1 + nu_C^2 theta^2/6, |G|^2 = 1 - nu_C^2 (1 - 3 nu_C^2) theta^4/12: Donea (1984), "
    "doi:10.1002/nme.1620200108; with the means k^4/k^2 = 3/w^2 and k^4 = 3/w^4 of the power spectrum of exp(-(x/w)^2)"
)
FRONT = (
    "a jump whose modes are multiplied by the amplification factor, Donea (1984), doi:10.1002/nme.1620200108; to leading order the "
    "integral of an Airy function whose middle lags by a part of its width (3 lag nu_C n)^(1/3) cells, for a phase error lag theta^2; "
    "read off between samples by a straight line; the bound of a tenth of a cell was set with the measured 0.04 in view"
)


def _waves(profile: CosineHill | Gaussian | Step, solver: TaylorGalerkin) -> tuple[Criterion, ...]:
    """Return the criteria on phase error and decay of a Gaussian that travelled one length, or on the position of a front."""
    if isinstance(profile, Gaussian):
        return (
            PhaseError("u", 2, 0.2, LEADING, solver.name, 3 / profile.width**2),
            AmplitudeDecay("u", 3, 0.2, LEADING, solver.name, 3 / profile.width**4),
        )
    if isinstance(profile, Step):
        return (FrontPosition("u", solver.name, 0.1, FRONT),)
    return ()


def _case(profile: CosineHill | Gaussian | Step, *criteria: Criterion) -> Case:
    series = tuple(
        Series(
            solver,
            halving(1.0, 32, quick=6, full=8, courant=courant),
            (*criteria, *_waves(profile, solver), MASS),
        )
        for solver, numbers in COURANT.items()
        for courant in numbers
    )
    return Case(profile.name, advection(profile), series, shown="u")


SPECTRUM = tuple(
    Series(
        solver,
        halving(1.0, 32, quick=2, full=4, courant=courant),
        (Amplification(solver.passes, 1e-12, "von Neumann analysis: Donea (1984), doi:10.1002/nme.1620200108"), MASS),
    )
    for solver, numbers in COURANT.items()
    for courant in numbers
)

STUDY = Study(
    name="advection",
    title="Advection of a scalar",
    summary="A profile is carried once around a periodic domain, or a jump half-way through an open one, by two-step "
    "Taylor-Galerkin with lumped and with consistent mass at several Courant numbers.",
    cases=(
        _case(Gaussian(), Order("u", "L2", 1.8, 2.2, DONEA)),
        _case(
            CosineHill(),
            Order(
                "u",
                "L2",
                1.55,
                1.95,
                f"order {expected_order(2, CosineHill.derivatives, 'L2'):.3g} for s = {CosineHill.derivatives - 0.5:g}; "
                f"the upper edge was set with the measured 1.77 to 1.90 in view; {BRENNER}",
            ),
        ),
        _case(Step(), Order("u", "L1", 0.45, 0.8, STEP)),
        Case("spectrum", advection(Gaussian(width=0.02), end_time=0.25), SPECTRUM, shown="u"),
    ),
)
