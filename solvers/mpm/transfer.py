"""Transfer between particles and grid over the nodes of a support, in one, two and three dimensions.

Values of nodes (C, n) are counted with x fastest.
"""

from ..tracing import traced
from .nodes import add_field, gathered, gathered_by
from .state import Grid
from .stencil import corner
from .vectors import axpy, combination, dyad, null, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def spread(grid: Grid, nodes, component, at, amount):
    """Particles to grid: a_I += N_Ip a, into the rows from `component` on."""
    if len(at) == 5:
        add_field(grid, nodes, component, at[0], at[1], at[1], amount, None)
    else:
        share = scale(1 / (1 << len(at[0])), amount)
        for c in range(1 << len(at[0])):
            first, hats, _ = corner(grid, at[0], at[1], at[2], c)
            add_field(grid, nodes, component, first, hats, hats, share, None)


@traced
def spread_tensor(grid: Grid, nodes, component, at, T):
    """Particles to grid: a_I += sum_k T_k dN_Ip/dx_k, T_k the columns of a tensor, into the rows from `component` on."""
    if len(at) == 5:
        add_field(grid, nodes, component, at[0], at[1], at[2], None, T)
    else:
        for c in range(1 << len(at[0])):
            first, hats, at_corner = corner(grid, at[0], at[1], at[2], c)
            add_field(grid, nodes, component, first, hats, hats, combination(T, at_corner), None)


@traced
def gather(grid: Grid, nodes, at):
    """Grid to particles: the vector sum_I N_Ip a_I."""
    if len(at) == 5:
        return gathered(grid, nodes, at[0], at[1])
    mean, _, _ = null(grid.lower)
    for c in range(1 << len(at[0])):
        first, hats, _ = corner(grid, at[0], at[1], at[2], c)
        mean = axpy(1 / (1 << len(at[0])), gathered(grid, nodes, first, hats), mean)
    return mean


@traced
def gather_tensor(grid: Grid, nodes, at):
    """Grid to particles: the tensor with rows c and columns k, sum_I a_Ic dN_Ip/dx_k, row-major."""
    if len(at) == 5:
        return gathered_by(grid, nodes, at[0], at[1], at[2])
    _, mean, _ = null(grid.lower)
    for c in range(1 << len(at[0])):
        first, hats, at_corner = corner(grid, at[0], at[1], at[2], c)
        mean = axpy(1.0, dyad(gathered(grid, nodes, first, hats), at_corner), mean)
    return mean
