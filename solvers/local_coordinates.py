"""Local coordinates of points in two-node bars and four-node quadrilaterals, and the search for the element of a point.

References
----------
M. Molinos, GeHoJerez (2019), item "Get the nodal coordinates of the material points".
O. C. Zienkiewicz, R. L. Taylor and J. Z. Zhu, The Finite Element Method, 6th edition, Elsevier 2005, section 5.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mpmverify.errors import UsageError
from mpmverify.problem import Array

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Local coordinates of a quadrilateral's nodes, counter-clockwise."""
CONVERGED = 1e-14
"""Residual relative to the size of the element at which Newton's method takes its last step."""
ITERATIONS, HALVINGS = 60, 30
"""Largest number of Newton steps, and of halvings of one step."""
FLAT = 1e-10
"""An element is degenerate when the least Jacobian at its nodes, relative to its squared diameter, is at most this."""
TOUCHING = 1e-13
"""A point lies on an edge when its distance to the edge, relative to the size of the mesh, is at most this."""


@njit(cache=True, fastmath={"contract"})
def shape_functions(xi: Array, N: Array, dN: Array) -> None:
    """Set N_a (n,) and dN_a/dxi_j (n, dim) [1] of a bar, N = (1 -+ xi)/2, or a quadrilateral, N_a = (1 + xi_a xi)(1 + eta_a eta)/4."""
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
    square = 0.0
    for i in range(len(x)):
        mapped = 0.0
        for a in range(len(N)):
            mapped += N[a] * nodes[a, i]
        r[i] = x[i] - mapped
        square += r[i] * r[i]
    return math.sqrt(square)


@njit(cache=True, fastmath={"contract"})
def newton(corners: Array, point: Array, xi: Array) -> bool:
    """Solve sum_a N_a(xi) x_a = x for xi (dim,) by damped Newton steps J dxi = r from the centre; return whether it converged.

    In the limit of small steps the iterates map to the straight line from the image of the centre to x. For x in a convex
    element this line stays inside the element, where det J > 0, so that Newton's method converges if each step is halved until
    the residual decreases.
    """
    n, dim = corners.shape
    N, dN, r, step, trial = np.empty(n), np.empty((n, dim)), np.empty(dim), np.empty(dim), np.empty(dim)
    nodes, x, J = np.empty((n, dim)), np.empty(dim), np.empty((dim, dim))
    size, farthest = 0.0, 0.0
    for a in range(n):
        for i in range(dim):
            size = max(size, abs(corners[a, i] - corners[0, i]))
    # Shifted to a node and scaled by the size: a small element far from the origin would otherwise lose digits.
    for i in range(dim):
        for a in range(n):
            nodes[a, i] = (corners[a, i] - corners[0, i]) / size
        x[i] = (point[i] - corners[0, i]) / size
        farthest = max(farthest, abs(x[i]))
        xi[i] = 0.0
    error = residual(nodes, x, xi, N, dN, r)
    for _ in range(ITERATIONS):
        for i in range(dim):
            for j in range(dim):
                J[i, j] = 0.0
                for a in range(n):
                    J[i, j] += nodes[a, i] * dN[a, j]
        if dim == 1:
            step[0] = r[0] / J[0, 0]
        else:
            det = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
            if det == 0:
                return False
            step[0] = (J[1, 1] * r[0] - J[0, 1] * r[1]) / det
            step[1] = (J[0, 0] * r[1] - J[1, 0] * r[0]) / det
        if error <= CONVERGED * (1 + farthest):
            for i in range(dim):
                xi[i] += step[i]
            return True
        share = 1.0
        for _ in range(HALVINGS):
            for i in range(dim):
                trial[i] = xi[i] + share * step[i]
            reached = residual(nodes, x, trial, N, dN, r)
            if reached <= (1 - share / 4) * error:
                break
            share /= 2
        else:
            return False
        for i in range(dim):
            xi[i] = trial[i]
        error = reached
    return False


@njit(cache=True, fastmath={"contract"})
def least_jacobian(nodes: Array) -> float:
    """Least Jacobian at the nodes relative to diameter^dim; positive if and only if the element is convex and counter-clockwise."""
    n, dim = nodes.shape
    if dim == 1:
        length = nodes[1, 0] - nodes[0, 0]
        return length / max(abs(length), abs(nodes[0, 0]) * 1e-5, abs(nodes[1, 0]) * 1e-5)
    least, diameter = math.inf, 0.0
    for a in range(n):
        o, p, q, s = nodes[a - 2], nodes[a - 1], nodes[a], nodes[(a + 1) % n]
        cross = (q[0] - p[0]) * (s[1] - q[1]) - (q[1] - p[1]) * (s[0] - q[0])
        if math.isnan(cross):
            return math.nan
        least, diameter = min(least, cross), max(diameter, (q[0] - o[0]) ** 2 + (q[1] - o[1]) ** 2)
    return least / diameter if diameter > 0 else 0.0


@njit(cache=True, fastmath={"contract"})
def depth(nodes: Array, x: Array) -> float:
    """Least signed distance of x from the sides of a convex element [m]; positive inside."""
    n, dim = nodes.shape
    if dim == 1:
        return min(x[0] - nodes[0, 0], nodes[1, 0] - x[0])
    least = math.inf
    for a in range(n):
        p, q = nodes[a], nodes[(a + 1) % n]
        side = math.sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2)
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
    """Set `found` (P,) to the lowest element that contains each point, -1 if none, and `local` (P, dim) to its coordinates there.

    `corners` (E, n, dim) [m] are the nodes of each element, `lower` and `upper` (E, dim) [m] its bounding box;
    `around[first[i]:first[i + 1]]` are the elements at node i.
    """
    for k in range(len(points)):
        x, finite = points[k], True
        for i in range(len(x)):
            finite = finite and math.isfinite(x[i])
        if not finite:
            continue
        if guess[k] >= 0:
            for node in nodes[guess[k]]:
                for e in around[first[node] : first[node + 1]]:
                    # So far inside that no other element contains the point: the result does not depend on the guess.
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
            for i in range(len(x)):
                local[k, i] = math.nan


def elements_of(coordinates: Array, connectivity: NDArray[np.int64]) -> Array:
    """Return the nodal coordinates of each element (E, n, dim) [m]; raise a UsageError if an element is degenerate."""
    corners = np.ascontiguousarray(coordinates[connectivity])
    if corners.shape[1:] not in ((2, 1), (4, 2)):
        raise UsageError(
            f"elements are two-node bars in 1D or four-node quadrilaterals in 2D, not arrays of shape {corners.shape[1:]!r}"
        )
    for e, nodes in enumerate(corners):
        if not least_jacobian(nodes) > FLAT:
            bar, quadrilateral = "give its nodes in increasing order", "give a convex one with its nodes counter-clockwise"
            remedy = bar if nodes.shape[1] == 1 else quadrilateral
            raise UsageError(f"element {e} is degenerate, with nodes at {nodes.tolist()}: {remedy}")
    return corners


def inverse_map(nodes: ArrayLike, x: ArrayLike) -> Array:
    """Return the local coordinates xi of points, sum_a N_a(xi) x_a = x, by Newton's method.

    Parameters
    ----------
    nodes : ArrayLike
        Nodes of a two-node bar (2, 1) or of a convex four-node quadrilateral, counter-clockwise, (4, 2) [m].
    x : ArrayLike
        One point (dim,) or several (P, dim) [m], inside the element or near it.

    Returns
    -------
    Array
        xi [1], of the shape of `x`; inside the element every component is in [-1, 1].

    Raises
    ------
    UsageError
        If the element is degenerate, or Newton's method does not converge for a point, as where the map has no inverse.
    """
    corners = np.asarray(nodes, dtype=float)
    (corners,) = elements_of(corners, np.arange(len(corners))[None])
    points = np.asarray(x, dtype=float)
    local = np.empty((points.size // corners.shape[1], corners.shape[1]))
    for point, xi in zip(np.ascontiguousarray(points).reshape(local.shape), local, strict=True):
        if not newton(corners, point, xi):
            raise UsageError(
                f"the point {point.tolist()} has no local coordinates in the element {corners.tolist()}: give a point inside"
            )
    return local.reshape(points.shape)


def find_element(
    coordinates: ArrayLike, connectivity: ArrayLike, points: ArrayLike, guess: ArrayLike | None = None
) -> tuple[NDArray[np.int64], Array]:
    """Find the element that contains each point, and the point's local coordinates in it.

    Parameters
    ----------
    coordinates : ArrayLike
        Nodes of the mesh (n, dim) [m].
    connectivity : ArrayLike
        Node numbers of each element, (E, 2) in 1D or (E, 4) in 2D.
    points : ArrayLike
        Points (P, dim) [m].
    guess : ArrayLike, optional
        Element of each point at the previous step (P,), -1 if unknown. The search tries it and its neighbours first; the result
        is the same for every guess.

    Returns
    -------
    element : NDArray[np.int64]
        (P,) element numbers; on a shared edge the lowest one, outside all elements -1.
    local : Array
        (P, dim) local coordinates [1]; NaN outside all elements.

    Raises
    ------
    UsageError
        If an element is degenerate or has a node number that does not exist, or the shapes of the arrays do not match.
    """
    X, elements, x = np.asarray(coordinates, float), np.ascontiguousarray(connectivity, np.int64), np.asarray(points, float)
    if elements.size and not (elements.min() >= 0 and elements.max() < len(X)):
        raise UsageError(f"an element has a node number outside 0 to {len(X) - 1}: give numbers of existing nodes")
    corners = elements_of(X, elements)
    start = np.full(len(x), -1) if guess is None else np.asarray(guess, np.int64)
    if x.shape != (len(x), X.shape[1]) or start.shape != (len(x),) or not (start < len(elements)).all():
        raise UsageError("points must be (P, dim) where nodes are (n, dim), and guesses (P,) must be element numbers or -1")
    touching = TOUCHING * float(np.ptp(X, axis=0).max() + np.abs(X).max())
    order = np.argsort(elements.ravel(), kind="stable")
    first = np.searchsorted(elements.ravel()[order], np.arange(len(X) + 1))
    found, local = np.full(len(x), -1), np.full(x.shape, np.nan)
    boxes = corners.min(axis=1), corners.max(axis=1)
    around = order // elements.shape[1]
    search(corners, *boxes, touching, elements, first, around, start, np.ascontiguousarray(x), found, local)
    return found, local
