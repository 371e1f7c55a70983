"""Where the functions of a particle live, and what they are there.

A support is what `spread` and `gather` of `transfer` take. Where N_Ip is a product of functions along the axes it has four parts: the
first node, the functions w (d, W), their derivatives (d, W), and the first function along every axis (d,). Where N_Ip is a mean over
the corners of a domain (CPDI) it has three: the middle in cells (d,), the half edges R in cells as columns (d d), and R^-T/2^d (d d).
"""

from .basis import LONGEST, SHORTEST, affine_along, along, hat_along, integrated_along
from .compilation import jit
from .state import Grid, Particles, Scheme
from .tensors import cofactor, det
from .vectors import Vector, identity, null, row, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@jit
def place(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> Vector:
    """Where the functions of a particle are evaluated: X in the total Lagrangian formulation, else x."""
    return row(particles.reference if scheme.total else particles.position, p, grid.lower)


@jit
def cells_from_end(axis, x: float, scale: float) -> float:
    """Distance from the lower end in cells; a periodic axis brings it back between its ends."""
    s = (x - axis.lower) * scale
    beyond = axis.periodic and not 0 <= s < axis.cells  # to divide and floor takes as long as the rest of a step
    return s - axis.cells * (s // axis.cells) if beyond else s


@jit
def local(axes, x: Vector, scale: float) -> Vector:
    """Distances of a place from the lower ends of the axes in cells (d,)."""
    if len(x) == 1:
        return (cells_from_end(axes[0], x[0], scale),)
    if len(x) == 2:
        return cells_from_end(axes[0], x[0], scale), cells_from_end(axes[1], x[1], scale)
    return (
        cells_from_end(axes[0], x[0], scale),
        cells_from_end(axes[1], x[1], scale),
        cells_from_end(axes[2], x[2], scale),
    )


@jit
def inside(axes, s: Vector) -> bool:
    """Whether a place is on the grid; NaN is not."""
    if len(s) == 1:
        return 0 <= s[0] <= axes[0].cells
    if len(s) == 2:
        return 0 <= s[0] <= axes[0].cells and 0 <= s[1] <= axes[1].cells
    return 0 <= s[0] <= axes[0].cells and 0 <= s[1] <= axes[1].cells and 0 <= s[2] <= axes[2].cells


@jit
def deformation(scheme: Scheme, particles: Particles, p: int, like: Vector):
    """F that a domain follows: that of the particle, or the identity in the total Lagrangian formulation."""
    _, tensor, _ = null(like)
    return identity(tensor) if scheme.total else row(particles.F, p, tensor)


@jit
def fits(kind, scheme: Scheme, grid: Grid, particles: Particles, p: int) -> bool:
    """Whether the domain of a particle keeps within a cell from its middle on every side, as threads and the padding take for granted."""
    if len(kind) == 3:
        F = deformation(scheme, particles, p, grid.lower)
        n = len(grid.lower)
        for i in range(n):
            reach = 0.0
            for k in range(n):
                reach += abs(F[n * i + k])
            if not grid.half * reach <= 1:
                return False
    return True


@jit
def supported(scheme: Scheme, grid: Grid, particles: Particles, p: int) -> bool:
    """Whether a particle and its domain are on the grid; NaN is not."""
    return inside(grid.axes, local(grid.axes, place(scheme, grid, particles, p), grid.scale)) and fits(
        grid.kind, scheme, grid, particles, p
    )


@jit
def functions(kind, axis, s: float, grid: Grid, stretch: float):
    """First function, N (W,) and dN/dx (W,) [1/m] along an axis."""
    if len(kind) == 2:
        half = min(max(stretch, SHORTEST) * grid.half, LONGEST)
        return integrated_along(axis, s, half, grid.scale)
    first, N, dN = along(axis, s, grid.scale, grid.width)
    if grid.least_squares:
        dN, _ = affine_along(axis, first, s, grid.scale, N)
    return first, N, dN


@jit
def product(kind, axes, s: Vector, F, grid: Grid):
    """Support of a particle whose functions are products."""
    i, N, dN = functions(kind, axes[0], s[0], grid, F[0])
    if len(s) == 1:
        return i, (N,), (dN,), (i,)
    if len(s) == 2:
        j, M, dM = functions(kind, axes[1], s[1], grid, F[3])
        return i + j * grid.stride[1], (N, M), (dN, dM), (i, j)
    j, M, dM = functions(kind, axes[1], s[1], grid, F[4])
    k, L, dL = functions(kind, axes[2], s[2], grid, F[8])
    return i + j * grid.stride[1] + k * grid.stride[2], (N, M, L), (dN, dM, dL), (i, j, k)


@jit
def support(kind, scheme: Scheme, grid: Grid, particles: Particles, p: int):
    """Support of a particle, to be passed to `spread` and `gather`."""
    s = local(grid.axes, place(scheme, grid, particles, p), grid.scale)
    if len(kind) == 3:
        F = deformation(scheme, particles, p, grid.lower)
        share = grid.scale / ((1 << len(s)) * grid.half * det(F))
        return s, scale(grid.half, F), scale(share, cofactor(F))
    if len(kind) == 2:
        _, tensor, _ = null(s)
        F = deformation(scheme, particles, p, grid.lower) if grid.stretched else identity(tensor)
        return product(kind, grid.axes, s, F, grid)
    _, tensor, _ = null(s)
    return product(kind, grid.axes, s, tensor, grid)


@jit
def corner(axes, s: Vector, R, G, grid: Grid, c: int):
    """First node and hats (d, 2) of corner c of a domain, and the gradient (d,) [1/m] of what its nodes have there."""
    x = -1.0 if c % 2 == 0 else 1.0
    if len(s) == 1:
        i, N = hat_at(axes[0], s[0] + x * R[0])
        return i, (N,), (x * G[0],)
    y = -1.0 if c // 2 % 2 == 0 else 1.0
    if len(s) == 2:
        i, N = hat_at(axes[0], s[0] + x * R[0] + y * R[1])
        j, M = hat_at(axes[1], s[1] + x * R[2] + y * R[3])
        return i + j * grid.stride[1], (N, M), (x * G[0] + y * G[1], x * G[2] + y * G[3])
    z = -1.0 if c // 4 == 0 else 1.0
    i, N = hat_at(axes[0], s[0] + x * R[0] + y * R[1] + z * R[2])
    j, M = hat_at(axes[1], s[1] + x * R[3] + y * R[4] + z * R[5])
    k, L = hat_at(axes[2], s[2] + x * R[6] + y * R[7] + z * R[8])
    gradient = (x * G[0] + y * G[1] + z * G[2], x * G[3] + y * G[4] + z * G[5], x * G[6] + y * G[7] + z * G[8])
    return i + j * grid.stride[1] + k * grid.stride[2], (N, M, L), gradient


@jit
def hat_at(axis, s: float):
    """First hat and N (2,) at a place that may have left a periodic axis."""
    beyond = axis.periodic and not 0 <= s < axis.cells
    return hat_along(axis, s - axis.cells * (s // axis.cells) if beyond else s)


@jit
def affine_stencil(axes, s: Vector, grid: Grid, at):
    """N (x_I - x)/D (d, W) [1/m] along the axes, and the diagonal of D = sum_I N (x_I - x)(x_I - x)^T (d,) [m^2]."""
    _, w, _, first = at
    e, D = affine_along(axes[0], first[0], s[0], grid.scale, w[0])
    if len(s) == 1:
        return (e,), (D,)
    f, E = affine_along(axes[1], first[1], s[1], grid.scale, w[1])
    if len(s) == 2:
        return (e, f), (D, E)
    g, G = affine_along(axes[2], first[2], s[2], grid.scale, w[2])
    return (e, f, g), (D, E, G)
