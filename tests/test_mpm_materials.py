"""Constitutive laws in the solver: elastic laws conserve the energy of a vibrating body, viscous laws dissipate it."""

import numpy as np
import pytest

from mpmverify.errors import UsageError
from mpmverify.problem import Constant, Discretisation, Problem, Traction, Velocity
from mpmverify.problem.material import (
    Hencky,
    KelvinVoigt,
    LinearElastic,
    Maxwell,
    NeoHookean,
    NeoHookeanSplit,
    PlaneStress,
    SaintVenantKirchhoff,
)
from mpmverify.solvers.mpm import APIC, FLIP, TPIC, MaterialPoint

CONSTANTS = (1.0, 1.0, 0.3)
ELASTIC = [law(*CONSTANTS) for law in (LinearElastic, NeoHookean, NeoHookeanSplit, Hencky, SaintVenantKirchhoff)]
FIRST = MaterialPoint("USF")
VISCOUS = [KelvinVoigt(*CONSTANTS, viscosity=0.01), Maxwell(*CONSTANTS, relaxation_time=1.0)]


def vibrating(material, dimension, variant=FIRST, courant=0.2, amplitude=0.05):
    """Histories (N + 1,) of the mechanical and the dissipated energy of a vibrating box between rollers."""
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    swing = {"velocity": lambda X: amplitude * np.sin(np.pi * X)}
    problem = Problem("box", (0.0,) * dimension, (1.0,) * dimension, material, dict.fromkeys(names, Velocity()), 2.0, swing)
    solution = variant.solve(problem, Discretisation(1 / 16, courant, 2))
    assert solution.outcome.completed, str(solution.outcome)
    histories = solution.histories
    return histories["kinetic_energy"] + histories["strain_energy"], histories["dissipated_energy"]


@pytest.mark.parametrize("dimension", [1, 2])
@pytest.mark.parametrize("material", ELASTIC, ids=lambda law: type(law).__name__)
def test_an_elastic_body_conserves_its_energy(material, dimension):
    found, heat = vibrating(material, dimension)
    assert found == pytest.approx(found[0], rel=3e-3)
    assert not heat.any()


def test_plane_stress_conserves_energy_and_needs_two_dimensions():
    found, _ = vibrating(PlaneStress(*CONSTANTS), 2)
    assert found == pytest.approx(found[0], rel=3e-3)
    with pytest.raises(UsageError, match="plane stress in two dimensions"):
        vibrating(PlaneStress(*CONSTANTS), 1)


@pytest.mark.parametrize("dimension", [1, 2])
@pytest.mark.parametrize("material", VISCOUS, ids=lambda law: type(law).__name__)
def test_a_viscous_body_dissipates_its_energy(material, dimension):
    found, heat = vibrating(material, dimension)
    assert found[-1] < 0.9 * found[0]
    assert found.max() <= found[0] * (1 + 1e-3)
    assert heat[0] == 0
    assert np.diff(heat).min() >= 0
    assert found + heat == pytest.approx(found[0], rel=5e-3)


@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize("schedule", ["USF", "USL", "MUSL"])
@pytest.mark.parametrize("material", VISCOUS, ids=lambda law: type(law).__name__)
def test_the_error_of_mechanical_plus_dissipated_energy_falls_with_the_step(material, schedule, formulation):
    """Dissipation is recorded at the step of its stress in every schedule; one step off would be an error that does not fall."""
    drifts = []
    for courant in (0.2, 0.1):
        found, heat = vibrating(material, 1, MaterialPoint(schedule, formulation=formulation), courant, 1e-3)
        drifts.append(np.abs(found + heat - found[0]).max() / heat[-1])
    assert drifts[0] < 0.02
    assert drifts[1] < 0.6 * drifts[0]


@pytest.mark.parametrize(("transfer", "dimension"), [(FLIP, 2), (APIC, 2), (TPIC, 2), (APIC, 3)])
def test_the_angular_momentum_of_a_rotating_body_is_spin_times_moment_of_inertia(transfer, dimension):
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    spin = {"velocity": lambda X: 1e-3 * np.pad(np.stack([-X[:, 1], X[:, 0]], axis=1), ((0, 0), (0, dimension - 2)))}
    free, half = dict.fromkeys(names, Traction(Constant(0.0))), 0.5
    problem = Problem("box", (-half,) * dimension, (half,) * dimension, NeoHookean(*CONSTANTS), free, 0.5, spin)
    solution = MaterialPoint("USL", transfer, "quadratic", "total").solve(problem, Discretisation(1 / 8, 0.2, 2))
    assert solution.outcome.completed, str(solution.outcome)
    found = solution.histories["angular_momentum" if dimension == 2 else "angular_momentum_z"]
    assert found == pytest.approx(1e-3 / 6, rel=0.01)  # moment of inertia m (1 + 1)/12 of a unit square or cube
    for name in () if dimension == 2 else ("angular_momentum_x", "angular_momentum_y"):
        assert np.abs(solution.histories[name]).max() < 1e-12
