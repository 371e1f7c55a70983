"""An inconclusive verdict says which levels would decide it, and they do."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence import analyse, judge_order, verdict
from mpmverify.convergence.advice import natural

LIGHT = settings(max_examples=25)
HALVED = 2.0 ** -np.arange(10)


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (1 / 64, "1/64"),
        (1 / 3, "1/3"),
        (0.05, "0.05"),
        (0.0125, "0.0125"),
        (1 / 96, "1/96"),
        (0.123456, "0.1235"),
        (3.0, "3"),
        (2.5e-5, "2.5e-05"),
    ],
)
def test_sizes_are_written_as_people_write_them(size, text):
    assert natural(size) == text


@LIGHT
@given(st.integers(2, 10**5))
def test_a_size_that_is_read_back_is_the_same(cells):
    text = natural(1 / cells)
    value = 1 / int(text[2:]) if text.startswith("1/") else float(text)
    assert value == pytest.approx(1 / cells, rel=1e-3)


@pytest.mark.parametrize(
    ("h", "error", "advice"),
    [
        ([1, 0.5], [1, 0.25], "add h = 0.25"),
        ([1 / 32], [1], "add h = 1/64 and h = 1/128"),
        ([0.3, 0.1], [9, 1], "add h = 1/30"),
        ([1, 0.5, 0.25], [1e-9, 1e-14, 0], "add h = 4 and h = 2, where errors are larger, or levels between"),
        ([1, 0.5, 0.25, 0.125], [1e-6, 1e-9, 1e-14, 0], "add h = 2, where errors are larger, or levels between"),
    ],
)
def test_too_few_levels_are_told_which_to_add(h, error, advice):
    found, reason = verdict(h, error, band=(1.8, 2.2))
    assert found == "INCONCLUSIVE"
    assert reason.endswith(f"an order needs three: {advice}")


def added(series, reason):
    texts = re.findall(r"h = (\S+?)(?:,| and|$)", reason.split(": ")[-1])
    return [1 / int(text[2:]) if text.startswith("1/") else float(text) for text in texts]


@pytest.mark.parametrize(
    "error",
    [
        HALVED[:4] ** 2 * [1, 1.1, 0.93, 1.06],
        HALVED[:5] ** 2 + 0.01 * HALVED[:5],
        HALVED[:4] ** 2 * [1, 1.4, 1, 1.4],
        HALVED[:5] ** 2 * (1 + 3 * HALVED[:5]),
    ],
)
def test_the_advised_levels_decide_if_the_error_goes_on(error):
    h = HALVED[: len(error)]
    low, high = 1.9, 2.1
    found, reason = verdict(h, error, band=(low, high))
    assert found == "INCONCLUSIVE"
    series = analyse(h, error)
    sizes = np.array(added(series, reason))
    assert sizes.size, reason
    np.testing.assert_allclose(sizes, h[-1] / 2.0 ** np.arange(1, len(sizes) + 1), rtol=1e-3)
    further = series.estimate.predict(np.append(h[-1], sizes))[1:]
    for count in range(1, len(sizes) + 1):
        after, _ = verdict(np.append(h, sizes[:count]), np.append(error, further[:count]), band=(low, high))
        assert (after != "INCONCLUSIVE") is (count == len(sizes))


def test_no_finer_level_is_advised_at_round_off():
    error = 3e-11 * HALVED[:4] ** 2 * [1, 1.1, 0.9, 1.1]
    found, reason = verdict(HALVED[:4], error, band=(1.9, 2.1))
    assert found == "INCONCLUSIVE"
    assert reason.endswith("add levels between these")


def test_the_size_has_its_name():
    _, reason = judge_order(analyse([0.2, 0.1], [4, 1], size="dt"), 1.8, 2.2)
    assert reason.endswith("add dt = 0.05")
    rough = analyse(HALVED[:7], HALVED[:7] ** 2 * [30, 1, 1, 1, 1, 1, 1], size="dt")
    assert rough.dropped == ("dt=1: pre-asymptotic (30 times what the finer levels predict)",)


# Replicates.


def replicated(scatter, count=4, levels=4):
    generator = np.random.default_rng(0)
    h = HALVED[:levels].repeat(count)
    return h, h**2 * np.exp(scatter * generator.standard_normal(len(h)))


def test_replicates_enter_the_fit_as_they_are():
    h, error = replicated(0.1)
    series = analyse(h, error)
    slope, _ = np.polyfit(np.log(h), np.log(error), 1)
    assert series.fit.order == pytest.approx(slope)
    assert series.fit.high - series.fit.low < 0.2
    assert "from 16 errors at 4 sizes, each as it is" in verdict(h, error, band=(1.8, 2.2))[1]


def test_pairwise_orders_of_replicates_are_those_of_geometric_means():
    h, error = replicated(0.3)
    series = analyse(h, error)
    means = np.exp(np.log(error).reshape(4, -1).mean(axis=1))
    expected = np.diff(np.log(means)) / np.diff(np.log(HALVED[:4]))
    np.testing.assert_allclose(series.pairwise, np.concatenate([[np.nan] * 3, expected.repeat(4)]))


@LIGHT
@given(st.permutations(range(12)))
def test_the_order_of_replicates_does_not_matter(order):
    h, error = replicated(0.2, 3)
    one, other = analyse(h, error), analyse(h[list(order)], error[list(order)])
    np.testing.assert_array_equal(one.error, other.error)
    assert one.fit == other.fit


def test_replicates_at_two_sizes_are_too_few():
    h, error = replicated(0.1, 5, 2)
    found, reason = verdict(h, error, band=(1.8, 2.2))
    assert found == "INCONCLUSIVE"
    assert "add h = 0.25" in reason
