"""Parts of pages: frozen dataclasses of formatted text."""

from dataclasses import dataclass

from .thumbnails import Thumbnail


@dataclass(frozen=True)
class Link:
    """A link of the navigation."""

    text: str
    href: str
    current: bool = False


@dataclass(frozen=True)
class Mark:
    """A verdict: `kind` is its name in lower case, for style and icon; `note` is the number of criteria that have it."""

    kind: str
    text: str
    note: str = ""


@dataclass(frozen=True)
class GateMark:
    """The worst verdict of one gate."""

    gate: str
    mark: Mark


@dataclass(frozen=True)
class Share:
    """The number of findings with one verdict."""

    mark: Mark
    count: int


@dataclass(frozen=True)
class Cell:
    """A cell of a matrix: the worst verdict, a link to the findings, and a tooltip with the reasons of those that did not pass."""

    mark: Mark
    href: str
    hint: str


@dataclass(frozen=True)
class Row:
    """A row of a matrix: a solver, the page of it, and cells (verification, regression) by column; None where nothing was judged."""

    anchor: str
    solver: str
    href: str
    cells: tuple[tuple[Cell | None, Cell | None], ...]


@dataclass(frozen=True)
class Matrix:
    """Verdicts of the solvers of one family in the studies that they ran; `note` counts the solvers."""

    family: str
    note: str
    mark: Mark
    columns: tuple[Link, ...]
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Scheme:
    """A solver with the page of it, its choices and formal orders."""

    solver: str
    href: str
    choices: str
    orders: str


@dataclass(frozen=True)
class Criterion:
    """Title of a criterion; `footnote` is the number of its source among the sources of the case."""

    title: str
    footnote: int


@dataclass(frozen=True)
class Judgement:
    """Findings on one series that share their verdict and reason."""

    mark: Mark
    study: str
    case: str
    solver: str
    ladder: str
    gate: str
    criteria: tuple[Criterion, ...]
    reason: str
    href: str


@dataclass(frozen=True)
class Group:
    """A list of findings under one title, folded or not, with the command that runs them again, or ""."""

    anchor: str
    mark: Mark
    title: str
    gates: tuple[GateMark, ...]
    unfolded: bool
    judgements: tuple[Judgement, ...]
    command: str = ""


@dataclass(frozen=True)
class Fact:
    """A label and its value."""

    name: str
    value: str


@dataclass(frozen=True)
class Origin:
    """Provenance of the file of a study."""

    study: str
    href: str
    facts: tuple[Fact, ...]


@dataclass(frozen=True)
class Option:
    """An option of a selector."""

    value: str
    text: str
    selected: bool


@dataclass(frozen=True)
class Curve:
    """A series in the legend of its case."""

    index: int
    solver: str
    ladder: str
    order: str
    shown: bool
    passed: bool
    paint: str
    stroke: str
    symbol: str
    thumbnail: Thumbnail | None
    mark: Mark


@dataclass(frozen=True)
class ErrorCell:
    """Error of one level in one quantity and norm, and the order from the coarser level."""

    error: str
    absolute: str
    order: str
    kept: bool


@dataclass(frozen=True)
class OrderRow:
    """Errors of one series in one quantity and norm; a cell is None if there is no such level, the mark if the series passed."""

    solver: str
    ladder: str
    mark: Mark | None
    cells: tuple[ErrorCell | None, ...]
    order: str
    interval: str
    expected: str
    classification: str
    floor: str


@dataclass(frozen=True)
class OrderTable:
    """Errors and orders of a case in one quantity and norm; `axis` is the refined size, whose values head the columns."""

    key: str
    caption: str
    shown: bool
    axis: str
    sizes: tuple[Fact, ...]
    rows: tuple[OrderRow, ...]
    dropped: tuple[Fact, ...]


@dataclass(frozen=True)
class SourceRow:
    """One source of error of one design in one quantity and norm."""

    solver: str
    ladder: str
    error: str
    size: str
    exponent: str
    interval: str
    share: str
    fit: str


@dataclass(frozen=True)
class RunRow:
    """One run and its cost; `href` is empty if there is no run file."""

    solver: str
    ladder: str
    h: str
    dt: str
    courant: str
    ppc: str
    steps: str
    point_steps: str
    seconds: str
    outcome: str
    href: str
