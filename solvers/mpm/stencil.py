"""Where the functions of particles live, and what they are there, for up to four particles of one stencil at a time.

A support is what `spread` and `gather` of `transfer` take. Where N_Ip is a product of functions along the axes it has five parts: the
first node, the functions w (d, W), their derivatives (d, W), and along the axes the first node (d,) and the place in cells from the
lower end (d,). Where N_Ip is a mean over the corners of a domain (CPDI) it has three, for one particle: the middle in cells (d,), the
half edges R in cells as columns (d d), and R^-T/2^d (d d).
"""

import operator
from functools import reduce
from typing import NamedTuple

from ..tracing import (
    LANES,
    as_integer,
    cond,
    count_leading,
    fill_from_first,
    floor,
    leading_ones,
    load_row,
    load_rows,
    maximum,
    minimum,
    split_floor,
    traced,
    where,
)
from .basis import CPDI, GIMP, LONGEST, MLS, SHORTEST, along, integrated_along, moment_along
from .state import Grid, Particles, Scheme, columns_of
from .tensors import cofactor, det
from .vectors import Vector, axpy, dot, identity, scale

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


@traced
def place(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> Vector:
    """Where the functions of a particle are evaluated, in cells from the lower ends (d,).

    At X in the total Lagrangian formulation, else at x.
    """
    x = cond(
        scheme.total,
        lambda: load_row(particles.reference, (particles.place[p], 0), grid.lower),
        lambda: load_row(particles.state, (p, 0), grid.lower),
    )
    return local(grid, x)


@traced
def back(grid: Grid, k: int, s):
    """A distance from the lower end of axis k in cells, between its ends if they are joined."""
    there = (s >= 0.0) & (s < grid.cells[k])
    return where(grid.periodic[k], where(there, s, s - grid.cells[k] * floor(s / grid.cells[k])), s)


@traced
def local(grid: Grid, x: Vector) -> Vector:
    """Distances of a place from the lower ends of the axes in cells (d,)."""
    return tuple(back(grid, k, (x[k] - grid.lower[k]) * grid.scale) for k in range(len(x)))


@traced
def inside(grid: Grid, s: Vector) -> bool:
    """Whether a place is on the grid; NaN is not."""
    return reduce(operator.and_, [(a >= 0.0) & (a <= cells) for a, cells in zip(s, grid.cells, strict=True)])


@traced
def in_a_cell(s, cells):
    """Where places are in one of the cells of every axis, which its upper end and NaN are not."""
    return reduce(operator.and_, [(a >= 0.0) & (a < n) for a, n in zip(s, cells, strict=True)])


@traced
def domain(grid: Grid, F):
    """Deformation gradient of the domain of a particle, where it has one."""
    if len(grid.kind) not in (len(GIMP), len(CPDI)):
        return F
    return where(grid.stretched, F, axpy(0.0, F, identity(F)))


@traced
def supported(grid: Grid, s: Vector, F) -> bool:
    """Whether a particle is on the grid, which NaN is not, and its domain keeps within a cell from its middle on every side, as threads
    and the padding take for granted.
    """
    there, n = inside(grid, s), len(s)
    if len(grid.kind) == len(CPDI):
        for i in range(n):
            reach = reduce(operator.add, [maximum(R, -R) for R in F[n * i : n * i + n]])
            there = there & (grid.half * reach <= 1.0)
    return there


@traced
def stretches(grid: Grid, F):
    """How much the domain of a particle of GIMP stretches along the axes (d,)."""
    d = len(grid.lower)
    return F[:: d + 1] if len(grid.kind) == len(GIMP) else (1.0,) * d


@traced
def half_domain(grid: Grid, stretch):
    """Half the domain of a particle of GIMP along an axis, in cells."""
    return minimum(maximum(stretch, SHORTEST) * grid.half, LONGEST)


@traced
def ends(grid: Grid, F, s):
    """How far before their functions begin particles lie, in cells (d,): zero, or minus half the domain of GIMP and the padding."""
    if len(grid.kind) != len(GIMP):
        return (0.0,) * len(s)
    return tuple(grid.padding[k] - half_domain(grid, stretch) for k, stretch in enumerate(stretches(grid, F)))


@traced
def begin(grid: Grid, k: int, s: float, stretch: float):
    """First node along axis k of the functions of a particle at s cells from the lower end, and how far from it they begin."""
    if len(grid.kind) == len(GIMP):
        a = s - half_domain(grid, stretch) + grid.padding[k]
        a = where(grid.periodic[k], where(a < 0.0, a + grid.cells[k], a), a)
        return as_integer(a), a - as_integer(a)
    cell = minimum(as_integer(s), grid.cells[k] - 1)
    return cell, s - cell


@traced
def begins(grid: Grid, s: Vector, F):
    """First node along the axes, and how far from it the functions begin; zero, and the middle, for CPDI."""
    d = len(s)
    if len(grid.kind) == len(CPDI):
        return (0,) * d, s
    along_axes = [begin(grid, k, s[k], stretch) for k, stretch in enumerate(stretches(grid, F))]
    return tuple(first for first, _ in along_axes), tuple(offset for _, offset in along_axes)


@traced
def found(scheme: Scheme, grid: Grid, particles: Particles, p: int):
    """Whether a particle is on the grid, and what `begins` says of it."""
    s = place(scheme, grid, particles, p)
    F = domain(grid, load_row(particles.state, (p, columns_of(grid.lower, particles.deformation).F), particles.deformation))
    first, offset = begins(grid, s, F)
    return supported(grid, s, F), first, offset


@traced
def places(particles: Particles, which):
    """Places of particles in the order of the problem, by their numbers (1,) or (4,)."""
    return tuple(particles.place[number] for number in which)


@traced
def images(grid: Grid, s: Vector):
    """Places in cells (d,), those beyond joined ends between them, though next to an end it may be on its other side: `back`, sooner."""
    lengths = [where(periodic, cells, 0) for periodic, cells in zip(grid.periodic, grid.cells, strict=True)]
    return tuple(a - length * floor(a * (1 / n)) for a, length, n in zip(s, lengths, grid.cells, strict=True))


@traced
def in_cells(scheme: Scheme, grid: Grid, particles: Particles, which):
    """How far particles, by their numbers (4,), are from the lower ends in cells (d,), and how far their functions begin."""
    x = cond(
        scheme.total,
        lambda: load_rows(particles.reference, places(particles, which), 0, grid.lower),
        lambda: load_rows(particles.state, which, 0, grid.lower),
    )
    s = images(grid, scale(grid.scale, axpy(-1.0, grid.lower, x)))
    F = domain(grid, load_rows(particles.state, which, columns_of(grid.lower, particles.deformation).F, particles.deformation))
    return s, axpy(1.0, ends(grid, F, s), s) if len(grid.kind) == len(GIMP) else s


@traced
def group(scheme: Scheme, grid: Grid, particles: Particles, p: int, end: int) -> Group:
    """The particles from place p of the order on, before `end`, that one stencil serves."""
    order, last = particles.order, end - 1
    q = order[p]
    if len(grid.kind) == len(CPDI):
        here, first, middle = found(scheme, grid, particles, q)
        return Group(where(here, 1, 0), (q,), 1.0, first, middle)
    which = q, *(order[minimum(p + k, last)] for k in range(1, LANES))
    s, begin = in_cells(scheme, grid, particles, which)
    offset, under, shared = split_floor(begin)
    if len(grid.kind) == len(GIMP):
        alike = count_leading(reduce(operator.and_, [shared, in_a_cell(s, grid.cells), *(a >= 0.0 for a in begin)]))
    else:
        alike = where(in_a_cell(under, grid.cells), count_leading(shared), 0)

    def outside_or_on_the_edge():
        here, first, alone = found(scheme, grid, particles, q)
        return where(here, 1, 0), first, alone

    together = minimum(alike, end - p), tuple(as_integer(a) for a in under), offset
    count, first, offset = cond(alike > 0, together, outside_or_on_the_edge)
    numbers = q, *(where(count > k, which[k], q) for k in range(1, LANES))
    present = leading_ones(maximum(count, 1))
    return Group(count, numbers, present, first, fill_from_first(offset, present))


@traced
def functions(grid: Grid, k: int, first: int, offset, stretch):
    """N and dN/dx [1/m] (W,) along axis k, and the place of the particles in cells from the lower end."""
    if len(grid.kind) == len(GIMP):
        half = half_domain(grid, stretch)
        N, dN = integrated_along(grid, offset, half)
        return N, dN, offset + half + (first - grid.padding[k])
    N, dN = along(grid, k, first, offset)
    if len(grid.kind) == len(MLS):
        moment, D = moment_along(grid, k, first, offset + first, N)
        dN = scale(grid.scale / D, moment)
    return N, dN, offset + first


@traced
def node_of(grid: Grid, first) -> int:
    """Number of the node that is the first along all axes (d,)."""
    return dot(first, (1, *grid.stride[1:]))


@traced
def cell_number(grid: Grid, first) -> int:
    """Number of the cell that is so far along the axes (d,), x fastest."""
    number = first[-1]
    for k in reversed(range(len(first) - 1)):
        number = first[k] + grid.cells[k] * number
    return number


@traced
def support(grid: Grid, first, offset, F):
    """Support of particles whose functions begin at an offset (d,) from the first node along the axes (d,), for `spread` and `gather`.

    Their domains, if they have some, have the deformation gradient F.
    """
    d = len(offset)
    if len(grid.kind) == len(CPDI):
        share = grid.scale / (2**d * grid.half * det(F))
        return offset, scale(grid.half, F), scale(share, cofactor(F))
    along_axes = [functions(grid, k, first[k], offset[k], stretch) for k, stretch in enumerate(stretches(grid, F))]
    N, dN, place = zip(*along_axes, strict=True)
    return node_of(grid, first), N, dN, first, place


@traced
def corner(grid: Grid, s: Vector, R, G, c: int):
    """First node and hats (d, 2) of corner c of a domain, and the gradient (d,) [1/m] of what its nodes have there."""
    d = len(s)
    side = [1.0 if c >> k & 1 else -1.0 for k in range(d)]
    hats = [hat_at(grid, k, s[k] + dot(side, R[d * k : d * k + d])) for k in range(d)]
    gradient = tuple(dot(side, G[d * k : d * k + d]) for k in range(d))
    return node_of(grid, [first for first, _ in hats]), tuple(N for _, N in hats), gradient


@traced
def hat_at(grid: Grid, k: int, s: float):
    """First of the hats at a place that may lie in the padding or have left a periodic axis, and both of them (2,)."""
    a = back(grid, k, s) + grid.padding[k]
    cell = minimum(as_integer(a), grid.cells[k] + 2 * grid.padding[k] - 1)
    return cell, (1.0 - (a - cell), a - cell)


@traced
def moments(grid: Grid, first, place, w):
    """N (x_I - x) along the axes (d, W), and the diagonal of D = sum_I N (x_I - x)(x_I - x)^T (d,), in cells."""
    e, D = zip(*(moment_along(grid, k, first[k], place[k], w[k]) for k in range(len(place))), strict=True)
    return e, D
