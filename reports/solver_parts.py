"""Parts of the pages on solvers: frozen dataclasses of formatted text."""

from dataclasses import dataclass

from .parts import Cell, Link, Mark


@dataclass(frozen=True)
class OrderStrip:
    """One measured order.

    Parameters
    ----------
    mark : Mark
        Verdict on the order.
    again : bool
        Whether the strip above is of the same case and ladder.
    case, ladder, quantity, norm : str
    href : str
        Link to the verdicts on the solver in this case.
    strip : str
        SVG of the order, its interval, the accepted band and the formal order.
    order, interval, band, formal : str
        The same as text.
    """

    mark: Mark
    again: bool
    case: str
    ladder: str
    quantity: str
    norm: str
    href: str
    strip: str
    order: str
    interval: str
    band: str
    formal: str


@dataclass(frozen=True)
class StudyOrders:
    """The orders that were measured in one study."""

    study: Link
    strips: tuple[OrderStrip, ...]


@dataclass(frozen=True)
class ConservationRow:
    """A criterion of conservation, over all series on which it was judged.

    Parameters
    ----------
    quantity, criterion : str
    mark : Mark
        The worst verdict; its note is the number of series that have it.
    measured, bound : str
        The largest measured figure, and the bound on it.
    where : Link
        The series with the worst verdict, or else with the largest figure.
    """

    quantity: str
    criterion: str
    mark: Mark
    measured: str
    bound: str
    where: Link


@dataclass(frozen=True)
class TheoryRow:
    """What was measured of a limit of stability or a frequency, beside its theory."""

    mark: Mark
    what: str
    where: Link
    at: str
    measured: str
    theory: str
    deviation: str


@dataclass(frozen=True)
class CostRow:
    """Error and cost of one run."""

    solver: str
    ladder: str
    size: str
    error: str
    seconds: str
    point_steps: str


@dataclass(frozen=True)
class CostCase:
    """Error against cost in one case, beside a reference.

    Parameters
    ----------
    where : Link
        The case.
    error : str
        What the error is.
    ladders : tuple of str
        Ladders of the solver.
    reference : Link or None
        The solver beside it, with its ladder; None if no other ran the case.
    charts : tuple of str
        SVG of the error against seconds and against point-steps; a cost that was not recorded has none.
    comparison : str
        Costs at an error that both reach, and costs that were not recorded, in sentences.
    rows : tuple of CostRow
    """

    where: Link
    error: str
    ladders: tuple[str, ...]
    reference: Link | None
    charts: tuple[str, ...]
    comparison: str
    rows: tuple[CostRow, ...]


@dataclass(frozen=True)
class StudyRow:
    """The verdicts of one study on a solver; a cell is None where nothing was judged."""

    study: Link
    cases: str
    verification: Cell | None
    regression: Cell | None


@dataclass(frozen=True)
class SolverRow:
    """One solver in the list of solvers.

    Parameters
    ----------
    solver : Link
    mark : Mark
        The worst verdict.
    passed, limits, other : str
        Number of findings that passed, passed on a known limit, and did not pass.
    studies : str
        Number of studies.
    rug : str
        SVG of all measured orders; "" if there is none.
    orders : str
        Number and range of the measured orders.
    """

    solver: Link
    mark: Mark
    passed: str
    limits: str
    other: str
    studies: str
    rug: str
    orders: str


@dataclass(frozen=True)
class Family:
    """The solvers of one family."""

    anchor: str
    name: str
    rows: tuple[SolverRow, ...]
