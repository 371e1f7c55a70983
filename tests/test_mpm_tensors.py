"""Tensors stored as tuples, compared with matrices in one, two and three dimensions."""

import numpy as np
import pytest
from from_python import entries
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mpmverify.solvers import mpm

tensors = entries(mpm.tensors)

PLACES = {1: ([0], [0]), 2: ([0, 1, 0], [0, 1, 1]), 3: ([0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0])}
"""Row and column of each component of a symmetric tensor."""

dimensions = st.sampled_from([1, 2, 3])
# No entry so small that numpy's determinant warns of an underflow.
entries = st.floats(-2, 2).map(lambda x: round(x, 9))
pairs = dimensions.flatmap(lambda d: st.tuples(*2 * [arrays(float, (d, d), elements=entries)]))


def row_major(A):
    return tuple(np.ravel(A).tolist())


def symmetric(A):
    return tuple(A[PLACES[len(A)]].tolist())


def matrix(components):
    """Matrix of a row-major tuple."""
    d = {1: 1, 4: 2, 9: 3}[len(components)]
    return np.reshape(components, (d, d))


@given(pairs)
def test_every_operation_agrees_with_matrices(pair):
    A, B = pair
    d, S, T = len(A), (A + A.T) / 2, (B + B.T) / 2
    a, s, t = row_major(A), symmetric(S), symmetric(T)
    # Products of entries up to 2 sum up to some tens.
    assert tensors.det(a) == pytest.approx(np.linalg.det(A), abs=1e-13)
    assert matrix(tensors.deform(row_major(B), a)) == pytest.approx((np.eye(d) + B) @ A, abs=1e-13)
    assert matrix(tensors.full(tensors.left_cauchy_green(a))) == pytest.approx(A @ A.T, abs=1e-13)
    assert tensors.sym(a) == pytest.approx(s, abs=1e-15)
    assert np.array_equal(matrix(tensors.full(s)), S)
    assert tensors.dimension(s) == d
    assert tensors.trace(s) == pytest.approx(np.trace(S), abs=1e-14)
    assert tensors.ddot(s, t) == pytest.approx(np.sum(S * T), abs=1e-13)
    assert tensors.shifted(2.0, 3.0, s) == pytest.approx(symmetric(2 * np.eye(d) + 3 * S), abs=1e-14)
    assert tensors.combined(2.0, s, 3.0, t) == pytest.approx(symmetric(2 * S + 3 * T), abs=1e-14)
    assert tensors.squared(s) == pytest.approx(symmetric(S @ S), abs=1e-13)


@given(pairs)
def test_the_first_piola_kirchhoff_stress_carries_the_force_of_the_cauchy_stress(pair):
    """P F^T = J sigma, at a singular deformation too."""
    F, A = pair
    sigma = A + A.T
    P = matrix(tensors.first_piola_kirchhoff(symmetric(sigma), row_major(F)))
    assert np.abs(P @ F.T - np.linalg.det(F) * sigma).max() < 1e-11


gaps = st.one_of(st.just(0.0), st.floats(-17, 0).map(lambda power: 10**power))


@given(dimensions, st.integers(0, 2**32 - 1), st.tuples(gaps, gaps), st.floats(-2, 2))
def test_the_logarithm_is_accurate_where_eigenvalues_coincide(d, seed, apart, scale):
    """The differences of principal strains are between 0 and 4, of any order of magnitude."""
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(d, d)))
    strain = np.array([scale, scale + 2 * apart[0], scale - 2 * apart[1]])[:d]
    b, expected = (Q * np.exp(strain)) @ Q.T, (Q * strain) @ Q.T
    J = float(np.exp(np.sum(strain) / 2))
    ln_b = matrix(tensors.full(tensors.logarithm(symmetric((b + b.T) / 2), J)))
    # The least eigenvalue is known to the round-off of the greatest, whatever the method.
    assert np.abs(ln_b - expected).max() < 2e-15 * (1 + np.exp(np.ptp(strain))) * 4


@given(st.lists(st.floats(0.1, 10), min_size=3, max_size=3), st.integers(0, 2**32 - 1))
def test_eigenvalues_descend_and_are_those_of_the_matrix(values, seed):
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    b = (Q * values) @ Q.T
    found = tensors.eigenvalues(symmetric((b + b.T) / 2))
    # Half of the digits of their difference are lost where two meet.
    assert np.abs(found - np.sort(values)[::-1]).max() < 1e-7
    assert sum(found) == pytest.approx(sum(values))
