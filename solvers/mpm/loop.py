"""Compiled time loop of the explicit material point method."""

from functools import partial
from pathlib import Path
from types import SimpleNamespace

from mpmverify.problem import Array

from ..tracing import (
    Compiled,
    Variable,
    cond,
    equal,
    for_range,
    leavable,
    logical_not,
    maximum,
    outlined,
    traced,
    valued,
    when,
    where,
    while_loop,
)
from .faces import Faces
from .grid import (
    add_term,
    begin_series,
    clear_correction,
    hold_acceleration,
    hold_velocity,
    join,
    leapfrog,
    least_mass,
    load_faces,
    weigh,
)
from .histories import COMPLETED, INVERTED, LEFT_GRID, Histories, Outputs, add_heat, add_up, record_sums
from .order import ARRANGED, INTERVAL, UNSORTED, Strips
from .passes import MUSL, USF, USL, record_fields
from .state import FAILED, PASSED, STRAYED, Grid, Nodes, Particles, Scheme, Step, columns_of, full_mass
from .sweeps import IN_THREADS, IN_TURN
from .vectors import with_mass

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

SOURCES = Path(__file__).parent
"""Folder whose files the compiled loops are made of, beside those of the compiler."""


def refining(passes: SimpleNamespace):
    """Function that adds the terms of a series, see `refine`; its calls share one compiled function, which spares compilation."""

    @traced
    def refine(scheme, grid, particles, nodes, faces, strips, first, least, values, total, reaction, added) -> int:
        """Add the terms 0 < j < k of sum_{j < k} (I - S^+ S)^j to `total` (d, n), from the velocities or accelerations `values` (d, n).

        S maps nodes to particles and S^+ back, with the lumped mass: the more terms, the closer the sum comes to the result of the full
        mass matrix. `reaction` is 1 for accelerations and 0 for velocities, see `add_term`.
        """
        begin_series(grid, nodes, values)
        with for_range(1, scheme.series.terms) as _:
            passes.smooth(scheme, grid, particles, nodes, strips, first)
            add_term(grid, nodes, faces, least, total, reaction, added)
        return PASSED

    return outlined(refine)


@traced
def march_through(
    passes: SimpleNamespace,
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
    passes : SimpleNamespace
        The passes of a step, see `sweeps`, and `refine`.
    running : Array
        Sums carried from call to call (4 + d,): power and work at t^{n-1}, energy given to the body and turned into heat so far, and
        impulse to t^{n-1/2}.
    dt : float
        Time step [s].
    body : Array
        b at t^n of these steps, (end - begin, P, d) in the order of the problem or (end - begin, n, d) at nodes [m/s^2]; empty for
        none.
    begin, end : int
        Range of steps. A call without a step, before the first one, sorts the particles that threads work on.
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
    zero = grid.lower
    only_strip = valued(0, begin)  # passes in threads take all strips, whatever it says
    heaviest = Variable(0.0, like=dt)
    with for_range(0, particles.place.shape[0]) as p:
        heaviest.value = maximum(heaviest.value, particles.state[p, columns_of(zero, particles.deformation).mass])
    least, last, count = least_mass(grid, heaviest.value), faces.force.shape[1] - 1, nodes.inertia.shape[1]
    series, turns, velocity = scheme.series is not None, full_mass(scheme), nodes.velocity
    many = strips.passed.shape[0] > 1
    nothing, added = strips.total[0].head(0), strips.total[0].head(len(zero))
    sums_at_nodes = strips.total[1].head(2 + len(zero))
    # What the passes over the particles and those over the nodes take, and what `refine` does.
    state = scheme, grid, particles, nodes, strips, only_strip
    at_nodes = zero, nodes, strips
    refine = partial(passes.refine, scheme, grid, particles, nodes, faces, strips, only_strip, least)
    status = Variable(COMPLETED, like=begin)
    done = Variable(end)  # unless a step fails
    written = Variable(output)
    record = Variable(0, like=begin)
    passed = Variable(PASSED, like=begin)
    with when(many & equal(begin, end)):  # a particle off the grid is found again by the first step
        passes.sort(scheme, grid, particles, strips, begin)
    with while_loop(lambda: histories.step[record.value] < begin, like=begin):
        record.value += 1
    with leavable(begin) as leave, for_range(begin, end) as n:

        def stop(condition, code, steps) -> None:
            """End the run with a status after so many steps if a condition holds; `leave` alone ends the loop as it is."""
            with when(condition):
                status.value, done.value = code, steps
            leave(condition)

        sorted_at = strips.sorting[0]
        due = many & (equal(sorted_at, UNSORTED) | equal(n - sorted_at, INTERVAL))
        stop(equal(cond(due, lambda: passes.sort(scheme, grid, particles, strips, n), PASSED), FAILED), LEFT_GRID, n)
        with when(due | equal(n, 0) | (equal(n % ARRANGED, 0) & logical_not(scheme.total))):
            passes.arrange(*state)
        forces, recorded = logical_not(equal(scheme.schedule, USF)) | equal(n, 0), equal(histories.step[record.value], n)
        step = Step(body, n - begin, n, dt, recorded, forces, n < last)
        stop(equal(passes.to_grid(*state, step), FAILED), LEFT_GRID, n)
        join(grid, nodes.inertia, with_mass(0.0, zero))
        passes.nodal_velocity(*at_nodes, velocity, least, 0.0, 0.0, added, 0, count)
        hold_velocity(grid, nodes, faces, n, velocity, added)
        if series:
            with when(logical_not(turns)):
                clear_correction(zero, nodes)
            refine(velocity, where(turns, velocity, nodes.projected), valued(0.0, begin), added)
        with when(logical_not(forces)):
            stop(equal(passes.strain_particles(*state, step), FAILED), INVERTED, n)
            add_heat(strips, running)
        join(grid, nodes.internal, zero)
        join(grid, nodes.external, zero)
        weigh(scheme, zero, nodes, body, n - begin)
        passes.accelerate(*at_nodes, velocity, least, 0.0, 0.0, nothing, 0, count)
        load_faces(nodes, faces, least, n)
        hold_acceleration(grid, nodes, faces, n, dt)
        if series:
            with when(turns):
                refine(nodes.acceleration, nodes.acceleration, valued(1.0, begin), added)
        recording = equal(outputs.step[written.value], n)
        with when(recording):
            begin_at, end_at = strips.particles[0], strips.particles[-1]
            record_fields(scheme, grid, particles, nodes, outputs, written.value, n, dt, begin_at, end_at)
        kick, leap = leapfrog(n, dt)
        passes.kick_nodes(*at_nodes, velocity, least, kick, leap, sums_at_nodes, 0, count)
        add_up(zero, scheme, histories, record.value, running, added, sums_at_nodes, n, dt)
        passed.value = passes.grid_to_particles(*state, step)
        with when(recorded):
            sound = record_sums(zero, strips, histories, record.value, running)
            stop(logical_not(equal(sound, COMPLETED)), sound, n)
            record.value += 1
        written.value += where(recording, 1, 0)
        leave(equal(n, last))
        with when(equal(scheme.schedule, USL)):
            add_heat(strips, running)
        with when(equal(scheme.schedule, MUSL)):
            passes.fits_to_grid(*state, Step(body, n - begin, n, dt, recorded, valued(False, n), valued(True, n)))
            join(grid, nodes.inertia, with_mass(0.0, zero))
            passes.nodal_velocity(*at_nodes, nodes.projected, least, 0.0, 0.0, added, 0, count)
            hold_velocity(grid, nodes, faces, n + 1, nodes.projected, added)
            if series:
                with when(turns):
                    refine(nodes.projected, nodes.projected, valued(0.0, begin), added)
            passed.value = passes.strain_particles(*state, step)
            add_heat(strips, running)
        stop(equal(passed.value, FAILED), INVERTED, n + 1)
        strips.sorting[0] = where(equal(passed.value, STRAYED), UNSORTED, strips.sorting[0])
    return status.value, done.value, written.value


def _assembled(name: str, passes: SimpleNamespace) -> Compiled:
    """The loop with its passes."""
    return Compiled(partial(march_through, SimpleNamespace(**vars(passes), refine=refining(passes))), name, SOURCES)


march = _assembled("march", IN_TURN)
"""Loop in one thread, over one strip."""
march_in_threads = _assembled("march_in_threads", IN_THREADS)
"""Loop over several strips."""
