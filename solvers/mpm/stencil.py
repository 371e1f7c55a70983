"""Groups of up to four consecutive particles that one stencil serves, and their supports on the grid."""

from typing import NamedTuple

from ..tracing import (
    LANES,
    as_integer,
    cond,
    fill_from_first,
    leading_ones,
    load_row,
    load_rows,
    maximum,
    minimum,
    split_floor,
    traced,
    where,
)
from .places import images, local
from .state import Grid, Particles, Scheme, columns_of
from .vectors import Vector, axpy, identity, scale

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"


class Group(NamedTuple):
    """Up to four consecutive particles that share a stencil.

    size : int
        How many they are; 0 when the first is not on the grid.
    numbers : tuple of int
        Four particle numbers; the first also stands for missing particles. One number where a basis takes particles one by one.
    present : float
        1 for each particle, 0 for missing ones.
    first : tuple of int
        First node along the axes (d,).
    offset : tuple of float
        Distances in cells from it to where their functions begin (d,).
    """

    size: int
    numbers: tuple[int, ...]
    present: float
    first: tuple[int, ...]
    offset: tuple[float, ...]


@traced
def place(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> Vector:
    """Where the functions of a particle are evaluated, in cells from the lower ends (d,): at X if total Lagrangian, else at x."""
    x = cond(
        scheme.total,
        lambda: load_row(particles.reference, (particles.place[p], 0), grid.lower),
        lambda: load_row(particles.state, (p, 0), grid.lower),
    )
    return local(grid, x)


@traced
def domain(grid: Grid, F):
    """Deformation gradient of the domain of a particle; F as it is where the basis has no domains."""
    return where(grid.stretched, F, axpy(0.0, F, identity(F))) if grid.kind.domains else F


@traced
def found(scheme: Scheme, grid: Grid, particles: Particles, p: int):
    """Whether a particle is on the grid, the first node of its functions along the axes, and how far from it they begin (d,)."""
    s = place(scheme, grid, particles, p)
    F = domain(grid, load_row(particles.state, (p, columns_of(grid.lower, particles.deformation).F), particles.deformation))
    first, offset = grid.kind.begins(grid, s, F)
    return grid.kind.supported(grid, s, F), first, offset


@traced
def places(particles: Particles, which):
    """Places of particles in the order of the problem, by their numbers (1,) or (4,)."""
    return tuple(particles.place[number] for number in which)


@traced
def in_cells(scheme: Scheme, grid: Grid, particles: Particles, which):
    """Positions (d,) of four particles in cells from the lower ends of the grid, and where their functions begin, by numbers (4,)."""
    x = cond(
        scheme.total,
        lambda: load_rows(particles.reference, places(particles, which), 0, grid.lower),
        lambda: load_rows(particles.state, which, 0, grid.lower),
    )
    s = images(grid, scale(grid.scale, axpy(-1.0, grid.lower, x)))
    F = domain(grid, load_rows(particles.state, which, columns_of(grid.lower, particles.deformation).F, particles.deformation))
    return s, grid.kind.begin_in_cells(grid, s, F)


@traced
def group(scheme: Scheme, grid: Grid, particles: Particles, p: int, end: int) -> Group:
    """The particles from place p of the order on, before `end`, that one stencil serves."""
    order, last = particles.order, end - 1
    q = order[p]
    if not grid.kind.together:
        here, first, offset = found(scheme, grid, particles, q)
        return Group(where(here, 1, 0), (q,), 1.0, first, offset)
    which = q, *(order[minimum(p + k, last)] for k in range(1, LANES))
    s, begin = in_cells(scheme, grid, particles, which)
    offset, under, shared = split_floor(begin)
    alike = grid.kind.alike(grid, s, begin, under, shared)

    def outside_or_on_the_edge():
        here, first, alone = found(scheme, grid, particles, q)
        return where(here, 1, 0), first, alone

    together = minimum(alike, end - p), tuple(as_integer(a) for a in under), offset
    count, first, offset = cond(alike > 0, together, outside_or_on_the_edge)
    numbers = q, *(where(count > k, which[k], q) for k in range(1, LANES))
    present = leading_ones(maximum(count, 1))
    return Group(count, numbers, present, first, fill_from_first(offset, present))


@traced
def support_of(grid: Grid, particles: Particles, some: Group):
    """Support of the particles of a group, see `support`."""
    F = load_rows(particles.state, some.numbers, columns_of(grid.lower, particles.deformation).F, particles.deformation)
    return grid.kind.support(grid, some.first, some.offset, domain(grid, F))
