"""Comparison of whole arrays at once: `pytest.approx` compares them in a loop of Python, some microseconds a number."""

import numpy as np


def assert_close(found, expected, *, rel=0.0, abs=0.0, said=""):
    """Assert |found - expected| <= abs + rel |expected|, with equal shapes unless one is a number; NaN equals nothing.

    With one of the two tolerances it asks as much as `pytest.approx` with that one, or more where the expected value is nearly zero.
    """
    np.testing.assert_allclose(found, expected, rtol=rel, atol=abs, equal_nan=False, err_msg=said)
