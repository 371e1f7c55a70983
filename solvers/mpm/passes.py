"""The passes of a step over the particles of a strip, up to four at a time.

All take the same: how many steps the `load` is on in the block of body forces, the step n, and whether to `record` it and to `advance`.
"""

from mpmverify.problem import Array

from .affine import NO_AFFINE, gather_affine, spin_with, spread_momentum
from .compilation import jit
from .constitution import finite_strain
from .deformation import force_columns, move, stored_energy, strain
from .grid import leapfrog
from .lanes import total
from .memory import add_totals, row, rows, store_rows
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
    Outputs,
    Particles,
    Scheme,
    Strips,
    columns_of,
)
from .stencil import domain, group, places, support
from .tensors import det
from .tracing import traced
from .transfer import gather, gather_tensor, spread, spread_tensor
from .vectors import Vector, axpy, cross, dot, null, scale, with_mass

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

USF, USL, MUSL = range(3)


@jit
def stencil_of(scheme: Scheme, grid: Grid, particles: Particles, p: int, end: int):
    """The particles from p on that one stencil serves, and their support."""
    some = group(grid.kind, scheme, grid, particles, p, end)
    F = rows(particles.state, some.numbers, columns_of(grid.lower).F, null(grid.lower)[1])
    return some, support(grid, some.first, some.offset, domain(grid, F))


@traced
def spread_inertia(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, numbers, m, v: Vector, at) -> None:
    """m_I += m_p N_Ip, and the momentum."""
    if len(scheme.affine) == len(NO_AFFINE):
        spread(grid, nodes.inertia, 0, at, with_mass(m, v))
    else:
        spread(grid, nodes.inertia, 0, at, (m,))
        spread_momentum(scheme, grid, particles, nodes, numbers, m, v, at)


@jit
def particles_to_grid(
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
    """m_I = sum_p m_p N_Ip, p_I = sum_p m_p N_Ip [v_p + B_p D_p^-1 (x_I - x_p)] and, unless USF has yet to `advance` the strain, f_I.

    Internal -sum_p V_p sigma_p dN_Ip/dx and external sum_p m_p b_p N_Ip. FAILED when a particle is not on the grid.
    """
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    state, p, end = particles.state, strips.particles[s], strips.particles[s + 1]
    while p < end:
        some = group(grid.kind, scheme, grid, particles, p, end)
        if some.size == 0:
            return FAILED
        F = rows(state, some.numbers, column.F, tensor)
        at = support(grid, some.first, some.offset, domain(grid, F))
        m, V = scale(not_fitted(grid, nodes, some), rows(state, some.numbers, column.mass, (0.0, 0.0)))
        v, sigma = rows(state, some.numbers, column.velocity, zero), rows(state, some.numbers, column.stress, symmetric)
        spread_inertia(scheme, grid, particles, nodes, some.numbers, m, v, at)
        if advance:
            spread_tensor(grid, nodes.internal, 0, at, force_columns(scheme, V, sigma, F, zero))
        if body.shape[0] > 0 and not scheme.nodal_body:
            b = rows(body[load], places(particles, some.numbers), 0, zero)
            spread(grid, nodes.external, 0, at, scale(m, b))
        p += some.size
    return PASSED


@jit
def smooth(
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
    """p_I += sum_p m_p N_Ip sum_J N_Jp t_J: a term of the nodes, to the particles and back."""
    p, end = strips.particles[s], strips.particles[s + 1]
    while p < end:
        some, at = stencil_of(scheme, grid, particles, p, end)
        m = some.present * rows(particles.state, some.numbers, columns_of(grid.lower).mass, (0.0,))[0]
        spread(grid, nodes.inertia, 1, at, scale(m, gather(grid, nodes.term, at)))
        p += max(some.size, 1)
    return PASSED


@jit
def grid_to_particles(
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
    """To `record`, sums at t^n; then, to `advance`, v_p = flip (v_p + dt sum_I N_I a_I) + (1 - flip) sum_I N_I v_I, with the correction
    of XPIC, and what else a step changes.

    Half of dt for the velocities at n = 0. USL: strain and stress. USF and USL: x_p += dt sum_I N_I v_I. MUSL: the new
    momentum goes to the grid, which leaves both to `strain_particles`. FAILED at J <= 0, STRAYED when a particle passes the limits of
    the strip (2,) [m].
    """
    zero, _, _ = null(grid.lower)
    column = columns_of(zero)
    kick, step = leapfrog(n, dt)
    passed, state, p, end = PASSED, particles.state, strips.particles[s], strips.particles[s + 1]
    limits, sums = strips.limits[s], strips.sums[s]
    for c in range(sums.size):
        sums[c] = 0.0
    while p < end:
        some, at = stencil_of(scheme, grid, particles, p, end)
        before = rows(state, some.numbers, column.velocity, zero)
        moved = gather(grid, nodes.velocity, at)
        a = moved
        if record or scheme.flip > 0:
            a = gather(grid, nodes.acceleration, at)
        gradient = gather_tensor(grid, nodes.velocity, at)
        affine = gather_affine(scheme, grid, nodes, at, gradient)
        if record:
            m = some.present * rows(state, some.numbers, column.mass, (0.0,))[0]
            now, x = axpy(kick, a, before), rows(state, some.numbers, 0, zero)
            spin = spin_with(scheme, grid, particles, some.numbers, at, cross(x, now))
            sums[KINETIC] += total(0.5 * m * dot(now, now))
            for k in range(p, p + some.size):
                sums[STRAIN] += stored_energy(scheme, particles, particles.order[k], zero)
            add_totals(sums, MOMENTUM, m, now)
            add_totals(sums, MOMENTUM + len(zero), m, spin)
        if advance:
            v = axpy(scheme.flip, axpy(step, a, before), scale(1 - scheme.flip, moved))
            if len(scheme.series) > 0 and not scheme.full_mass:
                v = axpy(1.0, gather(grid, nodes.projected, at), v)
            store_rows(state, some.numbers, column.velocity, v)
            store_rows(state, some.numbers, column.affine, affine)
            if scheme.schedule == MUSL:
                m = some.present * rows(state, some.numbers, column.mass, (0.0,))[0]
                spread_momentum(scheme, grid, particles, nodes, some.numbers, m, v, at)
            else:
                passed = min(passed, move(grid, state, some, scale(dt, moved), limits))
                if scheme.schedule == USL:
                    passed = min(passed, strain(scheme.law, scheme, particles, p, some, scale(dt, gradient), dt, sums, zero))
        p += max(some.size, 1)
    return passed


@jit
def strain_particles(
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
    """A pass of its own for strain and stress: at the beginning of a step for USF, at its end for MUSL.

    USF: from the velocities of the grid before the kick, then the internal forces. MUSL: from those that were projected again,
    after x_p += dt sum_I N_I v_I. FAILED at J <= 0, STRAYED when a particle passes the limits of the strip (2,) [m].
    """
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    passed, first_of_all = PASSED, scheme.schedule == USF
    state, p, end = particles.state, strips.particles[s], strips.particles[s + 1]
    limits, sums = strips.limits[s], strips.sums[s]
    sums[HEAT] = 0.0
    nodal = nodes.velocity if first_of_all else nodes.projected
    while p < end:
        some, at = stencil_of(scheme, grid, particles, p, end)
        gradient, moved = gather_tensor(grid, nodal, at), gather(grid, nodes.velocity, at)
        if not first_of_all:
            passed = min(passed, move(grid, state, some, scale(dt, moved), limits))
        passed = min(passed, strain(scheme.law, scheme, particles, p, some, scale(dt, gradient), dt, sums, zero))
        if first_of_all:
            F, sigma = rows(state, some.numbers, column.F, tensor), rows(state, some.numbers, column.stress, symmetric)
            V = some.present * rows(state, some.numbers, column.volume, (0.0,))[0]
            spread_tensor(grid, nodes.internal, 0, at, force_columns(scheme, V, sigma, F, zero))
        p += max(some.size, 1)
    return passed


@jit
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
    """u^n, sigma^n, volume and v^n = v^{n-1/2} + dt/2 sum_I N_I a_I, as output k in the order of the problem."""
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    kick, _ = leapfrog(n, dt)
    state, p = particles.state, begin
    while p < end:
        some, at = stencil_of(scheme, grid, particles, p, end)
        at_place, x = places(particles, some.numbers), rows(state, some.numbers, 0, zero)
        now = axpy(kick, gather(grid, nodes.acceleration, at), rows(state, some.numbers, column.velocity, zero))
        store_rows(outputs.displacement[k], at_place, 0, axpy(-1.0, rows(particles.reference, at_place, 0, zero), x))
        store_rows(outputs.velocity[k], at_place, 0, now)
        store_rows(outputs.stress[k], at_place, 0, rows(state, some.numbers, column.stress, symmetric))
        # A small-strain body in material coordinates keeps its volume; its J may even be negative.
        keeps = scheme.total and not finite_strain(scheme.law)
        for j in range(some.size):
            q = particles.order[p + j]
            J = 1.0 if keeps else det(row(state, (q, column.F), tensor))
            outputs.volume[k, particles.place[q]] = state[q, column.volume] * J
        p += max(some.size, 1)
