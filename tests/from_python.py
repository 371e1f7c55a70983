"""What runs within a pass of a solver has no entry for Python, and lanes have no value there: the tests give them one."""

import inspect
from types import SimpleNamespace

import numpy as np

from mpmverify.solvers.mpm import splines, stencil, support
from mpmverify.solvers.mpm.order import strips
from mpmverify.solvers.mpm.state import nodal
from mpmverify.solvers.mpm.vectors import columns, constant, scale
from mpmverify.solvers.tracing import Compiled, traced, unpack, when


def entries(module):
    """All names of a module, its traced functions compiled."""
    known = dict(vars(module))
    for name, value in vars(module).items():
        if inspect.isfunction(value) and inspect.getsource(value).startswith("@traced"):
            known[name] = Compiled(value)
    return SimpleNamespace(**known)


@traced
def of_the_first(values):
    return tuple(unpack(value)[0] for value in values)


@traced
def _along(grid, s):
    (first,), (offset,) = grid.kind.begins(grid, (s,), (1.0,))
    N, dN = splines.along(grid, 0, first, offset)
    return first, N, dN, support.moment_along(grid, 0, first, offset, N)


_compiled_along = Compiled(_along)


def along(grid, s):
    """First function, N (W,) and dN/dx (W,) along the only axis of a grid."""
    first, N, dN, _ = _compiled_along(grid, s)
    return first, np.array(N), np.array(dN)


def moment_along(grid, s):
    """Moments N (x_I - x) (W,), and their moment D, in cells."""
    moment, D = _compiled_along(grid, s)[3]
    return np.array(moment), D


@traced
def _support(scheme, grid, particles, p):
    some = stencil.group(scheme, grid, particles, p, p + 1)
    return some, stencil.support_of(grid, particles, some)


@traced
def _moments_of_inertia(scheme, grid, particles, p):
    _, D = _support(scheme, grid, particles, p)[1].moments(grid)
    return of_the_first(scale(1 / (grid.scale * grid.scale), D))


moments_of_inertia = Compiled(_moments_of_inertia)
"""D of a particle, a diagonal (d,) [m^2]."""


@traced
def _spread(scheme, grid, particles, p, N, dN, directions):
    some, at = _support(scheme, grid, particles, p)
    at.spread(grid, N, 0, (some.present,))
    at.spread_tensor(grid, dN, 0, columns(directions, constant(some.present, grid.lower)))


@Compiled
def spread(scheme, grid, particles, p, N, dN, directions):
    """Add the functions of a particle if it is on the grid; return whether it is."""
    supported = stencil.found(scheme, grid, particles, p)[0]
    with when(supported):
        _spread(scheme, grid, particles, p, N, dN, directions)
    return supported


def functions_or_none(scheme, grid, particles, nodes, p):
    """N_I (n,) and dN_I/dx (n, d) of a particle on n nodes (n, d), None if it is not on the grid."""
    dimension, count = len(grid.lower), len(nodes)
    N, dN = nodal(1, count), nodal(dimension, count)
    if not spread(scheme, grid, particles, p, N, dN, tuple(np.eye(dimension).ravel().tolist())):
        return None
    return N[0], dN.T


def functions_of(scheme, grid, particles, nodes, p):
    """As `functions_or_none`, of a particle that has to be on the grid."""
    found = functions_or_none(scheme, grid, particles, nodes, p)
    assert found, "the particle is not on the grid"
    return found


def one_strip(grid, particles):
    """All particles in the only strip of a grid."""
    return strips(grid.lower[-1], 1 / grid.scale, grid.cells, 2, particles, False, grid.stride[-1], False)
