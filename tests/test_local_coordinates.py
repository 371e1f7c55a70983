"""Local coordinates: the inverse map inverts the map, and the search agrees with a test of every element."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.errors import UsageError
from mpmverify.problem import Array
from mpmverify.solvers.local_coordinates import CORNERS, find_element, inverse_map

UNIT = st.floats(-1, 1)
ANGLES = st.tuples(*[st.floats(0.05, 1.0)] * 4)
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def mapped(nodes: Array, xi: Array) -> Array:
    """Return x = sum_a N_a(xi) x_a (P, dim), written independently of the solver."""
    if nodes.shape[1] == 1:
        return (nodes[0] * (1 - xi) + nodes[1] * (1 + xi)) / 2
    s, t = CORNERS.T
    return (1 + np.outer(xi[:, 0], s)) * (1 + np.outer(xi[:, 1], t)) / 4 @ nodes


@st.composite
def convex_quadrilaterals(draw: st.DrawFn) -> Array:
    """Four points on a circle, counter-clockwise, under a well-conditioned affine map."""
    gaps = np.array(draw(ANGLES))
    angles = np.cumsum(gaps) * 2 * np.pi / gaps.sum()
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    a, b, c = draw(st.tuples(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(-3, 3)))
    shift = np.array(draw(st.tuples(*[st.floats(-100, 100)] * 2)))
    return circle @ np.array([[a, 0], [c, b]]) + shift


def least_jacobian(nodes: Array) -> float:
    edges = np.roll(nodes, -1, axis=0) - nodes
    return float(np.min(np.roll(edges, 1, axis=0)[:, 0] * edges[:, 1] - np.roll(edges, 1, axis=0)[:, 1] * edges[:, 0]))


@settings(max_examples=300)
@given(convex_quadrilaterals(), st.lists(st.tuples(UNIT, UNIT), min_size=1, max_size=8))
def test_round_trip_in_any_convex_quadrilateral(nodes: Array, local: list[tuple[float, float]]) -> None:
    xi = np.array(local)
    size = np.ptp(nodes, axis=0).max()
    condition = size**2 / least_jacobian(nodes) * (1 + np.abs(nodes).max() / size)
    np.testing.assert_allclose(inverse_map(nodes, mapped(nodes, xi)), xi, atol=1e-14 * condition)


@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3), st.floats(-3, 3))
def test_round_trip_in_any_bar(start: float, length: float, local: float) -> None:
    nodes, xi = np.array([[start], [start + length]]), np.array([[local]])
    found = inverse_map(nodes, mapped(nodes, xi))
    np.testing.assert_allclose(found, xi, atol=1e-14 * (1 + abs(start) / length))


def test_nodes_have_the_local_coordinates_of_the_corners() -> None:
    nodes = np.array([[0.0, 0.0], [3.0, -0.5], [2.5, 2.0], [0.5, 1.0]])
    np.testing.assert_allclose(inverse_map(nodes, nodes), CORNERS, atol=1e-14)
    np.testing.assert_allclose(inverse_map(nodes, nodes.mean(axis=0)), [0, 0], atol=1e-14)


def test_round_trip_in_a_nearly_triangular_element() -> None:
    nodes = np.array([[0.0, 0.0], [1.0, 0.0], [0.501, 0.5], [0.0, 1.0]])
    xi = np.stack(np.meshgrid(*[np.linspace(-1, 1, 41)] * 2), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(inverse_map(nodes, mapped(nodes, xi)), xi, atol=1e-10)


def test_a_point_outside_the_element_has_local_coordinates_beyond_one() -> None:
    assert inverse_map(SQUARE, [1.25, 0.5]) == pytest.approx([1.5, 0.0])


def test_a_point_where_the_map_has_no_inverse_is_refused() -> None:
    wedge = np.array([[0.0, 0.0], [2.0, 0.0], [1.5, 1.0], [0.5, 1.0]])
    with pytest.raises(UsageError, match=r"the point \[3.0, 3.0\] has no local coordinates"):
        inverse_map(wedge, [3.0, 3.0])
    with pytest.raises(UsageError, match="no local coordinates"):
        inverse_map(SQUARE, [math.nan, 0.0])


@pytest.mark.parametrize(
    "nodes",
    [
        SQUARE[::-1],
        SQUARE[[0, 1, 1, 3]],
        SQUARE[[0, 2, 1, 3]],
        SQUARE * [1, 0],
        SQUARE * math.nan,
        np.zeros((4, 2)),
        np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]]),
        np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0]]),
        np.array([[1.0], [1.0]]),
        np.array([[1.0], [0.0]]),
    ],
    ids=["clockwise", "double node", "crossed", "flat", "nan", "point", "concave", "triangle", "no length", "reversed"],
)
def test_degenerate_elements_are_refused_by_number(nodes: Array) -> None:
    with pytest.raises(UsageError, match="element 0 is degenerate"):
        inverse_map(nodes, nodes.mean(axis=0))
    good = SQUARE + 5 if nodes.shape[1] == 2 else np.array([[5.0], [6.0]])
    n = len(nodes)
    with pytest.raises(UsageError, match="element 1 is degenerate"):
        find_element(np.concatenate([good, nodes]), np.arange(2 * n).reshape(2, n), good)


def mesh(cells: int, seed: int, distortion: float = 0.2) -> tuple[Array, Array]:
    """Mesh of the unit square of distorted convex quadrilaterals in random order."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, cells + 1)] * 2, indexing="ij"), axis=-1)
    inner = grid[1:-1, 1:-1]
    inner += rng.uniform(-distortion, distortion, inner.shape) / cells
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    corners = (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:])
    connectivity = np.stack(corners, axis=-1).reshape(-1, 4)
    return grid.reshape(-1, 2), rng.permutation(connectivity)


def inside(nodes: Array, point: Array, slack: float) -> bool:
    """Whether a convex polygon contains a point: the point lies to the left of every side."""
    edges, towards = np.roll(nodes, -1, axis=0) - nodes, point - nodes
    return bool((edges[:, 0] * towards[:, 1] - edges[:, 1] * towards[:, 0] >= -slack).all())


@pytest.mark.parametrize("seed", range(5))
def test_the_search_agrees_with_a_test_of_every_element(seed: int) -> None:
    coordinates, connectivity = mesh(6, seed)
    rng = np.random.default_rng(100 + seed)
    points = rng.uniform(-0.1, 1.1, (400, 2))
    expected = [next((e for e, c in enumerate(connectivity) if inside(coordinates[c], p, 0.0)), -1) for p in points]
    found, local = find_element(coordinates, connectivity, points)
    np.testing.assert_array_equal(found, expected)
    contained = found >= 0
    assert 0 < contained.sum() < len(points)
    assert np.isnan(local[~contained]).all()
    assert (np.abs(local[contained]) <= 1 + 1e-12).all()
    again = [
        mapped(coordinates[connectivity[e]], xi[None])[0] for e, xi in zip(found[contained], local[contained], strict=True)
    ]
    np.testing.assert_allclose(again, points[contained], atol=1e-14)


@settings(max_examples=60)
@given(st.integers(0, 10**6), st.integers(1, 7), st.floats(0, 0.24))
def test_the_result_does_not_depend_on_the_guess(seed: int, cells: int, distortion: float) -> None:
    coordinates, connectivity = mesh(cells, seed, distortion)
    rng = np.random.default_rng(seed + 1)
    edges = (coordinates[connectivity] + np.roll(coordinates[connectivity], 1, axis=1)).reshape(-1, 2) / 2
    points = np.concatenate([rng.uniform(-0.1, 1.1, (50, 2)), coordinates, edges])
    found, local = find_element(coordinates, connectivity, points)
    for guess in (rng.integers(-1, len(connectivity), len(points)), found):
        other, other_local = find_element(coordinates, connectivity, points, guess)
        np.testing.assert_array_equal(other, found)
        np.testing.assert_array_equal(other_local, local)


@pytest.mark.parametrize("seed", range(3))
def test_points_on_edges_and_nodes_belong_to_the_lowest_element(seed: int) -> None:
    coordinates, connectivity = mesh(5, seed)
    found, _ = find_element(coordinates, connectivity, coordinates)
    np.testing.assert_array_equal(
        found, [np.flatnonzero((connectivity == n).any(axis=1)).min() for n in range(len(coordinates))]
    )
    for nodes in connectivity:
        for a, b in zip(nodes, np.roll(nodes, -1), strict=True):
            sharing = (connectivity == a).any(axis=1) & (connectivity == b).any(axis=1)
            share = np.linspace(0.1, 0.9, 7)[:, None]
            on_edge, _ = find_element(coordinates, connectivity, (1 - share) * coordinates[a] + share * coordinates[b])
            assert (on_edge == np.flatnonzero(sharing).min()).all()


def test_the_search_in_bars_of_random_order() -> None:
    rng = np.random.default_rng(7)
    x = np.sort(rng.uniform(-2, 3, 21))
    connectivity = rng.permutation(np.column_stack([np.arange(20), np.arange(1, 21)]))
    points = np.concatenate([rng.uniform(-3, 4, 200), x])[:, None]
    found, local = find_element(x[:, None], connectivity, points)
    lower, upper = x[connectivity].T
    contains = (lower <= points) & (points <= upper)
    np.testing.assert_array_equal(found, np.where(contains.any(axis=1), contains.argmax(axis=1), -1))
    contained = found >= 0
    back = lower[found[contained]] * (1 - local[contained, 0]) / 2 + upper[found[contained]] * (1 + local[contained, 0]) / 2
    np.testing.assert_allclose(back, points[contained, 0], atol=1e-14)


def test_points_outside_the_mesh_have_no_element() -> None:
    found, local = find_element(SQUARE, [[0, 1, 2, 3]], [[math.nan, 0.5], [math.inf, 0.5], [1.0 + 1e-9, 0.5], [0.5, -3.0]])
    assert (found == -1).all()
    assert np.isnan(local).all()


def test_a_small_element_far_from_the_origin_loses_no_digits() -> None:
    nodes = SQUARE * 2.0**-10 + 2.0**10
    np.testing.assert_allclose(inverse_map(nodes, nodes), CORNERS, atol=1e-14)


@pytest.mark.parametrize(
    ("connectivity", "points", "guess", "message"),
    [
        ([[0, 1, 2, 4]], [[0.5, 0.5]], None, "a node number outside 0 to 3"),
        ([[0, 1, 2]], [[0.5, 0.5]], None, "two-node bars"),
        ([[0, 1, 2, 3]], [[0.5]], None, "points must be"),
        ([[0, 1, 2, 3]], [[0.5, 0.5]], [1], "guesses"),
        ([[0, 1, 2, 3]], [[0.5, 0.5]], [0, 0], "guesses"),
    ],
)
def test_arrays_that_do_not_match_are_refused(connectivity: list, points: list, guess: list | None, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        find_element(SQUARE, connectivity, points, guess)
