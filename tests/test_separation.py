"""Separation of error sources on designs of known truth: with noise, missing sources, cancellation and unsuitable designs."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mpmverify.convergence.sources import REST, Separation, separate
from mpmverify.convergence.superposition import Model
from mpmverify.convergence.synthetic import measure_designs
from mpmverify.errors import UsageError

LIGHT = settings(max_examples=20)
HALVES = 0.5 ** np.arange(4)
H, DT = (grid.ravel() for grid in np.meshgrid(HALVES, 0.5 * HALVES, indexing="ij"))
EXPONENTS = st.sampled_from([1.0, 1.5, 2.0, 3.0, 4.0])
COSINES = st.sampled_from([-1.0, -0.5, 0.0, 0.5, 1.0])


def total(parts, cosine):
    """Norm of the sum of m fields on n runs, from their norms (m, n) and the cosines between them (m, m)."""
    return np.sqrt(np.maximum(np.einsum("in,ij,jn->n", parts, cosine, parts), 1e-30))


def pair(p, q, cosine=1.0, ratio=1.0):
    """Error with the sources h^p and dt^q, whose geometric mean ratio over the design is given."""
    parts = np.array([H**p, DT**q])
    parts[1] *= ratio * np.exp(np.mean(np.log(parts[0] / parts[1])))
    return 0.1 * total(parts, np.array([[1, cosine], [cosine, 1]]))


def by_size(separation: Separation):
    return {source.size: source for source in separation.sources}


@LIGHT
@given(EXPONENTS, EXPONENTS, COSINES, st.floats(0.2, 5))
def test_exponents_and_cosine_of_errors_without_noise_are_recovered(p, q, cosine, ratio):
    error = pair(p, q, cosine, ratio)
    assume(error.min() > 1e-9 * error.max())  # sources that cancel to round-off are an obstacle
    found = separate({"h": H, "dt": DT}, error)
    assert found.obstacle == ""
    assert by_size(found)["h"].exponent == pytest.approx(p, abs=1e-3)
    assert by_size(found)["dt"].exponent == pytest.approx(q, abs=1e-3)
    assert found.cosine["h", "dt"] == pytest.approx(cosine, abs=1e-2)


@LIGHT
@given(EXPONENTS, EXPONENTS, COSINES, st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.randoms(use_true_random=False))
def test_the_separation_reproduces_the_error_in_any_units_and_order_of_runs(p, q, cosine, metre, second, shuffle):
    runs = list(range(len(H)))
    shuffle.shuffle(runs)
    h, dt, error = (H * metre)[runs], (DT * second)[runs], pair(p, q, cosine)[runs]
    assume(error.min() > 1e-9 * error.max())
    found = separate({"dt": dt, "h": h}, error)
    assert [source.size for source in found.sources] == ["dt", "h"]
    sources = by_size(found)
    assert sources["h"].exponent == pytest.approx(p, abs=1e-3)
    parts = np.array([sources[name].amplitude * size ** sources[name].exponent for name, size in (("h", h), ("dt", dt))])
    angle = found.cosine["dt", "h"]
    assert np.all(np.abs(total(parts, np.array([[1, angle], [angle, 1]])) - error) < 1e-2 * parts.sum(axis=0))


def test_three_sources_are_separated():
    h, dt, ppc = (grid.ravel() for grid in np.meshgrid(HALVES[:3], HALVES[:3], [1, 2, 3], indexing="ij"))
    found = separate({"h": h, "dt": dt, "1/ppc": 1 / ppc}, 0.02 * h**2 + 0.01 * dt**1.5 + 0.01 / ppc**3)
    assert [round(source.exponent, 2) for source in found.sources] == [2.0, 1.5, 3.0]
    assert found.cosine == pytest.approx(dict.fromkeys((("h", "dt"), ("h", "1/ppc"), ("dt", "1/ppc")), 1.0), abs=0.01)


@pytest.mark.parametrize("cosine", [-1.0, 0.0, 1.0])
def test_a_single_size_is_separated_from_a_constant(cosine):
    dt = 0.5 ** np.arange(7.0)
    found = separate({"dt": dt}, total(np.array([0.1 * dt**2, np.full(7, 1e-3)]), np.array([[1, cosine], [cosine, 1]])))
    assert [source.size for source in found.sources] == ["dt", REST]
    assert found.sources[0].exponent == pytest.approx(2, abs=1e-3)
    assert found.sources[1].amplitude == pytest.approx(1e-3, rel=1e-2)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_an_absent_source_is_not_seen_and_has_no_exponent(noise):
    error = 0.1 * H**2 * np.exp(noise * np.random.default_rng(1).standard_normal(len(H)))
    found = by_size(separate({"h": H, "dt": DT}, error))
    assert found["h"].exponent == pytest.approx(2, abs=0.05)
    assert not found["dt"].seen
    assert np.isnan([found["dt"].exponent, found["dt"].low, found["dt"].high]).all()


def test_a_source_below_the_noise_is_not_seen():
    error = (0.1 * H**2 + 1e-3 * DT**2) * np.exp(0.02 * np.random.default_rng(2).standard_normal(len(H)))
    assert not by_size(separate({"h": H, "dt": DT}, error))["dt"].seen


OBSTACLES = [
    ({"h": HALVES, "dt": HALVES / 3}, HALVES**2, "h and dt fall together"),
    ({"h": H, "dt": H**1.5}, H**2, "h and dt fall together"),
    ({"h": H[:6], "dt": DT[:6]}, H[:6] ** 2, "an exponent needs three values of h"),
    ({"dt": HALVES}, HALVES**2, "4 runs above round-off for 4 parameters"),
    ({"h": H, "dt": DT}, np.where(H < 0.5, 1e-15, H**2), "an exponent needs three values of h on runs above round-off"),
    ({"h": H, "dt": DT}, np.where(H < 0.2, np.nan, H**2), "not finite"),
    ({"h": H, "dt": DT}, np.where(H < 0.2, np.inf, H**2), "not finite"),
    ({"h": H, "dt": DT}, np.zeros(len(H)), "an exponent needs three values"),
    ({"h": H, "dt": DT}, H**2 * np.tile([1, 1.3], 8), "do not explain the errors"),
    ({"h": H, "dt": DT}, np.exp(-3 * H) + DT**2, "do not explain the errors"),
]


@pytest.mark.parametrize(("sizes", "error", "obstacle"), OBSTACLES)
def test_the_obstacle_says_why_a_design_cannot_separate_sources(sizes, error, obstacle):
    assert obstacle in separate(sizes, error).obstacle


@pytest.mark.parametrize(
    ("sizes", "error", "reason"),
    [
        ({}, [1.0], "same length"),
        ({"h": [1.0, 0.5]}, [1.0], "same length"),
        ({"h": [1.0, 0.0]}, [1.0, 1.0], "positive and finite"),
        ({"h": [1.0, np.nan]}, [1.0, 1.0], "positive and finite"),
        ({"h": [1.0, 0.5]}, [1.0, -1.0], "negative"),
    ],
)
def test_invalid_arguments_are_refused(sizes, error, reason):
    with pytest.raises(UsageError, match=reason):
        separate(sizes, error)


def test_runs_at_round_off_are_an_obstacle_only_where_the_fit_predicts_larger_errors():
    error = pair(2, 2)
    spoilt = np.where(np.arange(len(H)) % 5 == 2, 0.0, error)
    assert "at round-off" in separate({"h": H, "dt": DT}, spoilt).obstacle
    small = error * 1e-11
    assert (small <= 1e-12).any()
    assert separate({"h": H, "dt": DT}, small).obstacle == ""


def test_the_jacobian_is_the_derivative_of_the_residuals():
    logs = {"h": np.log(H) - np.log(H).mean(), "dt": np.log(DT) - np.log(DT).mean(), REST: np.zeros(len(H))}
    model = Model(logs, np.log(pair(2, 2)), {REST: 0.0})
    x = np.array([-3.0, -2.5, -4.0, 2.2, 1.4, 0.3, -0.6, 0.8])
    assert len(x) == model.parameters
    steps = 1e-6 * np.eye(len(x))
    slopes = np.array([(model.residuals(x + step) - model.residuals(x - step)) / 2e-6 for step in steps]).T
    np.testing.assert_allclose(model.jacobian(x), slopes, atol=1e-8)


# Random designs.


def test_wrong_verdicts_on_random_designs_are_rare():
    inside, outside = measure_designs(100, seed=1)
    assert min(inside.series, outside.series) > 20
    assert outside.wrong_pass == 0
    assert inside.wrong_fail <= 0.02 * inside.series
    assert inside.right > 0.6 * inside.series
    assert outside.right > 0.5 * outside.series
