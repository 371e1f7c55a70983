"""Where the functions of particles live, and what they are there, for up to four particles of one stencil at a time.

A support is what `spread` and `gather` of `transfer` take. Where N_Ip is a product of functions along the axes it has five parts: the
first node, the functions w (d, W), their derivatives (d, W), and along the axes the first node (d,) and the place in cells from the
lower end (d,). Where N_Ip is a mean over the corners of a domain (CPDI) it has three, for one particle: the middle in cells (d,), the
half edges R in cells as columns (d d), and R^-T/2^d (d d).
"""

from typing import NamedTuple

import numpy as np

from .basis import LONGEST, ONE, SHORTEST, along, integrated_along, moment_along
from .compilation import jit
from .lanes import lanes, largest, least, repeated, split
from .memory import row, rows
from .state import Grid, Particles, Scheme, columns_of
from .tensors import cofactor, det
from .vectors import Vector, axpy, identity, null, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


class Group(NamedTuple):
    """Particles that follow each other and have one stencil: so many, at most four, and none when the first is not on the grid.

    Their numbers (4,), the first one's in the place of those that are missing, 1 and 0 for these as a value, the first node along the
    axes (d,), and how far from it in cells their functions begin, values (d,). CPDI takes one particle at a time, and its middle.
    """

    size: int
    numbers: tuple[int, ...]
    present: float
    first: tuple[int, ...]
    offset: tuple[float, ...]


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
    k = numbers(grid.lower)
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
        return F if grid.stretched else axpy(0.0, F, identity(F))
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
def half_domain(grid: Grid, stretch):
    """Half the domain of a particle of GIMP along an axis, in cells."""
    return least(largest(stretch, SHORTEST) * grid.half, LONGEST)


@jit
def ends(kind, grid: Grid, F, s):
    """How far before their functions begin particles lie, in cells (d,): zero, or minus half the domain of GIMP and the padding."""
    k = numbers(grid.lower)
    if len(kind) != 2:
        return scale(0.0, grid.lower)
    x = grid.padding[k[0]] - half_domain(grid, F[0])
    if len(s) == 1:
        return (x,)
    y = grid.padding[k[1]] - half_domain(grid, F[len(s) + 1])
    if len(s) == 2:
        return x, y
    return x, y, grid.padding[k[2]] - half_domain(grid, F[8])


@jit
def begin(kind, grid: Grid, k: int, s: float, stretch: float):
    """First node along axis k of the functions of a particle at s cells from the lower end, and how far from it they begin."""
    if len(kind) == 2:
        a = s - half_domain(grid, stretch) + grid.padding[k]
        if grid.periodic[k] and a < 0:
            a += grid.cells[k]
        return int(a), a - int(a)
    cell = min(int(s), grid.cells[k] - 1)
    return cell, s - cell


@jit
def begins(kind, grid: Grid, s: Vector, F):
    """First node along the axes, and how far from it the functions begin; zero, and the middle, for CPDI."""
    k = numbers(grid.lower)
    if len(kind) == 3:
        return k, s
    i, a = begin(kind, grid, k[0], s[0], F[0])
    if len(s) == 1:
        return (i,), (a,)
    j, b = begin(kind, grid, k[1], s[1], F[len(s) + 1])
    if len(s) == 2:
        return (i, j), (a, b)
    n, c = begin(kind, grid, k[2], s[2], F[8])
    return (i, j, n), (a, b, c)


@jit
def found(kind, scheme: Scheme, grid: Grid, particles: Particles, p: int):
    """Whether a particle is on the grid, and what `begins` says of it."""
    s = place(scheme, grid, particles, p)
    F = domain(kind, grid, row(particles.state, (p, columns_of(grid.lower).F), null(grid.lower)[1]))
    first, offset = begins(kind, grid, s, F)
    return supported(kind, grid, s, F), first, offset


@jit
def places(particles: Particles, which):
    """Places of particles in the order of the problem, by their numbers (1,) or (4,)."""
    at = particles.place
    if len(which) == 1:
        return (at[which[0]],)
    return at[which[0]], at[which[1]], at[which[2]], at[which[3]]


@jit
def group(kind, scheme: Scheme, grid: Grid, particles: Particles, p: int, end: int):
    """The particles from place p of the order on, before `end`, that one stencil serves."""
    order, last = particles.order, end - 1
    q = order[p]
    if len(kind) == 3:
        here, first, middle = found(kind, scheme, grid, particles, q)
        return Group(here * 1, (q,), 1.0, first, middle)
    which = (q, order[min(p + 1, last)], order[min(p + 2, last)], order[min(p + 3, last)])
    x = rows(particles.state, which, 0, grid.lower)
    if scheme.total:
        x = rows(particles.reference, places(particles, which), 0, grid.lower)
    s = scale(grid.scale, axpy(-1.0, grid.lower, x))
    F = domain(kind, grid, rows(particles.state, which, columns_of(grid.lower).F, null(grid.lower)[1]))
    offset, first, alike = split(axpy(1.0, ends(kind, grid, F, s), s), s, grid.cells)
    count = min(alike, end - p)
    if alike == 0:  # outside, or on the edge of the grid
        here, first, alone = found(kind, scheme, grid, particles, q)
        count, offset = here * 1, axpy(1.0, alone, scale(0.0, s))
    second, third, fourth = which[1] if count > 1 else q, which[2] if count > 2 else q, which[3] if count > 3 else q
    present = lanes((1.0, 1.0 * (count > 1), 1.0 * (count > 2), 1.0 * (count > 3)))
    return Group(count, (q, second, third, fourth), present, first, repeated(offset, present))


@jit
def functions(kind, grid: Grid, k: int, first: int, offset, stretch):
    """N and dN/dx [1/m] (W,) along axis k, and the place of the particles in cells from the lower end."""
    if len(kind) == 2:
        half = half_domain(grid, stretch)
        N, dN = integrated_along(grid, offset, half)
        return N, dN, offset + half + (first - grid.padding[k])
    N, dN = along(grid.width, grid, k, first, offset)
    if len(kind) == 4:
        moment, D = moment_along(grid, k, first, offset + first, N)
        dN = scale(grid.scale / D, moment)
    return N, dN, offset + first


@jit
def node_of(grid: Grid, first) -> int:
    """Number of the node that is the first along all axes (d,)."""
    node = first[0]
    for k in range(1, len(first)):
        node += first[k] * grid.stride[k]
    return node


@jit
def support(kind, grid: Grid, first, offset, F):
    """Support of particles whose functions begin at an offset (d,) from the first node along the axes (d,), for `spread` and `gather`.

    Their domains have the deformation gradient F.
    """
    if len(kind) == 3:
        share = grid.scale / ((1 << len(offset)) * grid.half * det(F))
        return offset, scale(grid.half, F), scale(share, cofactor(F))
    axis = numbers(grid.lower)
    N, dN, x = functions(kind, grid, axis[0], first[0], offset[0], F[0])
    if len(offset) == 1:
        return node_of(grid, first), (N,), (dN,), first, (x,)
    M, dM, y = functions(kind, grid, axis[1], first[1], offset[1], F[len(offset) + 1])
    if len(offset) == 2:
        return node_of(grid, first), (N, M), (dN, dM), first, (x, y)
    L, dL, z = functions(kind, grid, axis[2], first[2], offset[2], F[8])
    return node_of(grid, first), (N, M, L), (dN, dM, dL), first, (x, y, z)


@jit
def corner(grid: Grid, s: Vector, R, G, c: int):
    """First node and hats (d, 2) of corner c of a domain, and the gradient (d,) [1/m] of what its nodes have there."""
    axis, x = numbers(grid.lower), -1.0 if c % 2 == 0 else 1.0
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
    """First of the hats at a place that may lie in the padding or have left a periodic axis, and both of them (2,)."""
    a = back(grid, k, s) + grid.padding[k]
    cell = min(int(a), grid.cells[k] + 2 * grid.padding[k] - 1)
    return cell, (1 - (a - cell), a - cell)


@jit
def moments(grid: Grid, first, place, w):
    """N (x_I - x) along the axes (d, W), and the diagonal of D = sum_I N (x_I - x)(x_I - x)^T (d,), in cells."""
    axis = numbers(grid.lower)
    e, D = moment_along(grid, axis[0], first[0], place[0], w[0])
    if len(place) == 1:
        return (e,), (D,)
    f, E = moment_along(grid, axis[1], first[1], place[1], w[1])
    if len(place) == 2:
        return (e, f), (D, E)
    g, G = moment_along(grid, axis[2], first[2], place[2], w[2])
    return (e, f, g), (D, E, G)
