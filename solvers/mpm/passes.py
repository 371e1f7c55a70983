"""The passes of a step over the particles from `begin` to `end`."""

from mpmverify.problem import Array

from .compilation import jit
from .constitution import dissipation, finite_strain, reference_stress, strain_energy, stress, viscous
from .grid import leapfrog
from .lanes import row, store
from .state import Grid, Nodes, Outputs, Particles, Scheme, columns_of
from .stencil import domain, moments, place, support, supported
from .tensors import Symmetric, Tensor, deform, det, full
from .transfer import gather, gather_gradients, gather_tensor, spread, spread_field, spread_tensor
from .vectors import Vector, axial, axpy, by_columns, columns, constant, cross, dot, null, quotient, scale, with_mass

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

USF, USL, MUSL = range(3)
NO_AFFINE, APIC, TPIC = (), (0.0,), (0.0, 0.0)
"""What of the velocity's variation about a particle is kept; their lengths tell them apart where a function is compiled."""
KINETIC, STRAIN, HEAT, MOMENTUM = range(4)
"""Columns of the sums of a pass; the momentum takes one for each direction, and then comes the angular momentum."""
FAILED, STRAYED, PASSED = range(3)
"""What a pass says of its particles."""


@jit
def spread_inertia(kind, grid: Grid, particles: Particles, nodes: Nodes, p: int, m: float, v: Vector, s: Vector, at) -> None:
    """m_I += m_p N_Ip, and the momentum."""
    if len(kind) == 0:
        spread(grid, nodes.inertia, 0, at, with_mass(m, v))
    else:
        spread(grid, nodes.inertia, 0, at, (m,))
        spread_momentum(kind, grid, particles, nodes, p, m, v, s, at)


@jit
def spread_momentum(kind, grid: Grid, particles: Particles, nodes: Nodes, p: int, m: float, v: Vector, s: Vector, at) -> None:
    """p_I += m_p N_Ip [v_p + B_p D_p^-1 (x_I - x_p)], where TPIC keeps the gradient C_p = B_p D_p^-1, and v_p alone when none is kept."""
    if len(kind) == 0:
        spread(grid, nodes.inertia, 1, at, scale(m, v))
    else:
        e, D = moments(grid, s, at)
        kept = row(particles.state, (p, columns_of(s).affine), null(s)[1])
        factor = constant(m, D) if len(kind) == 2 else quotient(m, D)
        spread_field(grid, nodes.inertia, 1, at[0], at[1], e, scale(m, v), columns(kept, factor))


@jit
def gather_affine(kind, grid: Grid, particles: Particles, nodes: Nodes, p: int, s: Vector, at, gradient) -> None:
    """B_p = sum_I v_I N_Ip (x_I - x_p)^T, or the gradient for TPIC; nothing when none is kept."""
    if len(kind) == 1:
        e, _ = moments(grid, s, at)
        store(particles.state, (p, columns_of(s).affine), gather_gradients(grid, nodes.velocity, at[0], at[1], e))
    elif len(kind) == 2:
        store(particles.state, (p, columns_of(s).affine), gradient)


@jit
def affine_spin(kind, grid: Grid, particles: Particles, p: int, s: Vector, at):
    """Angular momentum that a particle keeps about itself, per unit of its mass; zero when no B is kept."""
    if len(kind) == 0:
        return cross(s, null(s)[0])
    kept = row(particles.state, (p, columns_of(s).affine), null(s)[1])
    if len(kind) == 1:
        return axial(kept)
    return axial(by_columns(kept, moments(grid, s, at)[1]))


@jit
def force_columns(scheme: Scheme, V0: float, sigma: Symmetric, F: Tensor, like: Vector):
    """-V sigma by columns, or -V0 P in the total Lagrangian formulation."""
    if scheme.total:
        return columns(reference_stress(scheme.law, sigma, F), constant(-V0, like))
    return columns(full(sigma), constant(-V0 * det(F), like))


@jit
def particles_to_grid(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, body: Array, load: int, forces: bool, begin: int, end: int
) -> int:
    """m_I = sum_p m_p N_Ip, p_I = sum_p m_p N_Ip [v_p + B_p D_p^-1 (x_I - x_p)] and, with `forces`, f_I.

    Internal -sum_p V_p sigma_p dN_Ip/dx and external sum_p m_p b_p N_Ip. FAILED when a particle is not on the grid.
    """
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    for p in range(begin, end):
        s, F = place(scheme, grid, particles, p), row(particles.state, (p, column.F), tensor)
        shape = domain(grid.kind, grid, F)
        if not supported(grid.kind, grid, s, shape):
            return FAILED
        at = support(grid.kind, grid, s, shape)
        m, V = row(particles.state, (p, column.mass), (0.0, 0.0))
        v, sigma = row(particles.state, (p, column.velocity), zero), row(particles.state, (p, column.stress), symmetric)
        spread_inertia(scheme.affine, grid, particles, nodes, p, m, v, s, at)
        if forces:
            spread_tensor(grid, nodes.internal, 0, at, force_columns(scheme, V, sigma, F, zero))
        if body.shape[0] > 0 and not scheme.nodal_body:
            b = row(body, (load, particles.place[p], 0), zero)
            spread(grid, nodes.external, 0, at, scale(m, b))
    return PASSED


@jit
def smooth(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, begin: int, end: int) -> int:
    """p_I += sum_p m_p N_Ip sum_J N_Jp t_J: a term of the nodes, to the particles and back."""
    zero, tensor, _ = null(grid.lower)
    column = columns_of(zero)
    for p in range(begin, end):
        F, m = row(particles.state, (p, column.F), tensor), particles.state[p, column.mass]
        at = support(grid.kind, grid, place(scheme, grid, particles, p), domain(grid.kind, grid, F))
        spread(grid, nodes.inertia, 1, at, scale(m, gather(grid, nodes.term, at)))
    return PASSED


@jit
def strain(scheme: Scheme, sigma: Symmetric, F: Tensor, V0: float, increment: Tensor, dt: float):
    """F += dt dv/dX or F = (I + dt dv/dx) F, and the stress that the law makes of it.

    With both, whether that went well, which it does not at a law or a volume that meets J <= 0, and the energy that turned into heat.
    """
    after, heat = axpy(1.0, increment, F) if scheme.total else deform(increment, F), 0.0
    if viscous(scheme.law):
        heat = V0 * (1.0 if scheme.total else det(F)) * dissipation(scheme.law, scheme.constants, sigma, increment, dt)
    passed = det(after) > 0 or (scheme.total and not finite_strain(scheme.law))
    return after, stress(scheme.law, scheme.constants, sigma, after, increment, dt), heat, passed


@jit
def move(grid: Grid, x: Vector, increment: Vector, limits: Array):
    """X + dt v, and STRAYED when its last coordinate, on a periodic axis all its images, passes the limits (2,) [m]."""
    moved = axpy(1.0, increment, x)
    y, last = moved[-1], len(x) - 1
    if grid.periodic[last] and not limits[0] <= y <= limits[1]:
        length = grid.cells[last] / grid.scale
        y -= length * ((y - limits[0]) // length)
    return moved, PASSED if limits[0] <= y <= limits[1] else STRAYED


@jit
def stored_energy(scheme: Scheme, sigma: Symmetric, F: Tensor, V0: float) -> float:
    """Strain energy of a particle."""
    current = not scheme.total and not finite_strain(scheme.law)
    return V0 * (det(F) if current else 1.0) * strain_energy(scheme.law, scheme.constants, sigma, F)


@jit
def grid_to_particles(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    n: int,
    dt: float,
    record: bool,
    advance: bool,
    limits: Array,
    sums: Array,
    begin: int,
    end: int,
) -> int:
    """To `record`, sums at t^n; then, to `advance`, v_p = flip (v_p + dt sum_I N_I a_I) + (1 - flip) sum_I N_I v_I, with the correction
    of XPIC, and what else a step changes.

    Half of dt for the velocities at n = 0. USL: strain and stress. USF and USL: x_p += dt sum_I N_I v_I. MUSL: the new
    momentum goes to the grid, which leaves both to `strain_particles`. FAILED at J <= 0, STRAYED when a particle passes the limits of
    the strip (2,) [m].
    """
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    kick, step = leapfrog(n, dt)
    passed, last = PASSED, MOMENTUM + len(zero)
    for c in range(sums.size):
        sums[c] = 0.0
    for p in range(begin, end):
        s, F = place(scheme, grid, particles, p), row(particles.state, (p, column.F), tensor)
        at = support(grid.kind, grid, s, domain(grid.kind, grid, F))
        x, before = row(particles.state, (p, 0), zero), row(particles.state, (p, column.velocity), zero)
        sigma, (m, V0) = row(particles.state, (p, column.stress), symmetric), row(particles.state, (p, column.mass), (0.0, 0.0))
        a, moved = zero, gather(grid, nodes.velocity, at)
        if record or scheme.flip > 0:
            a = gather(grid, nodes.acceleration, at)
        gradient = gather_tensor(grid, nodes.velocity, at)
        if record:
            now, spin = axpy(kick, a, before), affine_spin(scheme.affine, grid, particles, p, s, at)
            sums[KINETIC] += 0.5 * m * dot(now, now)
            sums[STRAIN] += stored_energy(scheme, sigma, F, V0)
            add_scaled(sums, MOMENTUM, m, now)
            add_scaled(sums, last, m, axpy(1.0, cross(x, now), spin))
            if not advance:
                continue
        v = axpy(scheme.flip, axpy(step, a, before), scale(1 - scheme.flip, moved))
        if len(scheme.series) > 0 and not scheme.full_mass:
            v = axpy(1.0, gather(grid, nodes.projected, at), v)
        store(particles.state, (p, column.velocity), v)
        gather_affine(scheme.affine, grid, particles, nodes, p, s, at, gradient)
        if scheme.schedule == MUSL:
            spread_momentum(scheme.affine, grid, particles, nodes, p, m, v, s, at)
            continue
        x, kept = move(grid, x, scale(dt, moved), limits)
        store(particles.state, (p, 0), x)
        passed = min(passed, kept)
        if scheme.schedule == USL:
            F, sigma, heat, strained = strain(scheme, sigma, F, V0, scale(dt, gradient), dt)
            store(particles.state, (p, column.F), F)
            store(particles.state, (p, column.stress), sigma)
            sums[HEAT] += heat
            passed = passed if strained else FAILED
    return passed


@jit
def add_scaled(sums: Array, first: int, m: float, some: Vector) -> None:
    """Add m times a vector to an array from a place on."""
    for c in range(len(some)):
        sums[first + c] += m * some[c]


@jit
def strain_particles(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, dt: float, limits: Array, sums: Array, begin: int, end: int
) -> int:
    """A pass of its own for strain and stress: at the beginning of a step for USF, at its end for MUSL.

    USF: from the velocities of the grid before the kick, then the internal forces. MUSL: from those that were projected again,
    after x_p += dt sum_I N_I v_I. FAILED at J <= 0, STRAYED when a particle passes the limits of the strip (2,) [m].
    """
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    passed, first_of_all = PASSED, scheme.schedule == USF
    sums[HEAT] = 0.0
    nodal = nodes.velocity if first_of_all else nodes.projected
    for p in range(begin, end):
        s, F = place(scheme, grid, particles, p), row(particles.state, (p, column.F), tensor)
        sigma, V0 = row(particles.state, (p, column.stress), symmetric), particles.state[p, column.volume]
        at = support(grid.kind, grid, s, domain(grid.kind, grid, F))
        gradient = gather_tensor(grid, nodal, at)
        if not first_of_all:
            moved = gather(grid, nodes.velocity, at)
            x, kept = move(grid, row(particles.state, (p, 0), zero), scale(dt, moved), limits)
            store(particles.state, (p, 0), x)
            passed = min(passed, kept)
        F, sigma, heat, strained = strain(scheme, sigma, F, V0, scale(dt, gradient), dt)
        store(particles.state, (p, column.F), F)
        store(particles.state, (p, column.stress), sigma)
        sums[HEAT] += heat
        passed = passed if strained else FAILED
        if first_of_all:
            spread_tensor(grid, nodes.internal, 0, at, force_columns(scheme, V0, sigma, F, zero))
    return passed


@jit
def record_fields(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, outputs: Outputs, k: int, n: int, dt: float
) -> None:
    """u^n, sigma^n, volume and v^n = v^{n-1/2} + dt/2 sum_I N_I a_I, as output k in the order of the problem."""
    zero, tensor, symmetric = null(grid.lower)
    column = columns_of(zero)
    kick, _ = leapfrog(n, dt)
    for p in range(particles.place.size):
        s, F = place(scheme, grid, particles, p), row(particles.state, (p, column.F), tensor)
        at, q = support(grid.kind, grid, s, domain(grid.kind, grid, F)), particles.place[p]
        a, X = gather(grid, nodes.acceleration, at), row(particles.reference, (q, 0), zero)
        store(outputs.displacement, (k, q, 0), axpy(-1.0, X, row(particles.state, (p, 0), zero)))
        store(outputs.velocity, (k, q, 0), axpy(kick, a, row(particles.state, (p, column.velocity), zero)))
        store(outputs.stress, (k, q, 0), row(particles.state, (p, column.stress), symmetric))
        # A small-strain body in material coordinates keeps its volume; its J may even be negative.
        J = det(F) if finite_strain(scheme.law) or not scheme.total else 1.0
        outputs.volume[k, q] = particles.state[p, column.volume] * J
