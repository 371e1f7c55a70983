"""Criterion on the sources of an error, told apart over a design of runs."""

from dataclasses import dataclass

import numpy as np

from mpmverify.axis import UNITS
from mpmverify.criteria.errors import OfErrors
from mpmverify.errors import UsageError
from mpmverify.gate import Evidence, Judgement, Verdict
from mpmverify.separation import Separation, Source, separate

NORMS = ("L2", "L2-max")
"""Norms in which error fields add as vectors do."""


@dataclass(frozen=True)
class Separated(OfErrors):
    """The exponent of every source of an error lies in its band.

    Parameters
    ----------
    quantity, norm : str
        The norm is one of `NORMS`.
    bands : tuple of (size, low, high)
        Accepted band of each exponent, by the size that the source vanishes with: "h", "dt", "1/ppc" or "h/ppc". What the runs
        vary beside these is a source too, and not judged.
    source : str

    Raises
    ------
    UsageError
        If the norm or a size is not one of these, or no band is given.
    """

    quantity: str
    norm: str
    bands: tuple[tuple[str, float, float], ...]
    source: str

    def __post_init__(self) -> None:
        if self.norm not in NORMS:
            raise UsageError(f"sources of error are told apart in {' or '.join(NORMS)}, not in {self.norm!r}")
        if not self.bands or any(size not in UNITS for size, _, _ in self.bands):
            raise UsageError(f"the sources of an error need bands by size: choose from {', '.join(UNITS)}")

    @property
    def title(self) -> str:
        bands = ", ".join(f"{size} in [{low:g}, {high:g}]" for size, low, high in self.bands)
        return f"exponents of the sources of {self.quantity} in {self.norm}: {bands}"

    def separation(self, evidence: Evidence) -> Separation:
        """Tell the sources apart: those that are judged, and what the runs vary beside them."""
        table, varied = evidence.sizes, list(evidence.axis.varied)
        declared = [size for size, _, _ in self.bands]
        if "h/ppc" in declared and "1/ppc" in varied:
            varied.remove("1/ppc")
        return separate(
            {size: table[size] for size in dict.fromkeys(declared + varied)}, evidence.relative(self.quantity, self.norm)
        )

    def judge(self, evidence: Evidence) -> Judgement:
        if not np.all(np.isfinite(evidence.relative(self.quantity, self.norm))):
            return Verdict.ERROR, "the error is not finite on at least one level"
        found = self.separation(evidence)
        if found.obstacle:
            return Verdict.INCONCLUSIVE, found.obstacle
        by_size = {entry.size: entry for entry in found.sources}
        verdicts = [_judge(by_size[size], low, high) for size, low, high in self.bands]
        reason = f"{', '.join(describe(by_size[size]) for size, _, _ in self.bands)}; the fit is off by {found.residual:.1%}"
        if Verdict.FAIL in verdicts:
            return Verdict.FAIL, reason
        return Verdict.INCONCLUSIVE if Verdict.INCONCLUSIVE in verdicts else Verdict.PASS, reason


def _judge(source: Source, low: float, high: float) -> Verdict:
    """FAIL when the interval lies wholly outside the band, PASS when it lies inside."""
    if source.high < low or source.low > high:
        return Verdict.FAIL
    return Verdict.PASS if low <= source.low and source.high <= high else Verdict.INCONCLUSIVE


def describe(source: Source) -> str:
    """Say what is known of a source."""
    if not source.seen:
        return f"{source.size}: not seen"
    return f"{source.size}: {source.exponent:.3f}, interval [{source.low:.3f}, {source.high:.3f}], up to {source.share:.0%}"
