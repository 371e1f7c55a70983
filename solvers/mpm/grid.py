"""What happens at the nodes: velocity, boundary conditions, acceleration, and what the external forces give."""

from mpmverify.problem import Array

from .compilation import jit
from .state import Faces, Grid, Nodes, Scheme

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@jit
def leapfrog(n: int, dt: float) -> tuple[float, float]:
    """Time from v^{n-1/2} to v^n and to v^{n+1/2}; v^0 is given, and v^{1/2} = v^0 + dt/2 a^0 keeps second order under load."""
    return (0.5 * dt, dt) if n > 0 else (0.0, 0.5 * dt)


@jit
def clear(nodes: Nodes) -> None:
    """Nothing at the nodes."""
    for i in range(nodes.inertia.shape[0]):
        nodes.inertia[i, 0] = 0.0
        for c in range(nodes.velocity.shape[1]):
            nodes.inertia[i, 1 + c] = nodes.internal[i, c] = nodes.external[i, c] = 0.0


@jit
def join(grid: Grid, sums) -> None:
    """Add what was spread to the ghost nodes of a periodic axis to their images."""
    for g in range(grid.ghosts.shape[0]):
        ghost, image = grid.ghosts[g, 0], grid.ghosts[g, 1]
        for c in range(sums.shape[1]):
            sums[image, c] += sums[ghost, c]
            sums[ghost, c] = 0.0


@jit
def repeat(grid: Grid, values) -> None:
    """Give the ghost nodes of a periodic axis the values of their images."""
    for g in range(grid.ghosts.shape[0]):
        ghost, image = grid.ghosts[g, 0], grid.ghosts[g, 1]
        for c in range(values.shape[1]):
            values[ghost, c] = values[image, c]


@jit
def nodal_velocity(grid: Grid, nodes: Nodes, faces: Faces, n: int, massless: float, velocity, added) -> None:
    """v_I = p_I/m_I and v_b(t^{n-1/2}) where it is held; `added` (d,) is the momentum that this adds, sum_I (m_I v_I - p_I)."""
    join(grid, nodes.inertia)
    for c in range(added.size):
        added[c] = 0.0
    for i in range(nodes.inertia.shape[0]):
        mass = nodes.inertia[i, 0]
        for c in range(len(grid.lower)):
            momentum = nodes.inertia[i, 1 + c]
            velocity[i, c] = momentum / mass if mass > massless else 0.0
            if mass <= massless:
                added[c] -= momentum
    for k in range(faces.held.shape[0]):
        i, c, face = faces.held[k, 0], faces.held[k, 1], faces.held[k, 2]
        held = faces.velocity[face, n]
        added[c] += nodes.inertia[i, 0] * (held - velocity[i, c])
        velocity[i, c] = held
    repeat(grid, velocity)


@jit
def accelerate(
    scheme: Scheme,
    grid: Grid,
    nodes: Nodes,
    faces: Faces,
    body: Array,
    load: int,
    n: int,
    dt: float,
    massless: float,
) -> None:
    """a_I = f_I/m_I with the tractions p n and m_I b_I of a body force at nodes; [v_b(t^{n+1/2}) - v_b(t^{n-1/2})]/dt where it is held.

    The reaction m_I a_I - f_I is an external force.
    """
    join(grid, nodes.internal)
    join(grid, nodes.external)
    _, step = leapfrog(n, dt)
    if body.shape[0] > 0 and scheme.nodal_body:
        for i in range(nodes.inertia.shape[0]):
            for c in range(len(grid.lower)):
                nodes.external[i, c] += nodes.inertia[i, 0] * body[load, i, c]
    for k in range(faces.loaded.shape[0]):
        i, c, face = faces.loaded[k, 0], faces.loaded[k, 1], faces.loaded[k, 2]
        nodes.external[i, c] += faces.area[k] * faces.force[face, n]
    for i in range(nodes.inertia.shape[0]):
        mass = nodes.inertia[i, 0]
        for c in range(len(grid.lower)):
            if mass > massless:
                nodes.acceleration[i, c] = (nodes.internal[i, c] + nodes.external[i, c]) / mass
            else:
                nodes.acceleration[i, c] = 0.0
                nodes.external[i, c] = -nodes.internal[i, c]
    for k in range(faces.held.shape[0]):
        i, c, face = faces.held[k, 0], faces.held[k, 1], faces.held[k, 2]
        nodes.acceleration[i, c] = (faces.velocity[face, n + 1] - faces.velocity[face, n]) / step
        nodes.external[i, c] = nodes.inertia[i, 0] * nodes.acceleration[i, c] - nodes.internal[i, c]
    repeat(grid, nodes.acceleration)


@jit
def begin_series(nodes: Nodes, values) -> None:
    """Values of the nodes (n, d) as the first term of a series; the momentum is set to zero for what the particles make of it."""
    for i in range(nodes.inertia.shape[0]):
        for c in range(values.shape[1]):
            nodes.term[i, c] = values[i, c]
            nodes.inertia[i, 1 + c] = 0.0


@jit
def add_term(grid: Grid, nodes: Nodes, faces: Faces, massless: float, total, force: bool, added) -> None:
    """t_I <- t_I - p_I/m_I, nothing where it is held, and `total` (n, d) += t: the next term of sum_j (I - S^+ S)^j.

    What a held node is refused counts as its reaction for a series of accelerations (`force`), else as momentum `added` (d,).
    """
    join(grid, nodes.inertia)
    for i in range(nodes.inertia.shape[0]):
        mass = nodes.inertia[i, 0]
        for c in range(len(grid.lower)):
            nodes.term[i, c] = nodes.term[i, c] - nodes.inertia[i, 1 + c] / mass if mass > massless else 0.0
            nodes.inertia[i, 1 + c] = 0.0
    for k in range(faces.held.shape[0]):
        i, c = faces.held[k, 0], faces.held[k, 1]
        refused = nodes.inertia[i, 0] * nodes.term[i, c]
        if force:
            nodes.external[i, c] -= refused
        else:
            added[c] -= refused
        nodes.term[i, c] = 0.0
    repeat(grid, nodes.term)
    for i in range(nodes.inertia.shape[0]):
        for c in range(len(grid.lower)):
            total[i, c] += nodes.term[i, c]


@jit
def external_force_and_power(grid: Grid, nodes: Nodes, kick: float, force) -> float:
    """Sum of the external forces into `force` (d,), and their power sum_I f_I v_I at t^n."""
    power = 0.0
    for c in range(force.size):
        force[c] = 0.0
    for i in range(nodes.inertia.shape[0]):
        for c in range(len(grid.lower)):
            f = nodes.external[i, c]
            force[c] += f
            power += f * (nodes.velocity[i, c] + kick * nodes.acceleration[i, c])
    return power


@jit
def kick_nodes(grid: Grid, nodes: Nodes, step: float) -> None:
    """v_I += step a_I, where it is held it arrives at v_b(t^{n+1/2}); the momentum is set to zero for another projection."""
    for i in range(nodes.inertia.shape[0]):
        for c in range(len(grid.lower)):
            nodes.velocity[i, c] += step * nodes.acceleration[i, c]
            nodes.inertia[i, 1 + c] = 0.0
