"""Records that the compiled time loop works on, for d dimensions, P particles, n nodes and N steps."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpmverify.problem import Array

from ..tracing import traced
from .constitution import Constants, Law
from .vectors import Vector

Integers = NDArray[np.int64]
FAILED, STRAYED, PASSED = range(3)
"""Status of a pass. FAILED: a law failed or a particle left the grid; STRAYED: a particle left its strip; PASSED: neither. The lowest wins."""
KINETIC, STRAIN, HEAT, MOMENTUM = range(4)
"""Columns of the sums of a pass; linear momentum has a column for each direction, and angular momentum follows it."""


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
    """The grid and the basis on it; see `basis.Axis` for what belongs to an axis.

    lower : tuple of float
        Lower corner (d,) [m].
    scale : float
        1/h [1/m].
    cells : tuple of int
        Numbers of cells (d,).
    periodic : tuple of bool
        Whether the ends of an axis are joined (d,).
    stride : tuple of int
        Steps in the number of a node from one to the next along an axis (d,).
    width : tuple of float
        W zeros: their number is the width of a stencil, known where the loop is compiled.
    padding : tuple of int
        Nodes beyond the lower end of an axis (d,).
    piece : ndarray
        Number of the piece of each cell (d, C).
    polynomials : ndarray
        Functions of the pieces of all axes (pieces, powers, W).
    nodes : ndarray
        Distances of the nodes from the lower ends in cells (d, n).
    ghosts : ndarray
        Ghost nodes of periodic axes, each with its image (G, 2).
    kind : Splines
        Kind of the basis, see `splines`.
    half : float
        Half the side of the domain of a particle at the beginning, in cells.
    stretched : bool
        Whether that domain deforms with the particle.
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
    """First columns of the parts of a particle's state, after its position x [m].

    velocity : int
        Of v at t^{n-1/2} [m/s].
    F : int
        Of F, or of J = det F alone [1].
    stress : int
        Of sigma [Pa].
    mass : int
        Of m [kg].
    volume : int
        Of V0 [m^d].
    affine : int
        Of what an affine transfer keeps, see `affine`.
    """

    velocity: int
    F: int
    stress: int
    mass: int
    volume: int
    affine: int


@traced
def columns_of(zero: Vector, deformation: Vector) -> Columns:
    """Columns of the state in the dimension of the vector `zero`, with as many numbers of the deformation as `deformation` has."""
    d = len(zero)
    stress = 2 * d + len(deformation)
    mass = stress + d * (d + 1) // 2
    return Columns(d, 2 * d, stress, mass, mass + 1, mass + 2)


class Particles(NamedTuple):
    """Particles; the properties are views of columns of the state.

    place : ndarray
        Places in the order of the problem (P,).
    reference : ndarray
        X in the order of the problem (P, d) [m].
    state : ndarray
        A row for each particle (P, K), see `Columns`.
    order : ndarray
        Order in which the passes take the particles (P,).
    deformation : tuple of float
        Zeros, as many as a particle keeps numbers of its deformation: d^2 for F, 1 for J alone. Their number is known where the loop
        is compiled.
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
    """Zeros at the nodes (components, count); one number more is allocated, for the lane that a stencil of three nodes does not use."""
    return np.zeros(components * count + 1)[:-1].reshape(components, count)


class Nodes(NamedTuple):
    """Values at the nodes; in less than three dimensions masses and forces are per unit of the missing area or length.

    inertia : ndarray
        m_I and p_I (1 + d, n) [kg, kg m/s].
    velocity : ndarray
        v_I (d, n) [m/s].
    projected : ndarray
        v_I of the momentum that MUSL projects again, or the correction of XPIC (d, n) [m/s].
    acceleration : ndarray
        a_I (d, n) [m/s^2].
    internal : ndarray
        Internal force (d, n) [N].
    external : ndarray
        External force (d, n) [N].
    term : ndarray
        Term of the series of XPIC or FMPM (d, n) [m/s or m/s^2].
    cells : ndarray
        Sums of the cells (C, K), see `fits.Parts`; none where the basis fits nothing.
    """

    inertia: Array
    velocity: Array
    projected: Array
    acceleration: Array
    internal: Array
    external: Array
    term: Array
    cells: Array


class Step(NamedTuple):
    """Arguments of the passes of a step.

    body : ndarray
        Block of body forces (N, P, d) in the order of the problem or (N, n, d) at nodes [m/s^2]; empty for none.
    load : int
        Index of the step in this block.
    n : int
        Number of the step.
    dt : float
        Time step [s].
    record : bool
        Whether to record sums at t^n.
    forces : bool
        Whether forces are transferred to the grid.
    advance : bool
        Whether to go on to t^{n+1}.
    """

    body: Array
    load: int
    n: int
    dt: float
    record: bool
    forces: bool
    advance: bool
