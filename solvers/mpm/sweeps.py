"""Passes over all particles and over all nodes, in one thread or in several: their parts do not depend on how many there are."""

from numba import prange

from mpmverify.problem import Array

from .constitution import Constants
from .grid import accelerate, clear, kick_nodes, nodal_velocity
from .order import Strips, arrange
from .passes import grid_to_particles, particles_to_grid, smooth, strain_particles
from .state import PASSED, Grid, Nodes, Particles, Scheme

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

TO_GRID, TO_PARTICLES, STRAIN_ALONE = (0.0,), (0.0, 0.0), (0.0, 0.0, 0.0)
SMOOTH, ARRANGE = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0)
CLEAR, VELOCITY, ACCELERATE, KICK = (0.0,), (0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
"""Passes over the particles and over the nodes; their lengths tell them apart where a function is compiled."""


def sweep(
    kind,
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    strips: Strips,
    body: Array,
    load: int,
    n: int,
    dt: float,
    record: bool,
    advance: bool,
) -> int:
    """One pass over all strips, those of one colour at the same time; the worst of what it says of them.

    Of the pass to the grid, `advance` says whether it takes the forces along.

    Notes
    -----
    A loop in threads takes arrays and flat tuples: what is nested is taken apart before and put together in it.
    """
    (schedule, affine, flip, series, terms, full_mass, total, nodal_body, law, constants) = scheme
    lame, shear, time = constants
    (lower, scale, cells, periodic, stride, width, padding, piece, polynomials, places, ghosts, basis, half, stretched) = grid
    said, count = strips.passed, strips.passed.size
    for colour in range(2):
        for k in prange((count + 1 - colour) // 2):
            choices = Scheme(
                schedule, affine, flip, series, terms, full_mass, total, nodal_body, law, Constants(lame, shear, time)
            )
            space = Grid(
                lower,
                scale,
                cells,
                periodic,
                stride,
                width,
                padding,
                piece,
                polynomials,
                places,
                ghosts,
                basis,
                half,
                stretched,
            )
            s = 2 * k + colour
            first, stop = strips.particles[s], strips.particles[s + 1]
            if len(kind) == 1:
                passed = particles_to_grid(choices, space, particles, nodes, body, load, advance, first, stop)
            elif len(kind) == 2:
                passed = grid_to_particles(
                    choices, space, particles, nodes, n, dt, record, advance, strips.limits[s], strips.sums[s], first, stop
                )
            elif len(kind) == 3:
                passed = strain_particles(choices, space, particles, nodes, dt, strips.limits[s], strips.sums[s], first, stop)
            elif len(kind) == 4:
                passed = smooth(choices, space, particles, nodes, first, stop)
            else:
                passed = arrange(choices, space, particles, strips, s, first, stop)
            said[s] = passed
    worst = PASSED
    for s in range(count):
        worst = min(worst, said[s])
    return worst


def sweep_nodes(
    kind,
    nodes: Nodes,
    strips: Strips,
    velocity: Array,
    massless: float,
    body: Array,
    load: int,
    kick: float,
    step: float,
    total: Array,
) -> None:
    """One pass over all nodes in as many parts as there are strips, and the sum of what the parts leave (n,)."""
    parts, count = strips.nodal.shape[0], nodes.inertia.shape[1]
    for k in prange(parts):
        begin, end = count * k // parts, count * (k + 1) // parts
        if len(kind) == 1:
            clear(nodes, begin, end)
        elif len(kind) == 2:
            nodal_velocity(nodes, velocity, massless, strips.nodal[k], begin, end)
        elif len(kind) == 3:
            accelerate(nodes, body, load, massless, begin, end)
        else:
            kick_nodes(nodes, kick, step, strips.nodal[k], begin, end)
    for c in range(total.size):
        total[c] = 0.0
        for k in range(parts):
            total[c] += strips.nodal[k, c]
