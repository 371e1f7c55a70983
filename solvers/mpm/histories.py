"""What a run sums up at every step, and how it says that it may go on."""

from math import isfinite

import numpy as np

from mpmverify.problem import Array

from .compilation import jit
from .grid import leapfrog
from .order import Strips
from .passes import HEAT, KINETIC, MOMENTUM, STRAIN
from .state import Grid, Histories, Nodes, Scheme

COMPLETED, UNSTABLE, NON_FINITE, LEFT_GRID, INVERTED, UNSORTED = range(6)
POWER, WORK, GIVEN, TURNED, IMPULSE = range(5)
"""Of what is carried from step to step, TURNED the energy that became heat; the impulse takes one place for each direction."""
GROWTH = 100.0
"""A run is unstable when its kinetic energy exceeds all the energy that it was ever given by this factor."""


@jit
def record_histories(
    scheme: Scheme,
    grid: Grid,
    nodes: Nodes,
    strips: Strips,
    histories: Histories,
    running: Array,
    added: Array,
    force: Array,
    power: float,
    n: int,
    dt: float,
) -> int:
    """Sums at t^n, where v^n = v^{n-1/2} + dt/2 sum_I N_I a_I; COMPLETED, UNSTABLE or NON_FINITE.

    Mass sum_I m_I; momentum sum_p m v; impulse of applied forces, reactions and, for PIC, of the momentum `added` at held nodes;
    kinetic energy sum_p m v^2/2; strain energy; work as the trapezoid of the power sum_I f_I^ext v_I; angular momentum
    sum_p m x cross v with that of the affine parts; the energy that turned into heat until t^n.
    """
    kick, step = leapfrog(n, dt)
    work = kick * (running[POWER] + power)
    kinetic, strain = 0.0, 0.0
    for i in range(nodes.inertia.shape[0]):
        histories.mass[n] += nodes.inertia[i, 0]
    for s in range(strips.sums.shape[0]):
        kinetic += strips.sums[s, KINETIC]
        strain += strips.sums[s, STRAIN]
        for c in range(len(grid.lower)):
            histories.momentum[n, c] += strips.sums[s, MOMENTUM + c]
        for c in range(histories.angular_momentum.shape[1]):
            histories.angular_momentum[n, c] += strips.sums[s, MOMENTUM + len(grid.lower) + c]
    for c in range(len(grid.lower)):
        histories.impulse[n, c] = running[IMPULSE + c] + kick * force[c]
        running[IMPULSE + c] += step * force[c] + (1 - scheme.flip) * added[c]
    histories.kinetic_energy[n] = kinetic
    histories.strain_energy[n] = strain
    histories.external_work[n] = running[WORK] + work
    histories.dissipated_energy[n] = running[TURNED]
    running[POWER] = power
    running[WORK] += work
    running[GIVEN] += abs(work) if n > 0 else kinetic + strain
    if not isfinite(kinetic + strain + running[WORK]):
        return NON_FINITE
    return COMPLETED if kinetic <= GROWTH * running[GIVEN] else UNSTABLE


@jit
def heat_of(strips: Strips) -> float:
    """Energy that a pass has turned into heat."""
    total = 0.0
    for s in range(strips.sums.shape[0]):
        total += strips.sums[s, HEAT]
    return total


def no_histories(steps: int, dimension: int) -> Histories:
    """Histories of a run of so many steps, all zero."""
    vectors = (np.zeros((steps + 1, count)) for count in (dimension, dimension, {1: 0, 2: 1, 3: 3}[dimension]))
    return Histories(*vectors, *(np.zeros(steps + 1) for _ in range(5)))


def by_component(histories: Histories, done: int) -> dict[str, Array]:
    """Histories by the names of `Solution`: a vector has one for each component where there are several."""
    found: dict[str, Array] = {}
    for name, values in histories._asdict().items():
        if values.ndim == 1 or values.shape[1] == 1:
            found[name] = values[:done].reshape(done)
        elif values.shape[1]:
            found |= {f"{name}_{axis}": values[:done, k].copy() for k, axis in enumerate("xyz"[: values.shape[1]])}
    return found
