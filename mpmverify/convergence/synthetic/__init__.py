"""Random error series of known truth, and the rates of right and wrong verdicts on them."""

from mpmverify.convergence.synthetic.designs import measure_designs
from mpmverify.convergence.synthetic.ideal import ideal_rates
from mpmverify.convergence.synthetic.kinds import KINDS, Kind, RandomSeries, Truth, draw_series
from mpmverify.convergence.synthetic.rates import Rate, measure, measure_limits, total

__all__ = [
    "KINDS",
    "Kind",
    "RandomSeries",
    "Rate",
    "Truth",
    "draw_series",
    "ideal_rates",
    "measure",
    "measure_designs",
    "measure_limits",
    "total",
]
