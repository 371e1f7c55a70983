"""Outputs and histories of a run: sums at every step, and the check whether the run may continue."""

from math import inf
from typing import NamedTuple

import numpy as np

from mpmverify.problem import Array

from ..tracing import for_range, maximum, traced, where
from .grid import leapfrog
from .order import Strips
from .state import HEAT, KINETIC, MOMENTUM, STRAIN, Integers, Scheme
from .vectors import Vector

# Numbers and lanes of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"

COMPLETED, UNSTABLE, NON_FINITE, LEFT_GRID, INVERTED = range(5)
POWER, WORK, GIVEN, TURNED, IMPULSE = range(5)
"""Entries of the sums that are carried from step to step: power and work of the external forces, the energy given to the body, the
energy that became heat, and the impulse, an entry for each direction."""
GROWTH = 100.0
"""A run is unstable when its kinetic energy exceeds this many times the energy that was ever given to it."""


class Outputs(NamedTuple):
    """Fields at the T output times, where positions and velocities are synchronous.

    step : ndarray
        Steps of the outputs (T,).
    displacement : ndarray
        u (T, P, d) [m].
    velocity : ndarray
        v (T, P, d) [m/s].
    stress : ndarray
        sigma (T, P, d (d + 1)/2) [Pa].
    volume : ndarray
        Current volume (T, P) [m^d].
    """

    step: Integers
    displacement: Array
    velocity: Array
    stress: Array
    volume: Array


class Histories(NamedTuple):
    """Sums at R recorded steps, per unit of the missing area or length in less than three dimensions.

    step : ndarray
        Steps (R,).
    momentum : ndarray
        Linear momentum (R, d) [kg m/s].
    impulse : ndarray
        Impulse of the external forces so far (R, d) [kg m/s].
    angular_momentum : ndarray
        Angular momentum (R, 0, 1 or 3) [kg m^2/s].
    mass : ndarray
        Mass of the nodes (R,) [kg].
    kinetic_energy : ndarray
        Kinetic energy (R,) [J].
    strain_energy : ndarray
        Stored energy (R,) [J].
    external_work : ndarray
        Work of the external forces so far (R,) [J].
    dissipated_energy : ndarray
        Energy that became heat so far (R,) [J].
    """

    step: Integers
    momentum: Array
    impulse: Array
    angular_momentum: Array
    mass: Array
    kinetic_energy: Array
    strain_energy: Array
    external_work: Array
    dissipated_energy: Array


@traced
def add_up(
    zero: Vector, scheme: Scheme, histories: Histories, k: int, running: Array, added: Array, at_nodes: Array, n: int, dt: float
) -> None:
    """Write impulse, mass, work and heat at t^n as record k; the next step overwrites it unless it is recorded.

    The impulse is that of applied forces, reactions and, for PIC, of the momentum `added` at held nodes (d,); the work is the integral
    of the power sum_I f_I^ext v_I by the trapezoidal rule. `at_nodes` (2 + d,) are power, forces and mass as of `kick_nodes`.
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
    """Write momentum sum_p m v, angular momentum, kinetic energy sum_p m v^2/2 and stored energy at t^n as record k.

    v^n = v^{n-1/2} + dt/2 sum_I N_I a_I. The angular momentum sum_p m x cross v includes that of the affine parts
    at t^n. Returns COMPLETED, UNSTABLE or NON_FINITE.
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
    """Add the energy that became heat in a pass."""
    with for_range(0, strips.sums.shape[0]) as s:
        running[TURNED] += strips.sums[s, HEAT]


def no_histories(steps: int, every: int, dimension: int) -> Histories:
    """Zero histories of a run of `steps` steps, recorded every so many steps and at the last one."""
    step = np.unique(np.append(np.arange(0, steps + 1, every), steps)).astype(np.int64)
    vectors = (np.zeros((len(step), count)) for count in (dimension, dimension, {1: 0, 2: 1, 3: 3}[dimension]))
    return Histories(step, *vectors, *(np.zeros(len(step)) for _ in range(5)))


def by_component(histories: Histories, done: int) -> dict[str, Array]:
    """Histories of the steps before `done` by the names of `Solution`; a vector with several components has one for each."""
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
