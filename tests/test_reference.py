"""Grid convergence and numerical references: orders of power laws, bounds on true errors, and verdicts against a reference."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpmverify.convergence import (
    Behaviour,
    Classification,
    analyse,
    grid_convergence,
    grid_convergence_of_differences,
    qualify,
    qualify_by_differences,
    verdict,
)
from mpmverify.convergence.gci import observed_order
from mpmverify.convergence.verdict import Verdict
from mpmverify.errors import UsageError
from mpmverify.exact.vibration import axial_vibration
from mpmverify.problem import Discretisation
from mpmverify.solvers.fem import FiniteElement

LIGHT = settings(max_examples=60)
RATIOS = st.lists(st.floats(1.2, 4), min_size=2, max_size=5)
ORDERS = st.floats(0.3, 5)
H = 0.1 * 0.5 ** np.arange(5.0)


def sizes(ratios):
    return 1 / np.cumprod([1.0, *ratios])


# Power laws.


@LIGHT
@given(RATIOS, ORDERS, st.floats(-10, 10), st.sampled_from([-2.0, 0.5, 3.0]), st.randoms(use_true_random=False))
def test_order_and_limit_of_a_power_law_are_recovered_at_any_ratios(ratios, order, limit, constant, random):
    h = sizes(ratios)
    value = limit + constant * h**order
    shuffled = random.sample(range(len(h)), len(h))
    found = grid_convergence(h[shuffled], value[shuffled], formal=order)
    # The order depends on differences of values, so round-off of the values limits its accuracy.
    lost = 1e-14 * (abs(limit) + abs(constant)) / abs(np.diff(value)[-1])
    assert found.behaviour is Behaviour.MONOTONE
    assert found.order == pytest.approx(order, abs=1e-10 + 50 * lost)
    assert found.limit == pytest.approx(limit, abs=1e-10 + 100 * lost * abs(constant))
    assert found.factor == 1.25


@LIGHT
@given(RATIOS, ORDERS, ORDERS, st.sampled_from([-2.0, 0.5]))
def test_the_uncertainty_bounds_the_true_error_for_any_formal_order(ratios, order, formal, constant):
    h = sizes(ratios)
    found = grid_convergence(h, 1 + constant * h**order, formal=formal)
    assert found.uncertainty >= abs(constant * h[-1] ** order) * (1 - 1e-6)
    assert found.factor == (1.25 if abs(order - formal) <= 0.1 * formal * (1 - 1e-6) else 3.0)


@LIGHT
@given(st.floats(1.1, 4), st.floats(1.1, 4), st.floats(-5, 8))
def test_observed_order_solves_its_equation_for_either_sign(coarse, fine, order):
    growth = (coarse**order - 1) / (1 - fine**-order) if abs(order) > 1e-3 else math.log(coarse) / math.log(fine)
    assert observed_order(coarse, fine, growth) == pytest.approx(order, abs=2e-3 if abs(order) < 1e-2 else 1e-6)


def test_a_published_example_with_unequal_ratios_is_reproduced():
    """Celik et al. 2008, table 1, reattachment length: r = 1.5, 1.333; 6.063, 5.972, 5.863 give p = 1.53, GCI = 2.2 %."""
    n = np.array([18000, 8000, 4500])
    found = grid_convergence(1 / np.sqrt(n), [6.063, 5.972, 5.863], formal=1.53)
    assert found.order == pytest.approx(1.53, abs=0.01)
    assert found.limit == pytest.approx(6.1685, abs=5e-4)
    assert found.uncertainty / 6.063 == pytest.approx(0.022, abs=5e-4)


@LIGHT
@given(RATIOS, ORDERS, st.floats(0.1, 10))
def test_norms_of_differences_give_the_order_and_bound_the_finest_error(ratios, order, size):
    h = sizes(ratios)
    found = grid_convergence_of_differences(h, size * -np.diff(h**order), formal=order)
    assert found.order == pytest.approx(order, abs=1e-8)
    assert found.uncertainty == pytest.approx(1.25 * size * h[-1] ** order, rel=1e-6)


def test_only_the_three_finest_levels_are_used():
    value = 1 + H**2
    coarse = value.copy()
    coarse[:2] = [40, -7]
    assert grid_convergence(H, coarse, formal=2) == grid_convergence(H, value, formal=2)


# Series without an order.


@pytest.mark.parametrize(
    ("value", "behaviour", "finite"),
    [
        (1 + 0.1 * (-0.3) ** np.arange(5.0), Behaviour.OSCILLATORY, True),
        (1 + 0.1 * (-1.3) ** np.arange(5.0), Behaviour.DIVERGENT, False),
        (1 + 0.1 * 1.2 ** np.arange(5.0), Behaviour.DIVERGENT, False),
        (np.arange(5.0), Behaviour.DIVERGENT, False),
        (np.ones(5), Behaviour.CONSTANT, False),
        ([1, 1.5, 1.7, 1.8, 1.8], Behaviour.CONSTANT, False),
        ([1, 2, 3, 3, 4], Behaviour.DIVERGENT, False),
        ([1, 2, 3, np.nan, 4], Behaviour.NON_FINITE, False),
        ([np.inf, 2, 3, 3, 4], Behaviour.NON_FINITE, False),
    ],
)
def test_without_monotone_convergence_there_is_no_limit_and_no_qualified_reference(value, behaviour, finite):
    found = grid_convergence(H, value, formal=2)
    assert found.behaviour is behaviour
    assert math.isnan(found.limit)
    assert math.isfinite(found.uncertainty) is finite
    reference = qualify(H, value, formal=2)
    assert not reference.qualified
    assert reference.uncertainty == math.inf
    assert reference.reason.startswith("not qualified")
    assert behaviour.value in reference.reason


def test_the_uncertainty_of_a_decreasing_oscillation_bounds_the_true_error():
    for shrinks in (0.2, 0.5, 0.9):
        value = 1 + 0.1 * (-shrinks) ** np.arange(5.0)
        assert grid_convergence(H, value, formal=2).uncertainty > abs(value[-1] - 1)


def test_two_levels_use_the_formal_order_with_the_larger_factor_and_do_not_qualify():
    found = grid_convergence(H[:2], 1 + H[:2] ** 2, formal=2)
    assert found.behaviour is Behaviour.TOO_SHORT
    assert found.uncertainty == pytest.approx(3 * H[1] ** 2)
    assert not qualify(H[:2], 1 + H[:2] ** 2, formal=2).qualified


def test_a_flat_order_or_a_size_of_zero_does_not_qualify():
    assert not qualify(H, 1 + H**0.1, formal=2).qualified
    assert not qualify(H, H**2 - H[-1] ** 2, formal=2).qualified
    assert not qualify_by_differences(H, -np.diff(H**2), formal=2, size=0.0).qualified


@pytest.mark.parametrize(
    "call",
    [
        lambda: grid_convergence([0.1], [1.0], formal=2),
        lambda: grid_convergence(H, H**2, formal=0),
        lambda: grid_convergence(H, H**2, formal=math.nan),
        lambda: grid_convergence(H, H[:3], formal=2),
        lambda: grid_convergence_of_differences(H, H, formal=2),
        lambda: grid_convergence_of_differences(H[::-1], H[1:], formal=2),
        lambda: grid_convergence_of_differences(H, -H[1:], formal=2),
        lambda: grid_convergence_of_differences([], [], formal=2),
        lambda: qualify_by_differences(H, H[1:], formal=2, size=math.nan),
        lambda: analyse(H, H**2, uncertainty=-1.0),
        lambda: analyse(H, H**2, uncertainty=math.nan),
    ],
)
def test_invalid_arguments_are_refused(call):
    with pytest.raises(UsageError):
        call()


# The judge and a reference.


def test_levels_finer_than_the_reference_are_dropped_by_name():
    error = H**2
    series = analyse(H, error, uncertainty=error[2] / 10)
    assert series.kept.tolist() == [True, True, False, False, False]
    assert series.classification is Classification.FINER_THAN_REFERENCE
    assert [sentence.split(":")[0] for sentence in series.dropped] == ["h=0.025", "h=0.0125", "h=0.00625"]
    assert all("times the uncertainty of the reference" in sentence for sentence in series.dropped)


@LIGHT
@given(st.integers(0, 5))
def test_a_pass_needs_three_levels_above_ten_times_the_uncertainty(usable):
    error = H**2
    uncertainty = (error[usable - 1] / 11) if usable else 1.0
    found, reason = verdict(H, error, band=(1.8, 2.2), uncertainty=uncertainty)
    assert found is (Verdict.PASS if usable >= 3 else Verdict.INCONCLUSIVE)
    assert ("uncertainty of the reference" in reason) is (usable < 5)


def test_nothing_passes_against_a_reference_that_is_not_qualified():
    reference = qualify(H, np.arange(5.0), formal=2)
    assert verdict(H, H**2, band=(1.8, 2.2), uncertainty=reference.uncertainty)[0] is Verdict.INCONCLUSIVE


# A finite element reference that qualifies on its own ladder is checked against the closed form.

BAR = axial_vibration(v0=1e-3)
CELLS = (8, 16, 32, 64)
POINTS = np.linspace(0, BAR.problem.lengths[0], 41)[1:-1]


def profile(solver, cells, quantity):
    """A field at the final time at fixed points, by quintic splines, whose error is small against that of the scheme."""
    from scipy.interpolate import make_interp_spline

    solution = solver.solve(BAR.problem, Discretisation(BAR.problem.lengths[0] / cells, 0.5))
    assert solution.outcome.completed
    order = np.argsort(solution.reference[:, 0])
    return make_interp_spline(solution.reference[order, 0], solution.fields[quantity][-1, order, 0], k=5)(POINTS)


def rms(values):
    return float(np.sqrt(np.mean(values**2)))


def steps(fields):
    return [rms(fine - coarse) for coarse, fine in itertools.pairwise(fields)]


@pytest.fixture(scope="module")
def ladder():
    solver = FiniteElement(2, "consistent", "newmark")
    return {quantity: [profile(solver, cells, quantity) for cells in CELLS] for quantity in ("displacement", "velocity")}


def exact(quantity):
    return BAR.exact.fields[quantity](POINTS[:, None], np.array([BAR.problem.end_time]))[0, :, 0]


@pytest.mark.parametrize("quantity", ["displacement", "velocity"])
def test_the_uncertainty_of_the_finite_element_reference_bounds_its_true_error(ladder, quantity):
    """P2 elements with Newmark at dt ~ h are of second order, by the time integration."""
    fields = ladder[quantity]
    reference = qualify_by_differences(1 / np.array(CELLS), steps(fields), formal=2.0, size=rms(fields[-1]))
    assert reference.qualified
    assert reference.convergence.factor == 1.25
    true = rms(fields[-1] - exact(quantity)) / rms(exact(quantity))
    assert true <= reference.uncertainty <= 1.6 * true


def test_the_uncertainty_of_a_scalar_reference_bounds_its_true_error(ladder):
    size = [rms(field) for field in ladder["displacement"]]
    reference = qualify(1 / np.array(CELLS), size, formal=2.0)
    assert reference.qualified
    true = abs(size[-1] / rms(exact("displacement")) - 1)
    assert true <= reference.uncertainty <= 1.6 * true


def test_verdicts_against_the_reference_and_against_the_closed_form_agree(ladder):
    solver = FiniteElement(1, "lumped", "newmark")
    cells = np.array([4, 8, 16, 32, 64])
    fields = [profile(solver, count, "displacement") for count in cells]
    finest, truth = ladder["displacement"][-1], exact("displacement")
    reference = qualify_by_differences(1 / np.array(CELLS), steps(ladder["displacement"]), formal=2.0, size=rms(finest))
    error = [rms(field - finest) / rms(finest) for field in fields]
    known = [rms(field - truth) / rms(truth) for field in fields]
    series = analyse(1 / cells, error, uncertainty=reference.uncertainty)
    assert 3 <= series.kept.sum() < len(cells), "the reference tells the coarse levels and not the finest"
    np.testing.assert_allclose(series.error[series.kept], np.array(known)[series.kept], rtol=0.1)
    np.testing.assert_array_equal(series.kept, series.error > 10 * reference.uncertainty)
    judged = verdict(1 / cells, error, band=(1.8, 2.2), uncertainty=reference.uncertainty)
    assert judged[0] is verdict(1 / cells, known, band=(1.8, 2.2))[0] is Verdict.PASS, judged[1]
