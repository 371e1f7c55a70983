"""Transfer between particles and grid over the nodes of a support, in one, two and three dimensions.

Numba knows the length of a tuple: it drops the branches of the other dimensions, and of the other kind of support, and unrolls the
loops over a stencil. A stencil is its first node, the functions w (d,) along each axis in lanes, whose products are N_Ip, and others e
in the place of one of them: the derivatives, whose products are dN_Ip/dx_k, or the affine ones. Nodes (C, n) are counted with x fastest.
"""

from .compilation import jit
from .lanes import add_to, lane, load, total
from .state import Grid
from .stencil import corner
from .vectors import axpy, combination, dyad, null, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@jit
def spread(grid: Grid, nodes, component, at, amount):
    """Particle to grid: a_I += N_Ip a, into the rows from `component` on."""
    if len(at) == 4:
        spread_products(grid, nodes, component, at[0], at[1], amount)
    else:
        share = scale(1 / (1 << len(at[0])), amount)
        for c in range(1 << len(at[0])):
            first, w, _ = corner(grid, at[0], at[1], at[2], c)
            spread_products(grid, nodes, component, first, w, share)


@jit
def spread_tensor(grid: Grid, nodes, component, at, T):
    """Particle to grid: a_I += sum_k T_k dN_Ip/dx_k, T_k the columns of a tensor, into the rows from `component` on."""
    if len(at) == 4:
        spread_field(grid, nodes, component, at[0], at[1], at[2], null(at[3])[0], T)
    else:
        for c in range(1 << len(at[0])):
            first, w, at_corner = corner(grid, at[0], at[1], at[2], c)
            spread_products(grid, nodes, component, first, w, combination(T, at_corner))


@jit
def gather(grid: Grid, nodes, at):
    """Grid to particle: the vector sum_I N_Ip a_I."""
    if len(at) == 4:
        return gather_products(grid, nodes, at[0], at[1])
    mean, _, _ = null(grid.lower)
    for c in range(1 << len(at[0])):
        first, w, _ = corner(grid, at[0], at[1], at[2], c)
        mean = axpy(1 / (1 << len(at[0])), gather_products(grid, nodes, first, w), mean)
    return mean


@jit
def gather_tensor(grid: Grid, nodes, at):
    """Grid to particle: the tensor with rows c and columns k, sum_I a_Ic dN_Ip/dx_k, row-major."""
    if len(at) == 4:
        return gather_gradients(grid, nodes, at[0], at[1], at[2])
    _, mean, _ = null(grid.lower)
    for c in range(1 << len(at[0])):
        first, w, at_corner = corner(grid, at[0], at[1], at[2], c)
        mean = axpy(1.0, dyad(gather_products(grid, nodes, first, w), at_corner), mean)
    return mean


@jit
def spread_products(grid: Grid, nodes, component, first, w, amount):
    """`spread` over one stencil."""
    if len(w) == 1:
        for c in range(len(amount)):
            add_to(nodes, (component + c, first), amount[c] * w[0])
    elif len(w) == 2:
        for b in range(len(grid.width)):
            for c in range(len(amount)):
                add_to(nodes, (component + c, first + b * grid.stride[1]), (lane(w[1], b) * amount[c]) * w[0])
    else:
        for k in range(len(grid.width)):
            for b in range(len(grid.width)):
                N_yz, node = lane(w[1], b) * lane(w[2], k), first + b * grid.stride[1] + k * grid.stride[2]
                for c in range(len(amount)):
                    add_to(nodes, (component + c, node), (N_yz * amount[c]) * w[0])


@jit
def spread_field(grid: Grid, nodes, component, first, w, e, amount, T):
    """A field that varies over one stencil: a_I += N_Ip a + sum_k T_k e_kI, T_k the columns of a tensor."""
    if len(w) == 1:
        add_to(nodes, (component, first), amount[0] * w[0] + T[0][0] * e[0])
    elif len(w) == 2:
        for b in range(len(grid.width)):
            N_y, y = lane(w[1], b), lane(e[1], b)
            for c in range(len(w)):
                along = (N_y * amount[c] + y * T[1][c]) * w[0] + (N_y * T[0][c]) * e[0]
                add_to(nodes, (component + c, first + b * grid.stride[1]), along)
    else:
        for k in range(len(grid.width)):
            for b in range(len(grid.width)):
                N_y, N_z, node = lane(w[1], b), lane(w[2], k), first + b * grid.stride[1] + k * grid.stride[2]
                N_yz, y_z, z_y = N_y * N_z, lane(e[1], b) * N_z, N_y * lane(e[2], k)
                for c in range(len(w)):
                    along = (N_yz * amount[c] + y_z * T[1][c] + z_y * T[2][c]) * w[0] + (N_yz * T[0][c]) * e[0]
                    add_to(nodes, (component + c, node), along)


@jit
def along_x(grid: Grid, nodes, c, first, w):
    """Component c along the first axis, in lanes: the rows of a stencil, each times its functions w along the other axes."""
    line = load(nodes, (c, first), grid.width)
    if len(w) == 2:
        line = lane(w[1], 0) * line
        for b in range(1, len(grid.width)):
            line = line + lane(w[1], b) * load(nodes, (c, first + b * grid.stride[1]), grid.width)
    elif len(w) == 3:
        line = (lane(w[1], 0) * lane(w[2], 0)) * line
        for number in range(1, len(grid.width) ** 2):
            b, k = number % len(grid.width), number // len(grid.width)
            node = first + b * grid.stride[1] + k * grid.stride[2]
            line = line + (lane(w[1], b) * lane(w[2], k)) * load(nodes, (c, node), grid.width)
    return line


@jit
def gather_products(grid: Grid, nodes, first, w):
    """`gather` over one stencil."""
    x = total(w[0] * along_x(grid, nodes, 0, first, w))
    if len(w) == 1:
        return (x,)
    y = total(w[0] * along_x(grid, nodes, 1, first, w))
    if len(w) == 2:
        return x, y
    return x, y, total(w[0] * along_x(grid, nodes, 2, first, w))


@jit
def gather_gradients(grid: Grid, nodes, first, w, e):
    """`gather_tensor` over one stencil."""
    if len(w) == 1:
        return gradient(grid, nodes, 0, first, w, e)
    x, y = gradient(grid, nodes, 0, first, w, e), gradient(grid, nodes, 1, first, w, e)
    if len(w) == 2:
        return (*x, *y)
    return (*x, *y, *gradient(grid, nodes, 2, first, w, e))


@jit
def gradient(grid: Grid, nodes, c, first, w, e):
    """Gradient of component c over one stencil."""
    x = total(e[0] * along_x(grid, nodes, c, first, w))
    if len(w) == 1:
        return (x,)
    if len(w) == 2:
        return x, total(w[0] * along_x(grid, nodes, c, first, (w[0], e[1])))
    y = total(w[0] * along_x(grid, nodes, c, first, (w[0], e[1], w[2])))
    return x, y, total(w[0] * along_x(grid, nodes, c, first, (w[0], w[1], e[2])))
