"""Compiled time loop of the explicit material point method."""

from pathlib import Path
from typing import Any

from mpmverify.problem import Array

from ..tracing import WITHOUT_ENTRY, checksum, compiled
from .faces import Faces
from .grid import (
    accelerate,
    add_term,
    begin_series,
    hold_acceleration,
    hold_velocity,
    join,
    kick_nodes,
    leapfrog,
    least_mass,
    load_faces,
    nodal_velocity,
    weigh,
)
from .histories import COMPLETED, INVERTED, LEFT_GRID, Histories, Outputs, add_heat, add_up, record_sums
from .order import ARRANGED, INTERVAL, UNSORTED, Strips, arrange, sort
from .passes import MUSL, USF, USL, grid_to_particles, record_fields, smooth, strain_particles
from .state import (
    FAILED,
    STRAYED,
    Grid,
    Nodes,
    Particles,
    Scheme,
    Step,
    columns_of,
    full_mass,
)
from .sweeps import IN_THREADS, IN_TURN, fits_to_grid, to_grid
from .vectors import with_mass

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

SOURCES = checksum(Path(__file__).parent)
"""Checksum of this package and of its compiler, part of the names of the loops: the disk cache compiles them anew when a file changes."""


def refine(
    series,
    scheme,
    grid,
    particles,
    nodes,
    faces,
    strips,
    least,
    values,
    total,
    reaction,
    added,
):
    """Add the terms 0 < j < k of sum_{j < k} (I - S^+ S)^j to `total` (d, n), from the velocities or accelerations `values` (d, n).

    S maps nodes to particles and S^+ back, with the lumped mass: the more terms, the closer the sum comes to the result of the full
    mass matrix. `reaction` is 1 for accelerations and 0 for velocities, see `add_term`. Without a series nothing happens.
    """
    if series is not None:
        begin_series(grid, nodes, values)
        for _ in range(series.terms - 1):
            smooth(scheme, grid, particles, nodes, strips, 0)
            add_term(grid, nodes, faces, least, total, reaction, added)


def march_through(
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
) -> tuple[int, int, int]:
    """Steps begin <= n < end of the scheme, each from x^n, F^n or J^n, sigma^n and v^{n-1/2}; step N records and does not advance.

    Parameters
    ----------
    running : Array
        Sums carried from call to call (4 + d,): power and work at t^{n-1}, energy given to the body and turned into heat so far, and
        impulse to t^{n-1/2}.
    dt : float
        Time step [s].
    body : Array
        b at t^n of these steps, (end - begin, P, d) in the order of the problem or (end - begin, n, d) at nodes [m/s^2]; empty for
        none.
    output : int
        Index of the next output.

    Returns
    -------
    tuple of int
        Status, the number of steps completed since the start, and the number of outputs written.

    References
    ----------
    Sulsky, Chen and Schreyer, 1994, doi:10.1016/0045-7825(94)90112-0; Sulsky, Zhou and Schreyer, 1995,
    doi:10.1016/0010-4655(94)00170-7; Bardenhagen, 2002, doi:10.1006/jcph.2002.7103 (USF and USL); Zhang, Chen and Liu, The
    Material Point Method, 2017 (the leapfrog form); de Vaucorbeil, Nguyen and Hutchinson, 2020,
    doi:10.1016/j.cma.2019.112783 (total Lagrangian).
    """
    heaviest = 0.0
    for p in range(particles.place.size):
        heaviest = max(heaviest, particles.state[p, columns_of(grid.lower, particles.deformation).mass])
    least, last, count = least_mass(grid, heaviest), faces.force.shape[1] - 1, nodes.inertia.shape[1]
    many, series, turns = strips.passed.size > 1, scheme.series, full_mass(scheme)
    velocity, nodal_body = nodes.velocity, body if scheme.nodal_body else body[:0]
    zero = grid.lower
    nothing, added, sums_at_nodes = (
        strips.total[0, :0],
        strips.total[0, : len(grid.lower)],
        strips.total[1, : 2 + len(grid.lower)],
    )
    if many and begin == end:  # the call that compiles
        sort(scheme, grid, particles, strips, begin)
    record = 0
    while histories.step[record] < begin:
        record += 1
    for n in range(begin, end):
        due = many and (strips.sorting[0] == UNSORTED or n - strips.sorting[0] == INTERVAL)
        if due and sort(scheme, grid, particles, strips, n) == FAILED:
            return LEFT_GRID, n, output
        if due or n == 0 or (n % ARRANGED == 0 and not scheme.total):
            arrange(scheme, grid, particles, nodes, strips, 0)
        forces, recorded = scheme.schedule != USF or n == 0, histories.step[record] == n
        step = Step(body, n - begin, n, dt, recorded, forces, n < last)
        if to_grid(scheme, grid, particles, nodes, strips, 0, step) == FAILED:
            return LEFT_GRID, n, output
        join(grid, nodes.inertia, with_mass(0.0, zero))
        nodal_velocity(zero, nodes, strips, velocity, least, 0.0, 0.0, added, 0, count)
        hold_velocity(grid, nodes, faces, n, velocity, added)
        sums = velocity if turns else nodes.projected
        if series is not None and not turns:
            sums[:] = 0.0
        refine(series, scheme, grid, particles, nodes, faces, strips, least, velocity, sums, 0.0, added)
        if not forces:
            passed = strain_particles(scheme, grid, particles, nodes, strips, 0, step)
            if passed == FAILED:
                return INVERTED, n, output
            add_heat(strips, running)
        join(grid, nodes.internal, zero)
        join(grid, nodes.external, zero)
        weigh(zero, nodes, nodal_body, n - begin)
        accelerate(zero, nodes, strips, velocity, least, 0.0, 0.0, nothing, 0, count)
        load_faces(nodes, faces, least, n)
        hold_acceleration(grid, nodes, faces, n, dt)
        if turns:
            sums = nodes.acceleration
            refine(series, scheme, grid, particles, nodes, faces, strips, least, sums, sums, 1.0, added)
        recording = outputs.step[output] == n
        if recording:
            first, stop = strips.particles[0], strips.particles[-1]
            record_fields(scheme, grid, particles, nodes, outputs, output, n, dt, first, stop)
        kick, leap = leapfrog(n, dt)
        kick_nodes(zero, nodes, strips, velocity, least, kick, leap, sums_at_nodes, 0, count)
        add_up(zero, scheme, histories, record, running, added, sums_at_nodes, n, dt)
        passed = grid_to_particles(scheme, grid, particles, nodes, strips, 0, step)
        if recorded:
            status = record_sums(zero, strips, histories, record, running)
            if status != COMPLETED:
                return status, n, output
            record += 1
        output += recording
        if n == last:
            break
        if scheme.schedule == USL:
            add_heat(strips, running)
        if scheme.schedule == MUSL:
            fits_to_grid(scheme, grid, particles, nodes, strips, 0, Step(body, n - begin, n, dt, recorded, False, True))
            join(grid, nodes.inertia, with_mass(0.0, zero))
            nodal_velocity(zero, nodes, strips, nodes.projected, least, 0.0, 0.0, added, 0, count)
            hold_velocity(grid, nodes, faces, n + 1, nodes.projected, added)
            if turns:
                sums = nodes.projected
                refine(series, scheme, grid, particles, nodes, faces, strips, least, sums, sums, 0.0, added)
            passed = strain_particles(scheme, grid, particles, nodes, strips, 0, step)
            add_heat(strips, running)
        if passed == FAILED:
            return INVERTED, n + 1, output
        if passed == STRAYED:
            strips.sorting[0] = UNSORTED
    return COMPLETED, end, output


def _assembled(name: str, passes: dict[str, Any], **options: bool) -> Any:
    """The loop with its passes, without reference counting: it allocates nothing, and reference counting would double the compilation time."""
    name = f"{name}_{SOURCES:08x}"
    series = compiled(refine, passes, f"refine_of_{name}", **WITHOUT_ENTRY, _nrt=False)
    return compiled(march_through, passes | {"refine": series}, name, cache=True, no_cfunc_wrapper=True, _nrt=False, **options)


march = _assembled("march", IN_TURN)
"""Loop in one thread, over one strip."""
march_in_threads = _assembled("march_in_threads", IN_THREADS, nogil=True)
"""Loop over several strips; call `numba.get_num_threads()`, which starts the threads, before its first call in a process."""
