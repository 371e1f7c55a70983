"""Random error series of known truth, and how often the judge is right about them."""

from mpmverify.convergence.synthetic.designs import measure_designs
from mpmverify.convergence.synthetic.kinds import KINDS, Kind, Specimen, Truth, specimen
from mpmverify.convergence.synthetic.rates import Rate, measure, measure_limits, total

__all__ = ["KINDS", "Kind", "Rate", "Specimen", "Truth", "measure", "measure_designs", "measure_limits", "specimen", "total"]
