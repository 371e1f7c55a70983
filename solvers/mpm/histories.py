"""What a run sums up at every step, and how it says that it may go on."""

from math import inf

import numpy as np

from mpmverify.problem import Array

from ..tracing import for_range, maximum, traced, where
from .grid import leapfrog
from .state import HEAT, KINETIC, MOMENTUM, STRAIN, Histories, Scheme, Strips
from .vectors import Vector

# What is a number of compiled code has no annotation.
# mypy: disable-error-code="no-untyped-def"

COMPLETED, UNSTABLE, NON_FINITE, LEFT_GRID, INVERTED = range(5)
POWER, WORK, GIVEN, TURNED, IMPULSE = range(5)
"""Of what is carried from step to step, TURNED the energy that became heat; the impulse takes one place for each direction."""
GROWTH = 100.0
"""A run is unstable when its kinetic energy exceeds all the energy that it was ever given by this factor."""


@traced
def add_up(
    zero: Vector, scheme: Scheme, histories: Histories, k: int, running: Array, added: Array, at_nodes: Array, n: int, dt: float
) -> None:
    """Impulse of applied forces, reactions and, for PIC, of the momentum `added` at held nodes; work as the trapezoid of the power
    sum_I f_I^ext v_I; and the energy that turned into heat until t^n, as record k until the next step comes.

    `at_nodes` are the power, the forces and the mass, see `kick_nodes`.
    """
    kick, leap = leapfrog(n, dt)
    work = kick * (running[POWER] + at_nodes[0])
    running[POWER] = at_nodes[0]
    running[WORK] += work
    running[GIVEN] += maximum(work, -work)
    for c in range(len(zero)):
        force = at_nodes[1 + c]
        histories.impulse[k, c] = running[IMPULSE + c] + kick * force
        running[IMPULSE + c] += leap * force + (1.0 - scheme.flip) * added[c]
    histories.mass[k] = at_nodes[1 + len(zero)]
    histories.external_work[k] = running[WORK]
    histories.dissipated_energy[k] = running[TURNED]


@traced
def record_sums(zero: Vector, strips: Strips, histories: Histories, k: int, running: Array) -> int:
    """Sums at t^n as record k, where v^n = v^{n-1/2} + dt/2 sum_I N_I a_I; COMPLETED, UNSTABLE or NON_FINITE.

    Momentum sum_p m v; kinetic energy sum_p m v^2/2; strain energy; angular momentum sum_p m x cross v with that of the affine parts.
    """
    d = len(zero)
    with for_range(0, strips.sums.shape[0]) as s:
        histories.kinetic_energy[k] += strips.sums[s, KINETIC]
        histories.strain_energy[k] += strips.sums[s, STRAIN]
        for c in range(d):
            histories.momentum[k, c] += strips.sums[s, MOMENTUM + c]
        for c in range(d * (d - 1) // 2):
            histories.angular_momentum[k, c] += strips.sums[s, MOMENTUM + d + c]
    kinetic = histories.kinetic_energy[k]
    energy = kinetic + histories.strain_energy[k]
    running[GIVEN] += where(k > 0, 0.0, energy)
    total = energy + running[WORK]
    finite = (total > -inf) & (total < inf)
    return where(finite, where(kinetic <= GROWTH * running[GIVEN], COMPLETED, UNSTABLE), NON_FINITE)


@traced
def add_heat(strips: Strips, running: Array):
    """Add the energy that a pass has turned into heat."""
    with for_range(0, strips.sums.shape[0]) as s:
        running[TURNED] += strips.sums[s, HEAT]


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
