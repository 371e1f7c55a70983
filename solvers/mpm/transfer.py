"""Transfer between particles and grid over the nodes of a support, in one, two and three dimensions.

Numba knows the length of a tuple: it drops the branches of the other dimensions, and of the other kind of support, and unrolls the
loops over a stencil. A stencil is its first node, the functions w (d, W) along each axis, whose products are N_Ip, and others e in the
place of one of them: the derivatives, whose products are dN_Ip/dx_k, or the affine ones. Nodes (n, C) are counted with x fastest.
"""

from .compilation import jit
from .state import Grid
from .stencil import corner
from .vectors import axpy, combination, dyad, null, row, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"


@jit
def spread(grid: Grid, nodes, column, at, amount):
    """Particle to grid: a_I += N_Ip a, into the columns from `column` on."""
    if len(at) == 4:
        spread_products(nodes, column, at[0], grid.stride, at[1], amount)
    else:
        share = scale(1 / (1 << len(at[0])), amount)
        for c in range(1 << len(at[0])):
            first, w, _ = corner(grid.axes, at[0], at[1], at[2], grid, c)
            spread_products(nodes, column, first, grid.stride, w, share)


@jit
def spread_tensor(grid: Grid, nodes, column, at, T):
    """Particle to grid: a_I += sum_k T_k dN_Ip/dx_k, T_k the columns of a tensor, into the columns from `column` on."""
    if len(at) == 4:
        spread_gradients(nodes, column, at[0], grid.stride, at[1], at[2], T)
    else:
        for c in range(1 << len(at[0])):
            first, w, gradient = corner(grid.axes, at[0], at[1], at[2], grid, c)
            spread_products(nodes, column, first, grid.stride, w, combination(T, gradient))


@jit
def gather(grid: Grid, nodes, at):
    """Grid to particle: the vector sum_I N_Ip a_I."""
    total, _, _ = null(grid.lower)
    if len(at) == 4:
        return gather_products(nodes, at[0], grid.stride, at[1], total)
    for c in range(1 << len(at[0])):
        first, w, _ = corner(grid.axes, at[0], at[1], at[2], grid, c)
        total = axpy(1 / (1 << len(at[0])), gather_products(nodes, first, grid.stride, w, null(at[0])[0]), total)
    return total


@jit
def gather_tensor(grid: Grid, nodes, at):
    """Grid to particle: the tensor with rows c and columns k, sum_I a_Ic dN_Ip/dx_k, row-major."""
    zero, total, _ = null(grid.lower)
    if len(at) == 4:
        return gather_gradients(nodes, at[0], grid.stride, at[1], at[2], zero)
    for c in range(1 << len(at[0])):
        first, w, gradient = corner(grid.axes, at[0], at[1], at[2], grid, c)
        total = axpy(1.0, dyad(gather_products(nodes, first, grid.stride, w, zero), gradient), total)
    return total


@jit
def spread_products(nodes, column, first, stride, w, amount):
    """`spread` over one stencil."""
    if len(w) == 1:
        for a in range(len(w[0])):
            for c in range(len(amount)):
                nodes[first + a, column + c] += w[0][a] * amount[c]
    elif len(w) == 2:
        for b in range(len(w[1])):
            for a in range(len(w[0])):
                N = w[0][a] * w[1][b]
                for c in range(len(amount)):
                    nodes[first + a + b * stride[1], column + c] += N * amount[c]
    else:
        for k in range(len(w[2])):
            for b in range(len(w[1])):
                N_yz = w[1][b] * w[2][k]
                for a in range(len(w[0])):
                    N = w[0][a] * N_yz
                    for c in range(len(amount)):
                        nodes[first + a + b * stride[1] + k * stride[2], column + c] += N * amount[c]


@jit
def spread_gradients(nodes, column, first, stride, w, e, T):
    """`spread_tensor` over one stencil."""
    if len(w) == 1:
        for a in range(len(w[0])):
            nodes[first + a, column] += e[0][a] * T[0][0]
    elif len(w) == 2:
        for b in range(len(w[1])):
            for a in range(len(w[0])):
                x, y = e[0][a] * w[1][b], w[0][a] * e[1][b]
                for c in range(len(w)):
                    nodes[first + a + b * stride[1], column + c] += x * T[0][c] + y * T[1][c]
    else:
        for k in range(len(w[2])):
            for b in range(len(w[1])):
                N_yz, y_z, z_y = w[1][b] * w[2][k], e[1][b] * w[2][k], w[1][b] * e[2][k]
                for a in range(len(w[0])):
                    x, y, z = e[0][a] * N_yz, w[0][a] * y_z, w[0][a] * z_y
                    for c in range(len(w)):
                        nodes[first + a + b * stride[1] + k * stride[2], column + c] += x * T[0][c] + y * T[1][c] + z * T[2][c]


@jit
def gather_products(nodes, first, stride, w, zero):
    """`gather` over one stencil; `zero` is the null vector."""
    total = zero
    if len(w) == 1:
        for a in range(len(w[0])):
            total = axpy(w[0][a], row(nodes, first + a, zero), total)
    elif len(w) == 2:
        for b in range(len(w[1])):
            for a in range(len(w[0])):
                total = axpy(w[0][a] * w[1][b], row(nodes, first + a + b * stride[1], zero), total)
    else:
        for k in range(len(w[2])):
            for b in range(len(w[1])):
                N_yz = w[1][b] * w[2][k]
                for a in range(len(w[0])):
                    total = axpy(w[0][a] * N_yz, row(nodes, first + a + b * stride[1] + k * stride[2], zero), total)
    return total


@jit
def gather_gradients(nodes, first, stride, w, e, zero):
    """`gather_tensor` over one stencil."""
    if len(w) == 1:
        x = zero
        for a in range(len(w[0])):
            x = axpy(e[0][a], row(nodes, first + a, zero), x)
        return x
    if len(w) == 2:
        x = y = zero
        for b in range(len(w[1])):
            for a in range(len(w[0])):
                value = row(nodes, first + a + b * stride[1], zero)
                x = axpy(e[0][a] * w[1][b], value, x)
                y = axpy(w[0][a] * e[1][b], value, y)
        return (x[0], y[0], x[1], y[1])
    x = y = z = zero
    for k in range(len(w[2])):
        for b in range(len(w[1])):
            N_yz, y_z, z_y = w[1][b] * w[2][k], e[1][b] * w[2][k], w[1][b] * e[2][k]
            for a in range(len(w[0])):
                value = row(nodes, first + a + b * stride[1] + k * stride[2], zero)
                x = axpy(e[0][a] * N_yz, value, x)
                y = axpy(w[0][a] * y_z, value, y)
                z = axpy(w[0][a] * z_y, value, z)
    return (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
