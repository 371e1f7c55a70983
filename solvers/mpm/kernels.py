"""The compiled time loop of the explicit one-dimensional material point method, and the stages of a step on the grid."""

import zlib
from math import isfinite
from pathlib import Path

from numba import njit

from mpmverify.problem import Array

from .laws import NEO_HOOKEAN, stress
from .recording import leapfrog, record_fields, record_histories
from .state import Ends, Grid, Histories, Nodes, Outputs, Particles, Scheme, Stencil
from .transfer import evaluate_basis, gather, particle_mass_to_grid, particle_momentum_to_grid, scatter

jit = njit(fastmath={"contract"}, error_model="numpy")

USF, USL, MUSL = range(3)
COMPLETED, UNSTABLE, NON_FINITE, LEFT_GRID, INVERTED = range(5)

MASSLESS = 1e-12
"""Nodes with less than this part of a particle's mass carry no velocity: f/m would overflow."""
SOURCES = zlib.crc32(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py"))))
"""As a default argument of the loop it adds the files that the loop inlines to the one that numba's disk cache watches."""


@jit
def nodal_velocity(nodes: Nodes, ends: Ends, n: int, massless: float) -> float:
    """v_I = p_I/m_I and v_b(t^{n-1/2}) at a held end; returns the momentum that this adds, sum_I (m_I v_I - p_I)."""
    added = 0.0
    for i in range(nodes.mass.size):
        nodes.velocity[i] = nodes.momentum[i] / nodes.mass[i] if nodes.mass[i] > massless else 0.0
        if nodes.mass[i] <= massless:
            added -= nodes.momentum[i]
    for side in range(2):
        if ends.held[side]:
            i = ends.node[side]
            added += nodes.mass[i] * (ends.velocity[side, n] - nodes.velocity[i])
            nodes.velocity[i] = ends.velocity[side, n]
    return added


@jit
def update_stress(scheme: Scheme, particles: Particles, stencil: Stencil, nodes: Nodes, dt: float) -> bool:
    """d_eps = dt sum_I dN_Ip v_I; F += d_eps with dN/dX, F *= 1 + d_eps with dN/dx (so rho = rho0/F); then sigma from the law.

    False when a law or a volume meets F <= 0.
    """
    for p in range(particles.mass.size):
        increment = dt * gather(stencil.first, stencil.gradient, nodes.velocity, p)
        F = particles.F[p] + increment if scheme.total else particles.F[p] * (1 + increment)
        if not F > 0 and (scheme.law == NEO_HOOKEAN or not scheme.total):
            return False
        particles.F[p] = F
        particles.stress[p] = stress(scheme.law, scheme.lame, scheme.shear, particles.stress[p], increment, F)
    return True


@jit
def grid_forces(
    scheme: Scheme, particles: Particles, stencil: Stencil, nodes: Nodes, ends: Ends, body: Array, row: int, n: int
) -> None:
    """Internal -sum_p V_p sigma_p dN_Ip, external sum_p m_p b_p N_Ip (or m_I b_I) + p n; V0, dN/dX if total Lagrangian."""
    for i in range(nodes.mass.size):
        nodes.internal[i] = nodes.external[i] = 0.0
    for p in range(particles.mass.size):
        volume = particles.volume[p] if scheme.total else particles.volume[p] * particles.F[p]
        scatter(stencil.first, stencil.gradient, nodes.internal, p, -volume * particles.stress[p])
    if body.size > 0 and not scheme.nodal_body:
        for p in range(particles.mass.size):
            scatter(stencil.first, stencil.value, nodes.external, p, particles.mass[p] * body[row, p])
    elif body.size > 0:
        for i in range(body.shape[1]):
            nodes.external[i] += nodes.mass[i] * body[row, i]
    for side in range(2):
        nodes.external[ends.node[side]] += ends.force[side, n]


@jit
def accelerate(nodes: Nodes, ends: Ends, n: int, dt: float, massless: float) -> None:
    """a_I = f_I/m_I; [v_b(t^{n+1/2}) - v_b(t^{n-1/2})]/dt at a held end, its reaction m_I a_I - f_I is an external force."""
    _, step = leapfrog(n, dt)
    for i in range(nodes.mass.size):
        nodes.acceleration[i] = 0.0
        if nodes.mass[i] > massless:
            nodes.acceleration[i] = (nodes.internal[i] + nodes.external[i]) / nodes.mass[i]
        else:
            nodes.external[i] = -nodes.internal[i]
    for side in range(2):
        if ends.held[side]:
            i = ends.node[side]
            nodes.acceleration[i] = (ends.velocity[side, n + 1] - ends.velocity[side, n]) / step
            nodes.external[i] = nodes.mass[i] * nodes.acceleration[i] - nodes.internal[i]


@jit
def advance(scheme: Scheme, particles: Particles, stencil: Stencil, nodes: Nodes, n: int, dt: float) -> None:
    """v_I += dt a_I, then v_p = flip (v_p + dt sum_I N_I a_I) + (1 - flip) sum_I N_I v_I and u_p += dt sum_I N_I v_I.

    Half of dt for the velocities at n = 0; at a held end v_I arrives at v_b(t^{n+1/2}).
    """
    _, step = leapfrog(n, dt)
    for i in range(nodes.mass.size):
        nodes.velocity[i] += step * nodes.acceleration[i]
    for p in range(particles.mass.size):
        moved = gather(stencil.first, stencil.value, nodes.velocity, p)
        kicked = particles.velocity[p] + step * gather(stencil.first, stencil.value, nodes.acceleration, p)
        particles.velocity[p] = scheme.flip * kicked + (1 - scheme.flip) * moved
        particles.displacement[p] += dt * moved


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def march(
    scheme: Scheme,
    grid: Grid,
    particles: Particles,
    stencil: Stencil,
    nodes: Nodes,
    ends: Ends,
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
        Impulse to t^{n-1/2}, power and work at t^{n-1}, energy given so far (4,): carried from call to call.
    dt : float
        Time step [s].
    body : Array
        b at t^n of these passes, (end - begin, P) at particles, (end - begin, C + degree) at nodes [m/s^2]; empty for none.
    output : int
        The next output.
    sources : int
        Not to be passed; see `SOURCES`.

    Returns
    -------
    tuple of int
        Status, the number of passes recorded since the start, and of outputs.

    References
    ----------
    Sulsky, Chen and Schreyer, 1994, doi:10.1016/0045-7825(94)90112-0; Sulsky, Zhou and Schreyer, 1995,
    doi:10.1016/0010-4655(94)00170-7; Bardenhagen, 2002, doi:10.1006/jcph.2002.7103 (USF and USL); Zhang, Chen and Liu, The
    Material Point Method, 2017 (the leapfrog form); de Vaucorbeil, Nguyen and Hutchinson, 2020,
    doi:10.1016/j.cma.2019.112783 (total Lagrangian).
    """
    massless = MASSLESS * particles.mass[0]
    for n in range(begin, end):
        if n == 0 or not scheme.total:
            if not evaluate_basis(grid, particles, stencil, scheme.total):
                return LEFT_GRID, n, output
            particle_mass_to_grid(particles, stencil, nodes)
        particle_momentum_to_grid(particles, stencil, nodes)
        added = nodal_velocity(nodes, ends, n, massless)
        if scheme.schedule == USF and n > 0 and not update_stress(scheme, particles, stencil, nodes, dt):
            return INVERTED, n, output
        grid_forces(scheme, particles, stencil, nodes, ends, body, n - begin, n)
        accelerate(nodes, ends, n, dt, massless)
        bounded = record_histories(scheme, particles, stencil, nodes, histories, running, n, dt, added)
        if not isfinite(histories.kinetic_energy[n] + histories.strain_energy[n] + histories.external_work[n]):
            return NON_FINITE, n, output
        if not bounded:
            return UNSTABLE, n, output
        if outputs.step[output] == n:
            record_fields(particles, stencil, nodes, outputs, output, n, dt)
            output += 1
        if n + 1 == histories.mass.size:
            break
        advance(scheme, particles, stencil, nodes, n, dt)
        if scheme.schedule == MUSL:
            particle_momentum_to_grid(particles, stencil, nodes)
            nodal_velocity(nodes, ends, n + 1, massless)
        if scheme.schedule != USF and not update_stress(scheme, particles, stencil, nodes, dt):
            return INVERTED, n + 1, output
    return COMPLETED, end, output
