"""Motion and deformation of the particles in a step, their stress and their energy."""

from mpmverify.problem import Array

from ..tracing import all_positive, cond, floor, load_rows, logical_not, reduce_sum, store_rows, traced, when, where
from .constitution import Linear, dissipation, finite_strain, reference_stress, strain_energy, stress, viscous
from .state import FAILED, HEAT, PASSED, STRAYED, Grid, Particles, Scheme, columns_of
from .stencil import Group
from .tensors import Symmetric, Tensor, deform, det, full
from .vectors import Vector, axpy, columns, constant, identity, null

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"


@traced
def strain_and_stress(particles: Particles, numbers, zero: Vector):
    """F, or J where that alone is kept, and sigma of particles."""
    column = columns_of(zero, particles.deformation)
    F = load_rows(particles.state, numbers, column.F, particles.deformation)
    return F, load_rows(particles.state, numbers, column.stress, null(zero)[2])


@traced
def force_columns(scheme: Scheme, V0, sigma: Symmetric, F: Tensor, like: Vector):
    """Columns (d, d) of -V sigma, or of -V0 P in the total Lagrangian formulation [J]."""
    T = where(scheme.total, reference_stress(scheme.law, sigma, F), full(sigma))
    V = where(scheme.total, V0, V0 * det(F))
    return columns(T, constant(-V, like))


@traced
def deformed(scheme: Scheme, increment: Tensor, F: Tensor):
    """F + dt dv/dX or (I + dt dv/dx) F after a step. Where J alone is kept, det(I + dt dv/dx) J, or J unchanged if total Lagrangian."""
    if len(F) < len(increment):
        return (where(scheme.total, F[0], F[0] * det(axpy(1.0, increment, identity(increment)))),)
    return cond(scheme.total, lambda: axpy(1.0, increment, F), lambda: deform(increment, F))


@traced
def strain(scheme: Scheme, particles: Particles, some: Group, increment: Tensor, dt: float, sums: Array, zero: Vector) -> int:
    """Update F or J as of `deformed`, and the stress by the law; add the energy that became heat to `sums`.

    FAILED when a law or a volume meets J <= 0.
    """
    column, state, law, constants = columns_of(zero, particles.deformation), particles.state, scheme.law, scheme.constants
    before, sigma = strain_and_stress(particles, some.numbers, zero)
    F = deformed(scheme, increment, before)
    store_rows(state, some.numbers, column.F, F)
    if not isinstance(law, Linear):
        with when(viscous(law)):
            V = some.present * load_rows(state, some.numbers, column.volume, (0.0,))[0]
            J = where(scheme.total, 1.0, det(before))
            sums[HEAT] += reduce_sum(V * J * dissipation(law, constants, sigma, increment, dt))
    store_rows(state, some.numbers, column.stress, stress(law, constants, sigma, F, increment, dt))
    return where(all_positive(det(F)) | keeps_volume(scheme), PASSED, FAILED)


@traced
def move(grid: Grid, state: Array, some: Group, increment: Vector, limits: Array) -> int:
    """Move by x += dt v; STRAYED when the last coordinate, or on a periodic axis each of its images, passes the limits (2,) [m]."""
    x = axpy(1.0, increment, load_rows(state, some.numbers, 0, increment))
    store_rows(state, some.numbers, 0, x)
    times = floor((x[-1] - limits[0]) * (grid.scale / grid.cells[-1]))
    image = x[-1] - (grid.cells[-1] / grid.scale) * times
    return where(within(x[-1], limits) | (grid.periodic[-1] & within(image, limits)), PASSED, STRAYED)


@traced
def within(y, limits: Array) -> bool:
    """Whether all values lie between limits (2,)."""
    return all_positive(y - limits[0]) & all_positive(limits[1] - y)


@traced
def stored_energy(scheme: Scheme, particles: Particles, some: Group, zero: Vector):
    """Stored energy of particles [J]."""
    column, state = columns_of(zero, particles.deformation), particles.state
    F, sigma = strain_and_stress(particles, some.numbers, zero)
    J = where(keeps_volume(scheme) | finite_strain(scheme.law), 1.0, det(F))
    V = some.present * load_rows(state, some.numbers, column.volume, (0.0,))[0]
    return V * J * strain_energy(scheme.law, scheme.constants, sigma, F)


@traced
def keeps_volume(scheme: Scheme) -> bool:
    """Whether volumes do not change: at small strain in the total Lagrangian formulation, where J may even be negative."""
    return scheme.total & logical_not(finite_strain(scheme.law))
