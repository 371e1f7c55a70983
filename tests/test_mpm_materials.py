"""Every constitutive law in the solver: the elastic ones keep the energy of a swinging body, the viscous ones lose it."""

import numpy as np
import pytest

from mpmverify.errors import UsageError
from mpmverify.material import (
    Hencky,
    KelvinVoigt,
    LinearElastic,
    Maxwell,
    NeoHookean,
    NeoHookeanSplit,
    PlaneStress,
    SaintVenantKirchhoff,
)
from mpmverify.problem import Discretisation, Problem, Velocity
from mpmverify.solvers.mpm import MaterialPoint

CONSTANTS = (1.0, 1.0, 0.3)
ELASTIC = [law(*CONSTANTS) for law in (LinearElastic, NeoHookean, NeoHookeanSplit, Hencky, SaintVenantKirchhoff)]
VISCOUS = [KelvinVoigt(*CONSTANTS, viscosity=0.01), Maxwell(*CONSTANTS, relaxation_time=1.0)]


def energy(material, dimension):
    """Kinetic and strain energy of a box between rollers that swings (N + 1,)."""
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    swing = {"velocity": lambda X: 0.05 * np.sin(np.pi * X)}
    problem = Problem("box", (0.0,) * dimension, (1.0,) * dimension, material, dict.fromkeys(names, Velocity()), 2.0, swing)
    solution = MaterialPoint("USF").solve(problem, Discretisation(1 / 16, 0.2, 2))
    assert solution.outcome.completed, str(solution.outcome)
    return solution.histories["kinetic_energy"] + solution.histories["strain_energy"]


@pytest.mark.parametrize("dimension", [1, 2])
@pytest.mark.parametrize("material", ELASTIC, ids=lambda law: type(law).__name__)
def test_an_elastic_body_keeps_its_energy(material, dimension):
    found = energy(material, dimension)
    assert found == pytest.approx(found[0], rel=3e-3)


def test_so_does_one_in_plane_stress_which_is_of_two_dimensions():
    found = energy(PlaneStress(*CONSTANTS), 2)
    assert found == pytest.approx(found[0], rel=3e-3)
    with pytest.raises(UsageError, match="plane stress in two dimensions"):
        energy(PlaneStress(*CONSTANTS), 1)


@pytest.mark.parametrize("dimension", [1, 2])
@pytest.mark.parametrize("material", VISCOUS, ids=lambda law: type(law).__name__)
def test_a_viscous_body_loses_energy(material, dimension):
    found = energy(material, dimension)
    assert found[-1] < 0.9 * found[0]
    assert found.max() <= found[0] * (1 + 1e-3)
