"""What particles keep of the variation of velocity about them.

A kind is an empty NamedTuple, which tells compiled loops apart; its methods run while the time loop is traced. Where x_I - x_p varies
within the support, D_p = sum_I N_Ip (x_I - x_p)(x_I - x_p)^T is diagonal. What a kind has:

slopes(grid, kept, m, D)
    Columns (d, d) of m_p times the velocity gradient, in cells; `kept` are the numbers of the particle (d d), D is in cells (d,).
gather(grid, values, at, gradient)
    What the particle keeps of the `values` of the nodes v (d, n), (d d); `gradient` is a function that returns
    sum_I v_I dN_Ip/dx (d d).
spin(grid, kept, at)
    Angular momentum of the particle about itself per unit of mass, as `cross` has its components.

To add one, write its kind, enter it in `AFFINE`, and the transfers that have it in `transfers`.
"""

from typing import NamedTuple

from ..tracing import load_rows, traced
from .nodes import add_field, gathered_by
from .state import Grid, Nodes, Particles, Scheme, columns_of
from .vectors import Vector, axial, axpy, by_columns, columns, constant, null, quotient, scale

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"


class Uniform(NamedTuple):
    """Nothing: the velocity is the same about the particle."""


class Moment(NamedTuple):
    """B_p = sum_I v_I N_Ip (x_I - x_p)^T [m^2/s], of which the gradient is B_p D_p^-1 (APIC)."""

    def slopes(self, grid: Grid, kept, m, D):
        return columns(kept, quotient(m * grid.scale, D))

    def gather(self, grid: Grid, values, at, gradient):
        e, _ = at.moments(grid)
        return scale(1 / grid.scale, gathered_by(grid, values, at.first, at.N, e))

    def spin(self, grid: Grid, kept, at):
        return axial(kept)


class Gradient(NamedTuple):
    """The gradient C_p = sum_I v_I dN_Ip/dx [1/s] itself (TPIC)."""

    def slopes(self, grid: Grid, kept, m, D):
        return columns(kept, constant(m / grid.scale, D))

    def gather(self, grid: Grid, values, at, gradient):
        return gradient()

    def spin(self, grid: Grid, kept, at):
        _, D = at.moments(grid)
        return axial(by_columns(kept, scale(1 / (grid.scale * grid.scale), D)))


AFFINE = {None: Uniform(), "moment": Moment(), "gradient": Gradient()}
"""Kinds by the name that a `Transfer` has for them."""


@traced
def spread_momentum(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, numbers, m, v: Vector, at) -> None:
    """p_I += m_p N_Ip [v_p + C_p (x_I - x_p)] with the velocity gradient C_p that the particle keeps, if it keeps one."""
    if isinstance(scheme.affine, Uniform):
        at.spread(grid, nodes.inertia, 1, scale(m, v))
    else:
        e, D = at.moments(grid)
        slopes = scheme.affine.slopes(grid, affine_of(grid, particles, numbers), m, D)
        add_field(grid, nodes.inertia, 1, at.first, at.N, e, scale(m, v), slopes)


@traced
def gather_affine(scheme: Scheme, grid: Grid, nodes: Nodes, at, gradient):
    """What a particle keeps after a step; an empty tuple where it keeps nothing."""
    return () if isinstance(scheme.affine, Uniform) else scheme.affine.gather(grid, nodes.velocity, at, lambda: gradient)


@traced
def spin_with(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, numbers, at, spin: Vector, kick):
    """Angular momentum of particles per unit of mass at t^n: `spin` of their centres, with that about themselves.

    What they keep belongs to t^{n-1/2}; what the acceleration adds to it in the time `kick` brings it to t^n, as it does the velocity.
    """
    if isinstance(scheme.affine, Uniform):
        return spin
    a = nodes.acceleration
    rate = scheme.affine.gather(grid, a, at, lambda: at.gather_tensor(grid, a))
    now = axpy(kick, rate, affine_of(grid, particles, numbers))
    return axpy(1.0, spin, scheme.affine.spin(grid, now, at))


@traced
def affine_of(grid: Grid, particles: Particles, numbers):
    """What particles keep, row-major (d d)."""
    return load_rows(particles.state, numbers, columns_of(grid.lower, particles.deformation).affine, null(grid.lower)[1])
