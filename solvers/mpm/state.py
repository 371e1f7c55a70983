"""What the compiled time loop works on; d dimensions, P particles, n nodes, N steps, T outputs, S strips."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpmverify.problem import Array

from ..tracing import traced
from .constitution import Constants, Law
from .vectors import Vector

Integers = NDArray[np.int64]
FAILED, STRAYED, PASSED = range(3)
"""What a pass says of its particles."""
UNSORTED = -1
"""In the place of the step of the last sorting: the particles are to be sorted before the next."""
KINETIC, STRAIN, HEAT, MOMENTUM = range(4)
"""Columns of the sums of a pass; the momentum takes one for each direction, and then comes the angular momentum."""


class Series(NamedTuple):
    """The series sum_{j < k} (I - S^+ S)^j of a transfer.

    terms : int
        k.
    full_mass : bool
        Whether it stands for the inverse of the full mass (FMPM), or adds to the velocity of particles (XPIC).
    """

    terms: int
    full_mass: bool


class Scheme(NamedTuple):
    """Choices of the scheme; the types of `affine`, `series` and `law` are known where a time loop is compiled.

    schedule : int
        `USF`, `USL` or `MUSL` of `passes`.
    affine : NamedTuple
        What particles keep of the variation of velocity, a kind of `affine`.
    flip : float
        Share of FLIP [1].
    series : Series, optional
        Of XPIC and FMPM.
    total : bool
        Whether the formulation is total Lagrangian.
    nodal_body : bool
        Whether the body force acts at the nodes.
    law : Linear or Numbered
        Constitutive law.
    constants : Constants
        Of the law.
    """

    schedule: int
    affine: Any
    flip: float
    series: Series | None
    total: bool
    nodal_body: bool
    law: Law
    constants: Constants


class Grid(NamedTuple):
    """Lower corner (d,) [m], 1/h [1/m], numbers of cells, whether the ends of an axis are joined, steps from node to node (d,).

    W numbers that tell the width of a stencil; of all axes as of `Axis` the padding (d,), the pieces (d, C), the polynomials, to which
    these refer, and the nodes (d, n) in cells from the lower end; a ghost node of a periodic axis and its image (G, 2). The kind of the
    basis, half the side of a particle at first, in cells, and whether it stretches.
    """

    lower: tuple[float, ...]
    scale: float
    cells: tuple[int, ...]
    periodic: tuple[bool, ...]
    stride: tuple[int, ...]
    width: tuple[float, ...]
    padding: tuple[int, ...]
    piece: NDArray[np.uint8]
    polynomials: Array
    nodes: Array
    ghosts: Integers
    kind: Any
    half: float
    stretched: bool


@traced
def full_mass(scheme: Scheme) -> bool:
    """Whether a series stands for the inverse of the full mass."""
    return False if scheme.series is None else scheme.series.full_mass


class Columns(NamedTuple):
    """First column of what makes up the state of a particle; x [m] comes first.

    v at t^{n-1/2} [m/s], F or J = det F [1], sigma [Pa], m [kg], V0 [m^d], and B [m^2/s], or B D^-1 [1/s], where the transfer keeps one.
    """

    velocity: int
    F: int
    stress: int
    mass: int
    volume: int
    affine: int


@traced
def columns_of(zero: Vector, deformation: Vector) -> Columns:
    """Columns of the state in as many dimensions as a vector has, with as many numbers of the deformation as another one has."""
    d = len(zero)
    stress = 2 * d + len(deformation)
    mass = stress + d * (d + 1) // 2
    return Columns(d, 2 * d, stress, mass, mass + 1, mass + 2)


class Particles(NamedTuple):
    """Place in the order of the problem (P,), X in that order [m] (P, d), the state (P, K), a row of which is read at once, and in which
    order the passes take them (P,); as many zeros as they keep numbers of their deformation, d^2 of F or one, J, if that is enough.

    See `Columns`; the properties are views.
    """

    place: Integers
    reference: Array
    state: Array
    order: Integers
    deformation: tuple[float, ...]

    def _part(self, first: int, count: int) -> Array:
        return self.state[:, first : first + count]

    @property
    def _columns(self) -> Columns:
        return columns_of((0.0,) * self.reference.shape[1], self.deformation)

    @property
    def position(self) -> Array:
        return self._part(0, self.reference.shape[1])

    @property
    def velocity(self) -> Array:
        return self._part(self._columns.velocity, self.reference.shape[1])

    @property
    def F(self) -> Array:  # noqa: N802 (the field writes it so)
        return self._part(self._columns.F, len(self.deformation))

    @property
    def stress(self) -> Array:
        return self.state[:, self._columns.stress : self._columns.mass]

    @property
    def mass(self) -> Array:
        return self.state[:, self._columns.mass]

    @property
    def volume(self) -> Array:
        return self.state[:, self._columns.volume]

    @property
    def affine(self) -> Array:
        return self.state[:, self._columns.affine :]


def nodal(components: int, count: int) -> Array:
    """Zero at the nodes (components, count), with room behind the last one for the lane that a stencil of three does not use."""
    return np.zeros(components * count + 1)[:-1].reshape(components, count)


class Nodes(NamedTuple):
    """m_I and p_I in one array (1 + d, n) [kg, kg m/s]; the others (d, n).

    v_I, v_I of the momentum projected again or the correction of XPIC [m/s], a_I [m/s^2], internal and external f_I [N], and a term
    of the series of XPIC and FMPM [m/s or m/s^2]. The sums of the cells, see `fits.Parts` (C, K).

    In less than three dimensions masses and forces are per unit of the area or length that is left out.
    """

    inertia: Array
    velocity: Array
    projected: Array
    acceleration: Array
    internal: Array
    external: Array
    term: Array
    cells: Array


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


class Strips(NamedTuple):
    """S strips of cells across the last axis, each with its particles.

    First particle of each strip and the number of particles (S + 1,), first row of cells of each strip and the number of rows
    (S + 1,), how far its particles may go before they are sorted again (S, 2) [m], what the passes say of each strip (S,) and the
    sums that they leave; those that passes over as many parts of the nodes leave (S, 8), a cache line each, and two sums
    of these (2, 8). The first nodes or the cells of the particles (P,); how many of a strip have each (S, C), for `arrange`; how many
    particles are in the cells before each (C + 1,) and room for a state (K,), for `sort`; the step of the last sorting, and for tests how
    many there were (2,).
    """

    particles: Integers
    rows: Integers
    limits: Array
    passed: Integers
    sums: Array
    nodal: Array
    total: Array
    node: NDArray[np.int32]
    shares: Integers
    start: Integers
    spare: Array
    sorting: Integers


class Step(NamedTuple):
    """What the passes of a step are told.

    A block of body forces (N, P, d) in the order of the problem or (N, n, d) at nodes [m/s^2], empty for none, and which of it this
    step is on; the step n and dt [s]; whether to record, whether particles bring forces to the grid, and whether to go on to t^{n+1}.
    """

    body: Array
    load: int
    n: int
    dt: float
    record: bool
    forces: bool
    advance: bool


class Outputs(NamedTuple):
    """Steps of the outputs (T,), and the synchronous u, v (T, P, d), sigma (T, P, d (d + 1)/2), and volume (T, P)."""

    step: Integers
    displacement: Array
    velocity: Array
    stress: Array
    volume: Array


class Histories(NamedTuple):
    """Steps that are recorded (R,); momentum and impulse (R, d), angular momentum (R, 0, 1 or 3), and (R,) of the other synchronous sums.

    Per unit of the area or length that is left out in less than three dimensions.
    """

    step: Integers
    momentum: Array
    impulse: Array
    angular_momentum: Array
    mass: Array
    kinetic_energy: Array
    strain_energy: Array
    external_work: Array
    dissipated_energy: Array
