"""What runs within a pass of a solver has no entry for Python, and lanes have no value there: the tests give them one."""

from types import SimpleNamespace

import numpy as np
from numba import njit
from numba.core.dispatcher import Dispatcher

from mpmverify.solvers.mpm import basis, stencil, transfer
from mpmverify.solvers.mpm.compilation import ARITHMETIC
from mpmverify.solvers.mpm.lanes import add_to, row
from mpmverify.solvers.mpm.state import columns_of, nodal
from mpmverify.solvers.mpm.vectors import null


def callable_from_python(function):
    """The same compiled function, with an entry."""
    return njit(**ARITHMETIC)(function.py_func)


def entries(module):
    """All names of a module, its compiled functions with an entry."""
    return SimpleNamespace(
        **{
            name: callable_from_python(value) if isinstance(value, Dispatcher) else value
            for name, value in vars(module).items()
        }
    )


@njit(**ARITHMETIC)
def along(grid, s):
    """First function, N (W,) and dN/dx (W,) along the only axis of a grid."""
    k, width = stencil.numbers((s,))[0], grid.width
    first, N, dN = basis.along(width, grid, k, s)
    found = np.zeros((2, 4))
    add_to(found, (0, 0), N)
    add_to(found, (1, 0), dN)
    return first, found[0, : len(width)], found[1, : len(width)]


@njit(**ARITHMETIC)
def moment_along(grid, s):
    """Moments N (x_I - x) (W,), and their moment D."""
    k, width = stencil.numbers((s,))[0], grid.width
    first, N, _ = basis.along(width, grid, k, s)
    moment, D = basis.moment_along(grid, k, first, s, N)
    found = np.zeros(4)
    add_to(found, (0,), moment)
    return found[: len(width)], D


@njit(**ARITHMETIC)
def _support(scheme, grid, particles, p):
    zero, tensor, _ = null(grid.lower)
    F = stencil.domain(grid.kind, grid, row(particles.state, (p, columns_of(zero).F), tensor))
    s = stencil.place(scheme, grid, particles, p)
    return s, F, stencil.support(grid.kind, grid, s, F)


@njit(**ARITHMETIC)
def supported(scheme, grid, particles, p):
    """Whether a particle is on the grid."""
    s, F, _ = _support(scheme, grid, particles, p)
    return stencil.supported(grid.kind, grid, s, F)


@njit(**ARITHMETIC)
def moments_of_inertia(scheme, grid, particles, p):
    """D of a particle, a diagonal (d,)."""
    s, _, at = _support(scheme, grid, particles, p)
    return stencil.moments(grid, s, at)[1]


@njit(**ARITHMETIC)
def _spread(scheme, grid, particles, p, N, dN, directions):
    _, _, at = _support(scheme, grid, particles, p)
    transfer.spread(grid, N, 0, at, (1.0,))
    transfer.spread_tensor(grid, dN, 0, at, directions)


def functions_of(scheme, grid, particles, nodes, p):
    """N_I (n,) and dN_I/dx (n, d) of a particle on n nodes (n, d)."""
    dimension, count = len(grid.lower), len(nodes)
    N, dN = nodal(1, count), nodal(dimension, count)
    _spread(scheme, grid, particles, p, N, dN, tuple(tuple(line) for line in np.eye(dimension).tolist()))
    return N[0], dN.T
