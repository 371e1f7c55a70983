"""The body that all benchmarks solve: a periodic box of linear elastic material, moved by a wave through more than a cell."""

import math

import numpy as np

from mpmverify.problem import Array, Discretisation, LinearElastic, Periodic, Problem

MATERIAL = LinearElastic(youngs_modulus=1.0, density=1.0, poissons_ratio=0.3)
SPEED = 0.05
"""Largest velocity of a sine, by the speed of P waves [1]."""


def swaying(points: Array) -> Array:
    """Velocity (P, d) [m/s]: v_k = v0 (sin 2 pi x_k + cos 2 pi x_{k+1})."""
    following = np.roll(points, -1, axis=1)
    return SPEED * MATERIAL.wave_speed * (np.sin(2 * math.pi * points) + np.cos(2 * math.pi * following))


def periodic_body(dimension: int, particles: float, steps: int, ppc: int = 2) -> tuple[Problem, Discretisation]:
    """Unit box of about so many particles, `ppc` along each axis of a cell, for a number of steps at a Courant number of 0.3.

    Every function of the grid is a uniform spline, the layout is regular, and fields are returned at the first and last time only.
    """
    h = 1 / round(particles ** (1 / dimension) / ppc)
    at = Discretisation(h, courant=0.3, ppc=ppc)
    faces = {axis + side: Periodic() for axis in "xyz"[:dimension] for side in "-+"}
    end = steps * at.courant * h / MATERIAL.wave_speed
    lower, upper = (0.0,) * dimension, (1.0,) * dimension
    return Problem("swaying", lower, upper, MATERIAL, faces, end, {"velocity": swaying}, outputs=1), at
