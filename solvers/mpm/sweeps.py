"""The passes of a step as the time loop calls them: in one thread, or in several over strips of particles and parts of the nodes.

The strips and parts do not depend on the number of threads, and so neither do the results.
"""

from functools import wraps
from types import SimpleNamespace
from typing import Any

from ..tracing import for_range, outlined, parallel_for, traced, where
from .fits import POPULATION
from .grid import accelerate, clear, kick_nodes, nodal_velocity
from .order import arrange, no_sort, sort
from .passes import grid_to_particles, particles_to_grid, smooth, strain_particles
from .reconstruction import fit_cells, spread_fits
from .state import PASSED

# Numbers, lanes and arrays of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"


def _over_strips(one: Any) -> Any:
    """A pass over all strips, in parallel over those of one colour; it returns the minimum status over the strips."""

    @wraps(one)
    def over_strips(scheme, grid, particles, nodes, strips, _, *step):
        passed = strips.passed
        count = passed.shape[0]
        with for_range(0, where(count > 1, 2, 1)) as colour:
            shared = colour, scheme, grid, particles, nodes, strips, *step
            with parallel_for((count + 1 - colour) // 2, shared) as (k, there):
                of_strip(k, *there)
        with for_range(1, count) as s:
            passed[0] = where(passed[s] < passed[0], passed[s], passed[0])
        return passed[0]

    def of_strip(k, colour, scheme, grid, particles, nodes, strips, *step):
        s = 2 * k + colour
        strips.passed[s] = one(scheme, grid, particles, nodes, strips, s, *step)

    return traced(over_strips)


def _over_parts(one: Any) -> Any:
    """A pass over the nodes, in parallel over as many parts as there are strips; its sums are those over the parts."""

    @wraps(one)
    def over_parts(zero, nodes, strips, velocity, least, kick, leap, sums, begin, end):
        parts = strips.nodal.shape[0]
        with parallel_for(parts, (zero, nodes, strips, velocity, least, kick, leap, begin, end)) as (k, there):
            of_part(k, *there)
        with for_range(0, sums.shape[0]) as c:
            sums[c] = 0.0
            with for_range(0, parts) as k:
                sums[c] += strips.nodal[k, c]

    def of_part(k, zero, nodes, strips, velocity, least, kick, leap, begin, end):
        parts, count = strips.nodal.shape[0], end - begin
        first, last = begin + count * k // parts, begin + count * (k + 1) // parts
        one(zero, nodes, strips, velocity, least, kick, leap, strips.nodal[k], first, last)

    return traced(over_parts)


def _with_grid(of_particles: list[Any], of_nodes: list[Any], sort: Any) -> SimpleNamespace:
    """Passes, with `sort`, `to_grid`, which combines all passes to the grid, and `fits_to_grid`, the same once more for fitted bases."""
    passes = {one.__name__: one for one in of_particles + of_nodes}

    def all_to_grid(scheme, grid, particles, nodes, strips, s, step) -> int:
        passes["clear"](grid.lower, nodes, strips, nodes.velocity, 0.0, 0.0, 0.0, strips.total[0], 0, nodes.inertia.shape[1])
        if grid.kind.fitted:
            with for_range(0, nodes.cells.shape[0]) as c:
                nodes.cells[c, POPULATION] = 0.0
            passes["fit_cells"](scheme, grid, particles, nodes, strips, s, step)
            passes["spread_fits"](scheme, grid, particles, nodes, strips, s, step)
        return passes["particles_to_grid"](scheme, grid, particles, nodes, strips, s, step)

    twice = outlined(all_to_grid)

    def to_grid(scheme, grid, particles, nodes, strips, s, step) -> int:
        once = twice if grid.kind.fitted else all_to_grid
        return once(scheme, grid, particles, nodes, strips, s, step)

    def fits_to_grid(scheme, grid, particles, nodes, strips, s, step) -> int:
        return twice(scheme, grid, particles, nodes, strips, s, step) if grid.kind.fitted else PASSED

    more = {"to_grid": traced(to_grid), "fits_to_grid": traced(fits_to_grid), "sort": sort}
    return SimpleNamespace(**passes | more | {"strain_particles": outlined(passes["strain_particles"])})


OF_PARTICLES = [particles_to_grid, grid_to_particles, strain_particles, smooth, arrange, fit_cells, spread_fits]
OF_NODES = [clear, nodal_velocity, accelerate, kick_nodes]
IN_TURN = _with_grid(OF_PARTICLES, OF_NODES, no_sort)
"""Passes of the loop in one thread, over one strip."""
IN_THREADS = _with_grid([_over_strips(one) for one in OF_PARTICLES], [_over_parts(one) for one in OF_NODES], outlined(sort))
"""Passes of the loop in several threads, over several strips."""
