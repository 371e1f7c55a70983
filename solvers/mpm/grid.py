"""Operations on the nodes: velocity, boundary conditions, acceleration, and the power of the external forces."""

import operator
from collections.abc import Callable
from functools import reduce
from typing import Any, NamedTuple

from mpmverify.problem import Array

from ..tracing import LANES, Consecutive, add_sums, for_range, traced, where
from .faces import Faces
from .state import Grid, Nodes, Scheme
from .vectors import Vector

# Numbers, lanes and arrays of compiled code have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def leapfrog(n: int, dt: float) -> tuple[float, float]:
    """Times from v^{n-1/2} to v^n and to v^{n+1/2} [s]; the first step begins with v^0, so that v^{1/2} = v^0 + dt/2 a^0 is of second order."""
    return where(n > 0, (0.5 * dt, dt), (0.0, 0.5 * dt))


class LeastMass(NamedTuple):
    """Nodal masses below which a node is massless [kg].

    velocity : float
        Of p_I/m_I, and of the acceleration by the body force.
    force : float
        Of f_I/m_I of the internal force and of tractions.
    """

    velocity: float
    force: float


def _pass(at_node: Callable[..., None]) -> Any:
    """A pass over the nodes from `begin` to `end`, four at a time and the rest one by one; it sets `sums` to zero first."""

    def over_nodes(zero, nodes, strips, velocity, least, kick, leap, sums, begin, end):
        with for_range(0, sums.shape[0]) as c:
            sums[c] = 0.0
        last = end - (end - begin) % LANES
        with for_range(begin, last, LANES) as i:
            at_node(zero, nodes, velocity, least, kick, leap, sums, Consecutive(i))
        with for_range(last, end) as i:
            at_node(zero, nodes, velocity, least, kick, leap, sums, i)

    over_nodes.__name__, over_nodes.__doc__ = at_node.__name__, at_node.__doc__
    return traced(over_nodes)


SMALLEST = 1e-290
"""Part of the mass of the heaviest particle below which a nodal mass has lost its digits."""
MASSLESS = 1e-12
"""Part of the mass of the heaviest particle below which a hat function has too little mass for its internal force."""


@traced
def least_mass(grid: Grid, heaviest: float) -> LeastMass:
    """Nodal masses above which p_I/m_I is a velocity, and f_I/m_I an acceleration.

    Momentum, body force and mass of a node are sums over the same particles with weights that are not negative. The quotients of the
    first two by the mass are means over the particles and well conditioned, however small the mass. A node that had no velocity instead
    would strain the body, since the slope of its function is 1/h even where a particle on a cell edge gives it a mass of 1e-16.

    The weights of the internal force are slopes. Where a hat vanishes its slope does not: f_I/m_I grows without bound, though the
    particles see N_I f_I/m_I, which is finite. USL would strain a particle at a cell edge by it without bound, so the internal force of
    a hat below `MASSLESS` is dropped, and the momentum that it carries is lost for this step. Where splines, and hats that are averaged
    over domains, vanish their slopes vanish, too: they need no limit. Fitted bases give a node mass and momentum by integrals of two
    polynomials, whose quotient is no mean, and have both limits.

    Known remedies, and what each breaks: MUSL and USF strain by velocities that are means again (Sulsky, Zhou and Schreyer, 1995,
    doi:10.1016/0010-4655(94)00170-7), but are other schedules; splines and GIMP are other bases; forces of small nodes that are shared
    among their neighbours (Ma, Giguere, Jayaraman and Zhang, Journal of Computational Physics 229, 2010, 7819-7833) keep the momentum
    but change the gradient; a larger limit, or a floor under the mass, drops forces that count at every free surface.
    """
    hats = len(grid.width) == 2 and not grid.kind.domains
    limited = MASSLESS if hats or grid.kind.fitted else SMALLEST
    return LeastMass((limited if grid.kind.fitted else SMALLEST) * heaviest, limited * heaviest)


@_pass
def clear(zero: Vector, nodes: Nodes, velocity: Array, least: LeastMass, kick: float, leap: float, sums: Array, i) -> None:
    """Zero mass, momentum and forces."""
    for values, count in (nodes.inertia, 1 + len(zero)), (nodes.internal, len(zero)), (nodes.external, len(zero)):
        for c in range(count):
            values[c, i] = 0.0


@_pass
def nodal_velocity(
    zero: Vector, nodes: Nodes, velocity: Array, least: LeastMass, kick: float, leap: float, sums: Array, i
) -> None:
    """v_I = p_I/m_I, or 0 at massless nodes, see `least_mass`; `sums` (d,) is minus the momentum that is lost there."""
    mass, lost = nodes.inertia[0, i], []
    for c in range(len(zero)):
        momentum = nodes.inertia[1 + c, i]
        velocity[c, i] = where(mass > least.velocity, momentum / mass, 0.0)
        lost.append(where(mass > least.velocity, 0.0, momentum))
    add_sums(sums, 0, -1.0, lost)


@_pass
def accelerate(zero: Vector, nodes: Nodes, velocity: Array, least: LeastMass, kick: float, leap: float, sums: Array, i) -> None:
    """a_I = (f_I^int + m_I b_I)/m_I, without the internal force at massless nodes and 0 where there is no mass, see `least_mass`."""
    mass = nodes.inertia[0, i]
    for c in range(len(zero)):
        force = nodes.external[c, i] + where(mass > least.force, nodes.internal[c, i], 0.0)
        nodes.acceleration[c, i] = where(mass > least.velocity, force / mass, 0.0)


@_pass
def kick_nodes(zero: Vector, nodes: Nodes, velocity: Array, least: LeastMass, kick: float, leap: float, sums: Array, i) -> None:
    """v_I += leap a_I, which at a held node is v_b(t^{n+1/2}); zero the nodal momentum before it is accumulated again.

    `sums` (2 + d,) are those at t^n: power sum_I f_I v_I and sum f_I of the external forces, and the mass.
    """
    power, forces = [], []
    for c in range(len(zero)):
        external, v, a = nodes.external[c, i], nodes.velocity[c, i], nodes.acceleration[c, i]
        power.append(external * (v + kick * a))
        forces.append(external)
        nodes.velocity[c, i] = v + leap * a
        nodes.inertia[1 + c, i] = 0.0
    add_sums(sums, 0, 1.0, (reduce(operator.add, power), *forces, nodes.inertia[0, i]))


@traced
def weigh(scheme: Scheme, zero: Vector, nodes: Nodes, body: Array, load: int):
    """Add the body force m_I b_I to the external forces, where the scheme has it at the nodes and `body` (N, n, d) is not empty."""
    with for_range(0, where(scheme.nodal_body & (body.shape[0] > 0), nodes.inertia.shape[1], 0)) as i:
        for c in range(len(zero)):
            nodes.external[c, i] += nodes.inertia[0, i] * body[load, i, c]


@traced
def join(grid: Grid, values, like) -> None:
    """Add the values of the ghost nodes of a periodic axis to their images, as many components as `like` has, and set them to zero."""
    with for_range(0, grid.ghosts.shape[0]) as g:
        ghost, image = grid.ghosts[g, 0], grid.ghosts[g, 1]
        for c in range(len(like)):
            values[c, image] += values[c, ghost]
            values[c, ghost] = 0.0


@traced
def repeat(grid: Grid, values) -> None:
    """Copy the values (d, n) of the images to the ghost nodes of a periodic axis."""
    with for_range(0, grid.ghosts.shape[0]) as g:
        ghost, image = grid.ghosts[g, 0], grid.ghosts[g, 1]
        for c in range(len(grid.lower)):
            values[c, ghost] = values[c, image]


@traced
def hold_velocity(grid: Grid, nodes: Nodes, faces: Faces, n: int, velocity: Array, added: Array) -> None:
    """Set v_b(t^{n-1/2}) at held nodes, and add to `added` (d,) the momentum that this takes."""
    with for_range(0, faces.held.shape[0]) as k:
        i, c, face = (faces.held[k, j] for j in range(3))
        held = faces.velocity[face, n]
        added[c] += nodes.inertia[0, i] * (held - velocity[c, i])
        velocity[c, i] = held
    repeat(grid, velocity)


@traced
def load_faces(nodes: Nodes, faces: Faces, least: LeastMass, n: int) -> None:
    """Add the tractions p n at t^n to the external forces and the acceleration; a massless node takes none."""
    with for_range(0, faces.loaded.shape[0]) as k:
        i, c, face = (faces.loaded[k, j] for j in range(3))
        mass = nodes.inertia[0, i]
        load = where(mass > least.force, faces.area[k] * faces.force[face, n], 0.0)
        nodes.external[c, i] += load
        nodes.acceleration[c, i] += where(mass > least.force, load / mass, 0.0)


@traced
def hold_acceleration(grid: Grid, nodes: Nodes, faces: Faces, n: int, dt: float) -> None:
    """Set [v_b(t^{n+1/2}) - v_b(t^{n-1/2})]/dt at held nodes; the reaction m_I a_I - f_I becomes their external force."""
    _, leap = leapfrog(n, dt)
    with for_range(0, faces.held.shape[0]) as k:
        i, c, face = (faces.held[k, j] for j in range(3))
        nodes.acceleration[c, i] = (faces.velocity[face, n + 1] - faces.velocity[face, n]) / leap
        nodes.external[c, i] = nodes.inertia[0, i] * nodes.acceleration[c, i] - nodes.internal[c, i]
    repeat(grid, nodes.acceleration)


@traced
def clear_correction(zero: Vector, nodes: Nodes) -> None:
    """Zero the correction of XPIC."""
    with for_range(0, nodes.inertia.shape[1]) as i:
        for c in range(len(zero)):
            nodes.projected[c, i] = 0.0


@traced
def begin_series(grid: Grid, nodes: Nodes, values) -> None:
    """Take values of the nodes (d, n) as the first term of a series; zero the nodal momentum before `smooth` accumulates it."""
    with for_range(0, nodes.inertia.shape[1]) as i:
        for c in range(len(grid.lower)):
            nodes.term[c, i] = values[c, i]
            nodes.inertia[1 + c, i] = 0.0


@traced
def add_term(grid: Grid, nodes: Nodes, faces: Faces, least: LeastMass, total, reaction: float, added: Array) -> None:
    """t_I <- t_I - p_I/m_I, 0 at held nodes, and `total` (d, n) += t: the next term of sum_j (I - S^+ S)^j.

    The part of the term that is dropped at a held node counts as its reaction in a series of accelerations (`reaction` 1), as
    momentum `added` (d,) in a series of velocities (`reaction` 0).
    """
    count, d = nodes.inertia.shape[1], len(grid.lower)
    join(grid, nodes.inertia, (0.0, *grid.lower))
    with for_range(0, count) as i:
        mass = nodes.inertia[0, i]
        for c in range(d):
            nodes.term[c, i] = where(mass > least.velocity, nodes.term[c, i] - nodes.inertia[1 + c, i] / mass, 0.0)
            nodes.inertia[1 + c, i] = 0.0
    with for_range(0, faces.held.shape[0]) as k:
        i, c = faces.held[k, 0], faces.held[k, 1]
        refused = nodes.inertia[0, i] * nodes.term[c, i]
        nodes.external[c, i] -= reaction * refused
        added[c] -= (1.0 - reaction) * refused
        nodes.term[c, i] = 0.0
    repeat(grid, nodes.term)
    with for_range(0, count) as i:
        for c in range(d):
            total[c, i] += nodes.term[c, i]
