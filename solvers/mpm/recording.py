"""What a pass of the time loop records: synchronous fields and histories."""

from numba import njit

from mpmverify.problem import Array

from .laws import NEO_HOOKEAN, strain_energy
from .state import Histories, Nodes, Outputs, Particles, Scheme, Stencil
from .transfer import gather

jit = njit(fastmath={"contract"}, error_model="numpy")

IMPULSE, POWER, WORK, GIVEN = range(4)
GROWTH = 100.0
"""A run is unstable when its kinetic energy exceeds all the energy that it was ever given by this factor."""


@jit
def leapfrog(n: int, dt: float) -> tuple[float, float]:
    """Time from v^{n-1/2} to v^n and to v^{n+1/2}; v^0 is given, and v^{1/2} = v^0 + dt/2 a^0 keeps second order under load."""
    return (0.5 * dt, dt) if n > 0 else (0.0, 0.5 * dt)


@jit
def record_histories(
    scheme: Scheme,
    particles: Particles,
    stencil: Stencil,
    nodes: Nodes,
    histories: Histories,
    running: Array,
    n: int,
    dt: float,
    added: float,
) -> bool:
    """Sums at t^n, where v^n = v^{n-1/2} + dt/2 sum_I N_I a_I.

    Mass sum_I m_I; momentum sum_p m v; impulse of applied forces, reactions and, for PIC, of the momentum `added` at held ends;
    kinetic energy sum_p m v^2/2; strain energy; work as the trapezoid of the power sum_I f_I^ext v_I. False when the kinetic
    energy outgrows the energy ever given.
    """
    kick, step = leapfrog(n, dt)
    momentum, kinetic, strain = 0.0, 0.0, 0.0
    for p in range(particles.mass.size):
        v = particles.velocity[p] + kick * gather(stencil.first, stencil.value, nodes.acceleration, p)
        volume = particles.volume[p] if scheme.total or scheme.law == NEO_HOOKEAN else particles.volume[p] * particles.F[p]
        momentum += particles.mass[p] * v
        kinetic += 0.5 * particles.mass[p] * v * v
        strain += strain_energy(scheme.law, scheme.lame, scheme.shear, particles.stress[p], volume, particles.F[p])
    mass, force, power = 0.0, 0.0, 0.0
    for i in range(nodes.mass.size):
        mass += nodes.mass[i]
        force += nodes.external[i]
        power += nodes.external[i] * (nodes.velocity[i] + kick * nodes.acceleration[i])
    work = kick * (running[POWER] + power)
    histories.mass[n] = mass
    histories.momentum[n] = momentum
    histories.impulse[n] = running[IMPULSE] + kick * force
    histories.kinetic_energy[n] = kinetic
    histories.strain_energy[n] = strain
    histories.external_work[n] = running[WORK] + work
    running[IMPULSE] += step * force + (1 - scheme.flip) * added
    running[POWER] = power
    running[WORK] += work
    running[GIVEN] += abs(work) if n > 0 else kinetic
    return kinetic <= GROWTH * running[GIVEN]


@jit
def record_fields(particles: Particles, stencil: Stencil, nodes: Nodes, outputs: Outputs, k: int, n: int, dt: float) -> None:
    """u^n, sigma^n, F^n and v^n = v^{n-1/2} + dt/2 sum_I N_I a_I, as output k."""
    kick, _ = leapfrog(n, dt)
    for p in range(particles.mass.size):
        outputs.displacement[k, p] = particles.displacement[p]
        outputs.velocity[k, p] = particles.velocity[p] + kick * gather(stencil.first, stencil.value, nodes.acceleration, p)
        outputs.stress[k, p] = particles.stress[p]
        outputs.F[k, p] = particles.F[p]
