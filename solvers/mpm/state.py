"""Arrays and choices that the compiled time loop works on; C cells, P particles, N steps, T outputs."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpmverify.problem import Array


class Scheme(NamedTuple):
    """Choices of the scheme and Lame's parameters lambda, mu [Pa]."""

    schedule: int
    flip: float
    total: bool
    nodal_body: bool
    law: int
    lame: float
    shear: float


class Grid(NamedTuple):
    """C cells of size h [m] from `lower` [m] on; C + degree functions in arrays of length C + 2."""

    lower: float
    h: float
    cells: int
    degree: int


class Particles(NamedTuple):
    """Arrays (P,): X [m], u [m], v at t^{n-1/2} [m/s], F [1], sigma [Pa], m [kg/m^2], V0 [m]."""

    reference: Array
    displacement: Array
    velocity: Array
    F: Array
    stress: Array
    mass: Array
    volume: Array


class Stencil(NamedTuple):
    """First function of each particle (P,), N_Ip [1] and dN_Ip/dx [1/m], both (P, 3)."""

    first: NDArray[np.uint32]
    value: Array
    gradient: Array


class Nodes(NamedTuple):
    """Arrays (C + 2,): m_I [kg/m^2], p_I [kg/(m s)], v_I [m/s], a_I [m/s^2], internal and external f_I [Pa]."""

    mass: Array
    momentum: Array
    velocity: Array
    acceleration: Array
    internal: Array
    external: Array


class Ends(NamedTuple):
    """Conditions at x- and x+.

    Node and whether its velocity is prescribed (2,), v_b at 0 and all t^{n+1/2} (2, N + 2), p n at all t^n (2, N + 1).
    """

    node: NDArray[np.int64]
    held: NDArray[np.bool_]
    velocity: Array
    force: Array


class Outputs(NamedTuple):
    """Steps of the outputs (T,), and the synchronous u, v, sigma, F, (T, P)."""

    step: NDArray[np.int64]
    displacement: Array
    velocity: Array
    stress: Array
    F: Array


class Histories(NamedTuple):
    """Arrays (N + 1,) of synchronous sums per unit cross-section."""

    mass: Array
    momentum: Array
    impulse: Array
    kinetic_energy: Array
    strain_energy: Array
    external_work: Array
