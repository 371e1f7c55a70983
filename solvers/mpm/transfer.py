"""Transfer between particles and grid: where the basis is evaluated, gathered and scattered."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mpmverify.problem import Array

from .basis import basis
from .state import Grid, Nodes, Particles, Stencil

jit = njit(fastmath={"contract"}, error_model="numpy")


@jit
def evaluate_basis(grid: Grid, particles: Particles, stencil: Stencil, total: bool) -> bool:
    """N_I(x_p) and dN_I/dx(x_p), of X_p for the total Lagrangian; False when a particle is not on the grid, NaN included."""
    for p in range(particles.mass.size):
        x = particles.reference[p] if total else particles.reference[p] + particles.displacement[p]
        s = (x - grid.lower) / grid.h
        if not 0 <= s <= grid.cells:
            return False
        cell = min(int(s), grid.cells - 1)
        N0, N1, N2, d0, d1, d2 = basis(s - cell, cell, grid.cells, grid.degree)
        stencil.first[p] = cell
        stencil.value[p, 0], stencil.value[p, 1], stencil.value[p, 2] = N0, N1, N2
        stencil.gradient[p, 0], stencil.gradient[p, 1], stencil.gradient[p, 2] = d0 / grid.h, d1 / grid.h, d2 / grid.h
    return True


@jit
def gather(first: NDArray[np.uint32], weight: Array, nodal: Array, p: int) -> float:
    """Grid to particle: sum_I W_Ip a_I."""
    i = first[p]
    return weight[p, 0] * nodal[i] + weight[p, 1] * nodal[i + 1] + weight[p, 2] * nodal[i + 2]


@jit
def scatter(first: NDArray[np.uint32], weight: Array, nodal: Array, p: int, amount: float) -> None:
    """Particle to grid: a_I += W_Ip a."""
    i = first[p]
    nodal[i] += weight[p, 0] * amount
    nodal[i + 1] += weight[p, 1] * amount
    nodal[i + 2] += weight[p, 2] * amount


@jit
def particle_mass_to_grid(particles: Particles, stencil: Stencil, nodes: Nodes) -> None:
    """m_I = sum_p m_p N_Ip."""
    for i in range(nodes.mass.size):
        nodes.mass[i] = 0.0
    for p in range(particles.mass.size):
        scatter(stencil.first, stencil.value, nodes.mass, p, particles.mass[p])


@jit
def particle_momentum_to_grid(particles: Particles, stencil: Stencil, nodes: Nodes) -> None:
    """p_I = sum_p m_p v_p N_Ip."""
    for i in range(nodes.momentum.size):
        nodes.momentum[i] = 0.0
    for p in range(particles.mass.size):
        scatter(stencil.first, stencil.value, nodes.momentum, p, particles.mass[p] * particles.velocity[p])
