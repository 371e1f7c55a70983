"""Runs and studies to be stored, and the comparison of arrays bit for bit."""

import dataclasses

import numpy as np
import xarray as xr
from faulty_solvers import Scripted, study, transported

from mpmverify.criteria import (
    Amplification,
    Balance,
    EnergyDrift,
    Exact,
    FieldSums,
    Order,
    Published,
    Separated,
    Stall,
)
from mpmverify.dataset.runs import Run
from mpmverify.exact.advection import Gaussian, advection
from mpmverify.problem import (
    Discretisation,
)

EXTREME = np.array([-0.0, 5e-324, np.nan, np.inf, -np.inf, 1 / 3, 9.969209968386869e36, 1e308])
"""Floats that are easily changed by a round trip; 9.97e36 is the fill value of netCDF."""


def solution(**changes):
    made = transported(advection(Gaussian()).problem, Discretisation(h=1 / len(EXTREME), courant=0.5), 0.01)
    return dataclasses.replace(made, **changes)


def run_of(made, **measured):
    return Run(made, **{"errors": {}, "metrics": {}, "shown": True} | measured)


def bits(arrays):
    return {name: (values.shape, values.tobytes()) for name, values in arrays.items()}


def tree_of(path):
    """File of a study as xarray reads it."""
    with xr.open_datatree(path) as tree:
        return tree.load()


# One study.

MIXED = study(Scripted("good"), Scripted("unstable", below=0.1), Scripted("raises", below=0.04), name="mixed")


CRITERION_OF_EACH_KIND = (
    Order("u", "L2", 1.8, 2.2, 'a "source", é'),
    Stall("u", "L1", 0.5, 0.01, 0.9, "s"),
    Exact("u", "L2-max", 1e-12, "s"),
    Published("u", "L2", ((1 / 8, 4.471e-3), (1 / 3, 0.1 + 0.2)), 3, "s"),
    Separated("u", "L2", (("h", 1.8, 2.2), ("h/ppc", 1 / 3, 0.1 + 0.2)), "s"),
    Balance("mass", "", "s"),
    EnergyDrift(1.8, "s"),
    FieldSums(("mass", "momentum"), "s"),
    Amplification(3, 1e-12, "s"),
)
