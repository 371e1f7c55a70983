"""What the pages show: one frozen value a page, ready to print; a template adds no number and no decision to it."""

from dataclasses import dataclass

from .parts import (
    Curve,
    Fact,
    Fates,
    FaultRow,
    GateMark,
    Group,
    Judgement,
    Link,
    Mark,
    Option,
    OrderTable,
    Origin,
    Plain,
    RateTable,
    Row,
    RunRow,
    Scheme,
    Share,
    SourceRow,
)
from .theory import Theory


@dataclass(frozen=True)
class CaseSection:
    """A case on the page of its study.

    `figures` is JSON for the script, safe within HTML; `charted` tells whether any error can be drawn against what its ladder
    refines; `theory` is there where something was measured that a scheme's own theory knows, and `maps` are the titles of the
    dominance maps. A case that has a theory, and whose orders nobody judges, is not charted and has no tables.
    """

    anchor: str
    name: str
    gates: tuple[GateMark, ...]
    exposes: str
    citation: str
    equations: tuple[str, ...]
    setup: tuple[Fact, ...]
    quantities: tuple[Option, ...]
    norms: tuple[Option, ...]
    charted: bool
    theory: Theory | None
    curves: tuple[Curve, ...]
    wave_quantities: tuple[Option, ...]
    thumbnail_quantity: str
    tables: tuple[OrderTable, ...]
    source_rows: tuple[SourceRow, ...]
    maps: tuple[str, ...]
    groups: tuple[Group, ...]
    sources: tuple[str, ...]
    runs: tuple[RunRow, ...]
    cost: str
    figures: str


@dataclass(frozen=True)
class IndexPage:
    """The first page: every study and solver at a glance.

    Parameters
    ----------
    title, generator : str
    navigation : tuple of Link
    mark : Mark
        The worst verdict of all.
    gates : tuple of GateMark
    shares : tuple of Share
        How many findings have each verdict.
    lacking : tuple of Judgement
        Of each study that lacks series of the baseline.
    exit_status : str
        With which status the gate would end, in a sentence.
    columns : tuple of Link
        Studies of the matrix.
    rows : tuple of Row
    groups : tuple of Group
        What is no PASS.
    origins : tuple of Origin
    """

    title: str
    generator: str
    navigation: tuple[Link, ...]
    mark: Mark
    gates: tuple[GateMark, ...]
    shares: tuple[Share, ...]
    lacking: tuple[Judgement, ...]
    exit_status: str
    columns: tuple[Link, ...]
    rows: tuple[Row, ...]
    groups: tuple[Group, ...]
    origins: tuple[Origin, ...]


@dataclass(frozen=True)
class StudyPage:
    """The page of a study.

    Parameters
    ----------
    title, generator : str
    navigation : tuple of Link
        The index page and the cases.
    restricted_to : str
        The part of the study that was run, "" for the whole.
    summary : str
    gates : tuple of GateMark
    shares : tuple of Share
    lacking : tuple of Judgement
        One when the study lacks series of the baseline.
    columns : tuple of Link
        Cases of the matrix.
    rows : tuple of Row
    schemes : tuple of Scheme
    cases : tuple of CaseSection
    origins : tuple of Origin
        Of this study alone.
    """

    title: str
    generator: str
    navigation: tuple[Link, ...]
    restricted_to: str
    summary: str
    gates: tuple[GateMark, ...]
    shares: tuple[Share, ...]
    lacking: tuple[Judgement, ...]
    columns: tuple[Link, ...]
    rows: tuple[Row, ...]
    schemes: tuple[Scheme, ...]
    cases: tuple[CaseSection, ...]
    origins: tuple[Origin, ...]


@dataclass(frozen=True)
class TrustPage:
    """How far to trust the verdicts.

    Parameters
    ----------
    title, generator : str
    navigation : tuple of Link
    mark : Mark
        Of the self-test; its note says how many of the faults that change results were caught.
    sample : str
        Which faults were planted, in a sentence.
    fates : tuple of str
        Columns of the kill table.
    rules : tuple of Fates
    total : Fates
    meanings : tuple of Fact
        What each fate means.
    survivors : tuple of FaultRow
        With what no trial comes to.
    named, by_rule : tuple of FaultRow
    runs : tuple of Plain
        Of the unmodified solvers.
    alarms : str
        How many of them raised a false alarm, in a sentence.
    judge : str
        How often the judge is wrong about random series, in a sentence.
    rates : tuple of RateTable
    command : str
        Makes the page anew.
    origins : tuple of Origin
    """

    title: str
    generator: str
    navigation: tuple[Link, ...]
    mark: Mark
    sample: str
    fates: tuple[str, ...]
    rules: tuple[Fates, ...]
    total: Fates
    meanings: tuple[Fact, ...]
    survivors: tuple[FaultRow, ...]
    named: tuple[FaultRow, ...]
    by_rule: tuple[FaultRow, ...]
    runs: tuple[Plain, ...]
    alarms: str
    judge: str
    rates: tuple[RateTable, ...]
    command: str
    origins: tuple[Origin, ...]
