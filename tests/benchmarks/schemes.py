"""What the peers solve, and the order in which the particles lie."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mpmverify.problem import Array, Discretisation, Problem
from mpmverify.solvers.mpm import APIC, FLIP, MaterialPoint


@dataclass(frozen=True)
class Body:
    """Regular layout in a periodic unit box of n cells along each axis, sorted by cell; mass and volume V0 [m^d] of a particle.

    Positions and velocities (P, d) [m, m/s], Lame's constants [Pa] and the time step [s].
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
    """What a peer carries from step to step: x [m], v [m/s], C [1/s] (P, d, d), sigma = (xx, yy, xy) or (xx, yy, zz, xy, yz, zx) [Pa], J."""

    position: Array
    velocity: Array
    affine: Array
    stress: Array
    J: Array


class Peer(Protocol):
    """A code that advances particles."""

    def load(self, state: State) -> None:
        """Take a state."""

    def state(self) -> State:
        """Give the state."""

    def step(self, kick: float, dt: float) -> None:
        """Kick the velocity by `kick` and move by `dt` [s], without waiting for the end of it."""

    def wait(self) -> None:
        """Wait until all steps are done."""


RARELY = 1_000_000
"""Steps between records: the peers keep no histories, so that ours has the first step and the last."""
SCHEMES = {
    "linear USL FLIP": MaterialPoint("USL", FLIP, "linear", record_every=RARELY),
    "quadratic USL APIC": MaterialPoint("USL", APIC, "quadratic", record_every=RARELY),
}


def sorted_body(problem: Problem, at: Discretisation, reference: Array) -> tuple[Body, Array]:
    """Particles at their reference positions (P, d) [m] in the order of their cells, and that order (P,)."""
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
    """Take steps of the leapfrog from v^0; the first one kicks by half a step."""
    peer.load(at_rest(body))
    for n in range(steps):
        peer.step(body.dt if n else 0.5 * body.dt, body.dt)
    peer.wait()


def synchronous(peer: Peer, body: Body) -> State:
    """State with v^n = v^{n-1/2} + dt/2 sum_I N_I a_I, the last term from two steps that differ in their kick alone."""
    state, moved = peer.state(), []
    for kick in (0.5 * body.dt, 0.0):
        peer.load(state)
        peer.step(kick, body.dt)
        peer.wait()
        moved.append(peer.state().velocity)
    return replace(state, velocity=state.velocity + moved[0] - moved[1])
