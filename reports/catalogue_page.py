"""The catalogue: every verification problem with its equations, its drawing, who solves it, and the faults that it caught."""

from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import quote

from mpmverify.judgement.kill_table import Fate, PlantedFault

from .bibliography import Bibliography, downloadable
from .drawing import drawing
from .equations import mathml
from .motion import Motion, motion
from .notation import count, typeset_numbers
from .overview import case_anchors, origin
from .parts import Link, Origin
from .record import Case, Record
from .solver_names import pages_of

UNFOLDED = 6
"""Largest number of named faults of a problem whose list is open at first."""


@dataclass(frozen=True)
class CaughtFault:
    """A named fault, and what caught it: the criterion and the solver in which the fault was planted."""

    name: str
    criterion: str
    solver: str


@dataclass(frozen=True)
class Caught:
    """Planted faults that a problem was the first to catch.

    Parameters
    ----------
    sentence : str
        Their number.
    unfolded : bool
        Whether the list is open at first.
    named : tuple of CaughtFault
        Those of the hand-written list; the others, which rules made, are in the number alone.
    """

    sentence: str
    unfolded: bool
    named: tuple[CaughtFault, ...]


@dataclass(frozen=True)
class CatalogueProblem:
    """A verification problem.

    Parameters
    ----------
    link : Link
        Its case on the page of the study.
    dimension, exposes, citation : str
    equations : tuple of str
        MathML.
    drawing, legend : str
        SVG of the domain with its bodies, supports and loads, and the meaning of the symbols.
    motion : Motion or None
        The exact solution in motion, if it was kept at several times.
    solvers : tuple of Link
    caught : Caught or None
        None if it was not the first to catch any planted fault, or no self-test is at hand.
    """

    link: Link
    dimension: str
    exposes: str
    citation: str
    equations: tuple[str, ...]
    drawing: str
    legend: str
    motion: Motion | None
    solvers: tuple[Link, ...]
    caught: Caught | None


@dataclass(frozen=True)
class CatalogueStudy:
    """A study with its problems."""

    title: Link
    anchor: str
    note: str
    summary: str
    problems: tuple[CatalogueProblem, ...]


@dataclass(frozen=True)
class CataloguePage:
    """The catalogue of the verification problems.

    Parameters
    ----------
    title, generator, root : str
    navigation : tuple of Link
    studies : tuple of CatalogueStudy
    moving, tested : bool
        Whether any picture moves, and whether a self-test is at hand.
    bibliography : Bibliography or None
        Sources of all problems.
    origins : tuple of Origin
    """

    title: str
    generator: str
    root: str
    navigation: tuple[Link, ...]
    studies: tuple[CatalogueStudy, ...]
    moving: bool
    tested: bool
    bibliography: Bibliography | None
    origins: tuple[Origin, ...]


def catalogue_page(records: Sequence[Record], faults: Sequence[PlantedFault], generator: str) -> CataloguePage:
    """Make the catalogue of the problems of all studies.

    Parameters
    ----------
    records : sequence of Record
    faults : sequence of PlantedFault
        Faults of the self-test; none if it was not run.
    generator : str
        Name and version of the program.
    """
    studies = tuple(_study(record, faults) for record in records)
    return CataloguePage(
        title="Problems",
        generator=generator,
        root="",
        navigation=(Link("Overview", "index.html"), Link("Solvers", "solvers.html"), Link("Problems", "problems.html", True)),
        studies=studies,
        moving=any(problem.motion for study in studies for problem in study.problems),
        tested=bool(faults),
        bibliography=downloadable((case.citation for record in records for case in record.cases), "problems"),
        origins=tuple(origin(record) for record in records),
    )


def _study(record: Record, faults: Sequence[PlantedFault]) -> CatalogueStudy:
    anchors = case_anchors(record)
    many = len(record.cases)
    return CatalogueStudy(
        title=Link(str(record.attributes["title"]), f"{quote(record.name)}.html"),
        anchor=f"study-{record.name}",
        note=f"{many} problem{'s' * (many != 1)}",
        summary=str(record.attributes["summary"]),
        problems=tuple(_problem(record, case, anchors[case.name], faults) for case in record.cases),
    )


def _problem(record: Record, case: Case, anchor: str, faults: Sequence[PlantedFault]) -> CatalogueProblem:
    svg, legend = drawing(dict(case.setup))
    files = pages_of(record)
    solvers = dict.fromkeys(series.solver for series in record.series if series.case == case.name)
    return CatalogueProblem(
        link=Link(case.name, f"{record.name}.html#{anchor}"),
        dimension=f"{case.dimension}D",
        exposes=case.exposes,
        citation=case.citation,
        equations=tuple(mathml(latex) for latex in case.equations),
        drawing=svg,
        legend=legend,
        motion=motion(record, case),
        solvers=tuple(Link(name, files[name]) for name in solvers),
        caught=_caught([f for f in faults if f.fate is Fate.KILLED and (f.study, f.case) == (record.name, case.name)]),
    )


def _caught(faults: Sequence[PlantedFault]) -> Caught | None:
    """Return the faults that a problem was the first to catch; None if there are none."""
    if not faults:
        return None
    named = [fault for fault in faults if fault.rule == "named"]
    by_rule = len(faults) - len(named)
    sentence = f"First to catch {count(len(faults))} planted fault{'s' * (len(faults) != 1)}"
    if named and by_rule:
        sentence += f": {count(len(named))} named, {count(by_rule)} by rule"
    elif by_rule:
        sentence += ", by rule"
    listed = tuple(CaughtFault(fault.name, typeset_numbers(fault.criterion), fault.solver) for fault in named)
    return Caught(sentence, len(named) <= UNFOLDED, listed)
