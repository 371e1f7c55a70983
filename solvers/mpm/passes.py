"""The passes of a step over the particles of a strip, up to four at a time."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..tracing import (
    Variable,
    add_sums,
    cond,
    equal,
    for_range,
    for_strides,
    load_rows,
    logical_not,
    maximum,
    minimum,
    reduce_sum,
    store_rows,
    traced,
    unpack,
    when,
    where,
)
from .affine import Uniform, gather_affine, spin_with, spread_momentum
from .deformation import force_columns, keeps_volume, move, stored_energy, strain, strain_and_stress
from .grid import leapfrog
from .histories import Outputs
from .order import Strips
from .reconstruction import not_fitted
from .state import (
    FAILED,
    HEAT,
    KINETIC,
    MOMENTUM,
    PASSED,
    STRAIN,
    Grid,
    Nodes,
    Particles,
    Scheme,
    Step,
    columns_of,
)
from .stencil import group, places, support_of
from .tensors import det
from .vectors import Vector, axpy, cross, dot, null, scale, with_mass

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"

USF, USL, MUSL = range(3)


@contextmanager
def groups(scheme: Scheme, grid: Grid, particles: Particles, begin: int, end: int) -> Iterator[tuple[Any, Any]]:
    """A loop over groups of particles that share a stencil: the group and its support."""
    with for_strides(begin, end) as (p, advance):
        some = group(scheme, grid, particles, p, end)
        with when(some.size > 0):
            yield some, support_of(grid, particles, some)
        advance(maximum(some.size, 1))


@traced
def spread_inertia(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, numbers, m, v: Vector, at) -> None:
    """m_I += m_p N_Ip, and p_I as of `spread_momentum`."""
    if isinstance(scheme.affine, Uniform):
        at.spread(grid, nodes.inertia, 0, with_mass(m, v))
    else:
        at.spread(grid, nodes.inertia, 0, (m,))
        spread_momentum(scheme, grid, particles, nodes, numbers, m, v, at)


@traced
def particles_to_grid(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int, step: Step
) -> int:
    """Mass, momentum and, if `step.forces`, forces of the particles to the grid; FAILED when a particle is not on the grid.

    m_I = sum_p m_p N_Ip and p_I = sum_p m_p N_Ip [v_p + C_p (x_I - x_p)] with the gradient C_p of an affine transfer. The internal
    force is -sum_p V_p sigma_p dN_Ip/dx, the external one sum_p m_p b_p N_Ip.
    """
    zero, state, passed, end = null(grid.lower)[0], particles.state, Variable(PASSED, s), strips.particles[s + 1]
    column = columns_of(zero, particles.deformation)
    with for_strides(strips.particles[s], end) as (p, advance):
        some = group(scheme, grid, particles, p, end)
        with when(some.size > 0):
            at = support_of(grid, particles, some)
            m, V = scale(not_fitted(grid, nodes, some), load_rows(state, some.numbers, column.mass, (0.0, 0.0)))
            v = load_rows(state, some.numbers, column.velocity, zero)
            spread_inertia(scheme, grid, particles, nodes, some.numbers, m, v, at)
            with when(step.forces):
                F, sigma = strain_and_stress(particles, some.numbers, zero)
                at.spread_tensor(grid, nodes.internal, 0, force_columns(scheme, V, sigma, F, zero))
            with when((step.body.shape[0] > 0) & logical_not(scheme.nodal_body)):
                b = load_rows(step.body[step.load], places(particles, some.numbers), 0, zero)
                at.spread(grid, nodes.external, 0, scale(m, b))
        passed.value = where(some.size > 0, passed.value, FAILED)
        advance(maximum(some.size, 1))
    return passed.value


@traced
def smooth(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int) -> int:
    """p_I += sum_p m_p N_Ip sum_J N_Jp t_J: a term of a series from the nodes to the particles and back."""
    with groups(scheme, grid, particles, strips.particles[s], strips.particles[s + 1]) as (some, at):
        m = (
            some.present
            * load_rows(particles.state, some.numbers, columns_of(grid.lower, particles.deformation).mass, (0.0,))[0]
        )
        at.spread(grid, nodes.inertia, 1, scale(m, at.gather(grid, nodes.term)))
    return PASSED


@traced
def grid_to_particles(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int, step: Step
) -> int:
    """If `step.record`, sums at t^n; then, if `step.advance`, the new velocities and, for some schedules, positions and stresses.

    v_p = flip (v_p + dt sum_I N_I a_I) + (1 - flip) sum_I N_I v_I, with the correction of XPIC; dt/2 at n = 0.

    - USF: x_p += dt sum_I N_I v_I.
    - USL: the same, then strain and stress.
    - MUSL: the new momentum to the grid; `strain_particles` does the rest.

    FAILED at J <= 0, STRAYED when a particle passes the limits of its strip.
    """
    zero = null(grid.lower)[0]
    column = columns_of(zero, particles.deformation)
    kick, leap = leapfrog(step.n, step.dt)
    passed, state = Variable(PASSED, s), particles.state
    limits, sums = strips.limits[s], strips.sums[s]
    with for_range(0, sums.shape[0]) as c:
        sums[c] = 0.0
    with groups(scheme, grid, particles, strips.particles[s], strips.particles[s + 1]) as (some, at):
        before = load_rows(state, some.numbers, column.velocity, zero)
        a = cond(step.record | (scheme.flip > 0), lambda: at.gather(grid, nodes.acceleration), zero)
        with when(step.record):
            m = some.present * load_rows(state, some.numbers, column.mass, (0.0,))[0]
            now, x = axpy(kick, a, before), load_rows(state, some.numbers, 0, zero)
            spin = spin_with(scheme, grid, particles, nodes, some.numbers, at, cross(x, now), kick)
            sums[KINETIC] += reduce_sum(0.5 * m * dot(now, now))
            sums[STRAIN] += reduce_sum(stored_energy(scheme, particles, some, zero))
            add_sums(sums, MOMENTUM, m, now)
            add_sums(sums, MOMENTUM + len(zero), m, spin)
        with when(step.advance):
            moved = at.gather(grid, nodes.velocity)
            gradient = at.gather_tensor(grid, nodes.velocity)
            affine = gather_affine(scheme, grid, nodes, at, gradient)
            v = axpy(scheme.flip, axpy(leap, a, before), scale(1 - scheme.flip, moved))
            if scheme.series is not None:
                v = cond(scheme.series.full_mass, v, lambda: axpy(1.0, at.gather(grid, nodes.projected), v))
            store_rows(state, some.numbers, column.velocity, v)
            store_rows(state, some.numbers, column.affine, affine)
            again = equal(scheme.schedule, MUSL)
            with when(again):
                m = some.present * load_rows(state, some.numbers, column.mass, (0.0,))[0]
                spread_momentum(scheme, grid, particles, nodes, some.numbers, m, v, at)
            with when(logical_not(again)):
                passed.value = minimum(passed.value, move(grid, state, some, scale(step.dt, moved), limits))
                with when(equal(scheme.schedule, USL)):
                    strained = strain(scheme, particles, some, scale(step.dt, gradient), step.dt, sums, zero)
                    passed.value = minimum(passed.value, strained)
    return passed.value


@traced
def strain_particles(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, strips: Strips, s: int, step: Step) -> int:
    """Strain and stress in a pass of their own: at the beginning of a step for USF, at its end for MUSL.

    - USF: from the velocities of the nodes before they are accelerated, then the internal forces.
    - MUSL: x_p += dt sum_I N_I v_I, then strain from the velocities of the momentum that was projected again.

    FAILED at J <= 0, STRAYED when a particle passes the limits of its strip.
    """
    zero = null(grid.lower)[0]
    column = columns_of(zero, particles.deformation)
    passed, first_of_all = Variable(PASSED, s), equal(scheme.schedule, USF)
    state, limits, sums = particles.state, strips.limits[s], strips.sums[s]
    sums[HEAT] = 0.0
    nodal = where(first_of_all, nodes.velocity, nodes.projected)
    with groups(scheme, grid, particles, strips.particles[s], strips.particles[s + 1]) as (some, at):
        gradient, moved = at.gather_tensor(grid, nodal), at.gather(grid, nodes.velocity)
        with when(logical_not(first_of_all)):
            passed.value = minimum(passed.value, move(grid, state, some, scale(step.dt, moved), limits))
        strained = strain(scheme, particles, some, scale(step.dt, gradient), step.dt, sums, zero)
        passed.value = minimum(passed.value, strained)
        with when(first_of_all):
            F, sigma = strain_and_stress(particles, some.numbers, zero)
            V = some.present * load_rows(state, some.numbers, column.volume, (0.0,))[0]
            at.spread_tensor(grid, nodes.internal, 0, force_columns(scheme, V, sigma, F, zero))
    return passed.value


@traced
def record_fields(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    outputs: Outputs,
    k: int,
    n: int,
    dt: float,
    begin: int,
    end: int,
) -> None:
    """Record u^n, sigma^n, volume and v^n = v^{n-1/2} + dt/2 sum_I N_I a_I as output k, in the order of the problem."""
    zero = null(grid.lower)[0]
    column = columns_of(zero, particles.deformation)
    kick, _ = leapfrog(n, dt)
    state = particles.state
    with groups(scheme, grid, particles, begin, end) as (some, at):
        at_place, x = places(particles, some.numbers), load_rows(state, some.numbers, 0, zero)
        now = axpy(kick, at.gather(grid, nodes.acceleration), load_rows(state, some.numbers, column.velocity, zero))
        store_rows(outputs.displacement[k], at_place, 0, axpy(-1.0, load_rows(particles.reference, at_place, 0, zero), x))
        store_rows(outputs.velocity[k], at_place, 0, now)
        F, sigma = strain_and_stress(particles, some.numbers, zero)
        store_rows(outputs.stress[k], at_place, 0, sigma)
        J = where(keeps_volume(scheme), 1.0, det(F))
        volumes = unpack(J * load_rows(state, some.numbers, column.volume, (0.0,))[0])
        for number, volume in zip(at_place, volumes, strict=True):
            outputs.volume[k, number] = volume
