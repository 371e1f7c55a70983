"""Parts of the trust page: frozen dataclasses of formatted text."""

from dataclasses import dataclass

from .parts import Mark


@dataclass(frozen=True)
class FateCounts:
    """Number of planted faults of a rule, in total and for each fate."""

    rule: str
    planted: str
    counts: tuple[str, ...]


@dataclass(frozen=True)
class RateTable:
    """Rates of right and wrong verdicts on random series; each row has a kind of series, the true order and the rates."""

    caption: str
    rows: tuple[tuple[str, str, tuple[str, ...]], ...]


@dataclass(frozen=True)
class FaultRow:
    """A planted fault: the source text before and after, the criterion that caught it, and the trial."""

    mark: Mark
    name: str
    place: str
    before: str
    after: str
    by: str
    where: str
    reason: str


@dataclass(frozen=True)
class UnmodifiedRow:
    """A run of the unmodified solvers: verdict, numbers and reason."""

    mark: Mark
    cells: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class KillRow:
    """A fault with what each study saw of it: "killed", "passed" or "" where its line does not run."""

    name: str
    rule: str
    cells: tuple[str, ...]


@dataclass(frozen=True)
class StudyKillsRow:
    """A study with the number of faults that it ran, killed, and killed as the only one."""

    study: str
    ran: str
    killed: str
    alone: str
