"""The passes of a step over the particles from `begin` to `end`."""

from mpmverify.problem import Array

from .compilation import jit
from .constitution import finite_strain, reference_stress, strain_energy, stress
from .grid import leapfrog
from .state import Grid, Nodes, Outputs, Particles, Scheme
from .stencil import affine_stencil, inside, local, place, stencil
from .tensors import deform, det, full
from .transfer import gather, gather_tensor, spread, spread_tensor
from .vectors import Vector, axpy, by_columns, columns, constant, dot, null, row, scale, store, with_mass

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

USF, USL, MUSL = range(3)
NO_AFFINE, APIC, TPIC = range(3)
KINETIC, STRAIN, MOMENTUM = range(3)
"""Columns of the sums of a pass; the momentum takes one for each direction."""
FAILED, STRAYED, PASSED = range(3)
"""What a pass says of its particles."""


@jit
def spread_affine(scheme: Scheme, grid: Grid, affine: Array, nodes: Nodes, p: int, m: float, s: Vector, first: int, w) -> None:
    """p_I += m_p N_Ip B_p D_p^-1 (x_I - x_p), where TPIC keeps the gradient C_p = B_p D_p^-1; nothing when no B is kept."""
    if affine.ndim == 2:
        e, D = affine_stencil(grid.axes, s, grid, w)
        T = columns(row(affine, p, null(s)[1]), scale(m, D) if scheme.affine == TPIC else constant(m, D))
        spread_tensor(nodes.inertia, 1, first, grid.stride, w, e, T)


@jit
def gather_affine(scheme: Scheme, grid: Grid, affine: Array, nodes: Nodes, p: int, s: Vector, first: int, w, gradient) -> None:
    """B_p = sum_I v_I N_Ip (x_I - x_p)^T, or the gradient for TPIC; nothing when no B is kept."""
    if affine.ndim == 2:
        if scheme.affine == TPIC:
            store(affine, p, gradient)
        else:
            e, D = affine_stencil(grid.axes, s, grid, w)
            store(affine, p, by_columns(gather_tensor(nodes.velocity, first, grid.stride, w, e, null(s)[0]), D))


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
        s = local(grid.axes, place(scheme, grid, particles, p), grid.scale)
        if not inside(grid.axes, s):
            return FAILED
        first, w, d = stencil(grid.axes, s, grid)
        m, v = particles.mass[p], row(particles.velocity, p, zero)
        spread(nodes.inertia, 0, first, grid.stride, w, with_mass(m, v))
        spread_affine(scheme, grid, particles.affine, nodes, p, m, s, first, w)
        if forces:
            sigma, F = row(particles.stress, p, symmetric), row(particles.F, p, tensor)
            T = force_columns(scheme, particles.volume[p], sigma, F, zero)
            spread_tensor(nodes.internal, 0, first, grid.stride, w, d, T)
        if body.shape[0] > 0 and not scheme.nodal_body:
            b = row(body[load], particles.place[p], zero)
            spread(nodes.external, 0, first, grid.stride, w, scale(m, b))
    return PASSED


@jit
def smooth(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, begin: int, end: int) -> int:
    """p_I += sum_p m_p N_Ip sum_J N_Jp t_J: a term of the nodes, to the particles and back."""
    zero, _, _ = null(grid.lower)
    for p in range(begin, end):
        first, w, _ = stencil(grid.axes, local(grid.axes, place(scheme, grid, particles, p), grid.scale), grid)
        t = gather(nodes.term, first, grid.stride, w, zero)
        spread(nodes.inertia, 1, first, grid.stride, w, scale(particles.mass[p], t))
    return PASSED


@jit
def strain(scheme: Scheme, particles: Particles, p: int, like: Vector, increment: Vector, dt: float) -> bool:
    """F += dt dv/dX or F = (I + dt dv/dx) F, and the stress that the law makes of it; False at a law or a volume that meets J <= 0."""
    _, tensor, symmetric = null(like)
    before = row(particles.F, p, tensor)
    F = axpy(1.0, increment, before) if scheme.total else deform(increment, before)
    if not det(F) > 0 and (finite_strain(scheme.law) or not scheme.total):
        return False
    store(particles.F, p, F)
    store(particles.stress, p, stress(scheme.law, scheme.constants, row(particles.stress, p, symmetric), F, increment, dt))
    return True


@jit
def move(particles: Particles, p: int, increment: Vector, limits: Array) -> int:
    """x_p += dt v; STRAYED when its last coordinate passes the limits (2,) [m]."""
    x = axpy(1.0, increment, row(particles.position, p, increment))
    store(particles.position, p, x)
    return PASSED if limits[0] <= x[-1] <= limits[1] else STRAYED


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
    kinetic, stored, momentum = 0.0, 0.0, zero
    passed = PASSED
    for p in range(begin, end):
        s = local(grid.axes, place(scheme, grid, particles, p), grid.scale)
        first, w, d = stencil(grid.axes, s, grid)
        m, before = particles.mass[p], row(particles.velocity, p, zero)
        a, moved = gather(nodes.acceleration, first, grid.stride, w, zero), gather(nodes.velocity, first, grid.stride, w, zero)
        gradient = gather_tensor(nodes.velocity, first, grid.stride, w, d, zero)
        now = axpy(kick, a, before)
        kinetic += 0.5 * m * dot(now, now)
        stored += stored_energy(scheme, particles, p, zero)
        momentum = axpy(m, now, momentum)
        if not advance:
            continue
        v = axpy(scheme.flip, axpy(step, a, before), scale(1 - scheme.flip, moved))
        if scheme.terms > 1 and not scheme.full_mass:
            v = axpy(1.0, gather(nodes.projected, first, grid.stride, w, zero), v)
        store(particles.velocity, p, v)
        gather_affine(scheme, grid, particles.affine, nodes, p, s, first, w, gradient)
        if scheme.schedule == MUSL:
            spread(nodes.inertia, 1, first, grid.stride, w, scale(m, v))
            spread_affine(scheme, grid, particles.affine, nodes, p, m, s, first, w)
            continue
        passed = min(passed, move(particles, p, scale(dt, moved), limits))
        if scheme.schedule == USL and not strain(scheme, particles, p, zero, scale(dt, gradient), dt):
            passed = FAILED
    sums[KINETIC], sums[STRAIN] = kinetic, stored
    for c in range(len(momentum)):
        sums[MOMENTUM + c] = momentum[c]
    return passed


@jit
def strain_particles(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, dt: float, limits: Array, begin: int, end: int
) -> int:
    """A pass of its own for strain and stress: at the beginning of a step for USF, at its end for MUSL.

    USF: from the velocities of the grid before the kick, then the internal forces. MUSL: from those that were projected again,
    after x_p += dt sum_I N_I v_I. FAILED at J <= 0, STRAYED when a particle passes the limits of the strip (2,) [m].
    """
    zero, tensor, symmetric = null(grid.lower)
    passed, first_of_all = PASSED, scheme.schedule == USF
    nodal = nodes.velocity if first_of_all else nodes.projected
    for p in range(begin, end):
        first, w, d = stencil(grid.axes, local(grid.axes, place(scheme, grid, particles, p), grid.scale), grid)
        gradient = gather_tensor(nodal, first, grid.stride, w, d, zero)
        if not first_of_all:
            moved = gather(nodes.velocity, first, grid.stride, w, zero)
            passed = min(passed, move(particles, p, scale(dt, moved), limits))
        if not strain(scheme, particles, p, zero, scale(dt, gradient), dt):
            passed = FAILED
        if first_of_all:
            sigma, F = row(particles.stress, p, symmetric), row(particles.F, p, tensor)
            T = force_columns(scheme, particles.volume[p], sigma, F, zero)
            spread_tensor(nodes.internal, 0, first, grid.stride, w, d, T)
    return passed


@jit
def record_fields(
    scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, outputs: Outputs, k: int, n: int, dt: float
) -> None:
    """u^n, sigma^n, volume and v^n = v^{n-1/2} + dt/2 sum_I N_I a_I, as output k in the order of the problem."""
    zero, tensor, symmetric = null(grid.lower)
    kick, _ = leapfrog(n, dt)
    for p in range(particles.mass.size):
        first, w, _ = stencil(grid.axes, local(grid.axes, place(scheme, grid, particles, p), grid.scale), grid)
        a, q = gather(nodes.acceleration, first, grid.stride, w, zero), particles.place[p]
        X = row(particles.reference, p, zero)
        store(outputs.displacement[k], q, axpy(-1.0, X, row(particles.position, p, zero)))
        store(outputs.velocity[k], q, axpy(kick, a, row(particles.velocity, p, zero)))
        store(outputs.stress[k], q, row(particles.stress, p, symmetric))
        # A small-strain body in material coordinates keeps its volume; its J may even be negative.
        J = det(row(particles.F, p, tensor)) if finite_strain(scheme.law) or not scheme.total else 1.0
        outputs.volume[k, q] = particles.volume[p] * J
