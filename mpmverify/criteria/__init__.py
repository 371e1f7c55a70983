"""Criteria: what a study may demand of a series, each with its own failure sentence."""

from collections.abc import Mapping
from typing import Any

from mpmverify.criteria.errors import Exact, Order, Published, Stall
from mpmverify.criteria.histories import Balance, EnergyConserved, EnergyDrift
from mpmverify.criteria.modes import Amplification
from mpmverify.criteria.sources import Separated
from mpmverify.criteria.waves import AmplitudeDecay, Dispersion, FrontPosition, PhaseError

__all__ = [
    "CRITERIA",
    "Amplification",
    "AmplitudeDecay",
    "Balance",
    "Dispersion",
    "EnergyConserved",
    "EnergyDrift",
    "Exact",
    "FrontPosition",
    "Order",
    "PhaseError",
    "Published",
    "Separated",
    "Stall",
]

CRITERIA: Mapping[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        Order,
        Stall,
        Exact,
        Published,
        Separated,
        Balance,
        EnergyDrift,
        EnergyConserved,
        Amplification,
        Dispersion,
        PhaseError,
        AmplitudeDecay,
        FrontPosition,
    )
}
"""Criteria by the name under which files store them."""
