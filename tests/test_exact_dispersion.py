"""Dispersion relations: eigenvalues of the matrix of one step, which is assembled here independently, and limits of long waves."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from scipy.optimize import brentq
from scipy.sparse import csr_array
from scipy.special import itairy
from skfem import Basis, ElementLineP1, ElementLineP2, MeshLine
from skfem.models.poisson import laplace, mass

from mpmverify.exact.dispersion import RELATIONS, front_lag, leading_errors, linear_elements

LIGHT = settings(max_examples=10)
CELLS = 14
SCHEMES = [scheme for scheme in RELATIONS if "-ul-" not in scheme]
SPLINES = {
    "linear": (BSpline.basis_element([-1, 0, 1], extrapolate=False), 0.0),
    "quadratic": (BSpline.basis_element([-1.5, -0.5, 0.5, 1.5], extrapolate=False), 0.5),
}
"""B-spline centred on its node, and position of the node relative to the left end of its cell, in cells."""
LIMIT = {
    "fem-p1-lumped-cd": 1.0,
    "fem-p1-consistent-cd": 1 / math.sqrt(3),
    "fem-p1-lumped-newmark": 5.0,
    "fem-p1-consistent-newmark": 5.0,
    "fem-p2-lumped-cd": 1 / math.sqrt(6),
    "fem-p2-consistent-cd": 1 / math.sqrt(15),
    "tg-lumped": 1.0,
    "tg-consistent-3": 1 / math.sqrt(3),
} | {scheme: 0.7 if "usl" in scheme else 1.0 for scheme in RELATIONS if "mpm" in scheme}
"""Courant numbers below which each scheme is stable: material points with any number of particles per cell, quadratic elements on
both branches."""
every_scheme = pytest.mark.parametrize("scheme", SCHEMES)


def ring(*offsets):
    """Return the circulant matrix with these (offset, value) diagonals."""
    return sum(value * np.roll(np.eye(CELLS), offset, axis=1) for offset, value in offsets)


def step_of_elements(scheme, nu):
    """Return the matrix of one step (u, v, a) -> (u, v, a) of Newmark's rule on a ring, h = c = 1, assembled by scikit-fem."""
    degree = int(scheme[5])
    basis = Basis(MeshLine(np.arange(CELLS + 1.0)), (ElementLineP1(), ElementLineP2())[degree - 1], intorder=6)
    unknown = np.mod(np.round(basis.doflocs[0] * degree).astype(int), CELLS * degree)
    size = CELLS * degree
    fold = csr_array((np.ones(len(unknown)), (np.arange(len(unknown)), unknown)), (len(unknown), size))
    M, K = ((fold.T @ csr_array(form.assemble(basis)) @ fold).toarray() for form in (mass, laplace))
    M = np.diag(M.sum(axis=1)) if "lumped" in scheme else M
    beta, one, none = 0.25 if "newmark" in scheme else 0.0, np.eye(size), np.zeros((size, size))
    predictor = np.block([[one, nu * one, nu**2 * (0.5 - beta) * one], [none, one, nu / 2 * one]])
    a = -np.linalg.solve(M + beta * nu**2 * K, K) @ predictor[:size]
    return np.vstack([predictor + np.vstack([beta * nu**2 * a, nu / 2 * a]), a])


def step_of_taylor_galerkin(scheme, nu):
    """Return the matrix of one step (sigma, v) -> (sigma, v) on a ring, h = rho = E = 1: predictor in the elements, then mass passes."""
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


def step_of_particles(scheme, nu, ppc):
    """Return the matrix of one step (v_p, sigma_p) -> (v_p, sigma_p) on a ring, h = rho = E = 1, column by column."""
    count = CELLS * ppc
    x = (np.arange(count) + 0.5) / ppc
    left = np.floor(x).astype(int)
    N, dN = np.zeros((count, CELLS)), np.zeros((count, CELLS))
    spline, middle = SPLINES["linear" if "linear" in scheme else "quadratic"]
    for shift in range(-1, 3):
        distance = x - (left + shift) - middle
        node = (left + shift) % CELLS
        N[np.arange(count), node] += np.nan_to_num(spline(distance))
        dN[np.arange(count), node] += np.nan_to_num(spline.derivative()(distance))
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
        return step_of_particles(scheme, nu, ppc)
    return step_of_taylor_galerkin(scheme, nu) if scheme.startswith("tg") else step_of_elements(scheme, nu)


@every_scheme
@LIGHT
@given(st.floats(0.05, 0.99), st.integers(1, 4))
def test_factors_are_the_oscillating_eigenvalues_of_a_step(scheme, share, ppc):
    """All modes of the ring are tested except the constant and the shortest one, whose eigenvalues may be double."""
    nu = share * LIMIT[scheme]
    theta = 2 * np.pi * np.arange(1, CELLS // 2) / CELLS
    factors = RELATIONS[scheme](theta, nu, ppc)
    values = np.linalg.eigvals(one_step(scheme, nu, ppc))
    assert np.abs(factors[:, None] - values).min(axis=1).max() < 1e-6


@pytest.mark.parametrize("scheme", [scheme for scheme in SCHEMES if "p2" not in scheme])
@LIGHT
@given(st.floats(0.05, 0.95), st.integers(1, 4), st.floats(0.05, 3.0))
def test_the_mode_itself_is_multiplied_by_the_factor(scheme, share, ppc, fraction):
    """The stress or displacement s_n that starts from a wave obeys s_(n+1) = 2 Re(z) s_n - |z|^2 s_(n-1) exactly.

    Quadratic elements are left out, because the wave excites both of their branches.
    """
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
        ("fem-p2-lumped-cd", lambda nu: -(nu**2) / 24),
        ("fem-p2-consistent-cd", lambda nu: -(nu**2) / 24),
        ("tg-lumped", lambda nu: (1 - nu**2) / 6),
        ("tg-consistent-3", lambda nu: -(nu**2) / 6),
        ("mpm-tl-linear-usl-flip", lambda nu: (1 - nu**2) / 24 + 3 / 32),
        ("mpm-tl-linear-musl-flip", lambda nu: (1 - nu**2) / 24 + 3 / 32),
        ("mpm-tl-quadratic-usl-flip", lambda nu: (1 - nu**2) / 24 + 3 / 32 + 1 / 8),
    ],
)
def test_leading_phase_errors_are_those_of_the_literature(scheme, lag):
    """Belytschko and Mullen (1978), Hughes (1987), Donea (1984); material points by A = 1 - 2 mean xi (1 - xi) (1 - cos theta).

    The two particles of a cell lie at xi = 1/4 and 3/4; a quadratic spline has the variance 1/4 at every point.
    """
    for nu in (0.2, 0.4, 0.55):
        assert leading_errors(scheme, nu, 2)[0] == pytest.approx(lag(nu), abs=1e-6)


SHARP = {"fem-p1-lumped-cd", "fem-p1-consistent-cd", "tg-lumped", "tg-consistent-3"}


@every_scheme
@pytest.mark.parametrize("ppc", [1, 2, 3])
def test_waves_do_not_grow_below_the_limit_and_grow_above_a_sharp_limit(scheme, ppc):
    theta = np.linspace(0.01, np.pi, 500)
    assert np.abs(RELATIONS[scheme](theta, 0.99 * LIMIT[scheme], ppc)).max() <= 1 + 1e-12
    if scheme in SHARP:
        assert np.abs(RELATIONS[scheme](theta, 1.02 * LIMIT[scheme], ppc)).max() > 1


@pytest.mark.parametrize(("scheme", "limit"), [("usl", math.sqrt(0.5)), ("usf", 2.0), ("musl", 2.0)])
def test_the_limits_of_material_points_with_one_centred_particle_per_cell(scheme, limit):
    theta = np.linspace(0.01, np.pi - 0.01, 2000)
    relation = RELATIONS[f"mpm-tl-linear-{scheme}-flip"]
    assert np.abs(relation(theta, limit - 1e-3, 1)).max() <= 1 + 1e-9
    assert np.abs(relation(theta, limit + 2e-3, 1)).max() > 1


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("integrator", ["cd", "newmark"])
def test_small_steps_give_the_semi_discrete_dispersion(mass, integrator):
    theta = np.linspace(0.1, 3, 30)
    z = RELATIONS[f"fem-p1-{mass}-{integrator}"](theta, 1e-4, 1)
    assert np.allclose(np.angle(z) / 1e-4, np.sqrt(linear_elements(theta, mass)), rtol=1e-6)


@pytest.mark.parametrize("scheme", ["fem-p1-lumped-cd", "tg-lumped"])
def test_at_a_unit_courant_number_waves_are_translated_exactly(scheme):
    theta = np.linspace(0.1, 3, 30)
    assert np.allclose(RELATIONS[scheme](theta, 1.0, 1), np.exp(1j * theta), rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("scheme", "loss"),
    [
        ("tg-lumped", lambda nu: nu * (1 - nu**2) / 8),
        ("tg-consistent-3", lambda nu: nu * (1 - 3 * nu**2) / 24),
        ("mpm-tl-linear-usl-flip", lambda nu: nu * 3 / 32),
        ("fem-p1-consistent-newmark", lambda nu: 0.0),
        ("mpm-tl-linear-musl-flip", lambda nu: 0.0),
    ],
)
def test_leading_losses_are_those_of_the_literature(scheme, loss):
    """Donea (1984): |G|^2 = 1 - nu^2 (1 - nu^2) theta^4/4, or nu^2 (1 - 3 nu^2) theta^4/12; USL: |z|^2 = 1 - nu^2 D (1 - A)."""
    for nu in (0.2, 0.4, 0.55):
        assert leading_errors(scheme, nu, 2)[1] == pytest.approx(loss(nu), abs=1e-6)


# Fronts.


@pytest.mark.parametrize("scheme", ["fem-p1-lumped-cd", "fem-p1-consistent-cd", "tg-lumped", "mpm-tl-linear-musl-flip"])
def test_the_lag_of_a_front_tends_to_that_of_an_airy_function(scheme):
    """The middle of the integral of Ai lies at the zero of int_{-s}^inf Ai - 1/2, in units of the width (3 lag nu_C n)^(1/3)."""
    middle = brentq(lambda s: itairy(s)[2] - 1 / 6, 0, 2)
    nu, steps = 0.5, 20000
    lag, _ = leading_errors(scheme, nu, 2)
    width = math.copysign(abs(3 * lag * nu * steps) ** (1 / 3), lag)
    assert front_lag(scheme, nu, steps, 2) == pytest.approx(middle * width, rel=0.03)


def test_a_front_that_is_translated_exactly_does_not_lag():
    assert front_lag("tg-lumped", 1.0, 200) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("passes", [1, 3])
def test_the_lag_of_a_front_is_that_of_the_scheme_stepped_on_a_long_ring(passes):
    """The initial jump lies on a node."""
    cells, nu, steps = 400, 0.5, 150
    position = np.arange(cells)
    u = np.where((position > 50) & (position < 200), 1.0, 0.0)
    u[[50, 200]] = 0.5

    def step(u):
        right, left = np.roll(u, -1), np.roll(u, 1)
        residual = -nu / 2 * (right - left) + nu**2 / 2 * (right - 2 * u + left)
        change = np.zeros(cells)
        for _ in range(passes):
            change = change + residual - (np.roll(change, -1) + 4 * change + np.roll(change, 1)) / 6
        return u + change

    for _ in range(steps):
        u = step(u)
    j = 200 + np.flatnonzero((u[200:] >= 0.5) & (np.roll(u, -1)[200:] < 0.5))[0]
    position_of_front = j + (u[j] - 0.5) / (u[j] - u[j + 1])
    scheme = "tg-lumped" if passes == 1 else "tg-consistent-3"
    assert front_lag(scheme, nu, steps) == pytest.approx(200 + nu * steps - position_of_front, abs=0.02)
