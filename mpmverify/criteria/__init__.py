"""Criteria that a study declares for a series, the quantities that they measure on a solution, and the sentences of their verdicts.

Here belong error norms (`norms`), measurements on waves, conservation in histories (`histories`), the evidence that is collected from
runs, and the criteria that judge it. To add a criterion, write its class in the module of what it measures and enter it in `CRITERIA`
below. Verdicts on a whole study are made in `judgement`.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.energies import EnergyConserved, EnergyDecays, EnergyDrift
from mpmverify.criteria.errors import Exact, Order, Published, Reproduced, Size, Stall
from mpmverify.criteria.evidence import SeriesId
from mpmverify.criteria.field_sums import FieldSums
from mpmverify.criteria.histories import Balance, ExactTotal
from mpmverify.criteria.modes import Amplification
from mpmverify.criteria.outcomes import Unstable
from mpmverify.criteria.sources import Separated
from mpmverify.criteria.stability import StabilityLimit
from mpmverify.criteria.waves import AmplitudeDecay, Dispersion, FrontPosition, PhaseError
from mpmverify.errors import UsageError

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
    "ExactTotal",
    "FieldSums",
    "FrontPosition",
    "Order",
    "PhaseError",
    "Published",
    "Reproduced",
    "Separated",
    "Size",
    "StabilityLimit",
    "Stall",
    "Unstable",
    "check_storable",
]

CRITERIA: Mapping[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        Order,
        Size,
        Stall,
        Exact,
        Published,
        Reproduced,
        Separated,
        Balance,
        ExactTotal,
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


def check_storable(study: str, declared: Mapping[SeriesId, Sequence[Criterion]]) -> None:
    """Refuse criteria that a file does not give back: they are stored by the name of their class.

    Raises
    ------
    UsageError
        If a criterion is not of a class in `CRITERIA`.
    """
    for series, criteria in declared.items():
        for criterion in criteria:
            kind = type(criterion)
            if CRITERIA.get(kind.__name__) is not kind:
                raise UsageError(
                    f"the criterion {kind.__name__!r} of {study}/{series.case} is not one of mpmverify.criteria and cannot be stored: "
                    f"choose from {', '.join(CRITERIA)}, or judge it with the fixture `verify`"
                )
