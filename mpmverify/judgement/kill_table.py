"""What a self-test finds: the fate of every planted fault, of every run of the unmodified solvers, and of random series."""

from dataclasses import dataclass
from enum import StrEnum

from mpmverify.convergence.synthetic import Rate, total

__all__ = ["Fate", "PlantedFault", "Rate", "Rates", "SelfTest", "UnmodifiedRun", "total"]

WRONG_PASS, WRONG_FAIL = 0.001, 0.01
"""Share of random series, all kinds together, of which as many may be judged wrongly."""


class Fate(StrEnum):
    """What may become of a fault.

    Killed by verification, to which the contract of a solution belongs, or by the regression gate alone; it does not compile, raises,
    hangs or ends its process; its results agree with the original's on all trials to round-off, or no trial comes to its passage;
    the machine was too busy to tell; or its results differ and everything passed.
    """

    KILLED = "killed"
    REGRESSION = "killed by regression alone"
    BROKEN = "does not run"
    EQUIVALENT = "equivalent"
    NOT_EXERCISED = "not exercised"
    UNDECIDED = "undecided"
    SURVIVED = "survived"


@dataclass(frozen=True)
class PlantedFault:
    """A fault and what became of it.

    Parameters
    ----------
    id, family, rule, name : str
        What it is; the rule is "named" for a fault of the list.
    file, before, after : str
        Where it stands, and the passage before and after.
    line : int
    fate : Fate
    study, case, solver, gate, verdict, criterion : str
        What killed it, or the worst that was said of it; "" where nothing was.
    reason : str
        What was measured, or why it does not run.
    deviation : float
        Largest relative deviation from the original's results on the trials that it lived to see; infinite where they have
        another shape.
    trials : int
        How many those were.
    seconds : float
        Compilation included.
    explanation : str
        Of a survivor: what would kill it.
    """

    id: str
    family: str
    rule: str
    name: str
    file: str
    line: int
    before: str
    after: str
    fate: Fate
    study: str = ""
    case: str = ""
    solver: str = ""
    gate: str = ""
    verdict: str = ""
    criterion: str = ""
    reason: str = ""
    deviation: float = 0.0
    trials: int = 0
    seconds: float = 0.0
    explanation: str = ""


@dataclass(frozen=True)
class UnmodifiedRun:
    """One run of all trials with the solvers as they are shipped: `verdict` is the worst, of `judged` ones."""

    jobs: int
    threads: int
    jitter: float
    seed: int
    verdict: str
    judged: int
    reason: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Rates:
    """How often the judge is right about random series, about designs, and about series at the limits of what can be seen."""

    series: tuple[Rate, ...] = ()
    designs: tuple[Rate, ...] = ()
    limits: tuple[Rate, ...] = ()

    @property
    def astray(self) -> bool:
        """Whether too many verdicts on series or designs are wrong; those at the limits are inherent."""
        return any(
            rate.wrong_pass >= WRONG_PASS * rate.series or rate.wrong_fail >= WRONG_FAIL * rate.series
            for rate in (total(self.series), total(self.designs))
        )


@dataclass(frozen=True)
class SelfTest:
    """A self-test: `sites` counts the faults that the rules make, of which the table has a sample."""

    tier: str
    sites: int
    faults: tuple[PlantedFault, ...]
    runs: tuple[UnmodifiedRun, ...]
    rates: Rates = Rates()

    @property
    def unexplained(self) -> tuple[PlantedFault, ...]:
        """Survivors of which nobody has said what would kill them."""
        return tuple(fault for fault in self.faults if fault.fate is Fate.SURVIVED and not fault.explanation)

    @property
    def alarms(self) -> tuple[UnmodifiedRun, ...]:
        """Unmodified runs that did not pass."""
        return tuple(run for run in self.runs if run.verdict != "PASS")

    @property
    def passed(self) -> bool:
        fates = {fault.fate for fault in self.faults}
        asked = bool(self.runs) and not fates.isdisjoint({Fate.KILLED, Fate.REGRESSION})
        return asked and Fate.UNDECIDED not in fates and not (self.unexplained or self.alarms or self.rates.astray)

    def table(self) -> dict[str, dict[Fate, int]]:
        """How many faults of each rule met each fate, the named ones first."""
        rules = sorted({fault.rule for fault in self.faults}, key=lambda rule: (rule != "named", rule))
        return {rule: {fate: sum(f.rule == rule and f.fate is fate for f in self.faults) for fate in Fate} for rule in rules}
