"""The compiled time loop of the finite element method on a bar, and the records that it works on."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mpmverify.problem import Array

GROWTH = 1e6
"""A run is unstable above 1e6 times the energy, 1000 times the amplitude, that data and loads can supply."""
EPSILON = float(np.finfo(float).eps)
STABLE, GREW, OVERFLOWED, INVERTED = range(4)


class Law(NamedTuple):
    """Lame's constants [Pa], and whether the law is the linear or the neo-Hookean one."""

    lame: float
    shear: float
    linear: bool


class Mesh(NamedTuple):
    """E elements of k degrees of freedom with Q quadrature points; the n degrees of freedom are numbered along the bar."""

    dofs: NDArray[np.int64]  # (E, k)
    gradient: Array  # (E, Q, k) [1/m]
    weight: Array  # (E, Q) [m]


class State(NamedTuple):
    """Nodal values at one instant, (n,) each; the force is external: loads and reactions, per unit cross-section."""

    displacement: Array
    velocity: Array
    acceleration: Array
    force: Array


class Bands(NamedTuple):
    """Lower bands, bands[d, j] = A[j + d, j], of M, of A = M + beta dt^2 K and of A's Cholesky factor [kg/m^2]."""

    mass: Array
    operator: Array
    factor: Array


class Ends(NamedTuple):
    """Either end of the bar: whether its motion is prescribed (2,), load [Pa] and acceleration [m/s^2] (N + 1, 2)."""

    held: NDArray[np.bool_]
    load: Array
    acceleration: Array


class Record(NamedTuple):
    """Histories (5, N + 1), output row of each step or -1 (N + 1,), nodal values (T, n) and stress (T, E, Q) at the outputs."""

    histories: Array
    row: NDArray[np.int64]
    displacement: Array
    velocity: Array
    stress: Array


HISTORIES = ("momentum", "impulse", "kinetic_energy", "strain_energy", "external_work")
"""Rows of `Record.histories`."""


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def response(e: float, law: Law) -> tuple[float, float]:
    """First Piola-Kirchhoff stress P [Pa] and energy density [J/m^3] at the displacement gradient e = F - 1.

    Linear: (lambda + 2 mu) e. Neo-Hookean: lambda ln(F)/F + mu (F - 1/F), with F - 1/F = e (2 + e)/F free of cancellation.
    """
    lame, shear, linear = law
    if linear:
        return (lame + 2 * shear) * e, (lame + 2 * shear) * e * e / 2
    F, ln_F = 1 + e, math.log1p(e)
    return lame * ln_F / F + shear * e * (2 + e) / F, lame * ln_F * ln_F / 2 + shear * (e * (2 + e) / 2 - ln_F)


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def internal_force(u: Array, mesh: Mesh, law: Law, stress: Array, force: Array) -> tuple[float, float]:
    """Set P (E, Q) and B^T (w P(1 + B u)) (n,) [Pa]; return the strain energy [J/m^2] and the least F."""
    energy, least = 0.0, math.inf
    for i in range(len(force)):
        force[i] = 0.0
    for i in range(mesh.weight.shape[0]):
        for q in range(mesh.weight.shape[1]):
            e = 0.0
            for k in range(mesh.dofs.shape[1]):
                e += mesh.gradient[i, q, k] * u[mesh.dofs[i, k]]
            stress[i, q], density = response(e, law)
            energy += mesh.weight[i, q] * density
            least = min(least, 1 + e)
            for k in range(mesh.dofs.shape[1]):
                force[mesh.dofs[i, k]] += mesh.weight[i, q] * mesh.gradient[i, q, k] * stress[i, q]
    return energy, least


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def multiply(bands: Array, x: Array, y: Array) -> None:
    """Set y = A x for the symmetric A with A[j + d, j] = bands[d, j]."""
    for j in range(len(x)):
        y[j] = bands[0, j] * x[j]
    for d in range(1, len(bands)):
        for j in range(len(x) - d):
            y[j + d] += bands[d, j] * x[j]
            y[j] += bands[d, j] * x[j + d]


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def substitute(factor: Array, x: Array) -> None:
    """Solve L L^T x = b in place for the banded Cholesky factor L[j + d, j] = factor[d, j]."""
    for j in range(len(x)):
        for d in range(1, min(len(factor), j + 1)):
            x[j] -= factor[d, j - d] * x[j - d]
        x[j] /= factor[0, j]
    for j in range(len(x) - 1, -1, -1):
        for d in range(1, min(len(factor), len(x) - j)):
            x[j] -= factor[d, j] * x[j + d]
        x[j] /= factor[0, j]


@njit(cache=True, fastmath={"contract"}, error_model="numpy")
def advance(
    first: int,
    last: int,
    dt: float,
    beta: float,
    limit: float,
    bands: Bands,
    body: Array,
    law: Law,
    mesh: Mesh,
    ends: Ends,
    state: State,
    record: Record,
) -> tuple[int, int]:
    """Make Newmark's steps `first` to `last` - 1 with gamma = 1/2.

    u~ = u + dt v + dt^2 (1/2 - beta) a,  v~ = v + dt/2 a,
    (M + beta dt^2 K) a = f - f_int(u~),  u = u~ + beta dt^2 a,  v = v~ + dt/2 a.

    A step of no length, with M for operator, finds the first acceleration. `limit` is the energy above which the run counts
    as unstable [J/m^2]; `body` the nodal loads (last - first, n), or (1, n) when constant [Pa]. Returns the step that failed
    and why, or `last` and STABLE.
    """
    u, v, a, force = state
    inner, product = np.empty_like(u), np.empty_like(u)
    stress, reached = np.empty_like(mesh.weight), np.empty_like(u)
    nodes = (0, len(u) - 1)
    for n in range(first, last):
        moved = dt * v + dt * dt * (0.5 - beta) * a
        u += moved
        v += dt / 2 * a
        strain, least = internal_force(u, mesh, law, stress, inner)
        for i in range(len(u)):
            reached[i] = body[(n - first) % len(body), i]
            a[i] = 0.0
        for end, node in enumerate(nodes):
            reached[node] += ends.load[n, end]
            a[node] = ends.acceleration[n, end]
        multiply(bands.operator, a, product)
        for i in range(len(u)):
            if not ((i == 0 and ends.held[0]) or (i == len(u) - 1 and ends.held[1])):
                a[i] = reached[i] - inner[i] - product[i]
        substitute(bands.factor, a)
        multiply(bands.operator, a, product)
        for end, node in enumerate(nodes):
            if ends.held[end]:
                reached[node] = product[node] + inner[node]
        moved += beta * dt * dt * a
        u += beta * dt * dt * a
        v += dt / 2 * a
        if beta > 0:
            strain, least = internal_force(u, mesh, law, stress, inner)
        multiply(bands.mass, v, product)
        momentum, kinetic, impulse, work = 0.0, 0.0, 0.0, 0.0
        for i in range(len(u)):
            momentum += product[i]
            kinetic += product[i] * v[i] / 2
            impulse += (force[i] + reached[i]) * dt / 2
            # Mean force times displacement, not mean power times dt: the average acceleration rule then closes to round-off.
            work += (force[i] + reached[i]) * moved[i] / 2
        if not law.linear and least <= 0:
            return n, INVERTED
        if not math.isfinite(kinetic + strain):
            return n, OVERFLOWED
        if kinetic + strain > limit:
            return n, GREW
        for i in range(len(u)):
            force[i] = reached[i]
        before, histories, row = max(n - 1, 0), record.histories, record.row[n]
        sums = momentum, histories[1, before] + impulse, kinetic, strain, histories[4, before] + work
        for k, value in enumerate(sums):
            histories[k, n] = value
        if row >= 0:
            for i in range(len(u)):
                record.displacement[row, i], record.velocity[row, i] = u[i], v[i]
            for i in range(stress.shape[0]):
                for q in range(stress.shape[1]):
                    record.stress[row, i, q] = stress[i, q]
    return last, STABLE
