"""Compiled time loop of two-step Taylor-Galerkin for a linear first-order system U_t + A U_x = S."""

import numba
import numpy as np
from numpy.typing import NDArray

from mpmverify.problem import Array

compiled = numba.njit(cache=True, fastmath={"contract"})


@compiled
def dot(A_k: Array, x: Array) -> float:
    """Dot product of row k of A (m,) with x (m,): component k of A x."""
    total = 0.0
    for column in range(x.size):
        total += A_k[column] * x[column]
    return total


@compiled
def half_step(U_k: float, A_k: Array, slope: Array, S_k: float, dt: float) -> float:
    """Component k of the predictor U* = U - dt/2 (A U_x - S); row A_k (m,) and slope U_x (m,)."""
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
    r"""Advance U in place by a block of steps; stop at a step whose amplitude exceeds its limit.

    Parameters
    ----------
    U : (nodes, m) nodal unknowns. A periodic mesh has as many nodes as elements, any other has one more.
    form : A (m, m), load (m,) and weight (m,) of the system U_t + A U_x = load b and of the amplitude sum_k weight_k |U_k|.
    faces : l (2, m), incoming (2, m), correction (2, m) and datum (2, 2 N + 1). Each face prescribes l . U = datum, with the
        datum given at every half step. The contour flux uses the state U* + incoming (datum - l . U*). Every pass after the
        first adds correction (datum - l . U) to U.
    source : (2 count, elements) b at the Gauss points, at t^n and t^{n+1/2} of every step.
    passes : mass-matrix passes.
    mass : (nodes,) lumped mass matrix M_L [m].
    h, dt : element size [m] and time step [s].
    first, count : number of steps before this block, and number of steps in it.
    limit : (N + 1,) largest amplitude allowed at any node after each step.
    row, fields : (N + 1,), (T, elements, m); row[n] is the row of `fields` that stores the Gauss-point values of step n, or -1.
    history : total, square, gain (N + 1, m), work (N + 1,), ends (N + 1, 2, m); sum_i M_L,i U_i, sum_i M_L,i U_i^2,
        the part of the total that faces and source added, the sum of dt h load b . U*, and the states at the two faces.

    Returns
    -------
    tuple of int and float
        Number of steps that stayed within their limits, and the amplitude that exceeded its limit, or 0.

    Notes
    -----
    .. math::

        U^* &= U^n - \tfrac{\Delta t}{2} (A U_x - S) \quad\text{at the Gauss points}\\
        M\,\Delta U &= \Delta t \left[\int N_x F^* + \int N S^* - \oint N F^* n\right] = R, \quad F = A U\\
        \Delta U_j &= \Delta U_{j-1} + M_L^{-1} (R - M\,\Delta U_{j-1}), \quad \Delta U_0 = 0
    """
    A, load, weight = form
    prescribed, incoming, correction, datum = faces
    total, square, gain, work, ends = history
    nodes, m = U.shape
    elements = source.shape[1]
    bounded = nodes > elements
    R, dU, MdU = np.empty_like(U), np.empty_like(U), np.empty_like(U)
    slope, star, trace = np.empty(m), np.empty(m), np.empty(m)
    for n in range(first, first + count):
        b, b_half = source[2 * (n - first)], source[2 * (n - first) + 1]
        for i in range(nodes):
            for k in range(m):
                R[i, k] = dU[i, k] = MdU[i, k] = 0.0
        for k in range(m):
            gain[n + 1, k] = gain[n, k]
        work[n + 1] = work[n]
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
                gap = datum[face, 2 * n + 1] - dot(prescribed[face], star)
                for k in range(m):
                    trace[k] = star[k] + incoming[face, k] * gap
                for k in range(m):
                    contour = normal * dot(A[k], trace)
                    R[i, k] -= dt * contour
                    gain[n + 1, k] -= dt * contour
        for sweep in range(passes):
            for i in range(nodes):
                for k in range(m):
                    dU[i, k] += (R[i, k] - MdU[i, k]) / mass[i]
            if bounded and sweep > 0:
                for face in range(2):
                    i = nodes - 1 if face else 0
                    for k in range(m):
                        star[k] = U[i, k] + dU[i, k]
                    gap = datum[face, 2 * n + 2] - dot(prescribed[face], star)
                    for k in range(m):
                        dU[i, k] += correction[face, k] * gap
                        if sweep == passes - 1:
                            gain[n + 1, k] += mass[i] * correction[face, k] * gap
            if sweep < passes - 1:
                for i in range(nodes):
                    for k in range(m):
                        MdU[i, k] = 0.0
                for e in range(elements):
                    i, j = e, (e + 1) % nodes
                    for k in range(m):
                        MdU[i, k] += h / 6 * (2 * dU[i, k] + dU[j, k])
                        MdU[j, k] += h / 6 * (dU[i, k] + 2 * dU[j, k])
        for i in range(nodes):
            for k in range(m):
                U[i, k] += dU[i, k]
        for k in range(m):
            ends[n + 1, 0, k], ends[n + 1, 1, k] = U[0, k], U[nodes - 1, k]
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
