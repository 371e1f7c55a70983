"""How a run ended: its status, and the advice of its cause where the state at its end tells it."""

from typing import NamedTuple

import numpy as np

from mpmverify.problem import Array, Discretisation, Problem, Velocity
from mpmverify.solution import Outcome, Status

from .histories import COMPLETED, INVERTED, LEFT_GRID, NON_FINITE, UNSTABLE
from .state import Nodes

STATUSES = {
    COMPLETED: Status.COMPLETED,
    UNSTABLE: Status.UNSTABLE,
    NON_FINITE: Status.NON_FINITE,
    LEFT_GRID: Status.LEFT_GRID,
    INVERTED: Status.NON_FINITE,
}
LIGHT = 0.25
"""Part of the largest nodal mass below which the fastest node of a run that failed counts as one of small mass."""


class End(NamedTuple):
    """State of a run at its last step.

    code : int
        Status of the time loop.
    step, steps : int
        The last step, and the number of steps.
    dt : float
        Time step [s].
    reference, position : ndarray
        X and x of the particles (P, d) [m].
    nodes : Nodes
        Values at the nodes.
    """

    code: int
    step: int
    steps: int
    dt: float
    reference: Array
    position: Array
    nodes: Nodes


def outcome(end: End, problem: Problem, level: Discretisation, basis: str) -> Outcome:
    """Say how a run with a basis ended, at which step, and what helps."""
    status = STATUSES[end.code]
    if status is Status.COMPLETED:
        return Outcome()
    causes = {INVERTED: "; a particle's deformation gradient reached zero"}
    if basis == "cpdi":
        causes[LEFT_GRID] = "; a domain reaches further than a cell from its particle, or a particle left the grid"
    detail = f"at step {end.step} of {end.steps}{causes.get(end.code, '')}"
    if end.code == LEFT_GRID:
        return Outcome(status, detail, _of_moving_face(end, problem))
    return Outcome(status, detail, _of_small_mass(end.nodes, level) if basis == "linear" else "")


def _of_moving_face(end: End, problem: Problem) -> str:
    """Advice where faces carried a particle off the grid: across its axis, they moved half as far as that particle or more.

    The faces of a larger box move as well, while its grid stays at rest.
    """
    time, faces = np.array([end.step * end.dt]), []
    for face, condition in problem.boundary.items():
        if isinstance(condition, Velocity):
            k, moved = "xyz".index(face[0]), abs(condition.value.integral(time)[0])
            x = end.position[:, k]
            outside = (x < problem.lower[k]) | (x > problem.upper[k])
            if moved > 0 and np.any(np.abs(x - end.reference[:, k])[outside] <= 2 * moved):
                faces.append(face)
    return (
        f"the motion of {' and '.join(faces)} carried a particle off the background grid, which stays at rest, and the faces of a larger "
        "domain move as well: take the total Lagrangian formulation, or a shorter motion"
        if faces
        else ""
    )


def _of_small_mass(nodes: Nodes, level: Discretisation) -> str:
    """Advice where a hat of small mass is the fastest node, at a Courant number below the limit that cells of full mass have."""
    mass, speed = nodes.inertia[0], np.sqrt((nodes.velocity**2).sum(axis=0))
    fastest = np.argmax(np.where(mass > 0, speed, 0.0))
    share = mass[fastest] / mass.max()
    if not np.isfinite(speed).all() or share > LIGHT or level.courant > 1 / np.sqrt(len(nodes.velocity)):
        return ""
    return (
        f"the fastest node has {share:.1g} of the largest nodal mass, and the stable time step falls with the mass of a node: take the "
        "schedule MUSL or USF with FLIP, or B-splines or GIMP, before a smaller step"
    )
