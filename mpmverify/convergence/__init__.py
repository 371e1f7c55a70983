"""From error series to verdict: takes plain arrays from any code, returns an order with its confidence interval and a verdict.

Here belong fits, the classification of series, grid convergence indices, the separation of error sources, tables of errors, and
random series of known truth that measure how often verdicts are right. Nothing here knows solvers, problems or results files.
"""

from mpmverify.convergence.fits import CONFIDENCE, Fit, FloorFit, fit_floor, fit_order, pairwise_orders
from mpmverify.convergence.gci import Behaviour, GridConvergence, grid_convergence, grid_convergence_of_differences
from mpmverify.convergence.grid_levels import GridLevel, grid_levels
from mpmverify.convergence.order_verdict import PLAUSIBLE, judge_order, verdict
from mpmverify.convergence.reference import Reference, qualify, qualify_by_differences
from mpmverify.convergence.series import FLAT, ROUND_OFF, Classification, Convergence, analyse
from mpmverify.convergence.table import Table, read_table

__all__ = [
    "CONFIDENCE",
    "FLAT",
    "PLAUSIBLE",
    "ROUND_OFF",
    "Behaviour",
    "Classification",
    "Convergence",
    "Fit",
    "FloorFit",
    "GridConvergence",
    "GridLevel",
    "Reference",
    "Table",
    "analyse",
    "fit_floor",
    "fit_order",
    "grid_convergence",
    "grid_convergence_of_differences",
    "grid_levels",
    "judge_order",
    "pairwise_orders",
    "qualify",
    "qualify_by_differences",
    "read_table",
    "verdict",
]
