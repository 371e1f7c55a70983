"""Passes over all particles and over all nodes in threads: their parts do not depend on how many there are."""

from typing import Any

from numba import prange

from mpmverify.problem import Array

from .compilation import WITHOUT_ENTRY, compiled
from .constitution import Constants
from .grid import accelerate, clear, kick_nodes, nodal_velocity
from .order import arrange
from .passes import grid_to_particles, particles_to_grid, smooth, strain_particles
from .reconstruction import fit_cells, spread_fits
from .state import PASSED, Grid, Nodes, Particles, Scheme, Strips
from .vectors import Vector

OF_PARTICLES: tuple[Any, ...] = (
    particles_to_grid,
    grid_to_particles,
    strain_particles,
    smooth,
    arrange,
    fit_cells,
    spread_fits,
)
OF_NODES: tuple[Any, ...] = (clear, nodal_velocity, accelerate, kick_nodes)


def _over_strips(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    strips: Strips,
    s: int,
    body: Array,
    load: int,
    n: int,
    dt: float,
    record: bool,
    advance: bool,
) -> int:
    """One pass over all strips from s on, those of one colour at the same time; the worst of what it says of them.

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
            number = s + 2 * k + colour
            passed = one_pass(choices, space, particles, nodes, strips, number, body, load, n, dt, record, advance)
            said[number] = passed
    worst = PASSED
    for number in range(count):
        worst = min(worst, said[number])
    return worst


def _over_parts(
    zero: Vector,
    nodes: Nodes,
    strips: Strips,
    velocity: Array,
    massless: float,
    kick: float,
    step: float,
    sums: Array,
    begin: int,
    end: int,
) -> None:
    """One pass over the nodes in as many parts as there are strips, and the sum of what the parts leave."""
    parts = strips.nodal.shape[0]
    for k in prange(parts):
        first, stop = begin + (end - begin) * k // parts, begin + (end - begin) * (k + 1) // parts
        one_pass(zero, nodes, strips, velocity, massless, kick, step, strips.nodal[k], first, stop)
    for c in range(sums.size):
        sums[c] = 0.0
        for k in range(parts):
            sums[c] += strips.nodal[k, c]


one_pass: Any = None
"""In a loop over strips or parts the pass that it is compiled for."""


def name_of(one: Any) -> str:
    """Name of a function, compiled or traced."""
    return str(getattr(one, "py_func", one).__name__)


def _in_threads(over: Any, one: Any) -> Any:
    return compiled(over, {"one_pass": one}, f"{over.__name__}_{name_of(one)}", **WITHOUT_ENTRY, parallel=True)


IN_THREADS = {name_of(one): _in_threads(_over_strips, one) for one in OF_PARTICLES} | {
    name_of(one): _in_threads(_over_parts, one) for one in OF_NODES
}
"""The passes by name."""
