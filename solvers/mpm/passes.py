"""The passes of a step over the particles from `begin` to `end`."""

from mpmverify.problem import Array

from .compilation import jit
from .constitution import dissipation, finite_strain, reference_stress, strain_energy, stress
from .grid import leapfrog
from .state import Grid, Nodes, Outputs, Particles, Scheme
from .stencil import affine_stencil, local, place, support, supported
from .tensors import deform, det, full
from .transfer import gather, gather_gradients, gather_tensor, spread, spread_gradients, spread_tensor
from .vectors import Vector, axial, axpy, by_columns, columns, constant, cross, dot, null, row, scale, store, with_mass

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

USF, USL, MUSL = range(3)
NO_AFFINE, APIC, TPIC = range(3)
KINETIC, STRAIN, HEAT, MOMENTUM = range(4)
"""Columns of the sums of a pass; the momentum takes one for each direction, and then comes the angular momentum."""
FAILED, STRAYED, PASSED = range(3)
"""What a pass says of its particles."""


@jit
def spread_affine(scheme: Scheme, grid: Grid, particles: Particles, affine: Array, nodes: Nodes, p: int, m: float, at) -> None:
    """p_I += m_p N_Ip B_p D_p^-1 (x_I - x_p), where TPIC keeps the gradient C_p = B_p D_p^-1; nothing when no B is kept."""
    if affine.ndim == 2:
        s = local(grid.axes, place(scheme, grid, particles, p), grid.scale)
        e, D = affine_stencil(grid.axes, s, grid, at)
        T = columns(row(affine, p, null(s)[1]), scale(m, D) if scheme.affine == TPIC else constant(m, D))
        spread_gradients(nodes.inertia, 1, at[0], grid.stride, at[1], e, T)


@jit
def gather_affine(scheme: Scheme, grid: Grid, particles: Particles, affine: Array, nodes: Nodes, p: int, at, gradient) -> None:
    """B_p = sum_I v_I N_Ip (x_I - x_p)^T, or the gradient for TPIC; nothing when no B is kept."""
    if affine.ndim == 2:
        if scheme.affine == TPIC:
            store(affine, p, gradient)
        else:
            s = local(grid.axes, place(scheme, grid, particles, p), grid.scale)
            e, D = affine_stencil(grid.axes, s, grid, at)
            store(affine, p, by_columns(gather_gradients(nodes.velocity, at[0], grid.stride, at[1], e, null(s)[0]), D))


@jit
def affine_spin(scheme: Scheme, grid: Grid, particles: Particles, affine: Array, p: int, at):
    """Angular momentum that a particle keeps about itself, per unit of its mass; zero when no B is kept."""
    zero, tensor, _ = null(grid.lower)
    if affine.ndim == 2:
        B = row(affine, p, tensor)
        if scheme.affine == TPIC:
            s = local(grid.axes, place(scheme, grid, particles, p), grid.scale)
            B = by_columns(B, affine_stencil(grid.axes, s, grid, at)[1])
        return axial(B)
    return cross(zero, zero)


@jit
def force_columns(scheme: Scheme, V0: float, sigma: Vector, F: Vector, like: Vector):
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
    for p in range(begin, end):
        if not supported(scheme, grid, particles, p):
            return FAILED
        at = support(grid.kind, scheme, grid, particles, p)
        m, v = particles.mass[p], row(particles.velocity, p, zero)
        spread(grid, nodes.inertia, 0, at, with_mass(m, v))
        spread_affine(scheme, grid, particles, particles.affine, nodes, p, m, at)
        if forces:
            sigma, F = row(particles.stress, p, symmetric), row(particles.F, p, tensor)
            T = force_columns(scheme, particles.volume[p], sigma, F, zero)
            spread_tensor(grid, nodes.internal, 0, at, T)
        if body.shape[0] > 0 and not scheme.nodal_body:
            b = row(body[load], particles.place[p], zero)
            spread(grid, nodes.external, 0, at, scale(m, b))
    return PASSED


@jit
def smooth(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, begin: int, end: int) -> int:
    """p_I += sum_p m_p N_Ip sum_J N_Jp t_J: a term of the nodes, to the particles and back."""
    for p in range(begin, end):
        at = support(grid.kind, scheme, grid, particles, p)
        spread(grid, nodes.inertia, 1, at, scale(particles.mass[p], gather(grid, nodes.term, at)))
    return PASSED


@jit
def strain(scheme: Scheme, particles: Particles, p: int, like: Vector, increment: Vector, dt: float):
    """F += dt dv/dX or F = (I + dt dv/dx) F, and the stress that the law makes of it.

    Whether that went well, which it does not at a law or a volume that meets J <= 0, and the energy that turned into heat.
    """
    _, tensor, symmetric = null(like)
    before = row(particles.F, p, tensor)
    F = axpy(1.0, increment, before) if scheme.total else deform(increment, before)
    if not det(F) > 0 and (finite_strain(scheme.law) or not scheme.total):
        return False, 0.0
    sigma = row(particles.stress, p, symmetric)
    heat = (
        particles.volume[p]
        * (1.0 if scheme.total else det(before))
        * dissipation(scheme.law, scheme.constants, sigma, increment, dt)
    )
    store(particles.F, p, F)
    store(particles.stress, p, stress(scheme.law, scheme.constants, sigma, F, increment, dt))
    return True, heat


@jit
def move(grid: Grid, particles: Particles, p: int, increment: Vector, limits: Array) -> int:
    """x_p += dt v; STRAYED when its last coordinate, on a periodic axis all its images, passes the limits (2,) [m]."""
    x = axpy(1.0, increment, row(particles.position, p, increment))
    store(particles.position, p, x)
    y, axis = x[-1], grid.axes[len(x) - 1]
    if axis.periodic and not limits[0] <= y <= limits[1]:
        length = axis.cells / grid.scale
        y -= length * ((y - limits[0]) // length)
    return PASSED if limits[0] <= y <= limits[1] else STRAYED


@jit
def stored_energy(scheme: Scheme, particles: Particles, p: int, like: Vector) -> float:
    """Strain energy of a particle."""
    _, tensor, symmetric = null(like)
    sigma, F = row(particles.stress, p, symmetric), row(particles.F, p, tensor)
    per_volume = strain_energy(scheme.law, scheme.constants, sigma, F)
    current = not scheme.total and not finite_strain(scheme.law)
    return particles.volume[p] * (det(F) if current else 1.0) * per_volume


@jit
def grid_to_particles(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    nodes: Nodes,
    n: int,
    dt: float,
    advance: bool,
    limits: Array,
    sums: Array,
    begin: int,
    end: int,
) -> int:
    """Sums at t^n; then, to `advance`, v_p = flip (v_p + dt sum_I N_I a_I) + (1 - flip) sum_I N_I v_I, with the correction
    of XPIC, and what else a step changes.

    Half of dt for the velocities at n = 0. USL: strain and stress. USF and USL: x_p += dt sum_I N_I v_I. MUSL: the new
    momentum goes to the grid, which leaves both to `strain_particles`. FAILED at J <= 0, STRAYED when a particle passes the limits of
    the strip (2,) [m].
    """
    zero, _, _ = null(grid.lower)
    kick, step = leapfrog(n, dt)
    kinetic, stored, turned, momentum, angular = 0.0, 0.0, 0.0, zero, cross(zero, zero)
    passed = PASSED
    for p in range(begin, end):
        at = support(grid.kind, scheme, grid, particles, p)
        m, before = particles.mass[p], row(particles.velocity, p, zero)
        a, moved = gather(grid, nodes.acceleration, at), gather(grid, nodes.velocity, at)
        gradient = gather_tensor(grid, nodes.velocity, at)
        now = axpy(kick, a, before)
        kinetic += 0.5 * m * dot(now, now)
        stored += stored_energy(scheme, particles, p, zero)
        momentum = axpy(m, now, momentum)
        around = axpy(
            1.0, cross(row(particles.position, p, zero), now), affine_spin(scheme, grid, particles, particles.affine, p, at)
        )
        angular = axpy(m, around, angular)
        if not advance:
            continue
        v = axpy(scheme.flip, axpy(step, a, before), scale(1 - scheme.flip, moved))
        if scheme.terms > 1 and not scheme.full_mass:
            v = axpy(1.0, gather(grid, nodes.projected, at), v)
        store(particles.velocity, p, v)
        gather_affine(scheme, grid, particles, particles.affine, nodes, p, at, gradient)
        if scheme.schedule == MUSL:
            spread(grid, nodes.inertia, 1, at, scale(m, v))
            spread_affine(scheme, grid, particles, particles.affine, nodes, p, m, at)
            continue
        passed = min(passed, move(grid, particles, p, scale(dt, moved), limits))
        if scheme.schedule == USL:
            strained, heat = strain(scheme, particles, p, zero, scale(dt, gradient), dt)
            turned += heat
            passed = passed if strained else FAILED
    sums[KINETIC], sums[STRAIN], sums[HEAT] = kinetic, stored, turned
    store_from(sums, MOMENTUM, momentum)
    store_from(sums, MOMENTUM + len(momentum), angular)
    return passed


@jit
def store_from(values: Array, first: int, some: Vector) -> None:
    """Write a vector into an array from a place on."""
    for c in range(len(some)):
        values[first + c] = some[c]


@jit
def strain_particles(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, dt: float, limits: Array, sums: Array, begin: int, end: int
) -> int:
    """A pass of its own for strain and stress: at the beginning of a step for USF, at its end for MUSL.

    USF: from the velocities of the grid before the kick, then the internal forces. MUSL: from those that were projected again,
    after x_p += dt sum_I N_I v_I. FAILED at J <= 0, STRAYED when a particle passes the limits of the strip (2,) [m].
    """
    zero, tensor, symmetric = null(grid.lower)
    passed, first_of_all, turned = PASSED, scheme.schedule == USF, 0.0
    nodal = nodes.velocity if first_of_all else nodes.projected
    for p in range(begin, end):
        at = support(grid.kind, scheme, grid, particles, p)
        gradient = gather_tensor(grid, nodal, at)
        if not first_of_all:
            moved = gather(grid, nodes.velocity, at)
            passed = min(passed, move(grid, particles, p, scale(dt, moved), limits))
        strained, heat = strain(scheme, particles, p, zero, scale(dt, gradient), dt)
        turned += heat
        if not strained:
            passed = FAILED
        if first_of_all:
            sigma, F = row(particles.stress, p, symmetric), row(particles.F, p, tensor)
            T = force_columns(scheme, particles.volume[p], sigma, F, zero)
            spread_tensor(grid, nodes.internal, 0, at, T)
    sums[HEAT] = turned
    return passed


@jit
def record_fields(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, outputs: Outputs, k: int, n: int, dt: float
) -> None:
    """u^n, sigma^n, volume and v^n = v^{n-1/2} + dt/2 sum_I N_I a_I, as output k in the order of the problem."""
    zero, tensor, symmetric = null(grid.lower)
    kick, _ = leapfrog(n, dt)
    for p in range(particles.mass.size):
        at = support(grid.kind, scheme, grid, particles, p)
        a, q = gather(grid, nodes.acceleration, at), particles.place[p]
        X = row(particles.reference, p, zero)
        store(outputs.displacement[k], q, axpy(-1.0, X, row(particles.position, p, zero)))
        store(outputs.velocity[k], q, axpy(kick, a, row(particles.velocity, p, zero)))
        store(outputs.stress[k], q, row(particles.stress, p, symmetric))
        # A small-strain body in material coordinates keeps its volume; its J may even be negative.
        J = det(row(particles.F, p, tensor)) if finite_strain(scheme.law) or not scheme.total else 1.0
        outputs.volume[k, q] = particles.volume[p] * J
