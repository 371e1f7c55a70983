"""The nodes that a particle touches, and the functions along each axis whose products are N_Ip, dN_Ip/dx and the affine ones."""

from .basis import affine_along, along
from .compilation import jit
from .state import Grid, Particles, Scheme
from .vectors import Vector, row

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
    return s - axis.cells * (s // axis.cells) if axis.periodic else s


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
def stencil(axes, s: Vector, grid: Grid):
    """First node, N (d, W) [1] and dN/dx (d, W) [1/m] along the axes."""
    i, N, dN = along(axes[0], s[0], grid.scale, grid.width)
    if len(s) == 1:
        return i, (N,), (dN,)
    j, M, dM = along(axes[1], s[1], grid.scale, grid.width)
    if len(s) == 2:
        return i + j * grid.stride[1], (N, M), (dN, dM)
    k, L, dL = along(axes[2], s[2], grid.scale, grid.width)
    return i + j * grid.stride[1] + k * grid.stride[2], (N, M, L), (dN, dM, dL)


@jit
def affine_stencil(axes, s: Vector, grid: Grid, w):
    """N (x_I - x)/D (d, W) [1/m] along the axes, and the diagonal of D = sum_I N (x_I - x)(x_I - x)^T (d,) [m^2]."""
    e, D = affine_along(axes[0], s[0], grid.scale, w[0])
    if len(s) == 1:
        return (e,), (D,)
    f, E = affine_along(axes[1], s[1], grid.scale, w[1])
    if len(s) == 2:
        return (e, f), (D, E)
    g, G = affine_along(axes[2], s[2], grid.scale, w[2])
    return (e, f, g), (D, E, G)
