"""What a run sums up at every step, and how it says that it may go on."""

from math import isfinite

import numpy as np

from mpmverify.problem import Array

from .compilation import jit
from .grid import leapfrog
from .state import HEAT, KINETIC, MOMENTUM, STRAIN, Grid, Histories, Nodes, Scheme, Strips

COMPLETED, UNSTABLE, NON_FINITE, LEFT_GRID, INVERTED, UNSORTED = range(6)
POWER, WORK, GIVEN, TURNED, IMPULSE = range(5)
"""Of what is carried from step to step, TURNED the energy that became heat; the impulse takes one place for each direction."""
GROWTH = 100.0
"""A run is unstable when its kinetic energy exceeds all the energy that it was ever given by this factor."""


@jit
def add_up(
    scheme: Scheme,
    histories: Histories,
    k: int,
    record: bool,
    running: Array,
    added: Array,
    power_and_force: Array,
    n: int,
    dt: float,
) -> None:
    """Impulse of applied forces, reactions and, for PIC, of the momentum `added` at held nodes; work as the trapezoid of the power
    sum_I f_I^ext v_I; and the energy that turned into heat until t^n. What is to `record` becomes record k.
    """
    kick, step = leapfrog(n, dt)
    power, force = power_and_force[0], power_and_force[1:]
    work = kick * (running[POWER] + power)
    running[POWER] = power
    running[WORK] += work
    running[GIVEN] += abs(work)
    for c in range(force.size):
        if record:
            histories.impulse[k, c] = running[IMPULSE + c] + kick * force[c]
        running[IMPULSE + c] += step * force[c] + (1 - scheme.flip) * added[c]
    if record:
        histories.external_work[k] = running[WORK]
        histories.dissipated_energy[k] = running[TURNED]


@jit
def record_sums(grid: Grid, nodes: Nodes, strips: Strips, histories: Histories, k: int, running: Array) -> int:
    """Sums at t^n as record k, where v^n = v^{n-1/2} + dt/2 sum_I N_I a_I; COMPLETED, UNSTABLE or NON_FINITE.

    Mass sum_I m_I; momentum sum_p m v; kinetic energy sum_p m v^2/2; strain energy; angular momentum sum_p m x cross v with that of
    the affine parts.
    """
    kinetic, strain = 0.0, 0.0
    for i in range(nodes.inertia.shape[1]):
        histories.mass[k] += nodes.inertia[0, i]
    for s in range(strips.sums.shape[0]):
        kinetic += strips.sums[s, KINETIC]
        strain += strips.sums[s, STRAIN]
        for c in range(len(grid.lower)):
            histories.momentum[k, c] += strips.sums[s, MOMENTUM + c]
        for c in range(histories.angular_momentum.shape[1]):
            histories.angular_momentum[k, c] += strips.sums[s, MOMENTUM + len(grid.lower) + c]
    histories.kinetic_energy[k] = kinetic
    histories.strain_energy[k] = strain
    if k == 0:
        running[GIVEN] += kinetic + strain
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


def no_histories(steps: int, every: int, dimension: int) -> Histories:
    """Histories of a run of so many steps, of which each so many'th and the last are recorded, all zero."""
    step = np.unique(np.append(np.arange(0, steps + 1, every), steps)).astype(np.int64)
    vectors = (np.zeros((len(step), count)) for count in (dimension, dimension, {1: 0, 2: 1, 3: 3}[dimension]))
    return Histories(step, *vectors, *(np.zeros(len(step)) for _ in range(5)))


def by_component(histories: Histories, done: int) -> dict[str, Array]:
    """Histories of the steps below `done` by the names of `Solution`: a vector has one for each component where there are several."""
    found: dict[str, Array] = {}
    records = int(np.searchsorted(histories.step, done))
    for name, values in histories._asdict().items():
        if name == "step":
            continue
        if values.ndim == 1 or values.shape[1] == 1:
            found[name] = values[:records].reshape(records)
        elif values.shape[1]:
            found |= {f"{name}_{axis}": values[:records, k].copy() for k, axis in enumerate("xyz"[: values.shape[1]])}
    return found
