"""The compiled time loop of the explicit material point method."""

from typing import Any

import numpy as np
from numba import njit, prange

from mpmverify.problem import Array

from .basis import Axis
from .compilation import SOURCES, WITHOUT_ENTRY, compiled
from .constitution import Constants
from .grid import accelerate, add_term, begin_series, clear, external_force_and_power, kick_nodes, leapfrog, nodal_velocity
from .histories import COMPLETED, INVERTED, LEFT_GRID, TURNED, UNSORTED, heat_of, record_histories
from .order import INTERVAL, Strips
from .passes import (
    FAILED,
    MUSL,
    PASSED,
    STRAYED,
    USF,
    USL,
    grid_to_particles,
    particles_to_grid,
    record_fields,
    smooth,
    strain_particles,
)
from .state import Faces, Grid, Histories, Nodes, Outputs, Particles, Scheme

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

TO_GRID, TO_PARTICLES, STRAIN_ALONE, SMOOTH = range(4)
MASSLESS = 1e-12
"""Nodes with less than this part of the largest particle's mass carry no velocity: f/m would overflow."""


@njit
def joined_axes(like, x: Axis, y: Axis, z: Axis):
    """As many axes as there are dimensions; it returns arrays, so references to them must be counted."""
    if len(like) == 1:
        return (x,)
    if len(like) == 2:
        return (x, y)
    return (x, y, z)


def sweep(
    kind: int,
    scheme: Scheme,
    grid: Grid,
    x: Axis,
    y: Axis,
    z: Axis,
    particles: Particles,
    nodes: Nodes,
    strips: Strips,
    body: Array,
    load: int,
    n: int,
    dt: float,
    choice: bool,
) -> int:
    """One pass over all strips, those of one colour at the same time; the worst of what it says of them.

    Notes
    -----
    A loop in threads takes arrays and flat tuples: what is nested is taken apart before and put together in it. In less than
    three dimensions the axes that are missing repeat the last one.
    """
    (schedule, affine, flip, terms, full_mass, total, nodal_body, law, constants) = scheme
    lame, shear, time = constants
    _, lower, scale, stride, width, ghosts, basis, least_squares, half, stretched = grid
    said, count = strips.passed, strips.passed.size
    for colour in range(2):
        for k in prange((count + 1 - colour) // 2):
            choices = Scheme(schedule, affine, flip, terms, full_mass, total, nodal_body, law, Constants(lame, shear, time))
            axes = joined_axes(lower, x, y, z)
            space = Grid(axes, lower, scale, stride, width, ghosts, basis, least_squares, half, stretched)
            s = 2 * k + colour
            first, stop = strips.particles[s], strips.particles[s + 1]
            if kind == TO_GRID:
                passed = particles_to_grid(choices, space, particles, nodes, body, load, choice, first, stop)
            elif kind == TO_PARTICLES:
                passed = grid_to_particles(
                    choices, space, particles, nodes, n, dt, choice, strips.limits[s], strips.sums[s], first, stop
                )
            elif kind == SMOOTH:
                passed = smooth(choices, space, particles, nodes, first, stop)
            else:
                passed = strain_particles(choices, space, particles, nodes, dt, strips.limits[s], strips.sums[s], first, stop)
            said[s] = passed
    worst = PASSED
    for s in range(count):
        worst = min(worst, said[s])
    return worst


def refine(
    scheme: Scheme,
    grid: Grid,
    x: Axis,
    y: Axis,
    z: Axis,
    particles,
    nodes,
    faces,
    strips,
    body,
    massless,
    values,
    total,
    force,
    added,
):
    """Add the terms 0 < j < k of sum_{j < k} (I - S^+ S)^j to `total` (n, d), from the velocities or accelerations `values` (n, d).

    S takes nodes to particles and S^+ back, with the lumped mass: the more terms, the closer comes the sum to what the full mass
    would have given.
    """
    begin_series(nodes, values)
    for _ in range(scheme.terms - 1):
        sweep(SMOOTH, scheme, grid, x, y, z, particles, nodes, strips, body, 0, 0, 0.0, True)
        add_term(grid, nodes, faces, massless, total, force, added)


def march(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    faces: Faces,
    strips: Strips,
    outputs: Outputs,
    histories: Histories,
    running: Array,
    dt: float,
    body: Array,
    begin: int,
    end: int,
    output: int,
    sources: int = SOURCES,
) -> tuple[int, int, int]:
    """Passes begin <= n < end of the scheme, each at x^n, F^n, sigma^n and v^{n-1/2}; pass N records and does not advance.

    Parameters
    ----------
    running : Array
        Power and work at t^{n-1}, energy given and turned into heat so far, impulse to t^{n-1/2} (4 + d,): carried from call to call.
    dt : float
        Time step [s].
    body : Array
        b at t^n of these passes, (end - begin, P, d) in the order of the problem or (end - begin, n, d) at nodes [m/s^2]; empty for
        none.
    output : int
        The next output.
    sources : int
        Not to be passed; see `SOURCES`.

    Returns
    -------
    tuple of int
        Status, the number of passes recorded since the start, and of outputs; UNSORTED when the particles are to be sorted before it
        goes on.

    References
    ----------
    Sulsky, Chen and Schreyer, 1994, doi:10.1016/0045-7825(94)90112-0; Sulsky, Zhou and Schreyer, 1995,
    doi:10.1016/0010-4655(94)00170-7; Bardenhagen, 2002, doi:10.1006/jcph.2002.7103 (USF and USL); Zhang, Chen and Liu, The
    Material Point Method, 2017 (the leapfrog form); de Vaucorbeil, Nguyen and Hutchinson, 2020,
    doi:10.1016/j.cma.2019.112783 (total Lagrangian).
    """
    massless = MASSLESS * particles.mass.max()
    count, last, strayed = strips.passed.size, histories.mass.size - 1, False
    x, y, z = grid.axes[0], grid.axes[min(1, len(grid.lower) - 1)], grid.axes[len(grid.lower) - 1]
    added, force = np.zeros(len(grid.lower)), np.zeros(len(grid.lower))
    for n in range(begin, end):
        if strayed or (count > 1 and n - begin == INTERVAL):
            return UNSORTED, n, output
        clear(nodes)
        load, forces = n - begin, scheme.schedule != USF or n == 0
        if sweep(TO_GRID, scheme, grid, x, y, z, particles, nodes, strips, body, load, n, dt, forces) == FAILED:
            return LEFT_GRID, n, output
        nodal_velocity(grid, nodes, faces, n, massless, nodes.velocity, added)
        if scheme.terms > 1:
            total = nodes.velocity
            if not scheme.full_mass:
                total = nodes.projected
                total[:] = 0.0
            refine(scheme, grid, x, y, z, particles, nodes, faces, strips, body, massless, nodes.velocity, total, False, added)
        if not forces:
            passed = sweep(STRAIN_ALONE, scheme, grid, x, y, z, particles, nodes, strips, body, load, n, dt, True)
            if passed == FAILED:
                return INVERTED, n, output
            running[TURNED] += heat_of(strips)
        accelerate(scheme, grid, nodes, faces, body, load, n, dt, massless)
        if scheme.full_mass:
            same = nodes.acceleration
            refine(scheme, grid, x, y, z, particles, nodes, faces, strips, body, massless, same, same, True, force)
        recording = outputs.step[output] == n
        if recording:
            record_fields(scheme, grid, particles, nodes, outputs, output, n, dt)
        kick, step = leapfrog(n, dt)
        power = external_force_and_power(grid, nodes, kick, force)
        kick_nodes(grid, nodes, step)
        passed = sweep(TO_PARTICLES, scheme, grid, x, y, z, particles, nodes, strips, body, load, n, dt, n < last)
        status = record_histories(scheme, grid, nodes, strips, histories, running, added, force, power, n, dt)
        if status != COMPLETED:
            return status, n, output
        output += recording
        if n == last:
            break
        if scheme.schedule == USL:
            running[TURNED] += heat_of(strips)
        if scheme.schedule == MUSL:
            nodal_velocity(grid, nodes, faces, n + 1, massless, nodes.projected, added)
            if scheme.full_mass:
                same = nodes.projected
                refine(scheme, grid, x, y, z, particles, nodes, faces, strips, body, massless, same, same, False, added)
            passed = sweep(STRAIN_ALONE, scheme, grid, x, y, z, particles, nodes, strips, body, load, n, dt, True)
            running[TURNED] += heat_of(strips)
        if passed == FAILED:
            return INVERTED, n + 1, output
        strayed = passed == STRAYED
    return COMPLETED, end, output


def _assembled(march: Any, of_sweep: dict[str, bool], **options: bool) -> Any:
    passes = {"sweep": compiled(sweep, {}, **WITHOUT_ENTRY, **of_sweep)}
    return compiled(
        march,
        passes | {"refine": compiled(refine, passes, **WITHOUT_ENTRY, **options)},
        cache=True,
        no_cfunc_wrapper=True,
        **options,
    )


march_in_threads = _assembled(march, {"parallel": True}, nogil=True)
march = _assembled(march, {})
