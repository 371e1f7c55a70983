"""What a transfer keeps of the velocity's variation about a particle."""

from ..tracing import load_rows, traced
from .nodes import add_field, gathered_by
from .state import Grid, Nodes, Particles, Scheme, columns_of
from .stencil import moments
from .transfer import spread
from .vectors import Vector, axial, axpy, by_columns, columns, constant, null, quotient, scale

# Tuples whose length decides what a function returns have no annotation.
# mypy: disable-error-code="no-untyped-def"

NO_AFFINE, APIC, TPIC = (), (0.0,), (0.0, 0.0)
"""What is kept; their lengths tell them apart where a function is compiled."""


@traced
def spread_momentum(scheme: Scheme, grid: Grid, particles: Particles, nodes: Nodes, numbers, m, v: Vector, at) -> None:
    """p_I += m_p N_Ip [v_p + B_p D_p^-1 (x_I - x_p)], where TPIC keeps the gradient C_p = B_p D_p^-1, and v_p alone when none is kept."""
    if len(scheme.affine) == len(NO_AFFINE):
        spread(grid, nodes.inertia, 1, at, scale(m, v))
    else:
        e, D = moments(grid, at[3], at[4], at[1])
        kept = load_rows(particles.state, numbers, columns_of(grid.lower, particles.deformation).affine, null(grid.lower)[1])
        C = columns(kept, constant(m / grid.scale, D) if len(scheme.affine) == len(TPIC) else quotient(m * grid.scale, D))
        add_field(grid, nodes.inertia, 1, at[0], at[1], e, scale(m, v), C)


@traced
def gather_affine(scheme: Scheme, grid: Grid, nodes: Nodes, at, gradient):
    """What the transfer keeps: B_p = sum_I v_I N_Ip (x_I - x_p)^T, or the gradient for TPIC; nothing else."""
    if len(scheme.affine) == len(APIC):
        e, _ = moments(grid, at[3], at[4], at[1])
        return scale(1 / grid.scale, gathered_by(grid, nodes.velocity, at[0], at[1], e))
    if len(scheme.affine) == len(TPIC):
        return gradient
    return ()


@traced
def spin_with(scheme: Scheme, grid: Grid, particles: Particles, numbers, at, spin: Vector):
    """Angular momentum of particles per unit of their mass, with what they keep of it about themselves."""
    if len(scheme.affine) == len(NO_AFFINE):
        return spin
    kept = load_rows(particles.state, numbers, columns_of(grid.lower, particles.deformation).affine, null(grid.lower)[1])
    if len(scheme.affine) == len(APIC):
        return axpy(1.0, spin, axial(kept))
    D = scale(1 / (grid.scale * grid.scale), moments(grid, at[3], at[4], at[1])[1])
    return axpy(1.0, spin, axial(by_columns(kept, D)))
