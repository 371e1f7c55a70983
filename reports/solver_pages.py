"""Content of the pages on solvers: frozen dataclasses of formatted text; the templates compute and decide nothing."""

from dataclasses import dataclass

from .failures import Failure
from .parts import Fact, Group, Judgement, Link, Mark, Origin, Share
from .solver_parts import ConservationRow, CostCase, Family, StudyOrders, StudyRow, TheoryRow


@dataclass(frozen=True)
class SolverPage:
    """The page of a solver.

    Parameters
    ----------
    title, generator, root : str
        The title is the name of the solver.
    navigation : tuple of Link
    family : Link
    mark : Mark
        The worst verdict.
    sentence : str
        The worst verdict in a sentence, in which known limits count by themselves.
    causes : str
        Which planted faults leave errors like those of a solver that failed; "" if none does.
    shares : tuple of Share
        Number of findings with each verdict; those on known limits count by themselves.
    compare : str
        Address of its comparison with another solver.
    choices, orders : tuple of Fact
        Choices of the scheme, and formal orders by quantity.
    variants : tuple of str
        The schemes that have this name, if there are several.
    failures : tuple of Failure
    groups : tuple of Group
        Findings that did not pass.
    scorecard : tuple of StudyOrders
    ruler : str
        SVG of the axis of all strips.
    conservation : tuple of ConservationRow
    theory : tuple of TheoryRow
    costs : tuple of CostCase
    limits : tuple of Judgement
        Known limits of the scheme that were found where they are known to be.
    studies : tuple of StudyRow
    origins : tuple of Origin
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    family: Link
    mark: Mark
    sentence: str
    causes: str
    shares: tuple[Share, ...]
    compare: str
    choices: tuple[Fact, ...]
    orders: tuple[Fact, ...]
    variants: tuple[str, ...]
    failures: tuple[Failure, ...]
    groups: tuple[Group, ...]
    scorecard: tuple[StudyOrders, ...]
    ruler: str
    conservation: tuple[ConservationRow, ...]
    theory: tuple[TheoryRow, ...]
    costs: tuple[CostCase, ...]
    limits: tuple[Judgement, ...]
    studies: tuple[StudyRow, ...]
    origins: tuple[Origin, ...]


@dataclass(frozen=True)
class SolversPage:
    """The page that lists all solvers.

    Parameters
    ----------
    title, generator, root : str
    navigation : tuple of Link
    families : tuple of Family
    ruler : str
        SVG of the axis of all strips.
    origins : tuple of Origin
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    families: tuple[Family, ...]
    ruler: str
    origins: tuple[Origin, ...]
