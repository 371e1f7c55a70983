"""What the compiled time loop works on; d dimensions, P particles, n nodes, N steps, T outputs, S strips."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpmverify.problem import Array

from .basis import Axis
from .constitution import Constants

Integers = NDArray[np.int64]


class Scheme(NamedTuple):
    """Choices of the scheme: schedule, affine part of the transfer, share of FLIP, terms of the series for the velocity and whether they
    stand for the inverse of the full mass, formulation, where the body force
    acts, law and its constants.
    """

    schedule: int
    affine: int
    flip: float
    terms: int
    full_mass: bool
    total: bool
    nodal_body: bool
    law: int
    constants: Constants


class Grid(NamedTuple):
    """Axes (d,), lower corner (d,) [m], 1/h [1/m], steps from node to node (d,), and W numbers that tell the width of a stencil.

    A ghost node of a periodic axis and its image, (G, 2). The kind of the basis, whether its gradients are those of moving least
    squares, half the side of a particle at first, in cells, and whether it stretches.
    """

    axes: tuple[Axis, ...]
    lower: tuple[float, ...]
    scale: float
    stride: tuple[int, ...]
    width: tuple[float, ...]
    ghosts: Integers
    kind: tuple[float, ...]
    least_squares: bool
    half: float
    stretched: bool


class Particles(NamedTuple):
    """Place in the order of the problem (P,), X, x [m] and v at t^{n-1/2} [m/s] (P, d), B [m^2/s] and F [1] (P, d d).

    sigma [Pa] (P, d (d + 1)/2), m [kg] (P,) and V0 [m^d] (P,). B is (0,) when the transfer keeps none, which numba sees.
    """

    place: Integers
    reference: Array
    position: Array
    velocity: Array
    affine: Array
    F: Array
    stress: Array
    mass: Array
    volume: Array


class Nodes(NamedTuple):
    """m_I and p_I in one array (n, 1 + d) [kg, kg m/s]; the others (n, d).

    v_I, v_I of the momentum projected again or the correction of XPIC [m/s], a_I [m/s^2], internal and external f_I [N], and a term
    of the series of XPIC and FMPM [m/s or m/s^2].

    In less than three dimensions masses and forces are per unit of the area or length that is left out.
    """

    inertia: Array
    velocity: Array
    projected: Array
    acceleration: Array
    internal: Array
    external: Array
    term: Array


class Faces(NamedTuple):
    """Conditions on the faces of the box, K held and L loaded components of nodes.

    `held` and `loaded` give the node, the component and the row of the tables (K, 3) and (L, 3); `area` is the integral of N_I over
    the face (L,) [m^(d-1)], `velocity` v_b at 0 and all t^{n+1/2} (rows, N + 2) [m/s], `force` p n at all t^n (rows, N + 1) [Pa].
    """

    held: Integers
    loaded: Integers
    area: Array
    velocity: Array
    force: Array


class Outputs(NamedTuple):
    """Steps of the outputs (T,), and the synchronous u, v (T, P, d), sigma (T, P, d (d + 1)/2), and volume (T, P)."""

    step: Integers
    displacement: Array
    velocity: Array
    stress: Array
    volume: Array


class Histories(NamedTuple):
    """Arrays (N + 1, d) of momentum and impulse, angular momentum (N + 1, 0, 1 or 3), and (N + 1,) of the other synchronous sums.

    Per unit of the area or length that is left out in less than three dimensions.
    """

    momentum: Array
    impulse: Array
    angular_momentum: Array
    mass: Array
    kinetic_energy: Array
    strain_energy: Array
    external_work: Array
    dissipated_energy: Array
