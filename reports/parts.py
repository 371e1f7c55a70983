"""Parts of pages: frozen values, ready to print."""

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
    """A verdict: `kind` is its name in lower case, for the style sheet and the icon; `note` says of how many."""

    kind: str
    text: str
    note: str = ""


@dataclass(frozen=True)
class GateMark:
    """The verdict of one gate."""

    gate: str
    mark: Mark


@dataclass(frozen=True)
class Share:
    """How many of the findings have a verdict."""

    mark: Mark
    count: int


@dataclass(frozen=True)
class Cell:
    """A cell of a matrix: the worst verdict with the reasons of those that are no PASS; None where nothing was judged."""

    mark: Mark
    href: str
    hint: str


@dataclass(frozen=True)
class Row:
    """A row of a matrix: a solver, and (verification, regression) for each column."""

    anchor: str
    solver: str
    cells: tuple[tuple[Cell | None, Cell | None], ...]


@dataclass(frozen=True)
class Scheme:
    """What a solver is: its choices and its formal orders."""

    solver: str
    choices: str
    orders: str


@dataclass(frozen=True)
class Criterion:
    """What was judged; `footnote` numbers its source among those of its case."""

    title: str
    footnote: int


@dataclass(frozen=True)
class Judgement:
    """Findings on one series that share their verdict and their reason."""

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
    """Findings that belong together, folded or not."""

    anchor: str
    mark: Mark
    title: str
    gates: tuple[GateMark, ...]
    unfolded: bool
    judgements: tuple[Judgement, ...]


@dataclass(frozen=True)
class Fact:
    """A name and its value."""

    name: str
    value: str


@dataclass(frozen=True)
class Origin:
    """Where the file of a study comes from."""

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
    """One level in one quantity and norm."""

    error: str
    absolute: str
    order: str
    kept: bool


@dataclass(frozen=True)
class OrderRow:
    """One series in one quantity and norm; a cell is None where it has no such level, the mark where the series passed."""

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
    """Errors and orders of a case in one quantity and norm; `axis` is the size that heads the columns."""

    key: str
    caption: str
    shown: bool
    axis: str
    sizes: tuple[Fact, ...]
    rows: tuple[OrderRow, ...]
    dropped: tuple[Fact, ...]


@dataclass(frozen=True)
class SourceRow:
    """One source of the error of one design in one quantity and norm."""

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
    """One run and its cost; `href` is empty when it left no file."""

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


@dataclass(frozen=True)
class Fates:
    """How many planted faults of a rule met each fate."""

    rule: str
    planted: str
    counts: tuple[str, ...]


@dataclass(frozen=True)
class RateTable:
    """How often the judge is right: rows of kind and truth, and of numbers; a command gives them."""

    caption: str
    rows: tuple[tuple[str, str, tuple[str, ...]], ...]


@dataclass(frozen=True)
class FaultRow:
    """A planted fault: the passage before and after, what caught it, and in which trial."""

    mark: Mark
    name: str
    place: str
    before: str
    after: str
    by: str
    where: str
    reason: str


@dataclass(frozen=True)
class Plain:
    """A row of a plain table: its verdict, its numbers and the reason."""

    mark: Mark
    cells: tuple[str, ...]
    reason: str
