"""What happens at the nodes: velocity, boundary conditions, acceleration, and what the external forces give."""

from mpmverify.problem import Array

from .compilation import jit
from .state import Faces, Grid, Nodes, Strips

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@jit
def leapfrog(n: int, dt: float) -> tuple[float, float]:
    """Time from v^{n-1/2} to v^n and to v^{n+1/2}; v^0 is given, and v^{1/2} = v^0 + dt/2 a^0 keeps second order under load."""
    return (0.5 * dt, dt) if n > 0 else (0.0, 0.5 * dt)


@jit
def clear(
    nodes: Nodes,
    strips: Strips,
    velocity: Array,
    massless: float,
    body: Array,
    load: int,
    kick: float,
    step: float,
    sums: Array,
    begin: int,
    end: int,
) -> None:
    """Nothing at the nodes from `begin` to `end`."""
    for totals in (nodes.inertia, nodes.internal, nodes.external):
        for c in range(totals.shape[0]):
            values = totals[c, begin:end]
            for i in range(values.size):
                values[i] = 0.0


@jit
def join(grid: Grid, sums) -> None:
    """Add what was spread to the ghost nodes of a periodic axis to their images."""
    for g in range(grid.ghosts.shape[0]):
        ghost, image = grid.ghosts[g, 0], grid.ghosts[g, 1]
        for c in range(sums.shape[0]):
            sums[c, image] += sums[c, ghost]
            sums[c, ghost] = 0.0


@jit
def repeat(grid: Grid, values) -> None:
    """Give the ghost nodes of a periodic axis the values of their images."""
    for g in range(grid.ghosts.shape[0]):
        ghost, image = grid.ghosts[g, 0], grid.ghosts[g, 1]
        for c in range(values.shape[0]):
            values[c, ghost] = values[c, image]


@jit
def nodal_velocity(
    nodes: Nodes,
    strips: Strips,
    velocity: Array,
    massless: float,
    body: Array,
    load: int,
    kick: float,
    step: float,
    sums: Array,
    begin: int,
    end: int,
) -> None:
    """v_I = p_I/m_I of the nodes from `begin` to `end`; `sums` (d,) is the momentum that this adds, where there is no mass."""
    mass = nodes.inertia[0, begin:end]
    for c in range(velocity.shape[0]):
        momentum, v = nodes.inertia[1 + c, begin:end], velocity[c, begin:end]
        for i in range(mass.size):
            v[i] = momentum[i] / mass[i] if mass[i] > massless else 0.0
        sums[c] = 0.0
        for i in range(mass.size):
            if mass[i] <= massless:
                sums[c] -= momentum[i]


@jit
def hold_velocity(grid: Grid, nodes: Nodes, faces: Faces, n: int, velocity, added) -> None:
    """v_b(t^{n-1/2}) where it is held, and the momentum that this adds (d,)."""
    for k in range(faces.held.shape[0]):
        i, c, face = faces.held[k, 0], faces.held[k, 1], faces.held[k, 2]
        held = faces.velocity[face, n]
        added[c] += nodes.inertia[0, i] * (held - velocity[c, i])
        velocity[c, i] = held
    repeat(grid, velocity)


@jit
def load_faces(nodes: Nodes, faces: Faces, n: int) -> None:
    """Add the tractions p n at t^n to the external forces."""
    for k in range(faces.loaded.shape[0]):
        i, c, face = faces.loaded[k, 0], faces.loaded[k, 1], faces.loaded[k, 2]
        nodes.external[c, i] += faces.area[k] * faces.force[face, n]


@jit
def accelerate(
    nodes: Nodes,
    strips: Strips,
    velocity: Array,
    massless: float,
    body: Array,
    load: int,
    kick: float,
    step: float,
    sums: Array,
    begin: int,
    end: int,
) -> None:
    """a_I = f_I/m_I of the nodes from `begin` to `end`, with m_I b_I of a body force (n, d) at nodes; the external force is the
    reaction where there is no mass.
    """
    mass = nodes.inertia[0, begin:end]
    for c in range(nodes.acceleration.shape[0]):
        internal, external, a = nodes.internal[c, begin:end], nodes.external[c, begin:end], nodes.acceleration[c, begin:end]
        if body.shape[0] > 0:
            for i in range(mass.size):
                external[i] += mass[i] * body[load, begin + i, c]
        for i in range(mass.size):
            external[i] = external[i] if mass[i] > massless else -internal[i]
            a[i] = (internal[i] + external[i]) / mass[i] if mass[i] > massless else 0.0


@jit
def hold_acceleration(grid: Grid, nodes: Nodes, faces: Faces, n: int, dt: float) -> None:
    """[v_b(t^{n+1/2}) - v_b(t^{n-1/2})]/dt where it is held; the reaction m_I a_I - f_I is an external force."""
    _, step = leapfrog(n, dt)
    for k in range(faces.held.shape[0]):
        i, c, face = faces.held[k, 0], faces.held[k, 1], faces.held[k, 2]
        nodes.acceleration[c, i] = (faces.velocity[face, n + 1] - faces.velocity[face, n]) / step
        nodes.external[c, i] = nodes.inertia[0, i] * nodes.acceleration[c, i] - nodes.internal[c, i]
    repeat(grid, nodes.acceleration)


@jit
def kick_nodes(
    nodes: Nodes,
    strips: Strips,
    velocity: Array,
    massless: float,
    body: Array,
    load: int,
    kick: float,
    step: float,
    sums: Array,
    begin: int,
    end: int,
) -> None:
    """v_I += step a_I of the nodes from `begin` to `end`, where it is held it arrives at v_b(t^{n+1/2}); the momentum is set to zero for
    another projection. Before, sum_I f_I v_I at t^n and sum_I f_I of the external forces (1 + d,).
    """
    sums[0] = 0.0
    for c in range(nodes.velocity.shape[0]):
        momentum, external = nodes.inertia[1 + c, begin:end], nodes.external[c, begin:end]
        v, a = nodes.velocity[c, begin:end], nodes.acceleration[c, begin:end]
        power, force = 0.0, 0.0
        for i in range(v.size):
            force += external[i]
            power += external[i] * (v[i] + kick * a[i])
        for i in range(v.size):
            v[i] += step * a[i]
            momentum[i] = 0.0
        sums[0] += power
        sums[1 + c] = force


@jit
def begin_series(nodes: Nodes, values) -> None:
    """Values of the nodes (d, n) as the first term of a series; the momentum is set to zero for what the particles make of it."""
    for i in range(nodes.inertia.shape[1]):
        for c in range(values.shape[0]):
            nodes.term[c, i] = values[c, i]
            nodes.inertia[1 + c, i] = 0.0


@jit
def add_term(grid: Grid, nodes: Nodes, faces: Faces, massless: float, total, reaction: float, added) -> None:
    """t_I <- t_I - p_I/m_I, nothing where it is held, and `total` (d, n) += t: the next term of sum_j (I - S^+ S)^j.

    What a held node is refused counts as its reaction for a series of accelerations (`reaction` 1), for one of velocities (0) as
    momentum `added` (d,).
    """
    join(grid, nodes.inertia)
    for i in range(nodes.inertia.shape[1]):
        mass = nodes.inertia[0, i]
        for c in range(len(grid.lower)):
            nodes.term[c, i] = nodes.term[c, i] - nodes.inertia[1 + c, i] / mass if mass > massless else 0.0
            nodes.inertia[1 + c, i] = 0.0
    for k in range(faces.held.shape[0]):
        i, c = faces.held[k, 0], faces.held[k, 1]
        refused = nodes.inertia[0, i] * nodes.term[c, i]
        nodes.external[c, i] -= reaction * refused
        added[c] -= (1 - reaction) * refused
        nodes.term[c, i] = 0.0
    repeat(grid, nodes.term)
    for i in range(nodes.inertia.shape[1]):
        for c in range(len(grid.lower)):
            total[c, i] += nodes.term[c, i]
