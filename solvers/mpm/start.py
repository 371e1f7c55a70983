"""Particles in the initial state of a body."""

import numpy as np

from mpmverify.problem import Array, LinearElastic, Problem

from .state import Particles, columns_of


def particles_at_start(problem: Problem, reference: Array, volume: Array, whole: bool, affine: bool) -> Particles:
    """Particles at reference positions (P, d) [m] with volumes (P,) [m^d], displaced and stressed as the body begins.

    Parameters
    ----------
    problem : Problem
    reference, volume : Array
    whole : bool
        Whether they keep the whole deformation gradient, or its determinant alone.
    affine : bool
        Whether they keep an affine part of the velocity, which is zero at first.
    """
    assert isinstance(problem.material, LinearElastic)
    count, dimension = reference.shape
    F = np.eye(dimension) + problem.initial_field("displacement_gradient", reference).reshape(-1, dimension, dimension)
    deformation = (0.0,) * (dimension**2 if whole else 1)
    state = np.zeros((count, columns_of((0.0,) * dimension, deformation).affine + (dimension**2 if affine else 0)))
    numbers = np.arange(count, dtype=np.int64)
    particles = Particles(numbers, reference, state, numbers.copy(), deformation)
    particles.position[:] = reference + problem.initial_field("displacement", reference)
    particles.velocity[:] = problem.initial_field("velocity", reference)
    particles.F[:] = F.reshape(count, -1) if whole else np.linalg.det(F)[:, None]
    particles.stress[:] = problem.initial_field("stress", reference)
    particles.mass[:], particles.volume[:] = problem.material.density * volume, volume
    return particles
