"""Schemes that all codes solve, the interface of a peer, and its particles sorted by cell."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mpmverify.problem import Array, Discretisation, Problem
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint


@dataclass(frozen=True)
class Body:
    """Particles on a regular layout in a periodic unit box, sorted by cell, with the material and the time step.

    Parameters
    ----------
    cells : number of cells along each axis.
    position, velocity : (P, d) [m], [m/s].
    mass, volume : mass and initial volume [m^d] of each particle.
    lame, shear : Lame's constants [Pa].
    dt : time step [s].
    """

    cells: int
    position: Array
    velocity: Array
    mass: float
    volume: float
    lame: float
    shear: float
    dt: float


@dataclass(frozen=True)
class State:
    """State of a peer's particles.

    Parameters
    ----------
    position, velocity : (P, d) [m], [m/s].
    affine : (P, d, d) APIC's matrix C [1/s].
    stress : (P, d (d + 1) / 2) Cauchy stress (xx, yy, xy) or (xx, yy, zz, xy, yz, zx) [Pa].
    J : (P,) volume ratio det F.
    """

    position: Array
    velocity: Array
    affine: Array
    stress: Array
    J: Array


class Peer(Protocol):
    """Another code that advances particles."""

    def load(self, state: State) -> None:
        """Set the state."""

    def state(self) -> State:
        """Return the state."""

    def step(self, kick: float, dt: float) -> None:
        """Start one step: change velocities by `kick` [s] times the acceleration, and positions by `dt` [s]; do not wait."""

    def wait(self) -> None:
        """Wait for all steps to finish."""


RECORD_EVERY = 1_000_000
"""Steps between records of the histories: so many that the first and last step alone are recorded, as the peers record none."""
SCHEMES = {
    "linear USL FLIP": MaterialPoint("USL", FLIP, "linear", record_every=RECORD_EVERY),
    "quadratic USL APIC": MaterialPoint("USL", APIC, "quadratic", record_every=RECORD_EVERY),
}


def sorted_body(problem: Problem, at: Discretisation, reference: Array) -> tuple[Body, Array]:
    """Return the particles at `reference` (P, d) [m] sorted by cell, and the permutation (P,) that sorts them."""
    assert not any(problem.lower)
    cells, dimension = at.cells(problem)[0], problem.dimension
    order = np.argsort((reference // at.h).astype(int) @ cells ** np.arange(dimension), kind="stable")
    velocity = problem.initial_field("velocity", reference)
    material, volume = problem.material, (at.h / at.ppc) ** dimension
    _, dt = at.time_steps(problem)
    lame, shear = material.lame_lambda, material.shear_modulus
    return Body(cells, reference[order], velocity[order], material.density * volume, volume, lame, shear, dt), order


def at_rest(body: Body) -> State:
    """Initial state of an undeformed body."""
    count, d = body.position.shape
    stress = np.zeros((count, d * (d + 1) // 2))
    return State(body.position, body.velocity, np.zeros((count, d, d)), stress, np.ones(count))


def advance(peer: Peer, body: Body, steps: int) -> None:
    """Advance by leapfrog steps from v^0; the first kick is half a step."""
    peer.load(at_rest(body))
    for n in range(steps):
        peer.step(body.dt if n else 0.5 * body.dt, body.dt)
    peer.wait()


def synchronous(peer: Peer, body: Body) -> State:
    """State with v^n = v^{n-1/2} + dt/2 sum_I N_I a_I; the last term is the difference of two steps with and without a kick."""
    state, moved = peer.state(), []
    for kick in (0.5 * body.dt, 0.0):
        peer.load(state)
        peer.step(kick, body.dt)
        peer.wait()
        moved.append(peer.state().velocity)
    return replace(state, velocity=state.velocity + moved[0] - moved[1])
