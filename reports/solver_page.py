"""The page of each solver, and the page that lists all solvers."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from textwrap import shorten

from mpmverify.convergence.verdict import Verdict
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.summary import KNOWN_LIMIT, ranked, tally

from .compare_page import comparison_of
from .conservation import conservation
from .cost import costs
from .dossiers import Dossier, Entry, dossiers
from .failures import Failure, failures
from .likenesses import likely_causes
from .limits import against_theory
from .manifest import COMPARE, SOLVERS
from .notation import DASH, count, ladder, order, slugs
from .overview import GATES, cell, judgements, mark, not_passed, origin, shares, solver_anchors, verdict_anchors
from .parts import Cell, Fact, Link, Mark
from .record import Record
from .scorecard import measured_orders, scorecard
from .solver_names import FAMILIES, OWN, choices
from .solver_pages import SolverPage, SolversPage
from .solver_parts import Family, SolverRow, StudyRow
from .strips import rug, ruler

Failures = Mapping[str, Mapping[tuple[str, str, str], Failure]]
"""Failures by (case, solver, refinement), by study."""

VERDICTS = tuple(map(str, Verdict))
BRIEF = 160
"""Largest number of characters of a reason in a sentence; the lists show all of it."""


def solver_pages(records: Sequence[Record], runs: Set[str], generator: str) -> dict[str, SolverPage | SolversPage]:
    """Return the pages of all solvers and the page that lists them, by the names of their files without ending.

    Parameters
    ----------
    records : sequence of Record
        All studies.
    runs : set of str
        Keys of the run files that exist.
    generator : str
        Name and version of the program.
    """
    known = dossiers(records)
    failed = {record.name: failures(record, verdict_anchors(record), runs) for record in records}
    listed = _families(known)
    pages: dict[str, SolverPage | SolversPage] = {
        dossier.file.removesuffix(".html"): solver_page(dossier, listed, failed, generator) for dossier in known
    }
    navigation = (
        Link("Overview", "index.html"),
        Link("Solvers", f"{SOLVERS}.html", True),
        Link("Compare", f"{COMPARE}.html"),
        *(Link(entry.name, f"#{entry.anchor}") for entry in listed),
    )
    origins = tuple(origin(record) for record in records)
    return pages | {SOLVERS: SolversPage("Solvers", generator, "", navigation, listed, ruler(), origins)}


def solver_page(dossier: Dossier, families: Sequence[Family], failed: Failures, generator: str) -> SolverPage:
    """Make the page of one solver."""
    mine = _failures(dossier, failed)
    anchors = {place: failure.anchor for place, failure in mine.items()}

    def href(finding: Finding) -> str:
        anchor = anchors.get((finding.study, finding.case, finding.solver, finding.refinement))
        return f"#{anchor}" if anchor and finding.verdict is Verdict.ERROR else dossier.entry(finding).href

    groups, scored, balances = not_passed(dossier.findings, href), scorecard(dossier), conservation(dossier)
    theory, cost, limited = against_theory(dossier), costs(dossier), [f for f in dossier.findings if f.word not in VERDICTS]
    sections = {
        "failed": ("Failed runs", mine),
        "not-passed": ("Not passed", groups),
        "orders": ("Orders", scored),
        "conservation": ("Conservation", balances),
        "theory": ("Theory", theory),
        "cost": ("Cost", cost),
        "limits": ("Known limits", limited),
        "studies": ("Studies", dossier.records),
    }
    links = [Link(title, f"#{anchor}") for anchor, (title, content) in sections.items() if content]
    return SolverPage(
        title=dossier.solver,
        generator=generator,
        root="",
        navigation=(Link("Overview", "index.html"), Link("Solvers", f"{SOLVERS}.html"), *links),
        family=next(Link(f.name, f"{SOLVERS}.html#{f.anchor}") for f in families if f.name == dossier.family),
        mark=mark(dossier.findings),
        sentence=sentence(dossier),
        causes=likely_causes(dossier),
        shares=shares(dossier.findings),
        compare=comparison_of(dossier.solver),
        choices=choices(dossier.schemes[0]),
        orders=tuple(
            Fact(quantity.replace("_", " "), " or ".join(f"{value:g}" for value in values))
            for quantity, values in dossier.formal.items()
        ),
        variants=dossier.schemes if len(dossier.schemes) > 1 else (),
        failures=tuple(mine.values()),
        groups=groups,
        scorecard=scored,
        ruler=ruler(),
        conservation=balances,
        theory=theory,
        costs=cost,
        limits=tuple(replace(entry, mark=Mark("limit", entry.mark.text)) for entry in judgements(limited, href)),
        studies=tuple(_study(record, dossier) for record in dossier.records),
        origins=tuple(origin(record) for record in dossier.records),
    )


def sentence(dossier: Dossier) -> str:
    """Say the worst verdict on a solver."""
    findings = dossier.findings
    if not findings:
        return "Nothing was judged."
    many = len(dossier.records)
    where = f"in {count(many)} studies" if many > 1 else f"in the study {dossier.records[0].name}"
    worst = next(iter(ranked(findings)), None)
    if worst:
        below = sum(finding.verdict is not Verdict.PASS for finding in findings)
        return (
            f"{count(below)} of {count(len(findings))} criteria {where} did not pass; the worst is {worst.verdict} in {worst.study}, "
            f"{worst.case}, {ladder(worst.refinement)}: {worst.criterion}: {shorten(worst.reason, BRIEF, placeholder=' …')}."
        )
    limits = tally(findings)[KNOWN_LIMIT]
    held = "The only criterion" if len(findings) == 1 else f"All {count(len(findings))} criteria"
    if not limits:
        return f"{held} {where} passed."
    hold = "holds" if len(findings) == 1 else "hold"
    plain = f"{count(len(findings) - limits)} passed, and " if len(findings) > limits else ""
    return f"{held} {where} {hold}: {plain}{count(limits)} passed on a known limit of the scheme."


def _failures(dossier: Dossier, failed: Failures) -> dict[tuple[str, str, str, str], Failure]:
    """Return the failures of a solver by (study, case, solver, refinement), with anchors for its own page."""
    found = {
        place: failure
        for place in dossier.places
        if (failure := failed[place[0]].get((place[1], place[2], place[3]))) is not None
    }
    return {place: replace(failure, anchor=f"failed-{k}") for k, (place, failure) in enumerate(found.items(), 1)}


def _study(record: Record, dossier: Dossier) -> StudyRow:
    entries = [entry for entry in dossier.entries if entry.record is record]
    place = f"{record.name}.html#{solver_anchors(record)[entries[0].series.solver]}"
    cells = (_cell(entries, gate, place) for gate in GATES)
    verification, regression = cells
    cases = ", ".join(dict.fromkeys(entry.series.case for entry in entries))
    return StudyRow(Link(str(record.attributes["title"]), place), cases, verification, regression)


def _cell(entries: Sequence[Entry], gate: str, href: str) -> Cell | None:
    judged = [finding for entry in entries for finding in entry.findings if finding.gate == gate]
    return cell(judged, href) if judged else None


def _families(known: Sequence[Dossier]) -> tuple[Family, ...]:
    names = [*dict.fromkeys(FAMILIES.values()), OWN]
    table: dict[str, list[SolverRow]] = {name: [] for name in names}
    for dossier in known:
        table[dossier.family].append(_row(dossier))
    anchors = slugs(names)
    return tuple(
        Family(anchors[name], name, tuple(sorted(rows, key=lambda row: row.solver.text)))
        for name, rows in table.items()
        if rows
    )


def _row(dossier: Dossier) -> SolverRow:
    number, measured = tally(dossier.findings), measured_orders(dossier)
    passed, limits = number[str(Verdict.PASS)], number[KNOWN_LIMIT]
    span = f"{order(min(measured))} to {order(max(measured))}" if measured else DASH
    return SolverRow(
        solver=Link(dossier.solver, dossier.file),
        mark=mark(dossier.findings),
        passed=count(passed),
        limits=count(limits),
        other=count(len(dossier.findings) - passed - limits),
        studies=count(len(dossier.records)),
        rug=rug(measured, [value for values in dossier.formal.values() for value in values]) if measured else "",
        orders=f"{count(len(measured))}: {span}" if measured else DASH,
    )
