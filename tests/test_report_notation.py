"""Numbers, intervals and formulas in the words of a page."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.reports.equations import mathml
from mpmverify.reports.notation import DASH, cell_size, interval, number, slugs, typeset_numbers


@given(st.floats(min_value=1e-30, max_value=1e30), st.booleans())
def test_numbers_read_back_to_three_digits(size: float, negative: bool) -> None:
    value = -size if negative else size
    text = number(value)
    assert "-" not in text
    back = text.replace("−", "-").translate(str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")).replace("×10", "e")
    assert float(back) == pytest.approx(value, rel=0.006)


def test_numbers_in_a_text_are_typeset() -> None:
    assert typeset_numbers("E = 1e+07 Pa, a = -2.5e-06 m/s on [-1, 2] m") == "E = 1×10⁷ Pa, a = −2.5×10⁻⁶ m/s on [−1, 2] m"
    assert typeset_numbers("neo-Hookean, mass-1e5, 3e, x1e5") == "neo-Hookean, mass-1e5, 3e, x1e5"


def test_notation() -> None:
    assert number(0.0) == "0"
    assert number(math.nan) == number(math.inf) == interval(1.0, math.inf) == DASH
    assert number(-1.234e-5) == "−1.23×10⁻⁵"
    assert number(0.012345) == "0.0123"
    assert [cell_size(h) for h in (1 / 64, 0.09765625, 1.0, 2.5)] == ["1/64", "0.09766", "1", "2.5"]
    assert interval(-0.5, 1.0) == "[−0.50, 1.00]"
    assert slugs(["a b", "a-b", "?"]) == {"a b": "a-b", "a-b": "a-b-2", "?": "x"}


@pytest.mark.parametrize("latex", [r"\frac{", r"\text{<script>1</script>}", r"\text{<a href='x'>y</a>}", ""])
def test_invalid_formulas_are_shown_as_code(latex: str) -> None:
    assert mathml(latex).startswith("<code>")
    assert "<script>" not in mathml(latex)


def test_formulas_become_mathml() -> None:
    assert mathml(r"\frac{a}{b}").startswith("<math")
