"""The GeHoJerez deck: at a unit Courant number every Gauss-point value of every step is known exactly."""

from mpmverify.criteria import Exact
from mpmverify.exact.deck import deck
from mpmverify.problem import Discretisation
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin
from mpmverify.study import Case, Refinement, Series, Study

from .variants import MOMENTUM

SOURCE = (
    "lumped two-step Taylor-Galerkin is Lax-Wendroff's scheme on a uniform mesh and translates exactly at nu_C = 1: Donea "
    "(1984), doi:10.1002/nme.1620200108; the deck is the last one-dimensional driver of the GeHoJerez notes, May 2019"
)


def _case(name: str, length: float, h: float) -> Case:
    series = Series(
        TaylorGalerkin(passes=1),
        Refinement("nu_C=1", (Discretisation(h=h, courant=1.0),), quick=1),
        (
            Exact("stress", "L2-max", 1e-12, SOURCE),
            Exact("velocity", "L2-max", 1e-12, SOURCE),
            MOMENTUM,
        ),
    )
    return Case(name, deck(length=length, h=h), (series,), shown="stress")


STUDY = Study(
    name="gehojerez-deck",
    title="The GeHoJerez deck",
    summary="A node at the free end of a bar is given a velocity; the pulse travels, doubles its stress at the fixed end and "
    "its velocity at the free one. The errors of all Gauss-point values at all steps are bounded.",
    cases=(_case("deck", 8.0, 1.0), _case("finer-twin", 5.0, 0.25)),
)
