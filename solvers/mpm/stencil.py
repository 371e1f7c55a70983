"""Where the functions of a particle live, and what they are there.

A support is what `spread` and `gather` of `transfer` take. Where N_Ip is a product of functions along the axes it has four parts: the
first node, the functions w (d,) in lanes, their derivatives (d,), and the first function along every axis (d,). Where N_Ip is a mean over
the corners of a domain (CPDI) it has three: the middle in cells (d,), the half edges R in cells as columns (d d), and R^-T/2^d (d d).
"""

import numpy as np

from .basis import LONGEST, ONE, SHORTEST, along, hat_along, integrated_along, moment_along
from .compilation import jit
from .lanes import row
from .state import Grid, Particles, Scheme
from .tensors import cofactor, det
from .vectors import Vector, identity, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@jit
def place(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> Vector:
    """Where the functions of a particle are evaluated, in cells from the lower ends (d,).

    At X in the total Lagrangian formulation, else at x.
    """
    x = row(particles.state, (p, 0), grid.lower)
    if scheme.total:
        x = row(particles.reference, (row(particles.place, (p,), ONE)[0], 0), grid.lower)
    return local(grid, x)


@jit
def cells_from_end(grid: Grid, k: int, x: float) -> float:
    """Distance from the lower end of axis k in cells; a periodic axis brings it back between its ends."""
    return back(grid, k, (x - grid.lower[k]) * grid.scale)


@jit
def back(grid: Grid, k: int, s: float) -> float:
    """The same distance in cells, between the ends if the axis is periodic."""
    beyond = grid.periodic[k] and not 0 <= s < grid.cells[k]
    return s - grid.cells[k] * np.floor(s / grid.cells[k]) if beyond else s


@jit
def numbers(like: Vector) -> tuple[int, ...]:
    """Numbers of the axes; they are sums, since for each literal number numba would compile anew."""
    x = len(like) - len(like)
    if len(like) == 1:
        return (x,)
    if len(like) == 2:
        return (x, x + 1)
    return (x, x + 1, x + 2)


@jit
def local(grid: Grid, x: Vector) -> Vector:
    """Distances of a place from the lower ends of the axes in cells (d,)."""
    k = numbers(x)
    if len(x) == 1:
        return (cells_from_end(grid, k[0], x[0]),)
    if len(x) == 2:
        return cells_from_end(grid, k[0], x[0]), cells_from_end(grid, k[1], x[1])
    return cells_from_end(grid, k[0], x[0]), cells_from_end(grid, k[1], x[1]), cells_from_end(grid, k[2], x[2])


@jit
def inside(grid: Grid, s: Vector) -> bool:
    """Whether a place is on the grid; NaN is not."""
    for k in range(len(s)):  # noqa: SIM110 (numba has no generator)
        if not 0 <= s[k] <= grid.cells[k]:
            return False
    return True


@jit
def domain(kind, grid: Grid, F):
    """Deformation gradient of the domain of a particle, where it has one."""
    if len(kind) == 2 or len(kind) == 3:
        return F if grid.stretched else identity(F)
    return F


@jit
def supported(kind, grid: Grid, s: Vector, F) -> bool:
    """Whether a particle is on the grid, which NaN is not, and its domain keeps within a cell from its middle on every side, as threads
    and the padding take for granted.
    """
    if len(kind) == 3:
        n = len(s)
        for i in range(n):
            reach = 0.0
            for k in range(n):
                reach += abs(F[n * i + k])
            if not grid.half * reach <= 1:
                return False
    return inside(grid, s)


@jit
def functions(kind, grid: Grid, k: int, s: float, stretch: float):
    """First function, lanes of N and dN/dx [1/m] along axis k."""
    if len(kind) == 2:
        return integrated_along(grid, k, s, min(max(stretch, SHORTEST) * grid.half, LONGEST))
    first, N, dN = along(grid.width, grid, k, s)
    if len(kind) == 4:
        moment, D = moment_along(grid, k, first, s, N)
        dN = (1 / D) * moment
    return first, N, dN


@jit
def support(kind, grid: Grid, s: Vector, F):
    """Support of a particle at a place in cells (d,), whose domain has the deformation gradient F; for `spread` and `gather`."""
    if len(kind) == 3:
        share = grid.scale / ((1 << len(s)) * grid.half * det(F))
        return s, scale(grid.half, F), scale(share, cofactor(F))
    axis = numbers(s)
    i, N, dN = functions(kind, grid, axis[0], s[0], F[0])
    if len(s) == 1:
        return i, (N,), (dN,), (i,)
    if len(s) == 2:
        j, M, dM = functions(kind, grid, axis[1], s[1], F[3])
        return i + j * grid.stride[1], (N, M), (dN, dM), (i, j)
    j, M, dM = functions(kind, grid, axis[1], s[1], F[4])
    k, L, dL = functions(kind, grid, axis[2], s[2], F[8])
    return i + j * grid.stride[1] + k * grid.stride[2], (N, M, L), (dN, dM, dL), (i, j, k)


@jit
def corner(grid: Grid, s: Vector, R, G, c: int):
    """First node and hats (d,) in lanes of corner c of a domain, and the gradient (d,) [1/m] of what its nodes have there."""
    axis, x = numbers(s), -1.0 if c % 2 == 0 else 1.0
    if len(s) == 1:
        i, N = hat_at(grid, axis[0], s[0] + x * R[0])
        return i, (N,), (x * G[0],)
    y = -1.0 if c // 2 % 2 == 0 else 1.0
    if len(s) == 2:
        i, N = hat_at(grid, axis[0], s[0] + x * R[0] + y * R[1])
        j, M = hat_at(grid, axis[1], s[1] + x * R[2] + y * R[3])
        return i + j * grid.stride[1], (N, M), (x * G[0] + y * G[1], x * G[2] + y * G[3])
    z = -1.0 if c // 4 == 0 else 1.0
    i, N = hat_at(grid, axis[0], s[0] + x * R[0] + y * R[1] + z * R[2])
    j, M = hat_at(grid, axis[1], s[1] + x * R[3] + y * R[4] + z * R[5])
    k, L = hat_at(grid, axis[2], s[2] + x * R[6] + y * R[7] + z * R[8])
    gradient = (x * G[0] + y * G[1] + z * G[2], x * G[3] + y * G[4] + z * G[5], x * G[6] + y * G[7] + z * G[8])
    return i + j * grid.stride[1] + k * grid.stride[2], (N, M, L), gradient


@jit
def hat_at(grid: Grid, k: int, s: float):
    """First hat and lanes of N at a place that may have left a periodic axis."""
    return hat_along(grid, k, back(grid, k, s))


@jit
def moments(grid: Grid, s: Vector, at):
    """N (x_I - x) (d,) [m] in lanes along the axes, and the diagonal of D = sum_I N (x_I - x)(x_I - x)^T (d,) [m^2]."""
    _, w, _, first = at
    axis = numbers(s)
    e, D = moment_along(grid, axis[0], first[0], s[0], w[0])
    if len(s) == 1:
        return (e,), (D,)
    f, E = moment_along(grid, axis[1], first[1], s[1], w[1])
    if len(s) == 2:
        return (e, f), (D, E)
    g, G = moment_along(grid, axis[2], first[2], s[2], w[2])
    return (e, f, g), (D, E, G)
