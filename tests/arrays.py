"""Comparison of whole arrays at once: `pytest.approx` compares them in a loop of Python, some microseconds a number."""

import numpy as np


def assert_close(found, expected, *, rel=0.0, abs=0.0, said=""):
    """Assert |found - expected| <= abs + rel |expected|, with equal shapes unless one is a number; NaN equals nothing.

    With one of the two tolerances it asks as much as `pytest.approx` with that one, or more where the expected value is nearly zero.
    """
    np.testing.assert_allclose(found, expected, rtol=rel, atol=abs, equal_nan=False, err_msg=said)


def assert_times_are_independent(field, X, t, k):
    """Assert that `field(X, t)` at its time k is what the field gives at that time alone.

    They agree to round-off: how a processor adds and multiplies may depend on the length of an array.
    """
    whole = field(X, t)
    assert_close(field(X, t[[k]]), whole[[k]], abs=16 * np.finfo(float).eps * np.max(np.abs(whole)))
