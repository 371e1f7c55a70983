"""The index page: an overview of all studies and solvers."""

from collections.abc import Sequence
from urllib.parse import quote

from mpmverify.convergence.verdict import exit_status

from .cards import card, changes, headline
from .notation import slugs
from .overview import MEANING, judgements, mark, matrix, not_passed, origin, shares, solver_anchors, verdict_anchors
from .pages import IndexPage
from .parts import Link, Matrix
from .record import Record
from .solver_names import family, pages_of
from .verdict_changes import verdict_changes


def index_page(records: Sequence[Record], generator: str, further: Sequence[Link] = ()) -> IndexPage:
    """Make the index page from all studies; `further` are links to pages that not every report has."""
    findings = [finding for record in records for finding in record.findings]
    places = {record.name: verdict_anchors(record) for record in records}
    judged = shares(findings)
    cards = tuple(card(record) for record in records)
    return IndexPage(
        title="Verification report",
        generator=generator,
        root="",
        navigation=(
            Link("Overview", "index.html", True),
            Link("Solvers", "solvers.html"),
            Link("Problems", "problems.html"),
            *further,
        ),
        mark=mark(findings),
        headline=headline(findings, judged),
        changes=changes(findings),
        runs=verdict_changes(records, places),
        made=_made(records),
        shares=judged,
        lacking=judgements([f for record in records for f in record.lacking], lambda f: f"{f.study}.html#lacking"),
        exit_status=MEANING[exit_status([finding.verdict for finding in findings], strict=True)],
        cards=cards,
        verdicts=tuple(dict.fromkeys(entry.mark.text for entry in sorted(cards, key=lambda entry: entry.mark.text))),
        dimensions=tuple(sorted({dimension for entry in cards for dimension in entry.dimensions})),
        families=tuple(dict.fromkeys(family for entry in cards for family in entry.families)),
        matrices=_matrices(records),
        groups=not_passed(findings, lambda f: f"{f.study}.html#{places[f.study].get((f.case, f.solver), 'lacking')}"),
        origins=tuple(origin(record) for record in records),
    )


def _matrices(records: Sequence[Record]) -> tuple[Matrix, ...]:
    """Return the verdict matrix of each family of solvers; its columns are the studies that any of them ran."""
    family_of = {solver: family((scheme,)) for record in records for solver, scheme in record.schemes.items()}
    anchors = {solver: f"solver-{anchor}" for solver, anchor in slugs(list(family_of)).items()}
    places = {record.name: solver_anchors(record) for record in records}
    pages = {solver: file for record in records for solver, file in pages_of(record).items()}
    table = []
    for name in dict.fromkeys(family_of.values()):
        mine = {solver: anchor for solver, anchor in anchors.items() if family_of[solver] == name}
        judged = [finding for record in records for finding in record.judged if finding.solver in mine]
        studies = [record for record in records if any(finding.study == record.name for finding in judged)]
        table.append(
            Matrix(
                name,
                f"{len(mine)} solver{'s' * (len(mine) != 1)} in {len(studies)} stud{'ies' if len(studies) != 1 else 'y'}",
                mark(judged),
                tuple(Link(str(record.attributes["title"]), f"{quote(record.name)}.html") for record in studies),
                matrix(
                    judged,
                    [record.name for record in studies],
                    lambda finding: finding.study,
                    lambda study, solver: f"{study}.html#{places[study][solver]}",
                    mine,
                    pages,
                ),
            )
        )
    return tuple(table)


def _made(records: Sequence[Record]) -> str:
    """Say from which commit, tier and platform the results are, and when the last of them was written."""
    if not records:
        return ""
    origins = [{fact.name: fact.value for fact in origin(record).facts} for record in records]
    several = {name: list(dict.fromkeys(facts[name] for facts in origins)) for name in ("Commit", "Tier", "Platform")}
    commit, tier, platform = (values[0] if len(values) == 1 else f"{len(values)} different" for values in several.values())
    return f"Commit {commit}, {tier} tier, {platform}; written {max(facts['Written'] for facts in origins)}."
