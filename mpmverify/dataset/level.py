"""What a study keeps of one run beside its file."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mpmverify.problem import Array

SeriesId = tuple[str, str, str]
"""(case, solver, refinement)."""


@dataclass(frozen=True)
class Level:
    """What is kept of one run beside its file: where it stands in the study, its errors and its metrics."""

    case: str
    solver: str
    refinement: str
    h: float
    courant: float
    ppc: int
    key: str
    jitter: float = 0.0
    seed: int = 0
    dt: float = np.nan
    steps: int = 0
    point_steps: int = 0
    seconds: float = 0.0
    outcome: str = "completed"
    errors: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)

    @property
    def series(self) -> SeriesId:
        return self.case, self.solver, self.refinement


@dataclass(frozen=True)
class Snapshots:
    """Profiles and histories of one run of a series: T times, P points, N samples of the histories."""

    case: str
    refinement: str
    h: float
    time: Array
    reference: Array
    position: Array
    fields: Mapping[str, Array]
    exact: Mapping[str, Array]
    histories: Mapping[str, Array]
