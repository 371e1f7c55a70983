"""Criteria, and evidence of made-up series that they judge."""

import math

import numpy as np
from hypothesis import settings

from mpmverify.convergence.verdict import Verdict
from mpmverify.criteria import (
    AmplitudeDecay,
    Dispersion,
    FieldSums,
    FrontPosition,
    Order,
    PhaseError,
    Published,
    Reproduced,
    Separated,
    StabilityLimit,
    Stall,
    Unstable,
)
from mpmverify.criteria.evidence import Evidence
from mpmverify.criteria.norms import NORMS
from mpmverify.judgement.findings import judge_criterion

LIGHT = settings(max_examples=25)
H = 0.5 ** np.arange(3.0, 8.0)
PASS, INCONCLUSIVE, FAIL, ERROR = Verdict.PASS, Verdict.INCONCLUSIVE, Verdict.FAIL, Verdict.ERROR
STALL = Stall("u", "L2", 0.5, 0.05, 20.0, "theory")
ORDER = Order("u", "L2", 1.8, 2.2, "theory")
PATCH = Reproduced("stress", 7.0, 1e-12, "theory")
OFF = Reproduced("stress", 7.0, 0.4, "theory", low=0.2, inside=0.5)
PUBLISHED = Published("u", "L2", tuple((float(h), float(f"{3 * h**2:.2e}")) for h in H), 3, "paper")
DISPERSION = Dispersion("tg-lumped", "u", 2.0, 1e-10, "theory")
PHASE = PhaseError("u", 2, 0.2, "theory", "tg-consistent-3", 72.0)  # at nu_C = 1/2 the wave is ahead by theta^2/24
DECAY = AmplitudeDecay("u", 3, 0.2, "theory", "tg-lumped", 64.0)  # at nu_C = 1/2 it loses 3/64 nu_C theta^4 in each step
LOSSLESS = AmplitudeDecay("u", 3, 0.2, "theory", "fem-p1-lumped-cd", 1.0)  # central differences lose nothing
FRONT = FrontPosition("u", "tg-lumped", 0.1, "theory")
SUMS = FieldSums(("mass", "momentum"), "theory")
UNSTABLE, GREW = Unstable(0.4, "theory"), ("unstable; at step 3 of 9; the solution grew",)
LIMIT = StabilityLimit("mpm-tl-linear-usl-flip", 0.01, "theory")
SEPARATED = Separated("u", "L2", (("h", 1.8, 2.2), ("dt", 0.8, 1.2)), "theory")
DESIGN_H, DESIGN_DT = (grid.ravel() for grid in np.meshgrid(H[:4], H[:4] / 2, indexing="ij"))
METRICS = (
    "momentum_defect",
    "mass_defect",
    "momentum_error",
    "mass_sum_defect",
    "momentum_sum_defect",
    "energy_drift",
    "energy_rise",
    "amplification_defect",
    "amplification_modes",
    *DISPERSION.metrics,
    *FRONT.metrics,
)


def series(error, h=H, *, reference=1.0, outcomes=None, quantity="u", metrics=None, **columns) -> Evidence:
    """Evidence with the same error in every norm."""
    error, h = np.asarray(error, dtype=float), np.asarray(h, dtype=float)
    table = np.repeat(error[:, None], len(NORMS), axis=1)
    size = np.broadcast_to(np.asarray(reference, dtype=float), h.shape)[:, None] * np.ones(len(NORMS))
    values = {name: np.asarray(value, dtype=float) for name, value in (metrics or {}).items()}
    one = np.ones(len(h))
    columns = {"dt": h / 2, "courant": one / 2, "ppc": one.astype(int)} | columns
    outcomes = ("completed",) * len(h) if outcomes is None else outcomes
    return Evidence(h, outcomes=outcomes, error={quantity: table}, reference={quantity: size}, metrics=values, **columns)


def limits(ratio) -> dict[str, np.ndarray]:
    """Metrics of a stability limit at a given ratio to the theoretical limit sqrt(1/2)."""
    theory = np.full(len(H), math.sqrt(0.5))
    return {"stability_limit": ratio * theory, "theoretical_stability_limit": theory}


def over_design(error, **columns) -> Evidence:
    return series(error, DESIGN_H, **({"dt": DESIGN_DT} | columns))


def falling(*orders) -> Evidence:
    """Evidence with the given observed orders, on halved sizes."""
    steps = np.arange(len(orders) + 1.0)
    return series(0.1 * 0.5 ** np.cumsum([0.0, *orders]), 0.5**steps)


def measured(**metrics) -> Evidence:
    return series(H**2, metrics=metrics)


def verdict(criterion, evidence) -> Verdict:
    found, reason = judge_criterion(criterion, evidence)
    assert reason
    return found


# Examples: criterion, evidence, expected verdict.

ONES = np.ones(5)
