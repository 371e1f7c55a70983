"""Published tables of errors are judged as their authors and theory say.

All numbers are from the pages that are named; nothing else is taken from them.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from mpmverify.convergence import analyse, verdict

STEP_7 = "deal.II, tutorial step-7, results"
STEP_51 = "deal.II, tutorial step-51, results"
STEP_85 = "deal.II, tutorial step-85, results"
DOLFIN = "DOLFIN 2018.1.0, bench/fem/convergence/cpp/README"
PERIDYNAMICS = "J. Burkardt, peridynamics_1d_steady, output of problem 4"
PFHUB = "gist.github.com/wd15/b51c1b74ad2f82e5422ae15c8e5a7356, a time step study"

HALVED = 2.0 ** -np.arange(10)
HDG = 1 / np.array([4, 6, 8, 12, 16, 24, 32, 48, 64, 96])
HDG_3D = 1 / np.array([2, 3, 4, 6, 8, 12, 16, 24, 32, 48])


@dataclass(frozen=True)
class Published:
    """A column of a table.

    Parameters
    ----------
    source, what : str
    h : array
        Sizes, as far as the table goes.
    error : tuple of float
    passes, fails : (float, float)
        A band in which the series must pass, and one in which it must fail; () for none.
    least_rough : int
        Least number of coarse levels that are dropped.
    """

    source: str
    what: str
    h: np.ndarray
    error: tuple[float, ...]
    passes: tuple[float, ...]
    fails: tuple[float, ...]
    least_rough: int = 0


TABLES = [
    Published(STEP_7, "Q1, L2", HALVED, (1.84, 3.57e-2, 1.192e-2, 3.047e-3, 7.66e-4), (1.8, 2.2), (2.5, 3.5), 1),
    Published(STEP_7, "Q1, H1", HALVED, (2.858, 1.199, 0.7565, 0.3823, 0.1917), (0.8, 1.2), (1.5, 2.5), 1),
    Published(STEP_7, "Q1, maximum", HALVED, (1.835, 0.1307, 7.168e-2, 2.128e-2, 5.554e-3), (1.25, 2.5), (2.5, 3.5), 1),
    Published(STEP_7, "Q2, L2", HALVED, (0.1606, 7.638e-3, 8.601e-4, 1.107e-4, 1.393e-5), (2.7, 3.3), (1.5, 2.5)),
    Published(STEP_7, "Q2, H1", HALVED, (1.278, 0.5248, 0.1086, 2.756e-2, 6.915e-3), (1.8, 2.2), (0.5, 1.5), 1),
    Published(
        STEP_51,
        "Q1, val",
        HDG,
        (18.04, 6.125, 0.9785, 0.273, 0.1493, 6.965e-2, 4.018e-2, 1.831e-2, 1.043e-2, 4.69e-3),
        (1.8, 2.2),
        (2.2, 12),
        2,
    ),
    Published(
        STEP_51,
        "Q1, grad",
        HDG,
        (22.07, 9.472, 4.26, 1.866, 1.046, 0.4846, 0.2784, 0.1264, 7.185e-2, 3.228e-2),
        (1.8, 2.2),
        (0.5, 1.5),
    ),
    Published(
        STEP_51,
        "Q1, post-processed",
        HDG,
        (17.98, 6.084, 0.7102, 6.115e-2, 2.88e-2, 9.204e-3, 4.027e-3, 1.236e-3, 5.306e-4, 1.599e-4),
        (2.7, 3.3),
        (1.8, 2.2),
        2,
    ),
    Published(
        STEP_51,
        "Q3, val",
        HDG,
        (0.3613, 6.411e-2, 3.48e-2, 8.297e-3, 2.254e-3, 4.558e-4, 1.471e-4, 2.956e-5, 9.428e-6, 1.876e-6),
        (3.8, 4.2),
        (2.8, 3.2),
        3,
    ),
    Published(
        STEP_51,
        "Q3, post-processed",
        HDG,
        (0.302, 3.238e-2, 5.277e-3, 6.33e-4, 1.403e-4, 1.844e-5, 4.378e-6, 5.75e-7, 1.362e-7, 1.788e-8),
        (4.8, 5.2),
        (3.8, 4.2),
    ),
    Published(
        STEP_51,
        "Q1 in three dimensions, val",
        HDG_3D,
        (7.122, 5.491, 3.646, 1.595, 0.6922, 0.2915, 0.1684, 7.972e-2, 4.637e-2, 2.133e-2),
        (1.7, 2.2),
        (2.2, 3.2),
        2,
    ),
    Published(
        STEP_51,
        "Q3 in three dimensions, val",
        HDG_3D,
        (5.67, 1.048, 0.2831, 7.883e-2, 3.642e-2, 8.546e-3, 2.598e-3, 5.314e-4, 1.723e-4, 3.482e-5),
        (3.6, 4.3),
        (2.7, 3.3),
        4,
    ),
    Published(
        STEP_85,
        "L2",
        np.array([0.3025, 0.1513, 0.0756, 0.0378]),
        (8.0657e-2, 1.8711e-2, 4.1624e-3, 9.3979e-4),
        (1.8, 2.4),
        (2.5, 3.5),
    ),
    Published(DOLFIN, "degree 1, two dimensions", HALVED, (0.3831, 0.1375, 3.748e-2), (), (3, 4)),
    Published(PERIDYNAMICS, "L2", HALVED, (2.3766e-2, 1.6805e-2, 1.1883e-2, 8.4024e-3, 5.9414e-3), (0.4, 0.6), (0.8, 1.2)),
    Published(PERIDYNAMICS, "H1", HALVED, (1.1497, 1.4641, 1.946, 2.6597, 3.6943), (), (0.25, 12)),
    Published(
        PFHUB,
        "L2",
        0.6 ** np.arange(7),
        (2.546636e-4, 2.50022e-4, 2.453652e-4, 2.448922e-4, 2.447349e-4, 2.451709e-4, 2.456623e-4),
        (),
        (0.8, 2.2),
    ),
]


@pytest.mark.parametrize("table", TABLES, ids=lambda table: f"{table.source}: {table.what}")
def test_a_published_table_passes_where_its_order_is_expected_and_fails_where_another_is(table):
    h = table.h[: len(table.error)]
    for band, right in ((table.passes, "PASS"), (table.fails, "FAIL")):
        if band:
            found, reason = verdict(h, table.error, band=band)
            assert found == right, reason
    dropped = analyse(h, table.error).dropped
    assert len(dropped) >= table.least_rough, dropped


@pytest.mark.parametrize("low", [2.0, 2.1, 2.5])
def test_rough_levels_do_not_bend_a_published_slope_into_a_band(low):
    val = next(table for table in TABLES if (table.source, table.what) == (STEP_51, "Q1, val"))
    assert verdict(val.h, val.error, band=(low, 12))[0] != "PASS"


def test_two_rough_levels_are_dropped_by_name():
    h = 2.0 ** -np.arange(8)
    error = h**2 * [20, 8, 1, 1, 1, 1, 1, 1]
    found, reason = verdict(h, error, band=(1.8, 2.2))
    assert found == "PASS"
    assert reason.startswith("order 2.000")
    assert "h=1: pre-asymptotic (20 times what the finer levels predict); h=0.5: pre-asymptotic (8 times" in reason


@pytest.mark.parametrize("error", [0.0699, 0.131, 1e-3])
def test_a_constant_error_is_stagnant(error):
    for band in ((1.8, 2.2), None):
        found, reason = verdict([1, 0.5, 0.25, 0.125], [error] * 4, band=band)
        assert found == "FAIL"
        assert "(stagnant)" in reason
