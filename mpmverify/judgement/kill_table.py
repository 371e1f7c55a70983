"""Results of a self-test: the fates of planted faults, runs of the unmodified solvers, and rates of verdicts on random series."""

from dataclasses import dataclass
from enum import StrEnum

from mpmverify.convergence.synthetic import Rate, total

__all__ = ["Fate", "PlantedFault", "Rate", "Rates", "SelfTest", "UnmodifiedRun", "total"]

WRONG_PASS, WRONG_FAIL = 0.001, 0.01
"""Largest accepted rates of wrong verdicts on random series, over all kinds together."""


class Fate(StrEnum):
    """Fate of a planted fault.

    KILLED
        Verification, or a check on what a solution must contain, detects it.
    REGRESSION
        Only the regression gate detects it.
    BROKEN
        It does not compile, raises an exception, hangs or ends its process.
    EQUIVALENT
        Its results agree with those of the original to round-off in all trials.
    NOT_EXERCISED
        No trial executes the changed code.
    UNDECIDED
        The machine was too busy to decide.
    SURVIVED
        Its results differ, but both gates pass.
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
    """A planted fault and its fate.

    Parameters
    ----------
    id, family, rule, name : str
        Identity of the fault; the rule is "named" for faults of the hand-written list.
    file, before, after : str
        File, and its source text without and with the fault.
    line : int
        Line in the file.
    fate : Fate
    study, case, solver, gate, verdict, criterion : str
        The finding that killed the fault, or else the worst finding; "" if there is none.
    reason : str
        What was measured, or why the fault does not run.
    deviation : float
        Largest relative deviation from the results of the original, over the trials until the fault was killed; infinite if the shapes
        differ.
    trials : int
        Number of these trials.
    killed_by, passed : str
        Names of the studies that killed the fault, and of those that ran it and did not, separated by commas.
    seconds : float
        Time of the trials, including compilation [s].
    explanation : str
        For a survivor: what would kill it.
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
    killed_by: str = ""
    passed: str = ""
    seconds: float = 0.0
    explanation: str = ""


@dataclass(frozen=True)
class UnmodifiedRun:
    """One run of all trials with the unmodified solvers.

    Parameters
    ----------
    jobs, threads : int
        Number of processes, and of threads in each.
    jitter : float
        Largest random displacement of a particle, relative to the particle spacing [1].
    seed : int
        Seed of the displacements.
    verdict : str
        The worst verdict.
    judged : int
        Number of verdicts.
    reason : str
        Reason of the worst verdict.
    seconds : float
        Wall time [s].
    """

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
    """Rates of right and wrong verdicts on random series, on designs, and on series that are hard to decide."""

    series: tuple[Rate, ...] = ()
    designs: tuple[Rate, ...] = ()
    limits: tuple[Rate, ...] = ()

    @property
    def wrong_too_often(self) -> bool:
        """Whether too many verdicts on series or designs are wrong; wrong verdicts on `limits` are inevitable and do not count."""
        return any(
            rate.wrong_pass >= WRONG_PASS * rate.series or rate.wrong_fail >= WRONG_FAIL * rate.series
            for rate in (total(self.series), total(self.designs))
        )


@dataclass(frozen=True)
class StudyKills:
    """What one study saw of the planted faults.

    Parameters
    ----------
    study : str
    killed, alone : int
        Number of faults that it killed, and of those that no other study killed.
    ran : int
        Number of faults that it ran.
    """

    study: str
    killed: int
    alone: int
    ran: int


@dataclass(frozen=True)
class SelfTest:
    """Results of a self-test.

    Parameters
    ----------
    tier : str
    sites : int
        Number of all faults that the rules can plant; `faults` contains a sample of them.
    faults : tuple of PlantedFault
    runs : tuple of UnmodifiedRun
    rates : Rates
    every_study : bool
        Whether each fault ran the trials of every study, and not only those up to its first kill.
    """

    tier: str
    sites: int
    faults: tuple[PlantedFault, ...]
    runs: tuple[UnmodifiedRun, ...]
    rates: Rates = Rates()
    every_study: bool = False

    @property
    def unexplained(self) -> tuple[PlantedFault, ...]:
        """Survivors without an explanation."""
        return tuple(fault for fault in self.faults if fault.fate is Fate.SURVIVED and not fault.explanation)

    @property
    def false_alarms(self) -> tuple[UnmodifiedRun, ...]:
        """Unmodified runs that did not pass."""
        return tuple(run for run in self.runs if run.verdict != "PASS")

    @property
    def passed(self) -> bool:
        fates = {fault.fate for fault in self.faults}
        asked = bool(self.runs) and not fates.isdisjoint({Fate.KILLED, Fate.REGRESSION})
        return (
            asked and Fate.UNDECIDED not in fates and not (self.unexplained or self.false_alarms or self.rates.wrong_too_often)
        )

    def table(self) -> dict[str, dict[Fate, int]]:
        """Number of faults by rule and fate, the named ones first."""
        rules = sorted({fault.rule for fault in self.faults}, key=lambda rule: (rule != "named", rule))
        return {rule: {fate: sum(f.rule == rule and f.fate is fate for f in self.faults) for fate in Fate} for rule in rules}

    def studies(self) -> tuple[StudyKills, ...]:
        """What each study saw of the faults; empty unless each fault ran every study."""
        if not self.every_study:
            return ()
        killed = [set(filter(None, fault.killed_by.split(","))) for fault in self.faults]
        ran = [by | set(filter(None, fault.passed.split(","))) for by, fault in zip(killed, self.faults, strict=True)]
        return tuple(
            StudyKills(
                name, sum(name in by for by in killed), sum(by == {name} for by in killed), sum(name in by for by in ran)
            )
            for name in sorted(set().union(*ran))
        )
