"""Content of the pages: one frozen dataclass of formatted text for each page; the templates compute and decide nothing."""

from dataclasses import dataclass

from .bibliography import Bibliography
from .cards import Card
from .failures import Failure
from .field_panel import FieldPanel
from .parts import (
    Curve,
    Fact,
    GateMark,
    Group,
    Judgement,
    Link,
    Mark,
    Matrix,
    Option,
    OrderTable,
    Origin,
    Row,
    RunRow,
    Scheme,
    Share,
    SourceRow,
)
from .theory import Theory
from .trust_parts import FateCounts, FaultRow, KillRow, RateTable, StudyKillsRow, UnmodifiedRow
from .verdict_changes import RunChanges


@dataclass(frozen=True)
class CaseSection:
    """A case on the page of its study.

    Parameters
    ----------
    anchor, name : str
    unfolded : bool
        Whether the case is open at first.
    mark : Mark
        The worst verdict.
    gates : tuple of GateMark
    exposes, citation : str
        The errors that the problem exposes, and the source of its exact solution.
    equations : tuple of str
        MathML.
    setup : tuple of Fact
    drawing, legend : str
        SVG of the domain with its bodies, supports and loads, and the meaning of the symbols.
    quantities, norms : tuple of Option
        Choices of the convergence chart.
    charted : bool
        Whether any error can be drawn against a refined size; False if there is theory and no order is judged.
    still : str
        SVG of the convergence chart as it is at first.
    theory : Theory or None
        Chart of measured frequencies or stability limits, if there are any.
    curves : tuple of Curve
    wave_quantities : tuple of Option
        Quantities of which the wave is drawn, in one dimension.
    histories : tuple of Option
        Series whose histories are drawn where there is no wave.
    thumbnail_quantity : str
    tables : tuple of OrderTable
        Empty if there is theory and no order is judged.
    source_rows : tuple of SourceRow
    maps : tuple of str
        Titles of the dominance maps.
    groups : tuple of Group
    sources : tuple of str
        Sources of the criteria, in the order of their footnote numbers.
    runs : tuple of RunRow
    cost : str
    figures : str
        JSON of the charts, escaped for use in HTML.
    field : FieldPanel or None
        Fields in two or three dimensions; None if no series has one.
    """

    anchor: str
    name: str
    unfolded: bool
    mark: Mark
    gates: tuple[GateMark, ...]
    exposes: str
    citation: str
    equations: tuple[str, ...]
    setup: tuple[Fact, ...]
    drawing: str
    legend: str
    quantities: tuple[Option, ...]
    norms: tuple[Option, ...]
    charted: bool
    still: str
    theory: Theory | None
    curves: tuple[Curve, ...]
    wave_quantities: tuple[Option, ...]
    histories: tuple[Option, ...]
    thumbnail_quantity: str
    tables: tuple[OrderTable, ...]
    source_rows: tuple[SourceRow, ...]
    maps: tuple[str, ...]
    groups: tuple[Group, ...]
    sources: tuple[str, ...]
    runs: tuple[RunRow, ...]
    cost: str
    figures: str
    field: FieldPanel | None = None


@dataclass(frozen=True)
class IndexPage:
    """The index page: an overview of all studies and solvers.

    Parameters
    ----------
    title, generator, root : str
        `root` leads to the folder of the report.
    navigation : tuple of Link
    mark : Mark
        The worst verdict of all findings.
    headline, changes : str
        What failed first and why, and how the errors compare with the baseline, in a sentence each.
    runs : tuple of RunChanges
        Which verdicts changed since the run before; empty if nothing was judged before.
    made : str
        Commit, tier, platform and date of the results.
    shares : tuple of Share
        Number of findings with each verdict.
    lacking : tuple of Judgement
        One for each study in which series of the baseline are missing.
    exit_status : str
        The exit status of the gate, in a sentence.
    cards : tuple of Card
        One for each study.
    verdicts, dimensions, families : tuple of str
        Choices of the filters.
    matrices : tuple of Matrix
        One for each family of solvers.
    groups : tuple of Group
        Findings that did not pass.
    origins : tuple of Origin
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    mark: Mark
    headline: str
    changes: str
    runs: tuple[RunChanges, ...]
    made: str
    shares: tuple[Share, ...]
    lacking: tuple[Judgement, ...]
    exit_status: str
    cards: tuple[Card, ...]
    verdicts: tuple[str, ...]
    dimensions: tuple[str, ...]
    families: tuple[str, ...]
    matrices: tuple[Matrix, ...]
    groups: tuple[Group, ...]
    origins: tuple[Origin, ...]


@dataclass(frozen=True)
class StudyPage:
    """The page of a study.

    Parameters
    ----------
    title, generator, root : str
        `root` leads to the folder of the report.
    navigation : tuple of Link
    restricted_to : str
        The part of the study that was run; "" for the whole study.
    summary : str
    gates : tuple of GateMark
    shares : tuple of Share
    lacking : tuple of Judgement
        One if series of the baseline are missing, else empty.
    failures : tuple of Failure
        Runs that failed, by series.
    columns : tuple of Link
        Cases, the columns of the matrix.
    rows : tuple of Row
    schemes : tuple of Scheme
    cases : tuple of CaseSection
    bibliography : Bibliography or None
        Sources of the problems and criteria.
    origins : tuple of Origin
        Provenance of this study.
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    restricted_to: str
    summary: str
    gates: tuple[GateMark, ...]
    shares: tuple[Share, ...]
    lacking: tuple[Judgement, ...]
    failures: tuple[Failure, ...]
    columns: tuple[Link, ...]
    rows: tuple[Row, ...]
    schemes: tuple[Scheme, ...]
    cases: tuple[CaseSection, ...]
    bibliography: Bibliography | None
    origins: tuple[Origin, ...]


@dataclass(frozen=True)
class TrustPage:
    """The trust page: results of the self-test.

    Parameters
    ----------
    title, generator, root : str
        `root` leads to the folder of the report.
    navigation : tuple of Link
    mark : Mark
        Verdict of the self-test; its note is the number of faults caught among those that change results.
    sample : str
        The planted faults, in a sentence.
    fates : tuple of str
        Columns of the kill table.
    rules : tuple of FateCounts
    total : FateCounts
    meanings : tuple of Fact
        Meaning of each fate.
    studies : tuple of StudyKillsRow
        What each study saw; empty unless each fault ran every study.
    kills : tuple of KillRow
        What each of these studies saw of each fault that changes results.
    survivors : tuple of FaultRow
        Faults that survived, are undecided or were not exercised.
    named, by_rule : tuple of FaultRow
    runs : tuple of UnmodifiedRow
    alarms : str
        Number of false alarms in these runs, in a sentence.
    judge : str
        Rates of wrong verdicts on random series, in a sentence.
    rates : tuple of RateTable
    command : str
        Command that reproduces the page.
    origins : tuple of Origin
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    mark: Mark
    sample: str
    fates: tuple[str, ...]
    rules: tuple[FateCounts, ...]
    total: FateCounts
    meanings: tuple[Fact, ...]
    studies: tuple[StudyKillsRow, ...]
    kills: tuple[KillRow, ...]
    survivors: tuple[FaultRow, ...]
    named: tuple[FaultRow, ...]
    by_rule: tuple[FaultRow, ...]
    runs: tuple[UnmodifiedRow, ...]
    alarms: str
    judge: str
    rates: tuple[RateTable, ...]
    command: str
    origins: tuple[Origin, ...]
