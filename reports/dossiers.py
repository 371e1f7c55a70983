"""Dossiers: everything that the records of all studies hold on one solver."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from urllib.parse import quote

from mpmverify.judgement.findings import Finding

from .overview import verdict_anchors
from .parts import Mark
from .record import Record, Series
from .solver_names import family, file_of, plain_scheme, subject


@dataclass(frozen=True)
class Entry:
    """A series of the solver, with its study and the link to the verdicts on it."""

    record: Record
    series: Series
    href: str

    @property
    def findings(self) -> tuple[Finding, ...]:
        return self.series.findings

    def judged(self, title: str) -> Finding | None:
        """Return the finding of a criterion, or None if it was not judged."""
        return next((f for f in self.findings if f.criterion == title and f.gate == "verification"), None)


@dataclass(frozen=True)
class Dossier:
    """Everything on one solver.

    Parameters
    ----------
    solver : str
    schemes : tuple of str
        The schemes that have this name: one, unless studies differ.
    entries : tuple of Entry
        Its series in all studies, and the measurements of its stability limit.
    """

    solver: str
    schemes: tuple[str, ...]
    entries: tuple[Entry, ...]

    @property
    def file(self) -> str:
        """File of its page."""
        return file_of(self.solver)

    @cached_property
    def family(self) -> str:
        return family(self.schemes)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        return tuple(finding for entry in self.entries for finding in entry.findings)

    @cached_property
    def places(self) -> dict[tuple[str, str, str, str], Entry]:
        """Entries by (study, case, solver, refinement), as findings name them."""
        return {(e.record.name, e.series.case, e.series.solver, e.series.refinement): e for e in self.entries}

    def entry(self, finding: Finding) -> Entry:
        return self.places[finding.study, finding.case, finding.solver, finding.refinement]

    @cached_property
    def formal(self) -> dict[str, tuple[float, ...]]:
        """Declared orders by quantity: one, unless studies differ."""
        table: dict[str, dict[float, None]] = {}
        for entry in self.entries:
            for quantity, order in entry.series.formal.items():
                table.setdefault(quantity, {})[float(order)] = None
        return {quantity: tuple(orders) for quantity, orders in table.items()}

    @property
    def records(self) -> tuple[Record, ...]:
        """The studies that ran it."""
        return tuple({entry.record.name: entry.record for entry in self.entries}.values())


def dossiers(records: Sequence[Record]) -> tuple[Dossier, ...]:
    """Return the dossier of every solver, in the order in which the studies declare them."""
    schemes: dict[str, dict[str, None]] = {}
    entries: dict[str, list[Entry]] = {}
    for record in records:
        for solver, scheme in record.schemes.items():
            schemes.setdefault(subject(solver, scheme), {})[plain_scheme(scheme)] = None
        for name, entry in _entries(record):
            entries.setdefault(name, []).append(entry)
    return tuple(Dossier(name, tuple(known), tuple(entries.get(name, ()))) for name, known in schemes.items())


def _entries(record: Record) -> Iterator[tuple[str, Entry]]:
    anchors = verdict_anchors(record)
    for series in record.series:
        href = f"{quote(record.name)}.html#{anchors[series.case, series.solver]}"
        yield subject(series.solver, record.schemes[series.solver]), Entry(record, series, href)


def mark_of(finding: Finding) -> Mark:
    """Return the mark of one finding; a known limit of the scheme has one of its own."""
    kind = finding.verdict.value.lower()
    return Mark("limit" if finding.word != finding.verdict.value else kind, finding.word)
