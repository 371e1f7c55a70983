"""The page that compares any two solvers in the series that both ran."""

from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlencode

from .compare_data import compare_data
from .dossiers import Dossier, dossiers
from .field_panel import escaped
from .manifest import COMPARE, SOLVERS
from .notation import DASH, count, number
from .overview import origin
from .pairs import Match, matches, middle, nearest, trials
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
    reference : Link or None
        None if no other solver ran any of its cases.
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
    reference: Link | None
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
        rows=_rows(known),
        data=escaped(compare_data(known)),
        origins=tuple(origin(record) for record in records),
    )


def comparison_of(first: str, second: str = "") -> str:
    """Return the address of the comparison of two solvers; the page picks the second if none is named."""
    return f"{COMPARE}.html#{urlencode({'a': first} | ({'b': second} if second else {}))}"


def _rows(known: Sequence[Dossier]) -> tuple[NearestRow, ...]:
    table = {dossier.solver: dossier for dossier in known}
    tried = {dossier.solver: tuple(trials(dossier)) for dossier in known}
    rows = []
    for dossier in sorted(known, key=lambda one: one.solver):
        beside = table.get(nearest(dossier))
        shared = matches(tried[dossier.solver], tried[beside.solver]) if beside else ()
        rows.append(_row(dossier, beside, shared))
    return tuple(rows)


def _row(dossier: Dossier, beside: Dossier | None, shared: Sequence[Match]) -> NearestRow:
    error = middle([match.ratio for match in shared])
    time = middle([match.time.ratio for match in shared if match.time])
    work = middle([match.work.ratio for match in shared if match.work])
    return NearestRow(
        solver=Link(dossier.solver, dossier.file),
        reference=Link(beside.solver, beside.file) if beside else None,
        href=comparison_of(dossier.solver, beside.solver if beside else ""),
        shared=count(len(shared)) if beside else DASH,
        error=number(error, 2),
        time=number(time, 2),
        work=number(work, 2),
        bar=ratio_bar(error, "median ratio of the errors"),
    )
