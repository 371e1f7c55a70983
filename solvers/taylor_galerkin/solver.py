"""Two-step Taylor-Galerkin on linear elements, for any linear hyperbolic system in one dimension."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numba
import numpy as np

from mpmverify.errors import UsageError
from mpmverify.problem import (
    Absorbing,
    Array,
    Discretisation,
    Inflow,
    LinearElastic,
    Outflow,
    Periodic,
    Problem,
    Spatial,
    Traction,
    Transport,
    Velocity,
    output_steps,
    require,
)
from mpmverify.solution import Outcome, Solution, Status, Work

from .kernel import march

MARGIN = 10.0
"""A run is unstable when its amplitude exceeds the bound of the exact solution times this; Gibbs overshoots stay below 2."""
BLOCK = 2**14
"""Largest number of body-force values that are stored at once, so that most runs have several blocks."""


def first_order_form(problem: Problem, solver: str) -> tuple[tuple[str, ...], tuple[Array, Array, Array]]:
    """Return the names of the unknowns U, and (A, load, weight) of the system U_t + A U_x = load b.

    The amplitude weight . |U| is the largest modulus that a characteristic variable can have.
    """
    require(problem.dimension == 1, solver, problem, "problems in one dimension")
    require(not isinstance(problem.body_force, Spatial), solver, problem, "a body force in material coordinates")
    require(problem.shape is None, solver, problem, "a body from end to end of its box")
    material = problem.material
    if isinstance(material, Transport):
        require(material.velocity != 0, solver, problem, "a transport velocity other than zero")
        require(problem.body_force is None, solver, problem, "transport without a body force")
        return ("u",), (np.array([[material.velocity]]), np.zeros(1), np.ones(1))
    require(type(material) is LinearElastic, solver, problem, "transport, or linear elasticity at small strain")
    stressed = "displacement" not in problem.initial or "stress" in problem.initial
    require(stressed, solver, problem, "an initial displacement only together with its initial stress")
    rho, c = material.density, material.wave_speed
    A = np.array([[0.0, -(material.lame_lambda + 2 * material.shear_modulus)], [-1 / rho, 0.0]])
    return ("stress", "velocity"), (A, np.array([0.0, 1.0]), np.array([1.0, rho * c]))


def boundary_terms(problem: Problem, solver: str, half_times: Array) -> tuple[bool, tuple[Array, ...]]:
    """Return whether the mesh has faces (is not periodic), and their (prescribed, incoming, correction, datum); see `march`.

    The contour flux is split into characteristics. With Z = rho c and the outward normal n, the outgoing variable sigma - n Z v
    is kept. The incoming part, along (n Z, 1), is set so that the traction or the velocity takes its prescribed value; at an
    absorbing face it is zero. With the lumped mass the flux alone imposes the condition, so that a free bar gains the impulse
    of its load to round-off. With the consistent mass every pass after the first resets the prescribed unknown: without this
    correction, or with a correction along the characteristic, these passes amplify reflected waves.
    """
    conditions = [problem.boundary["x-"], problem.boundary["x+"]]
    joined = [isinstance(condition, Periodic) for condition in conditions]
    require(all(joined) or not any(joined), solver, problem, "Periodic on both faces or on neither")
    rows: list[list[list[float]]] = []
    datum = np.zeros((2, half_times.size))
    for face, (normal, condition) in enumerate(zip((-1, 1), conditions, strict=True)):
        if isinstance(condition, Traction | Velocity | Inflow):
            datum[face] = condition.value(half_times)
        if isinstance(problem.material, Transport):
            inwards = normal * problem.material.velocity < 0
            supported = isinstance(condition, Periodic | (Inflow if inwards else Outflow))
            require(supported, solver, problem, "Inflow where the velocity points inwards, Outflow where not, or Periodic")
            rows.append([[float(inwards)]] * 3)
            continue
        supported = isinstance(condition, Traction | Velocity | Absorbing | Periodic)
        require(supported, solver, problem, "Traction, Velocity, Absorbing or Periodic at the ends of a bar")
        nZ = normal * problem.material.density * problem.material.wave_speed
        match condition:
            case Traction():
                rows.append([[1.0, 0.0], [1.0, 1 / nZ], [1.0, 0.0]])
            case Velocity():
                rows.append([[0.0, 1.0], [nZ, 1.0], [0.0, 1.0]])
            case _:
                rows.append([[1.0, nZ], [0.5, 0.5 / nZ], [0.5, 0.5 / nZ]])
    prescribed, incoming, correction = np.array(rows).swapaxes(0, 1).copy()
    return not all(joined), (prescribed, incoming, correction, datum)


def named_histories(problem: Problem, instants: Array, A: Array, history: tuple[Array, ...]) -> dict[str, Array]:
    """Histories (N + 1,) under their names in `Solution`, per unit cross-section."""
    total, square, gain, work, ends = history
    if isinstance(problem.material, Transport):
        return {"time": instants, "mass": total[:, 0], "inflow": gain[:, 0]}
    rho, modulus = problem.material.density, -A[0, 1]
    power = ends[:, 1].prod(axis=1) - ends[:, 0].prod(axis=1)
    by_faces = np.cumsum(0.5 * np.diff(instants, prepend=0.0) * (power + np.roll(power, 1)))
    return {
        "time": instants,
        "mass": np.full(instants.size, rho * problem.lengths[0]),
        "momentum": rho * total[:, 1],
        "impulse": rho * gain[:, 1],
        "kinetic_energy": 0.5 * rho * square[:, 1],
        "strain_energy": 0.5 * square[:, 0] / modulus,
        "external_work": by_faces + rho * work,
    }


@dataclass(frozen=True)
class TaylorGalerkin:
    r"""Two-step Taylor-Galerkin: a predictor at the Gauss points at t^{n+1/2}, then a corrector at the nodes.

    Parameters
    ----------
    passes : int
        Number k of mass-matrix passes. One pass uses the lumped mass and is stable up to the Courant number nu_C = 1. Two or
        more passes approach the consistent mass and are stable up to nu_C = 1/sqrt(3); three are customary.

    Raises
    ------
    UsageError
        If `passes` is less than 1.

    Notes
    -----
    On a uniform mesh each step multiplies a Fourier mode of phase theta per element by

    .. math:: G = 1 - [i \nu_C \sin\theta + \nu_C^2 (1 - \cos\theta)]\,[1 - (1 - m)^k] / m, \quad m = 1 - (1 - \cos\theta)/3

    where the factor [1 - (1 - m)^k] / m is 1 for k = 1. At nu_C = 1 the lumped scheme translates waves exactly, including
    their reflections at the ends.

    References
    ----------
    - Donea, J. (1984). A Taylor-Galerkin method for convective transport problems. Int. J. Numer. Meth. Engng 20.
    - Lohner, R., Morgan, K. and Zienkiewicz, O. C. (1984). The solution of non-linear hyperbolic equation systems by the
      finite element method. Int. J. Numer. Meth. Fluids 4.
    - Peraire, J. (1986). A finite element method for convection dominated flows. PhD thesis, University of Wales, Swansea.
    - Mabssout, M. and Pastor, M. (2003). A Taylor-Galerkin algorithm for shock wave propagation and strain localization
      failure of viscoplastic continua. Comput. Methods Appl. Mech. Engrg 192.
    """

    passes: int = 1

    def __post_init__(self) -> None:
        if self.passes < 1:
            raise UsageError(f"Taylor-Galerkin needs at least one mass-matrix pass, not {self.passes!r}")

    @property
    def name(self) -> str:
        return "tg-lumped" if self.passes == 1 else f"tg-consistent-{self.passes}"

    @property
    def orders(self) -> Mapping[str, float]:
        return {"u": 2, "stress": 2, "velocity": 2}

    @property
    def conserves(self) -> frozenset[str]:
        return frozenset({"momentum"})

    def solve(self, problem: Problem, discretisation: Discretisation) -> Solution:
        """Solve a problem; the sample points are the Gauss points, one at the centre of each element.

        Raises
        ------
        UsageError
            If the scheme cannot solve the problem: it takes transport, or linear elasticity at small strain, in one dimension.
        """
        quantities, form = first_order_form(problem, self.name)
        (elements,) = discretisation.cells(problem)
        steps, dt = discretisation.time_steps(problem)
        half_times = problem.end_time * np.arange(2 * steps + 1) / (2 * steps)
        instants = half_times[::2].copy()
        bounded, faces = boundary_terms(problem, self.name, half_times)
        h = problem.lengths[0] / elements
        nodes = problem.lower[0] + h * np.arange(elements + bounded, dtype=float)[:, None]
        centres = problem.lower[0] + h * (np.arange(elements, dtype=float)[:, None] + 0.5)
        mass = np.full(len(nodes), h)
        U = np.concatenate([problem.initial_field(quantity, nodes) for quantity in quantities], axis=1)
        prescribed, incoming, correction, datum = faces
        if bounded and isinstance(problem.material, LinearElastic):
            # Where initial state and boundary datum differ, the end node takes the datum: the front then starts at the face.
            for face in (0, -1):
                U[face] += correction[face] * (datum[face, 0] - prescribed[face] @ U[face])

        m = len(quantities)
        outputs = output_steps(steps, problem.outputs)
        row = np.full(steps + 1, -1)
        row[outputs] = np.arange(len(outputs))
        fields, total, square, gain = np.zeros((len(outputs), elements, m)), *np.zeros((3, steps + 1, m))
        work, ends = np.zeros(steps + 1), np.zeros((steps + 1, 2, m))
        if bounded:
            mass[[0, -1]] = 0.5 * h
            ends[0] = U[[0, -1]]
        fields[0] = 0.5 * (U[:elements] + np.roll(U, -1, axis=0)[:elements])
        total[0], square[0] = mass @ U, mass @ U**2

        # By d'Alembert's solution a characteristic variable grows by at most the datum at each reflection, and by the source.
        _, load, weight = form
        reflected = 2 * np.max(np.abs(incoming) @ weight * np.max(np.abs(datum), axis=1))
        bound = np.max(np.abs(U) @ weight) + reflected * (1 + problem.material.wave_speed * instants / problem.lengths[0])
        block = max(1, min(steps, BLOCK // (2 * elements)))
        source = np.zeros((2 * block, elements))
        made, failed, seconds, largest_source = 0, False, 0.0, 0.0
        history = total, square, gain, work, ends
        fixed = U, form, faces, source, self.passes, mass, h, dt
        types = tuple(map(numba.typeof, (*fixed, 0, 0, bound * instants, row, fields, history)))
        march.compile(types)
        advance = march.get_overload(types)  # does not find out the types at each call
        while made < steps and not failed:
            end = min(made + block, steps)
            if problem.body_force is not None:
                assert not isinstance(problem.body_force, Spatial)
                times = half_times[2 * made : 2 * end]
                source[: times.size] = np.reshape(problem.body_force(centres, times), (times.size, elements))
                largest_source = max(largest_source, float(np.max(np.abs(source))))
            limit = MARGIN * (bound + weight @ load * largest_source * instants)
            start = time.perf_counter()
            made, amplitude = advance(*fixed, made, end - made, limit, row, fields, history)
            seconds += time.perf_counter() - start
            failed = made < end

        outcome = Outcome()
        if failed:
            finite = np.isfinite(amplitude + limit[made + 1])
            outcome = Outcome(Status.UNSTABLE if finite else Status.NON_FINITE, f"at step {made + 1} of {steps}")
        kept = int(np.searchsorted(outputs, made, side="right"))
        histories = named_histories(problem, instants, form[0], (total, square, gain, work, ends))
        return Solution(
            time=instants[outputs[:kept]],
            dt=dt,
            reference=centres,
            position=np.repeat(centres[None], kept, axis=0),
            weight=np.full((kept, elements), h),
            fields={quantity: fields[:kept, :, k : k + 1] for k, quantity in enumerate(quantities)},
            histories={name: values[: made + 1] for name, values in histories.items()},
            work=Work(made, made * elements, seconds),
            outcome=outcome,
        )
