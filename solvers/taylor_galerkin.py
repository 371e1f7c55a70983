"""Two-step Taylor-Galerkin on linear elements, for any linear hyperbolic system in one dimension."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

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
    Traction,
    Transport,
    Velocity,
    output_steps,
    require,
)
from mpmverify.solution import Outcome, Solution, Status, Work

GENEROUS = 10.0
"""How far above the exact solution's bound the amplitude may go in a stable run; Gibbs overshoots stay below 2."""
BLOCK = 2**18
"""Most values of the body force held at once."""

compiled = numba.njit(cache=True, fastmath={"contract"})


@compiled
def dot(A_k: Array, x: Array) -> float:
    """Component k of A x from row k of A, both (m,)."""
    total = 0.0
    for column in range(x.size):
        total += A_k[column] * x[column]
    return total


@compiled
def half_step(U_k: float, A_k: Array, slope: Array, S_k: float, dt: float) -> float:
    """Component k of the predictor, U* = U - dt/2 (A U_x - S)."""
    return U_k - 0.5 * dt * (dot(A_k, slope) - S_k)


@compiled
def march(
    U: Array,
    form: tuple[Array, ...],
    faces: tuple[Array, ...],
    source: Array,
    passes: int,
    mass: Array,
    h: float,
    dt: float,
    first: int,
    count: int,
    limit: Array,
    row: NDArray[np.int64],
    fields: Array,
    history: tuple[Array, ...],
) -> tuple[int, float]:
    r"""Advance a block of steps in place, until one of them exceeds its limit.

    Parameters
    ----------
    U : (nodes, m) nodal unknowns; one node per element when periodic, one more otherwise.
    form : A (m, m), load (m,), weight (m,) of U_t + A U_x = load b and of the amplitude sum_k weight_k |U_k|.
    faces : keep (2, m, m), push (2, m), datum (2, 2 N + 1); U at a face becomes keep U + push datum, with the datum given
        at every half step.
    source : (2 count, elements) b at the Gauss points, at t^n and t^{n+1/2} of every step.
    passes : mass-matrix passes.
    mass : (nodes,) lumped mass matrix M_L [m].
    h, dt : element size [m] and time step [s].
    first, count : steps made before this block, and in it.
    limit : (N + 1,) the largest amplitude that a node may have after a step.
    row, fields : (N + 1,), (T, elements, m); where the Gauss-point values after a step are recorded, -1 for nowhere.
    history : total, square, gain (N + 1, m), work (N + 1,), ends (N + 1, 2, m); sum_i M_L,i U_i, sum_i M_L,i U_i^2,
        what faces and source added to the total, the sum of dt h load b . U*, and the states at the faces.

    Returns
    -------
    tuple of int and float
        Steps made within their limits, and the amplitude that exceeded its limit or 0.

    Notes
    -----
    .. math::

        U^* &= U^n - \tfrac{\Delta t}{2} (A U_x - S) \quad\text{at the Gauss points}\\
        M\,\Delta U &= \Delta t \left[\int N_x F^* + \int N S^* - \oint N F^* n\right] = R, \quad F = A U\\
        \Delta U_j &= \Delta U_{j-1} + M_L^{-1} (R - M\,\Delta U_{j-1}), \quad \Delta U_0 = 0
    """
    A, load, weight = form
    keep, push, datum = faces
    total, square, gain, work, ends = history
    nodes, m = U.shape
    elements = source.shape[1]
    bounded = nodes > elements
    R, dU, MdU = np.empty_like(U), np.empty_like(U), np.empty_like(U)
    slope, star, trace = np.empty(m), np.empty(m), np.empty(m)
    for n in range(first, first + count):
        b, b_half = source[2 * (n - first)], source[2 * (n - first) + 1]
        R[:] = 0.0
        gain[n + 1], work[n + 1] = gain[n], work[n]
        for e in range(elements):
            i, j = e, (e + 1) % nodes
            for k in range(m):
                slope[k] = (U[j, k] - U[i, k]) / h
            for k in range(m):
                star[k] = half_step(0.5 * (U[i, k] + U[j, k]), A[k], slope, load[k] * b[e], dt)
            for k in range(m):
                flux = dot(A[k], star)
                S = load[k] * b_half[e]
                R[i, k] += dt * (-flux + 0.5 * h * S)
                R[j, k] += dt * (flux + 0.5 * h * S)
                gain[n + 1, k] += dt * h * S
                work[n + 1] += dt * h * S * star[k]
        if bounded:
            for face in range(2):
                i, e, normal = (nodes - 1, elements - 1, 1.0) if face else (0, 0, -1.0)
                for k in range(m):
                    slope[k] = (U[e + 1, k] - U[e, k]) / h
                for k in range(m):
                    star[k] = half_step(U[i, k], A[k], slope, load[k] * b[e], dt)
                for k in range(m):
                    trace[k] = dot(keep[face, k], star) + push[face, k] * datum[face, 2 * n + 1]
                for k in range(m):
                    contour = normal * dot(A[k], trace)
                    R[i, k] -= dt * contour
                    gain[n + 1, k] -= dt * contour
        dU[:] = 0.0
        MdU[:] = 0.0
        for sweep in range(passes):
            for i in range(nodes):
                for k in range(m):
                    dU[i, k] += (R[i, k] - MdU[i, k]) / mass[i]
            if bounded:  # in every pass: imposed after the last one only, a consistent mass would amplify reflected waves
                for face in range(2):
                    i = nodes - 1 if face else 0
                    for k in range(m):
                        star[k] = U[i, k] + dU[i, k]
                    for k in range(m):
                        trace[k] = dot(keep[face, k], star) + push[face, k] * datum[face, 2 * n + 2]
                        ends[n + 1, face, k] = trace[k]
                        dU[i, k] = trace[k] - U[i, k]
                        if sweep == passes - 1:
                            gain[n + 1, k] += mass[i] * (trace[k] - star[k])
            if sweep < passes - 1:
                MdU[:] = 0.0
                for e in range(elements):
                    i, j = e, (e + 1) % nodes
                    for k in range(m):
                        MdU[i, k] += h / 6 * (2 * dU[i, k] + dU[j, k])
                        MdU[j, k] += h / 6 * (dU[i, k] + 2 * dU[j, k])
        U += dU
        for i in range(nodes):
            amplitude = 0.0
            for k in range(m):
                amplitude += weight[k] * abs(U[i, k])
            if not amplitude <= limit[n + 1]:
                return n, amplitude
            for k in range(m):
                total[n + 1, k] += mass[i] * U[i, k]
                square[n + 1, k] += mass[i] * U[i, k] ** 2
        if row[n + 1] >= 0:
            for e in range(elements):
                for k in range(m):
                    fields[row[n + 1], e, k] = 0.5 * (U[e, k] + U[(e + 1) % nodes, k])
    return first + count, 0.0


def first_order_form(problem: Problem, solver: str) -> tuple[tuple[str, ...], tuple[Array, Array, Array]]:
    """Unknowns U, and (A, load, weight) of U_t + A U_x = load b; weight . |U| is the largest characteristic variable."""
    require(problem.dimension == 1, solver, problem, "problems in one dimension")
    material = problem.material
    if isinstance(material, Transport):
        require(material.velocity != 0, solver, problem, "a transport velocity other than zero")
        require(problem.body_force is None, solver, problem, "transport without a body force")
        return ("u",), (np.array([[material.velocity]]), np.zeros(1), np.ones(1))
    require(type(material) is LinearElastic, solver, problem, "transport, or linear elasticity at small strain")
    silent = "displacement" in problem.initial and "stress" not in problem.initial
    require(not silent, solver, problem, "an initial displacement only with its initial stress beside it")
    rho, c = material.density, material.wave_speed
    A = np.array([[0.0, -(material.lame_lambda + 2 * material.shear_modulus)], [-1 / rho, 0.0]])
    return ("stress", "velocity"), (A, np.array([0.0, 1.0]), np.array([1.0, rho * c]))


def closure(problem: Problem, solver: str, half_times: Array) -> tuple[bool, tuple[Array, Array, Array]]:
    """Whether the faces bound the body, and their (keep, push, datum) for U = keep U + push datum.

    A prescribed traction or velocity replaces its own unknown and leaves the other one: the odd and even mirror of a body
    that goes on beyond its ends, hence as stable and as accurate as the interior. Keeping the outgoing characteristic
    instead amplifies waves at a reflecting end when the mass is consistent. Where nothing comes back, with Z = rho c and the
    normal n, sigma - n Z v is kept and the incoming sigma + n Z v is zero.
    """
    conditions = [problem.boundary["x-"], problem.boundary["x+"]]
    joined = [isinstance(condition, Periodic) for condition in conditions]
    require(all(joined) or not any(joined), solver, problem, "Periodic on both faces or on neither")
    keep, push, datum = [], [], np.zeros((2, half_times.size))
    for face, (normal, condition) in enumerate(zip((-1, 1), conditions, strict=True)):
        if isinstance(condition, Traction | Velocity | Inflow):
            datum[face] = condition.value(half_times)
        if isinstance(problem.material, Transport):
            enters = normal * problem.material.velocity < 0
            fits = isinstance(condition, Periodic | (Inflow if enters else Outflow))
            require(fits, solver, problem, "Inflow where the velocity points inwards, Outflow where not, or Periodic")
            keep.append([[float(not enters)]])
            push.append([float(enters)])
            continue
        fits = isinstance(condition, Traction | Velocity | Absorbing | Periodic)
        require(fits, solver, problem, "Traction, Velocity, Absorbing or Periodic at the ends of a bar")
        nZ = normal * problem.material.density * problem.material.wave_speed
        match condition:
            case Traction():
                keep.append([[0.0, 0.0], [0.0, 1.0]])
                push.append([1.0, 0.0])
            case Velocity():
                keep.append([[1.0, 0.0], [0.0, 0.0]])
                push.append([0.0, 1.0])
            case _:
                keep.append([[0.5, -0.5 * nZ], [-0.5 / nZ, 0.5]])
                push.append([0.0, 0.0])
    return not all(joined), (np.array(keep), np.array(push), datum)


def per_area(problem: Problem, instants: Array, A: Array, history: tuple[Array, ...]) -> dict[str, Array]:
    """Histories (N + 1,) in the bench's names, per unit cross-section."""
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
    r"""Two-step Taylor-Galerkin: predictor at the Gauss points for t^{n+1/2}, corrector at the nodes.

    Parameters
    ----------
    passes : int
        Mass-matrix passes k: 1 is the lumped mass, stable to nu_C = 1; 3 is customary for the consistent mass, stable to
        nu_C = 1/sqrt(3), as every number above 1 is.

    Notes
    -----
    On a uniform mesh every step multiplies a Fourier mode of phase theta per element by

    .. math:: G = 1 - [i \nu_C \sin\theta + \nu_C^2 (1 - \cos\theta)]\,[1 - (1 - m)^k] / m, \quad m = 1 - (1 - \cos\theta)/3

    where k = 1 leaves G without m. At nu_C = 1 the lumped scheme translates exactly, through reflections too.

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
        """Solve; the sample points are the Gauss points, one in the middle of every element."""
        quantities, form = first_order_form(problem, self.name)
        (elements,) = discretisation.cells(problem)
        steps, dt = discretisation.time_steps(problem)
        half_times = problem.end_time * np.arange(2 * steps + 1) / (2 * steps)
        instants = half_times[::2].copy()
        bounded, faces = closure(problem, self.name, half_times)
        h = problem.lengths[0] / elements
        nodes = problem.lower[0] + h * np.arange(elements + bounded, dtype=float)[:, None]
        middles = problem.lower[0] + h * (np.arange(elements, dtype=float)[:, None] + 0.5)
        mass = np.full(len(nodes), h)
        U = np.concatenate([problem.initial_field(quantity, nodes) for quantity in quantities], axis=1)
        keep, push, datum = faces
        if bounded and isinstance(problem.material, LinearElastic):
            # A jump at t = 0 is the odd mirror's: its node takes the datum, and the front starts where it should.
            for face in (0, -1):
                U[face] = keep[face] @ U[face] + push[face] * datum[face, 0]

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

        # By d'Alembert a characteristic variable gains at most the datum at every face, and the source on its way.
        _, load, weight = form
        kick = 2 * np.max(np.abs(push) @ weight * np.max(np.abs(datum), axis=1))
        bound = np.max(np.abs(U) @ weight) + kick * (1 + problem.material.wave_speed * instants / problem.lengths[0])
        block = max(1, min(steps, BLOCK // (2 * elements)))
        source = np.zeros((2 * block, elements))
        made, failed, seconds, strongest = 0, False, 0.0, 0.0
        while made < steps and not failed:
            end = min(made + block, steps)
            if problem.body_force is not None:
                times = half_times[2 * made : 2 * end]
                source[: times.size] = np.reshape(problem.body_force(middles, times), (times.size, elements))
                strongest = max(strongest, float(np.max(np.abs(source))))
            limit = GENEROUS * (bound + weight @ load * strongest * instants)
            history = total, square, gain, work, ends
            arguments = (U, form, faces, source, self.passes, mass, h, dt, made, end - made, limit, row, fields, history)
            march.compile(numba.typeof(arguments).types)
            start = time.perf_counter()
            made, amplitude = march(*arguments)
            seconds += time.perf_counter() - start
            failed = made < end

        outcome = Outcome()
        if failed:
            finite = np.isfinite(amplitude + limit[made + 1])
            outcome = Outcome(Status.UNSTABLE if finite else Status.NON_FINITE, f"at step {made + 1} of {steps}")
        kept = int(np.searchsorted(outputs, made, side="right"))
        histories = per_area(problem, instants, form[0], (total, square, gain, work, ends))
        return Solution(
            time=instants[outputs[:kept]],
            dt=dt,
            reference=middles,
            position=np.repeat(middles[None], kept, axis=0),
            weight=np.full((kept, elements), h),
            fields={quantity: fields[:kept, :, k : k + 1] for k, quantity in enumerate(quantities)},
            histories={name: values[: made + 1] for name, values in histories.items()},
            work=Work(made, made * elements, seconds),
            outcome=outcome,
        )
