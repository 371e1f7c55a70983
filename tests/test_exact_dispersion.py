"""Dispersion relations are the eigenvalues of one step, of which a matrix is made here by taking it, and tend to the wave equation."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from mpmverify.exact.dispersion import RELATIONS, linear_elements, phase_lag

LIGHT = settings(max_examples=20, deadline=None)
CELLS = 14
LIMIT = {
    "fem-p1-lumped-cd": 1.0,
    "fem-p1-consistent-cd": 1 / math.sqrt(3),
    "fem-p1-lumped-newmark": 5.0,
    "fem-p1-consistent-newmark": 5.0,
    "tg-lumped": 1.0,
    "tg-consistent-3": 1 / math.sqrt(3),
    "mpm-tl-linear-usf-flip": 1.0,
    "mpm-tl-linear-usl-flip": 0.7,
    "mpm-tl-linear-musl-flip": 1.0,
    "mpm-tl-quadratic-usf-flip": 1.0,
    "mpm-tl-quadratic-usl-flip": 0.7,
    "mpm-tl-quadratic-musl-flip": 1.0,
}
"""Courant numbers below which each scheme is stable; of material points at any number of particles per cell."""
every_scheme = pytest.mark.parametrize("scheme", RELATIONS)


def ring(*offsets):
    """Circulant matrix with entries at offsets from the diagonal."""
    return sum(value * np.roll(np.eye(CELLS), offset, axis=1) for offset, value in offsets)


def of_elements(scheme, nu):
    """One step (u, v, a) -> (u, v, a) of Newmark's rule on a ring, h = c = 1: M a = -K u at every level."""
    M = np.eye(CELLS) if "lumped" in scheme else ring((-1, 1 / 6), (0, 2 / 3), (1, 1 / 6))
    K = ring((-1, -1.0), (0, 2.0), (1, -1.0))
    beta, one, none = 0.25 if "newmark" in scheme else 0.0, np.eye(CELLS), np.zeros((CELLS, CELLS))
    predictor = np.block([[one, nu * one, nu**2 * (0.5 - beta) * one], [none, one, nu / 2 * one]])
    a = -np.linalg.solve(M + beta * nu**2 * K, K) @ predictor[:CELLS]
    return np.vstack([predictor + np.vstack([beta * nu**2 * a, nu / 2 * a]), a])


def of_taylor_galerkin(scheme, nu):
    """One step (sigma, v) -> (sigma, v) on a ring, h = rho = E = 1: predictor in the elements, corrector by mass passes."""
    mean, slope, none = ring((0, 0.5), (1, 0.5)), ring((0, -1.0), (1, 1.0)), np.zeros((CELLS, CELLS))
    half = np.block([[mean, nu / 2 * slope], [nu / 2 * slope, mean]])
    spread = np.block(
        [[none, nu * -slope.T], [nu * -slope.T, none]]
    )  # dt int grad N F*, F = (-v, -sigma), scattered to the nodes
    M = np.kron(np.eye(2), ring((-1, 1 / 6), (0, 2 / 3), (1, 1 / 6)))
    R, change = spread @ half, np.zeros((2 * CELLS, 2 * CELLS))
    for _ in range(3 if "consistent" in scheme else 1):
        change = change + R - M @ change
    return np.eye(2 * CELLS) + change


def of_particles(scheme, nu, ppc):
    """One step (v_p, sigma_p) -> (v_p, sigma_p) on a ring, h = rho = E = 1, column by column."""
    count = CELLS * ppc
    x = (np.arange(count) + 0.5) / ppc
    left = np.floor(x).astype(int)
    N, dN = np.zeros((count, CELLS)), np.zeros((count, CELLS))
    for p, i in enumerate(left):
        for node in range(i - 1, i + 3):
            if "linear" in scheme:
                spline, distance = BSpline.basis_element([-1, 0, 1], extrapolate=False), x[p] - node
            else:  # node k of a quadratic spline sits in the middle of cell k
                spline, distance = BSpline.basis_element([-1.5, -0.5, 0.5, 1.5], extrapolate=False), x[p] - node - 0.5
            N[p, node % CELLS] += np.nan_to_num(spline(distance))
            dN[p, node % CELLS] += np.nan_to_num(spline.derivative()(distance))
    m = V = 1 / ppc
    nodal_mass = m * N.sum(axis=0)

    def step(state):
        v, sigma = state[:count], state[count:]
        w = m * N.T @ v / nodal_mass
        if "usf" in scheme:
            sigma = sigma + nu * dN @ w
        a = -V * dN.T @ sigma / nodal_mass
        v, w = v + nu * N @ a, w + nu * a
        if "musl" in scheme:
            w = m * N.T @ v / nodal_mass
        return np.concatenate([v, sigma if "usf" in scheme else sigma + nu * dN @ w])

    return np.stack([step(column) for column in np.eye(2 * count)], axis=1)


def one_step(scheme, nu, ppc):
    if scheme.startswith("mpm"):
        return of_particles(scheme, nu, ppc)
    return of_taylor_galerkin(scheme, nu) if scheme.startswith("tg") else of_elements(scheme, nu)


@every_scheme
@LIGHT
@given(st.floats(0.05, 0.99), st.integers(1, 4))
def test_factors_are_the_oscillating_eigenvalues_of_a_step(scheme, share, ppc):
    """Of every mode of the ring but the constant and the shortest one, whose eigenvalues may be double."""
    nu = share * LIMIT[scheme]
    theta = 2 * np.pi * np.arange(1, CELLS // 2) / CELLS
    factors = RELATIONS[scheme](theta, nu, ppc)
    values = np.linalg.eigvals(one_step(scheme, nu, ppc))
    assert np.abs(factors[:, None] - values).min(axis=1).max() < 1e-6


@every_scheme
@LIGHT
@given(st.floats(0.05, 0.95), st.integers(1, 4), st.floats(0.05, 3.0))
def test_the_mode_itself_is_multiplied_by_the_factor(scheme, share, ppc, fraction):
    """From a wave, the grid's part of what a step makes obeys s'' = 2 Re(z) s' - |z|^2 s exactly."""
    nu = share * LIMIT[scheme]
    k = max(1, min(CELLS // 2 - 1, round(fraction * CELLS / 2 / 3.2)))
    theta = np.array([2 * np.pi * k / CELLS])
    (z,) = RELATIONS[scheme](theta, nu, ppc)
    assume(z.imag > 0)  # a mode that does not oscillate has two real factors
    matrix = one_step(scheme, nu, ppc)
    size = len(matrix)
    points = (np.arange(CELLS * ppc) + 0.5) / ppc if scheme.startswith("mpm") else np.arange(CELLS)
    start = np.zeros(size)
    velocity = slice(0, len(points)) if scheme.startswith("mpm") else slice(CELLS, 2 * CELLS)
    start[velocity] = np.sin(theta * points)
    states = [start]
    for _ in range(3):
        states.append(matrix @ states[-1])
    seen = slice(len(points), 2 * len(points)) if scheme.startswith("mpm") else slice(0, CELLS)
    s = [state[seen] for state in states]
    assert np.allclose(s[3], 2 * z.real * s[2] - abs(z) ** 2 * s[1], rtol=0, atol=1e-12)


@every_scheme
@pytest.mark.parametrize("courant", [0.3, 0.5])
def test_long_waves_obey_the_wave_equation_to_second_order(scheme, courant):
    theta = np.array([0.2, 0.1, 0.05])
    z = RELATIONS[scheme](theta, courant, 2)
    error = np.abs(np.angle(z) / (courant * theta) - 1)
    assert np.allclose(np.log2(error[:-1] / error[1:]), 2, atol=0.02)


@pytest.mark.parametrize(
    ("scheme", "lag"),
    [
        ("fem-p1-lumped-cd", lambda nu: (1 - nu**2) / 24),
        ("fem-p1-consistent-cd", lambda nu: -(1 + nu**2) / 24),
        ("fem-p1-consistent-newmark", lambda nu: (2 * nu**2 - 1) / 24),
        ("tg-lumped", lambda nu: (1 - nu**2) / 6),
        ("tg-consistent-3", lambda nu: -(nu**2) / 6),
        ("mpm-tl-linear-usl-flip", lambda nu: (1 - nu**2) / 24 + 3 / 32),
        ("mpm-tl-linear-musl-flip", lambda nu: (1 - nu**2) / 24 + 3 / 32),
        ("mpm-tl-quadratic-usl-flip", lambda nu: (1 - nu**2) / 24 + 3 / 32 + 1 / 8),
    ],
)
def test_leading_phase_errors_are_those_of_the_series(scheme, lag):
    """Belytschko and Mullen (1978), Hughes (1987), Donea (1984); of material points by A = 1 - 2 mean xi (1 - xi) (1 - cos theta).

    Two particles a cell lie at xi = 1/4 and 3/4; a quadratic spline has the variance 1/4 in every point.
    """
    for nu in (0.2, 0.4, 0.55):
        assert phase_lag(scheme, nu, 2) == pytest.approx(lag(nu), abs=1e-6)


SHARP = {"fem-p1-lumped-cd", "fem-p1-consistent-cd", "tg-lumped", "tg-consistent-3"}


@every_scheme
@pytest.mark.parametrize("ppc", [1, 2, 3])
def test_waves_do_not_grow_below_the_limit_and_do_above_a_sharp_one(scheme, ppc):
    theta = np.linspace(0.01, np.pi, 500)
    assert np.abs(RELATIONS[scheme](theta, 0.99 * LIMIT[scheme], ppc)).max() <= 1 + 1e-12
    if scheme in SHARP:
        assert np.abs(RELATIONS[scheme](theta, 1.02 * LIMIT[scheme], ppc)).max() > 1


@pytest.mark.parametrize(("scheme", "limit"), [("usl", math.sqrt(0.5)), ("usf", 2.0), ("musl", 2.0)])
def test_the_limits_of_material_points_at_one_centred_particle_a_cell(scheme, limit):
    theta = np.linspace(0.01, np.pi - 0.01, 2000)
    relation = RELATIONS[f"mpm-tl-linear-{scheme}-flip"]
    assert np.abs(relation(theta, limit - 1e-3, 1)).max() <= 1 + 1e-9
    assert np.abs(relation(theta, limit + 2e-3, 1)).max() > 1


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("integrator", ["cd", "newmark"])
def test_small_steps_leave_the_semi_discrete_dispersion(mass, integrator):
    theta = np.linspace(0.1, 3, 30)
    z = RELATIONS[f"fem-p1-{mass}-{integrator}"](theta, 1e-4, 1)
    assert np.allclose(np.angle(z) / 1e-4, np.sqrt(linear_elements(theta, mass)), rtol=1e-6)


@pytest.mark.parametrize("scheme", ["fem-p1-lumped-cd", "tg-lumped"])
def test_at_a_unit_courant_number_waves_are_translated_exactly(scheme):
    theta = np.linspace(0.1, 3, 30)
    assert np.allclose(RELATIONS[scheme](theta, 1.0, 1), np.exp(1j * theta), rtol=0, atol=1e-7)
