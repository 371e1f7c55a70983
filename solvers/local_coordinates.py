"""Local coordinates of points in two-node bars and four-node quadrilaterals, and the search for the element that holds them.

References
----------
M. Molinos, GeHoJerez (2019), item "Get the nodal coordinates of the material points".
O. C. Zienkiewicz, R. L. Taylor and J. Z. Zhu, The Finite Element Method, 6th edition, Elsevier 2005, section 5.
"""

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mpmverify.errors import UsageError
from mpmverify.problem import Array

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Local coordinates of a quadrilateral's nodes, counter-clockwise."""
CONVERGED = 1e-14
"""Residual, in diameters of the element, from which Newton's next step is the last."""
ITERATIONS, HALVINGS = 60, 30
FLAT = 1e-10
"""Least Jacobian at a node, in squared diameters, of an element that counts."""
TOUCHING = 1e-13
"""Distance, in sizes of the mesh, within which a point lies on an edge."""


@njit(cache=True, fastmath={"contract"})
def shape_functions(xi: Array, N: Array, dN: Array) -> None:
    """Set N_a (n,) and dN_a/dxi_j (n, dim) [1]: (1 -+ xi)/2, or (1 + xi_a xi)(1 + eta_a eta)/4."""
    if len(xi) == 1:
        N[0], N[1] = (1 - xi[0]) / 2, (1 + xi[0]) / 2
        dN[0, 0], dN[1, 0] = -0.5, 0.5
        return
    for a in range(4):
        s, t = CORNERS[a]
        N[a] = (1 + s * xi[0]) * (1 + t * xi[1]) / 4
        dN[a, 0], dN[a, 1] = s * (1 + t * xi[1]) / 4, t * (1 + s * xi[0]) / 4


@njit(cache=True, fastmath={"contract"})
def residual(nodes: Array, x: Array, xi: Array, N: Array, dN: Array, r: Array) -> float:
    """Set r = x - sum_a N_a(xi) x_a (dim,) and return its norm."""
    shape_functions(xi, N, dN)
    for i in range(len(x)):
        r[i] = x[i] - np.sum(N * nodes[:, i])
    return np.sqrt(np.sum(r * r))


@njit(cache=True, fastmath={"contract"})
def newton(corners: Array, point: Array, xi: Array) -> bool:
    """Solve sum_a N_a(xi) x_a = x for xi (dim,) from the centre by damped Newton steps J dxi = r; whether it converged.

    The path that the steps follow maps to the straight line from the centre to x. For x in a convex element that line stays inside,
    where det J > 0: with steps halved until the residual falls, Newton's method then always arrives.
    """
    n, dim = corners.shape
    N, dN, r, step, trial = np.empty(n), np.empty((n, dim)), np.empty(dim), np.empty(dim), np.empty(dim)
    centre = corners[0].copy()
    size = 0.0
    for a in range(n):
        size = max(size, np.abs(corners[a] - centre).max())
    # Relative to a node and to the size, or a small element far from the origin would lose its digits.
    nodes, x = (corners - centre) / size, (point - centre) / size
    xi[:] = 0.0
    error = residual(nodes, x, xi, N, dN, r)
    for _ in range(ITERATIONS):
        J = nodes.T @ dN
        if dim == 1:
            step[0] = r[0] / J[0, 0]
        else:
            det = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
            if det == 0:
                return False
            step[0] = (J[1, 1] * r[0] - J[0, 1] * r[1]) / det
            step[1] = (J[0, 0] * r[1] - J[1, 0] * r[0]) / det
        if error <= CONVERGED * (1 + np.abs(x).max()):
            xi += step
            return True
        share = 1.0
        for _ in range(HALVINGS):
            trial[:] = xi + share * step
            reached = residual(nodes, x, trial, N, dN, r)
            if reached <= (1 - share / 4) * error:
                break
            share /= 2
        else:
            return False
        xi[:], error = trial, reached
    return False


@njit(cache=True, fastmath={"contract"})
def least_jacobian(nodes: Array) -> float:
    """Least of the Jacobians at the nodes, in diameters^dim: positive for a convex element numbered counter-clockwise."""
    n, dim = nodes.shape
    if dim == 1:
        length = nodes[1, 0] - nodes[0, 0]
        return length / max(abs(length), np.abs(nodes).max() * 1e-5)
    least, diameter = np.inf, 0.0
    for a in range(n):
        before, after = nodes[a] - nodes[a - 1], nodes[(a + 1) % n] - nodes[a]
        cross = before[0] * after[1] - before[1] * after[0]
        if np.isnan(cross):
            return np.nan
        least, diameter = min(least, cross), max(diameter, np.sum((nodes[a] - nodes[a - 2]) ** 2))
    return least / diameter if diameter > 0 else 0.0


@njit(cache=True, fastmath={"contract"})
def depth(nodes: Array, x: Array) -> float:
    """Least signed distance of x to the sides of a convex element [m], positive inside."""
    n, dim = nodes.shape
    if dim == 1:
        return min(x[0] - nodes[0, 0], nodes[1, 0] - x[0])
    least = np.inf
    for a in range(n):
        p, q = nodes[a], nodes[(a + 1) % n]
        side = np.sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2)
        least = min(least, ((q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0])) / side)
    return least


@njit(cache=True, fastmath={"contract"})
def search(
    corners: Array,
    lower: Array,
    upper: Array,
    touching: float,
    nodes: NDArray[np.int64],
    first: NDArray[np.int64],
    around: NDArray[np.int64],
    guess: NDArray[np.int64],
    points: Array,
    found: NDArray[np.int64],
    local: Array,
) -> None:
    """Set the lowest element that holds each point (P,), -1 if none, and its local coordinates (P, dim).

    `corners` (E, n, dim) and boxes `lower`, `upper` (E, dim) [m]; `around[first[i]:first[i + 1]]` are the elements at node i.
    """
    for k in range(len(points)):
        x = points[k]
        if not np.isfinite(x).all():
            continue
        if guess[k] >= 0:
            for node in nodes[guess[k]]:
                for e in around[first[node] : first[node + 1]]:
                    # Deep enough for no other element to claim it: the answer does not depend on the guess.
                    if found[k] < 0 and depth(corners[e], x) > 1000 * touching:
                        found[k] = e
        if found[k] < 0:
            for e in range(len(corners)):
                boxed = True
                for i in range(len(x)):
                    boxed = boxed and lower[e, i] - touching <= x[i] <= upper[e, i] + touching
                if boxed and depth(corners[e], x) >= -touching:
                    found[k] = e
                    break
        if found[k] >= 0 and not newton(corners[found[k]], x, local[k]):
            local[k] = np.nan


def elements_of(coordinates: Array, connectivity: NDArray[np.int64]) -> Array:
    """Nodal coordinates by element (E, n, dim) [m], each checked."""
    corners = np.ascontiguousarray(coordinates[connectivity])
    if corners.shape[1:] not in ((2, 1), (4, 2)):
        raise UsageError(
            f"elements are two-node bars in 1D or four-node quadrilaterals in 2D, not {corners.shape[1:]!r} arrays"
        )
    for e, nodes in enumerate(corners):
        if not least_jacobian(nodes) > FLAT:
            remedy = "give its nodes in increasing order" if nodes.shape[1] == 1 else "give a convex one, counter-clockwise"
            raise UsageError(f"element {e} is degenerate, with nodes at {nodes.tolist()}: {remedy}")
    return corners


def inverse_map(nodes: ArrayLike, x: ArrayLike) -> Array:
    """Local coordinates xi of points, sum_a N_a(xi) x_a = x, by Newton's method.

    Parameters
    ----------
    nodes : ArrayLike
        Nodes of a two-node bar (2, 1) or of a convex four-node quadrilateral, counter-clockwise, (4, 2) [m].
    x : ArrayLike
        One point (dim,) or several (P, dim) [m], inside the element or near it.

    Returns
    -------
    Array
        xi, shaped as `x` [1]; within [-1, 1] inside the element.

    Raises
    ------
    UsageError
        If the element is degenerate, or a point lies where the map has no inverse.
    """
    corners = np.asarray(nodes, dtype=float)
    (corners,) = elements_of(corners, np.arange(len(corners))[None])
    points = np.asarray(x, dtype=float)
    local = np.empty((points.size // corners.shape[1], corners.shape[1]))
    for point, xi in zip(np.ascontiguousarray(points).reshape(local.shape), local, strict=True):
        if not newton(corners, point, xi):
            raise UsageError(
                f"the point {point.tolist()} has no local coordinates in the element {corners.tolist()}: give one inside"
            )
    return local.reshape(points.shape)


def find_element(
    coordinates: ArrayLike, connectivity: ArrayLike, points: ArrayLike, guess: ArrayLike | None = None
) -> tuple[NDArray[np.int64], Array]:
    """Find the element that holds each point, and the point's local coordinates there.

    Parameters
    ----------
    coordinates : ArrayLike
        Nodes of the mesh (n, dim) [m].
    connectivity : ArrayLike
        Nodes of each element (E, 2) in 1D or (E, 4) in 2D.
    points : ArrayLike
        Points (P, dim) [m].
    guess : ArrayLike, optional
        Element of each point a step ago (P,), -1 if unknown: it and its neighbours are tried first. It changes the cost only.

    Returns
    -------
    element : NDArray[np.int64]
        (P,), on a shared edge the lowest of the elements, -1 outside all of them.
    local : Array
        (P, dim) [1], NaN outside.

    Raises
    ------
    UsageError
        If an element is degenerate or names no node, or the arrays do not fit together.
    """
    X, elements, x = np.asarray(coordinates, float), np.ascontiguousarray(connectivity, np.int64), np.asarray(points, float)
    if elements.size and not (elements.min() >= 0 and elements.max() < len(X)):
        raise UsageError(f"an element names a node outside 0 to {len(X) - 1}")
    corners = elements_of(X, elements)
    start = np.full(len(x), -1) if guess is None else np.asarray(guess, np.int64)
    if x.shape != (len(x), X.shape[1]) or start.shape != (len(x),) or not (start < len(elements)).all():
        raise UsageError("points are (P, dim) as the nodes are (n, dim), and guesses (P,) name elements or are -1")
    touching = TOUCHING * float(np.ptp(X, axis=0).max() + np.abs(X).max())
    order = np.argsort(elements.ravel(), kind="stable")
    first = np.searchsorted(elements.ravel()[order], np.arange(len(X) + 1))
    found, local = np.full(len(x), -1), np.full(x.shape, np.nan)
    boxes = corners.min(axis=1), corners.max(axis=1)
    around = order // elements.shape[1]
    search(corners, *boxes, touching, elements, first, around, start, np.ascontiguousarray(x), found, local)
    return found, local
