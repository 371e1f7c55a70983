"""The order that regularity allows: its limits, the orders that finite-difference schemes show, and the bands of the studies."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify import studies
from mpmverify.criteria import Order
from mpmverify.exact.advection import CosineHill, FourierMode, Step
from mpmverify.exact.regularity import expected_order

orders = st.floats(1, 6)
norms = st.sampled_from(["L1", "L2", "Linf"])


@given(orders, norms)
def test_smooth_data_have_the_formal_order(formal, norm):
    assert expected_order(formal, math.inf, norm) == formal
    assert expected_order(formal, formal + 3, norm) == formal


@given(orders, norms, st.floats(1, 8), st.floats(0, 3))
def test_neither_more_derivatives_nor_a_better_scheme_lowers_the_order(formal, norm, derivatives, more):
    order = expected_order(formal, derivatives, norm)
    assert order <= min(formal, derivatives)
    assert expected_order(formal, derivatives + more, norm) >= order - 1e-12
    assert expected_order(formal + more, derivatives, norm) >= order - 1e-12
    assert expected_order(formal, derivatives, "L1") >= expected_order(formal, derivatives, "L2") >= 0


@pytest.mark.parametrize(
    ("formal", "derivatives", "norm", "order"),
    [
        (1, Step.derivatives, "L1", 1 / 2),
        (1, Step.derivatives, "L2", 1 / 4),
        (2, Step.derivatives, "L2", 1 / 3),
        (2, 2, "L1", 4 / 3),
        (2, 2, "L2", 1),
        (2, CosineHill.derivatives, "L2", 5 / 3),
        (2, FourierMode.derivatives, "L2", 2),
    ],
)
def test_known_orders(formal, derivatives, norm, order):
    assert expected_order(formal, derivatives, norm) == pytest.approx(order)


@pytest.mark.parametrize(("formal", "profile"), [(1, "jump"), (1, "kink"), (2, "jump"), (2, "kink"), (2, "second derivative")])
def test_upwind_and_lax_wendroff_schemes_have_the_expected_order_in_l2(formal, profile):
    """The profile goes once around a ring of up to 2^15 cells, by the amplification factors, and must return to its initial values."""
    derivatives = {"jump": 1, "kink": 2, "second derivative": 3}[profile]
    shape = {
        "jump": lambda x: np.where(np.abs(x - 0.5) < 0.2503, 1.0, 0.0),
        "kink": lambda x: np.maximum(0.2503 - np.abs(x - 0.5), 0),
        "second derivative": CosineHill(width=0.2503),
    }[profile]
    errors, cells, nu = [], 2 ** np.arange(9, 16), 0.5
    for n in cells:
        u, theta = shape(np.arange(n) / n), 2 * np.pi * np.arange(n // 2 + 1) / n
        difference = 1 - np.exp(-1j * theta)
        factor = 1 - nu * difference if formal == 1 else 1 - 1j * nu * np.sin(theta) - nu**2 * (1 - np.cos(theta))
        carried = np.fft.irfft(np.fft.rfft(u) * factor ** round(n / nu), n)
        errors.append(np.sqrt(np.mean((carried - u) ** 2)))
    measured = -np.polyfit(np.log(cells[3:]), np.log(errors[3:]), 1)[0]
    assert measured == pytest.approx(expected_order(formal, derivatives, "L2"), abs=0.05)


def declared():
    for name in studies.NAMES:
        for case, series in studies.get(name).series():
            for criterion in series.criteria:
                # The displacement is an integral and has one derivative more.
                derivatives = case.problem.exact.derivatives + (getattr(criterion, "quantity", "") == "displacement")
                if isinstance(criterion, Order) and math.isfinite(derivatives):
                    formal = series.solver.orders[criterion.quantity]
                    yield pytest.param(
                        criterion, formal, derivatives, id=f"{name}-{case.name}-{series.solver.name}-{criterion.quantity}"
                    )


@pytest.mark.parametrize(("criterion", "formal", "derivatives"), list(declared()))
def test_the_bands_of_the_studies_contain_the_order_that_regularity_allows(criterion, formal, derivatives):
    """Tests the bands of all solutions that are not smooth, with the formal order that the solver declares."""
    assert criterion.low <= expected_order(formal, derivatives, criterion.norm) <= criterion.high
