"""Finite element method for a bar, assembled by scikit-fem: the reference that shares no kernel with the other solvers."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky_banded
from scipy.sparse import csr_array, diags_array
from skfem import Basis, ElementLineP1, ElementLineP2, MeshLine
from skfem.models.poisson import laplace
from skfem.models.poisson import mass as unit_mass

from mpmverify.errors import UsageError
from mpmverify.problem import (
    Array,
    Discretisation,
    LinearElastic,
    NeoHookean,
    Problem,
    Spatial,
    Traction,
    Velocity,
    output_steps,
    require,
)
from mpmverify.solution import Outcome, Solution, Status, Work

from .kernel import (
    EPSILON,
    GREW,
    GROWTH,
    HISTORIES,
    INVERTED,
    STABLE,
    Bands,
    Ends,
    Law,
    Mesh,
    Record,
    State,
    advance,
)

# Two Gauss points more than the superconvergent ones: sampled there alone, the stress error would come out too small.
ELEMENTS = {1: (ElementLineP1(), 5), 2: (ElementLineP2(), 7)}
"""Element and order of the quadrature, by degree."""
BETA = {"central-differences": 0.0, "newmark": 0.25}
"""Newmark's beta by integrator; gamma is 1/2 in both."""
BLOCK = 2**14
"""Largest number of body-force values that are stored at once, so that most runs have several blocks."""


def lower_bands(matrix: Any) -> Array:
    """Diagonal and lower bands (width + 1, n) of a symmetric sparse matrix A: row d has the entries A[j + d, j]."""
    entries = matrix.tocoo()
    width = int(np.max(entries.row - entries.col))
    return np.stack([np.pad(matrix.diagonal(-d), (0, d)) for d in range(width + 1)])


def factorised(mass: Any, operator: Any, held: NDArray[np.bool_]) -> Bands:
    """Bands of both matrices, and the Cholesky factor of the operator with held ends replaced by identity rows."""
    free = np.ones(operator.shape[0])
    free[[0, -1]] = ~held
    reduced = diags_array(free) @ operator @ diags_array(free) + diags_array(1 - free)
    return Bands(
        lower_bands(mass), lower_bands(operator), np.ascontiguousarray(cholesky_banded(lower_bands(reduced), lower=True))
    )


def end_conditions(problem: Problem, law: LinearElastic, t: Array, dt: float) -> tuple[Ends, Array, float]:
    """Return the ends, their initial velocity (2,) [m/s] and the largest velocity amplitude that they send into the bar [m/s].

    The prescribed acceleration is the second difference of the prescribed displacement; at the first and last instants the
    prescribed velocity enters. With central differences the end then follows its displacement exactly, with the average
    acceleration rule within O(dt^2) and without drift. Momentum balances to round-off, because the end obeys the same
    recurrences as every node. Prescribing displacement and velocity instead would determine the acceleration by an
    alternating recurrence without damping.
    """
    ends, velocity, amplitude = Ends(np.zeros(2, bool), np.zeros((len(t), 2)), np.zeros((len(t), 2))), np.zeros(2), 0.0
    for end, (face, normal) in enumerate((("x-", -1), ("x+", 1))):
        condition = problem.boundary[face]
        if isinstance(condition, Traction):
            ends.load[:, end] = normal * condition.value(t)
            amplitude += float(np.abs(ends.load[:, end]).max()) / (law.density * law.wave_speed)
        elif isinstance(condition, Velocity):
            v, mean = condition.value(t), np.diff(condition.value.integral(t)) / dt
            ends.held[end], velocity[end] = True, v[0]
            ends.acceleration[:, end] = np.concatenate([[2 * (mean[0] - v[0])], np.diff(mean), [2 * (v[-1] - mean[-1])]]) / dt
            amplitude += float(np.abs(v).max())
    return ends, velocity, amplitude


@dataclass(frozen=True)
class FiniteElement:
    """Displacement-based finite elements for a bar, M a = f_ext - int B^T P(1 + B u) dX, with Newmark time integration.

    Parameters
    ----------
    degree : int
        Degree of the shape functions, 1 or 2.
    mass : str
        Mass matrix: "consistent", or "lumped" by row sums (for degree 2 these are the weights of Simpson's rule).
    integrator : str
        "central-differences", or "newmark" for the average acceleration rule, which is stable at any time step and takes the
        linear elastic law only.

    Raises
    ------
    UsageError
        If a parameter has any other value.

    Notes
    -----
    Central differences are stable up to nu_C = 1 (degree 1, lumped), 1/sqrt(3) (1, consistent), 1/sqrt(6) (2, lumped) and
    1/sqrt(15) (2, consistent).

    References
    ----------
    T. J. R. Hughes, The Finite Element Method, Prentice-Hall 1987, chapters 7 and 9.
    T. Gustafsson and G. D. McBain, scikit-fem, Journal of Open Source Software 5 (2020) 2369, doi:10.21105/joss.02369.
    """

    degree: int = 1
    mass: str = "consistent"
    integrator: str = "central-differences"

    def __post_init__(self) -> None:
        for what, value, known in (
            ("degree", self.degree, list(ELEMENTS)),
            ("mass", self.mass, ["consistent", "lumped"]),
            ("integrator", self.integrator, list(BETA)),
        ):
            if value not in known:
                raise UsageError(f"finite elements: the {what} is one of {', '.join(map(str, known))}, not {value!r}")

    @property
    def name(self) -> str:
        return f"fem-p{self.degree}-{self.mass}-{'newmark' if self.integrator == 'newmark' else 'cd'}"

    @property
    def space_orders(self) -> Mapping[str, float]:
        """Order in h of the L2 error of each quantity where the time error is negligible."""
        return {"displacement": self.degree + 1, "velocity": self.degree + 1, "stress": self.degree}

    @property
    def orders(self) -> Mapping[str, float]:
        """Order in h with dt proportional to h: at most 2, the order of both integrators."""
        return {quantity: min(order, 2) for quantity, order in self.space_orders.items()}

    @property
    def coarse_orders(self) -> Mapping[str, float]:
        """Order in h until the error of the time step shows: that in space."""
        return self.space_orders

    @property
    def conserves(self) -> frozenset[str]:
        return frozenset({"mass", "momentum"})

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve for a bar with free, loaded, fixed or driven ends; the sample points are the quadrature points.

        Raises
        ------
        UsageError
            If the problem is not such a bar, or prescribes an initial stress without the initial displacement that causes it.
        """
        law, beta = problem.material, BETA[self.integrator]
        require(problem.dimension == 1, self.name, problem, "one dimension")
        material = not isinstance(problem.body_force, Spatial)
        require(material, self.name, problem, "a body force in material coordinates")
        require(problem.shape is None, self.name, problem, "a bar from end to end of its box")
        require(type(law) in (LinearElastic, NeoHookean), self.name, problem, "a linear elastic or neo-Hookean bar")
        assert isinstance(law, LinearElastic)
        linear = type(law) is LinearElastic
        require(linear or beta == 0, self.name, problem, "a linear elastic bar (central differences take any law)")
        taken = all(isinstance(condition, Traction | Velocity) for condition in problem.boundary.values())
        require(taken, self.name, problem, "a free, loaded, fixed or driven end")
        (elements,), (steps, dt) = discretisation.cells(problem), discretisation.time_steps(problem)
        element, order = ELEMENTS[self.degree]
        basis = Basis(MeshLine(np.linspace(problem.lower[0], problem.upper[0], elements + 1)), element, intorder=order)
        points = np.asarray(basis.global_coordinates())[0].reshape(-1, 1)
        taken = "displacement" in problem.initial or not problem.initial_field("stress", points).any()
        require(taken, self.name, problem, "an initial stress only together with the displacement that causes it")

        along = np.argsort(basis.doflocs[0])
        nodes, dofs = basis.doflocs[0, along].reshape(-1, 1), np.argsort(along)[basis.element_dofs].T
        n, (E, Q) = len(nodes), basis.dx.shape
        gradient = np.stack([phi.grad[0] for (phi,) in basis.basis], axis=-1)
        mesh = Mesh(np.ascontiguousarray(dofs, np.int64), np.ascontiguousarray(gradient), np.ascontiguousarray(basis.dx))
        shape = np.stack([np.broadcast_to(np.asarray(phi), (E, Q)) for (phi,) in basis.basis], axis=-1).ravel()
        values = csr_array((shape, np.repeat(dofs, Q, axis=0).ravel(), np.arange(0, shape.size + 1, dofs.shape[1])), (E * Q, n))
        weight = basis.dx.ravel()

        mass, stiffness = (csr_array(form.assemble(basis))[along][:, along] for form in (unit_mass, laplace))
        mass = law.density * (mass if self.mass == "consistent" else diags_array(mass.sum(axis=1)))
        t, outputs = problem.end_time * np.arange(steps + 1) / steps, output_steps(steps, problem.outputs)
        ends, end_velocity, sent = end_conditions(problem, law, t, dt)
        start = factorised(mass, mass, ends.held)
        lame, shear = law.lame_lambda, law.shear_modulus
        bands = factorised(mass, mass + beta * dt**2 * (lame + 2 * shear) * stiffness, ends.held) if beta else start
        u, v = (problem.initial_field(quantity, nodes).ravel() for quantity in ("displacement", "velocity"))
        v[[0, -1]] = np.where(ends.held, end_velocity, v[[0, -1]])
        amplitude = EPSILON * law.wave_speed * float(np.abs(u).max()) / discretisation.h
        state = State(u.copy(), v.copy(), np.zeros(n), np.zeros(n))
        row = np.full(steps + 1, -1)
        row[outputs] = np.arange(len(outputs))
        reached, moving, stress = np.empty((len(outputs), n)), np.empty((len(outputs), n)), np.empty((len(outputs), E, Q))
        record = Record(np.zeros((len(HISTORIES), steps + 1)), row, reached, moving, stress)

        def loads(first: int, last: int) -> tuple[Array, float]:
            """Nodal loads (last - first, n) [Pa] of a range of steps, and the largest velocity that they can cause [m/s]."""
            if problem.body_force is None:
                return np.zeros((1, n)), 0.0
            assert not isinstance(problem.body_force, Spatial)
            b = problem.body_force(points, t[first:last])[:, :, 0]
            return np.ascontiguousarray(b * (law.density * weight) @ values), dt * float(np.abs(b).max(axis=1).sum())

        bar = (Law(lame, shear, linear), mesh, ends, state, record)
        types = tuple(map(numba.typeof, (0, 1, dt, beta, math.inf, start, np.zeros((1, n)), *bar)))
        advance.compile(types)
        march = advance.get_overload(types)  # does not find out the types at each call
        began = time.perf_counter()
        made, code = march(0, 1, 0.0, beta, math.inf, start, loads(0, 1)[0], *bar)
        # Bound on the velocity: from the initial energy, from round-off (a pure translation too has strains by round-off), and
        # from the waves that the ends send, which add up at every reflection.
        inertia, reflections = law.density * problem.lengths[0], 1 + law.wave_speed * problem.end_time / problem.lengths[0]
        amplitude += math.sqrt(2 * record.histories[2:4, 0].sum() / inertia) + 2 * sent * reflections
        block = max(1, BLOCK // len(points)) if problem.body_force else steps
        while code == STABLE and made <= steps:
            last = min(made + block, steps + 1)
            body, gained = loads(made, last)
            amplitude += gained
            limit = GROWTH * inertia * amplitude * amplitude / 2
            made, code = march(made, last, dt, beta, limit, bands, body, *bar)
        seconds = time.perf_counter() - began

        detail = f"at step {made} of {steps}" + (": an element turned inside out (F <= 0)" if code == INVERTED else "")
        status = {STABLE: Status.COMPLETED, GREW: Status.UNSTABLE}.get(code, Status.NON_FINITE)
        kept = outputs[outputs < made]
        displacement, velocity = ((values @ field[: len(kept)].T).T[:, :, None] for field in (reached, moving))
        stress = stress[: len(kept)].reshape(len(kept), E * Q, 1)
        histories = dict(zip(HISTORIES, record.histories[:, :made], strict=True))
        return Solution(
            time=t[kept],
            dt=dt,
            reference=points,
            position=points + displacement,
            weight=np.tile(weight, (len(kept), 1)),
            fields={"displacement": displacement, "velocity": velocity, "stress": stress},
            histories={"time": t[:made], "mass": np.full(made, mass.sum()), **histories},
            work=Work(max(made - 1, 0), max(made - 1, 0) * E, seconds),
            outcome=Outcome() if code == STABLE else Outcome(status, detail),
        )
