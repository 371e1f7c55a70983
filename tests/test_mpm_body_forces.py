"""Body forces in spatial coordinates: motion of the centre of mass, sorted particles, and solvers that refuse them."""

from dataclasses import replace

import numpy as np
import pytest
from arrays import assert_close

from mpmverify.errors import UsageError
from mpmverify.problem import Block, Discretisation, LinearElastic, NeoHookean, Problem, Spatial, Traction, Velocity
from mpmverify.solvers.fem import FiniteElement
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint
from mpmverify.solvers.mpm import solver as mpm_solver
from mpmverify.solvers.taylor_galerkin import TaylorGalerkin

MATERIAL = NeoHookean(1.0, 1.0, 0.3)
FREE = dict.fromkeys(("x-", "x+", "y-", "y+"), Traction())


def spring(x, t):
    """Body force towards a point, in proportion to the distance and growing in time."""
    return (np.arange(1, x.shape[1] + 1) - 4 * x)[None] * (1 + t)[:, None, None]


@pytest.mark.parametrize("formulation", ["updated", "total"])
@pytest.mark.parametrize(("schedule", "transfer"), [("USL", APIC), ("MUSL", FLIP)])
@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_the_middle_of_a_body_follows_a_force_that_is_linear_in_space(dimension, schedule, transfer, formulation):
    """However the body deforms: x^{n+1} = x^n + dt v^{n+1/2}, v^{n+1/2} = v^{n-1/2} + dt b(x^n, t^n).

    But for what the nodes do not carry that have less than 1e-12 of a particle's mass.
    """
    names = [axis + side for axis in "xyz"[:dimension] for side in "-+"]
    shape, soft = Block((-0.3,) * dimension, (0.4,) * dimension), NeoHookean(5.0, 1.0, 0.3)
    box = (-1.0,) * dimension, (1.0,) * dimension
    free = dict.fromkeys(names, Traction())
    problem = Problem("spring", *box, soft, free, 0.5, {"velocity": np.sin}, Spatial(spring), shape=shape)
    solution = MaterialPoint(schedule, transfer, "quadratic", formulation).solve(problem, Discretisation(0.25, 0.3, 2))
    assert solution.outcome.completed, str(solution.outcome)
    mass = solution.weight[0] / shape.measure
    x, v = mass @ solution.reference, mass @ np.sin(solution.reference)
    places = [x]
    for n in range(solution.work.steps):
        b = spring(x[None], np.array([n * solution.dt]))[0, 0]
        v = v + (0.5 if n == 0 else 1.0) * solution.dt * b
        x = x + solution.dt * v
        places.append(x)
    found = np.einsum("p,tpk->tk", mass, solution.position)
    assert_close(found, np.array(places)[np.round(solution.time / solution.dt).astype(int)], abs=1e-11)


def test_a_force_in_spatial_coordinates_finds_particles_that_are_sorted(monkeypatch):
    """A block that flies over several strips of the box, in one strip and in many."""
    free, shape = dict.fromkeys(FREE, Traction()), Block((-0.3, -0.6), (0.3, -0.1))
    flying = {"velocity": lambda X: np.full_like(X, [0.0, 1.0])}
    problem = Problem("flight", (-1.0, -1.0), (1.0, 1.0), MATERIAL, free, 0.5, flying, Spatial(spring), shape=shape)
    solver, at = MaterialPoint("USL", APIC, "quadratic"), Discretisation(1 / 16, 0.3, 2)
    one = solver.solve(problem, at)
    monkeypatch.setattr(mpm_solver, "MANY", 1)
    several = solver.solve(problem, at)
    for name, values in one.fields.items():
        assert_close(several.fields[name], values, abs=1e-13 * np.abs(values).max(), said=name)


def test_only_material_points_take_a_force_in_spatial_coordinates():
    bar = Problem("bar", (0.0,), (1.0,), LinearElastic(1.0, 1.0), {"x-": Velocity(), "x+": Traction()}, 1.0)
    bar, at = replace(bar, body_force=Spatial(spring)), Discretisation(0.25, 0.5)
    for solver in (FiniteElement(), TaylorGalerkin()):
        with pytest.raises(UsageError, match="a body force in material coordinates"):
            solver.solve(bar, at)
    with pytest.raises(UsageError, match="in spatial coordinates at the particles only"):
        MaterialPoint(formulation="total", body_force_at="nodes").solve(bar, at)


@pytest.mark.parametrize("shape", [(4,), (4, 1), (1, 4), (4, 1, 2), (1, 4, 2, 1)])
def test_a_body_force_of_another_shape_is_refused(shape):
    """Compiled code does not look at the shape, and would read what lies beside the array."""

    def of_shape(x, t):
        return np.zeros([{4: len(x), 1: len(t)}.get(n, n) for n in shape])

    problem = Problem("shape", (0.0, 0.0), (1.0, 1.0), MATERIAL, FREE, 0.1, {"velocity": np.sin}, of_shape)
    with pytest.raises(UsageError, match="the body force has shape"):
        MaterialPoint("USL", formulation="total").solve(problem, Discretisation(0.25, 0.3, 2))
