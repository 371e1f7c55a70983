"""Criteria that a study declares for a series, the quantities that they measure on a solution, and the sentences of their verdicts.

Here belong error norms (`norms`), measurements on waves, conservation in histories (`histories`), the evidence that is collected from
runs, and the criteria that judge it. To add a criterion, write its class in the module of what it measures and enter it in `CRITERIA`
below. Verdicts on a whole study are made in `judgement`.
"""

from collections.abc import Mapping
from typing import Any

from mpmverify.criteria.errors import Exact, Order, Published, Stall
from mpmverify.criteria.field_sums import FieldSums
from mpmverify.criteria.histories import Balance, EnergyConserved, EnergyDecays, EnergyDrift
from mpmverify.criteria.modes import Amplification
from mpmverify.criteria.outcomes import Unstable
from mpmverify.criteria.sources import Separated
from mpmverify.criteria.stability import StabilityLimit
from mpmverify.criteria.waves import AmplitudeDecay, Dispersion, FrontPosition, PhaseError

__all__ = [
    "CRITERIA",
    "Amplification",
    "AmplitudeDecay",
    "Balance",
    "Dispersion",
    "EnergyConserved",
    "EnergyDecays",
    "EnergyDrift",
    "Exact",
    "FieldSums",
    "FrontPosition",
    "Order",
    "PhaseError",
    "Published",
    "Separated",
    "StabilityLimit",
    "Stall",
    "Unstable",
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
        FieldSums,
        EnergyDrift,
        EnergyConserved,
        EnergyDecays,
        Unstable,
        StabilityLimit,
        Amplification,
        Dispersion,
        PhaseError,
        AmplitudeDecay,
        FrontPosition,
    )
}
"""Criteria by name, as stored in results files."""
