"""Criterion on the sources of an error, separated over a design of runs."""

from dataclasses import dataclass

import numpy as np

from mpmverify.convergence.axis import UNITS
from mpmverify.convergence.sources import Separation, judge_sources
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.criteria.errors import ErrorCriterion
from mpmverify.criteria.evidence import Evidence
from mpmverify.errors import UsageError

NORMS = ("L2", "L2-max")
"""Norms in which error fields add like vectors."""


@dataclass(frozen=True)
class Separated(ErrorCriterion):
    """The exponent of every source of an error lies in its band.

    Parameters
    ----------
    quantity, norm : str
        The norm is one of `NORMS`.
    bands : tuple of (size, low, high)
        Accepted band of each exponent, by the size with which the source vanishes: "h", "dt", "1/ppc" or "h/ppc". Other sizes that the
        runs vary are fitted as sources, but not judged.
    source : str

    Raises
    ------
    UsageError
        If the norm is not in `NORMS`, a size is unknown, or no band is given.
    """

    quantity: str
    norm: str
    bands: tuple[tuple[str, float, float], ...]
    source: str

    def __post_init__(self) -> None:
        if self.norm not in NORMS:
            raise UsageError(f"sources of error cannot be separated in the norm {self.norm!r}: choose {' or '.join(NORMS)}")
        if not self.bands or any(size not in UNITS for size, _, _ in self.bands):
            raise UsageError(f"the sources of an error need bands by size: choose from {', '.join(UNITS)}")

    @property
    def title(self) -> str:
        bands = ", ".join(f"{size} in [{low:g}, {high:g}]" for size, low, high in self.bands)
        return f"exponents of the sources of {self.quantity} in {self.norm}: {bands}"

    def separation(self, evidence: Evidence) -> Separation:
        """Separate the judged sources and those of all other sizes that the runs vary."""
        varied = list(evidence.axis.varied)
        declared = [size for size, _, _ in self.bands]
        if "h/ppc" in declared and "1/ppc" in varied:
            varied.remove("1/ppc")
        return evidence.separation(tuple(dict.fromkeys(declared + varied)), self.quantity, self.norm)

    def judge(self, evidence: Evidence) -> Judgement:
        if not np.all(np.isfinite(evidence.relative(self.quantity, self.norm))):
            return Verdict.ERROR, "the error is not finite on at least one level"
        return judge_sources(self.separation(evidence), self.bands)
