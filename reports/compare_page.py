"""The page that compares any two solvers in the series that both ran."""

from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlencode

from .compare_data import compare_data
from .dossiers import Dossier, dossiers
from .field_panel import escaped
from .manifest import COMPARE, SOLVERS
from .notation import count, number
from .overview import origin
from .pairs import Compared, Match, compared_measures, matches, middle, nearest, trials
from .parts import Link, Origin
from .ratios import ratio_bar
from .record import Record


@dataclass(frozen=True)
class Pickable:
    """The solvers of one family, as they can be picked."""

    family: str
    solvers: tuple[str, ...]


@dataclass(frozen=True)
class NearestRow:
    """A solver beside its nearest reference.

    Parameters
    ----------
    solver : Link
    reference : Link
    href : str
        Address of their comparison.
    shared : str
        Number of series that both ran.
    error, time, work : str
        Medians of the ratios of errors, of wall times and of point-steps.
    bar : str
        SVG of the ratio of the errors; "" if it is not known.
    """

    solver: Link
    reference: Link
    href: str
    shared: str
    error: str
    time: str
    work: str
    bar: str


@dataclass(frozen=True)
class ComparePage:
    """The page that compares two solvers.

    Parameters
    ----------
    title, generator, root : str
    navigation : tuple of Link
    choices : tuple of Pickable
    rows : tuple of NearestRow
        What the page shows without scripts.
    without : str
        Number of solvers that have no reference, in a sentence; "" if all have one.
    data : str
        JSON of all series, escaped for use in HTML.
    origins : tuple of Origin
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    choices: tuple[Pickable, ...]
    rows: tuple[NearestRow, ...]
    without: str
    data: str
    origins: tuple[Origin, ...]


def compare_page(records: Sequence[Record], generator: str) -> ComparePage:
    """Make the page from all studies.

    Parameters
    ----------
    records : sequence of Record
    generator : str
        Name and version of the program.
    """
    known = dossiers(records)
    families = dict.fromkeys(dossier.family for dossier in known)
    compared = compared_measures(records)
    rows = _rows(known, compared)
    return ComparePage(
        title="Compare two solvers",
        generator=generator,
        root="",
        navigation=(
            Link("Overview", "index.html"),
            Link("Solvers", f"{SOLVERS}.html"),
            Link("Compare", f"{COMPARE}.html", True),
            Link("Problems", "problems.html"),
        ),
        choices=tuple(
            Pickable(name, tuple(sorted(dossier.solver for dossier in known if dossier.family == name))) for name in families
        ),
        rows=rows,
        without=_without(len(known) - len(rows)),
        data=escaped(compare_data(known, compared)),
        origins=tuple(origin(record) for record in records),
    )


def comparison_of(first: str, second: str = "") -> str:
    """Return the address of the comparison of two solvers; the page picks the second if none is named."""
    return f"{COMPARE}.html#{urlencode({'a': first} | ({'b': second} if second else {}))}"


def _rows(known: Sequence[Dossier], compared: Compared) -> tuple[NearestRow, ...]:
    table = {dossier.solver: dossier for dossier in known}
    tried = {dossier.solver: trials(dossier, compared) for dossier in known}
    pairs = ((table[solver], table.get(nearest(tried[solver]))) for solver in sorted(table))
    return tuple(
        _row(dossier, beside, matches(tried[dossier.solver], tried[beside.solver])) for dossier, beside in pairs if beside
    )


def _row(dossier: Dossier, beside: Dossier, shared: Sequence[Match]) -> NearestRow:
    error = middle([match.ratio for match in shared])
    time = middle([match.time.ratio for match in shared if match.time])
    work = middle([match.work.ratio for match in shared if match.work])
    return NearestRow(
        solver=Link(dossier.solver, dossier.file),
        reference=Link(beside.solver, beside.file),
        href=comparison_of(dossier.solver, beside.solver),
        shared=count(len(shared)),
        error=number(error, 2),
        time=number(time, 2),
        work=number(work, 2),
        bar=ratio_bar(error, "median ratio of the errors"),
    )


def _without(many: int) -> str:
    if not many:
        return ""
    return f"{count(many)} solver{'s have' if many != 1 else ' has'} no reference: no other ran a series whose errors fall with a size."
