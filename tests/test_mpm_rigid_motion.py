"""A free body that translates keeps its velocity and has no stress, wherever its particles lie: on cell edges and just beside them."""

import numpy as np
import pytest

from mpmverify.problem import Block, Discretisation, LinearElastic, NeoHookean, Problem, Traction
from mpmverify.solvers.mpm import APIC, FLIP, PIC, MaterialPoint, fmpm, xpic

MODULUS = 1e3
STARTS = ((0.0, 1.0), (0.0, -1.0), (1e-15, 1.0), (-1e-15, -1.0), (1e-13, -1.0), (-1e-13, 1.0), (1e-9, 1.0), (-1e-9, -1.0))
"""Distance of the particles from where they come to lie on cell edges [m], and velocity [m/s]."""


def translated(variant, dimension, beside, velocity):
    """Solution for a block in the middle of a box that moves at a constant velocity along every axis."""
    free = {axis + side: Traction() for axis in "xyz"[:dimension] for side in "-+"}
    block = Block((1.5 + beside,) * dimension, (2.5 + beside,) * dimension)
    initial = {"velocity": lambda X: np.full(X.shape, velocity)}
    law = (
        NeoHookean if variant.basis in ("ugimp", "cpgimp", "cpdi") else LinearElastic
    )  # both keep F where particles have domains
    box = (0.0,) * dimension, (4.0,) * dimension
    problem = Problem("translate", *box, law(MODULUS, 10.0), free, 0.5, initial, shape=block)
    return variant.solve(problem, Discretisation(0.25, 0.5, ppc=2))


@pytest.mark.parametrize(("beside", "velocity"), STARTS)
@pytest.mark.parametrize(
    ("variant", "dimension"),
    [
        *(
            (MaterialPoint(schedule, by), 1)
            for schedule in ("USF", "USL", "MUSL")
            for by in (FLIP, PIC, APIC, xpic(2), fmpm(2))
        ),
        *((MaterialPoint(schedule, FLIP), 2) for schedule in ("USF", "USL", "MUSL")),
        *((MaterialPoint("USL", FLIP, basis), 1) for basis in ("quadratic", "cubic", "ugimp", "cpgimp", "cpdi")),
        (MaterialPoint("MUSL", FLIP, "linear", "total"), 1),
    ],
    ids=lambda value: value.name if isinstance(value, MaterialPoint) else f"{value}d",
)
def test_a_translation_strains_nothing(variant, dimension, beside, velocity):
    solution = translated(variant, dimension, beside, velocity)
    assert solution.outcome.completed
    assert np.abs(solution.fields["stress"]).max() <= 1e-12 * MODULUS
    assert np.abs(solution.fields["velocity"] - velocity).max() <= 1e-13
