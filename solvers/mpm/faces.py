"""Tables of the boundary conditions, over the nodes of the faces and the time levels of the leapfrog scheme, and of the body force."""

from typing import NamedTuple

import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem import Array, BodyForce, Fixed, Periodic, Problem, Spatial, Traction, Velocity

from .basis import Axis
from .state import Integers


class Faces(NamedTuple):
    """Conditions on the faces of the box, for K held and L loaded components of nodes.

    held : ndarray
        Node, component and row of `velocity` (K, 3).
    loaded : ndarray
        Node, component and row of `force` (L, 3).
    area : ndarray
        Integral of N_I over the face (L,) [m^(d-1)].
    velocity : ndarray
        v_b at 0 and all t^{n+1/2} (rows, N + 2) [m/s].
    force : ndarray
        p n at all t^n (rows, N + 1) [Pa].
    """

    held: Integers
    loaded: Integers
    area: Array
    velocity: Array
    force: Array


def node_numbers(axes: tuple[Axis, ...]) -> Integers:
    """Number of every node, an array with x last and fastest."""
    counts = [len(axis.nodes) for axis in reversed(axes)]
    return np.arange(np.prod(counts), dtype=np.int64).reshape(counts)


def node_positions(axes: tuple[Axis, ...]) -> Array:
    """Material coordinates of the nodes (n, d) [m], x fastest."""
    mesh = np.meshgrid(*(axis.nodes for axis in reversed(axes)), indexing="ij")
    return np.stack([coordinate.ravel() for coordinate in reversed(mesh)], axis=1)


def ghosts(axes: tuple[Axis, ...]) -> Integers:
    """Ghost nodes beyond the upper end of periodic axes, and their images (G, 2)."""
    numbers = node_numbers(axes)
    images = numbers
    for k, axis in enumerate(reversed(axes)):
        if axis.periodic:
            images = np.take(images, np.arange(len(axis.nodes)) % axis.cells, axis=k)
    beyond = numbers != images
    return np.stack([numbers[beyond], images[beyond]], axis=1)


def integrals(axis: Axis, h: float, lower: float, upper: float) -> Array:
    """Integral of every function along an axis from one place [m] to another (C + W - 1,) [m]."""
    width = axis.polynomials.shape[1]
    a, b = (np.clip((end - axis.lower) / h - np.arange(axis.cells), 0, 1) for end in (lower, upper))
    total = np.zeros(len(axis.nodes))
    for power in range(width):
        share = (b ** (power + 1) - a ** (power + 1)) / (power + 1)
        for k in range(width):
            first = axis.padding + k
            total[first : first + axis.cells] += h * share * axis.polynomials[axis.piece, power, k]
    if axis.periodic:
        np.add.at(total, np.arange(axis.cells, len(total)) % axis.cells, total[axis.cells :].copy())
    return total


def tabulate_faces(problem: Problem, axes: tuple[Axis, ...], h: float, steps: int, dt: float) -> Faces:
    """Conditions at the nodes of the faces; where faces meet, a clamped one takes precedence over a prescribed normal velocity.

    The nodes beyond a held face are held, too.
    """
    numbers = node_numbers(axes)
    levels = np.arange(steps + 1, dtype=np.float64) * dt
    halves = np.concatenate([[0.0], levels + 0.5 * dt])
    held, loaded, area = [], [], []
    velocity, force = [np.zeros(steps + 2)], [np.zeros(steps + 1)]
    own = tuple(slice(axis.cells if axis.periodic else None) for axis in reversed(axes))
    clamped_last = sorted(problem.boundary.items(), key=lambda item: isinstance(item[1], Fixed))
    for face, condition in clamped_last:
        k, sign = "xyz".index(face[0]), 1 if face[1] == "+" else -1
        across = problem.dimension - 1 - k
        if isinstance(condition, Periodic):
            continue
        edge = end_node(axes[k], sign)
        on_face = np.take(numbers[own], edge, axis=across).ravel()
        from_face = np.take(numbers[own], range(edge + 1) if sign < 0 else range(edge, len(axes[k].nodes)), axis=across)
        if isinstance(condition, Fixed):
            held += [(node, c, 0) for node in from_face.ravel() for c in range(problem.dimension)]
        elif isinstance(condition, Velocity):
            held += [(node, k, len(velocity)) for node in from_face.ravel()]
            velocity.append(condition.value(halves))
        else:
            assert isinstance(condition, Traction)
            values = condition.value(levels)
            if values.any() or not np.isfinite(values).all():
                loaded += [(node, k, len(force)) for node in on_face]
                sides = problem.touched(face)
                area.append(sum(_areas(axes, h, k, side.lower, side.upper).ravel() for side in sides))
                force.append(sign * values)
    return Faces(
        np.array(held, dtype=np.int64).reshape(-1, 3),
        np.array(loaded, dtype=np.int64).reshape(-1, 3),
        np.concatenate([*area, np.zeros(0)]),
        np.array(velocity),
        np.array(force),
    )


def end_node(axis: Axis, sign: int) -> int:
    """Node at the lower or upper end of an axis that is not periodic."""
    return axis.padding + (axis.cells + axis.polynomials.shape[1] - 2 if sign > 0 else 0)


def _areas(axes: tuple[Axis, ...], h: float, normal: int, lower: tuple[float, ...], upper: tuple[float, ...]) -> Array:
    """Integrals over the part of a face between two corners of the functions of its nodes."""
    total = np.ones(())
    for k, axis in reversed(list(enumerate(axes))):
        if k != normal:
            along = integrals(axis, h, lower[k], upper[k])[: axis.cells if axis.periodic else None]
            total = np.multiply.outer(total, along)
    return total


def tabulate_body_force(body_force: BodyForce | Spatial | None, points: Array, times: Array) -> Array:
    """Body force (B, K, d) [m/s^2] at points (K, d) [m] and times (B,) [s]; empty when there is none.

    Raises
    ------
    UsageError
        If what the body force returns has another shape.
    """
    if body_force is None:
        return np.zeros((0, 0, 0))
    force = body_force.force if isinstance(body_force, Spatial) else body_force
    values = np.ascontiguousarray(force(points, times), dtype=float)
    if values.shape != (expected := (len(times), *points.shape)):  # compiled code does not look at it
        raise UsageError(
            f"the body force has shape {values.shape} at {len(points)} points and {len(times)} times: return {expected}"
        )
    return values
