"""The problem of all benchmarks: a periodic box of linear elastic material whose particles move across cells."""

import math

import numpy as np

from mpmverify.problem import Array, Discretisation, LinearElastic, Periodic, Problem

MATERIAL = LinearElastic(youngs_modulus=1.0, density=1.0, poissons_ratio=0.3)
SPEED = 0.05
"""Amplitude of each sine in the velocity, relative to the speed of P waves [1]."""


def initial_velocity(points: Array) -> Array:
    """Initial velocity (P, d) [m/s]: v_k = v0 (sin 2 pi x_k + cos 2 pi x_{k+1})."""
    following = np.roll(points, -1, axis=1)
    return SPEED * MATERIAL.wave_speed * (np.sin(2 * math.pi * points) + np.cos(2 * math.pi * following))


def periodic_body(dimension: int, particles: float, steps: int, ppc: int = 2) -> tuple[Problem, Discretisation]:
    """Return the unit box of about `particles` particles, `ppc` per cell along each axis, for `steps` steps at Courant number 0.3.

    The particles are on a regular layout, and fields are returned at the first and last time only. Because the box is periodic, all
    shape functions of a spline basis are uniform.
    """
    h = 1 / round(particles ** (1 / dimension) / ppc)
    at = Discretisation(h, courant=0.3, ppc=ppc)
    faces = {axis + side: Periodic() for axis in "xyz"[:dimension] for side in "-+"}
    end = steps * at.courant * h / MATERIAL.wave_speed
    lower, upper = (0.0,) * dimension, (1.0,) * dimension
    return Problem("swaying", lower, upper, MATERIAL, faces, end, {"velocity": initial_velocity}, outputs=1), at
