"""The page of a study."""

import re
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any

from mpmverify.convergence.verdict import Verdict

from . import charts
from .balances import balances
from .bibliography import downloadable
from .dominance import maps, source_rows
from .drawing import drawing
from .equations import mathml
from .failures import Failure, failures
from .field_panel import field_panels
from .figures import figures
from .notation import MINUS, NORM_NAMES, cell_size, count, ladder, number, order, size, typeset_numbers
from .orders import first_measure, measures, order_tables
from .overview import (
    case_anchors,
    gate_marks,
    judgements,
    mark,
    matrix,
    origin,
    shares,
    solver_anchors,
    verdict_anchors,
)
from .pages import CaseSection, StudyPage
from .parts import Curve, Fact, Link, Option, RunRow, Scheme
from .record import Case, Measure, Record, Series
from .solver_names import pages_of
from .still import still
from .styles import STROKES, Style, selection, styles
from .theory import theory
from .thumbnails import thumbnail
from .verdict_groups import verdict_groups

PAGE, ROW = 5_850_000, 2_400
"""Characters that a page may take, and those that a verdict takes with its run, about."""
LEAST, MOST = 700_000, 2_000_000
"""Characters that the fields of a page may take whatever else is on it, and where nothing else is, about."""
DOUBTFUL = 8
"""Largest number of series that did not pass and are drawn at first in addition to the selection."""


def study_page(record: Record, runs: Set[str], generator: str) -> StudyPage:
    """Make the page of a study; `runs` are the keys of the run files that exist."""
    anchors, places = case_anchors(record), verdict_anchors(record)
    failed = failures(record, places, runs)
    curve_styles = styles(record.series)
    outputs = charts.outputs_within_budget([entry.profile for entry in record.series if entry.profile])
    sections = []
    doubtful = {finding.case for finding in record.judged if finding.verdict in (Verdict.FAIL, Verdict.ERROR)}
    unfolded = doubtful or {case.name for case in record.cases[:1]}
    for case in record.cases:
        chosen = [(entry, style) for entry, style in zip(record.series, curve_styles, strict=True) if entry.case == case.name]
        series, styled = [entry for entry, _ in chosen], [style for _, style in chosen]
        section = _section(record, case, anchors[case.name], places, failed, series, styled, outputs, runs)
        sections.append(replace(section, unfolded=case.name in unfolded))
    room = PAGE - sum(len(section.figures) for section in sections) - ROW * len(record.judged)
    drawn = {section.name: [curve.index for curve in section.curves if curve.shown] for section in sections}
    panels = field_panels(record, drawn, min(MOST, max(LEAST, room)))
    formal, pages = {entry.solver: entry.formal for entry in record.series}, pages_of(record)
    cases = [case.name for case in record.cases]
    return StudyPage(
        title=str(record.attributes["title"]),
        generator=generator,
        root="",
        navigation=(Link("Overview", "index.html"), Link("Solvers", "solvers.html"), Link("Problems", "problems.html")),
        restricted_to=record.restricted_to,
        summary=str(record.attributes["summary"]),
        gates=gate_marks(record.findings),
        shares=shares(record.findings),
        lacking=judgements(record.lacking, lambda _: "#lacking"),
        failures=tuple(failed.values()),
        columns=tuple(Link(name, f"#{anchors[name]}") for name in cases),
        rows=matrix(
            record.judged,
            cases,
            lambda finding: finding.case,
            lambda case, solver: f"#{places[case, solver]}",
            solver_anchors(record),
            pages,
        ),
        schemes=tuple(
            Scheme(name, pages[name], scheme, _orders(formal.get(name, {}))) for name, scheme in record.schemes.items()
        ),
        cases=tuple(replace(section, field=panels.get(section.name)) for section in sections),
        bibliography=downloadable(_sources(record), record.name),
        origins=(origin(record),),
    )


def _sources(record: Record) -> Iterator[str]:
    """Yield the texts that cite the sources of the problems and of the criteria."""
    yield from (case.citation for case in record.cases)
    yield from dict.fromkeys(finding.source for finding in record.judged)


def _orders(formal: Any) -> str:
    return ", ".join(f"{quantity} {value:g}" for quantity, value in formal.items())


def _section(
    record: Record,
    case: Case,
    anchor: str,
    places: Mapping[tuple[str, str], str],
    failed: Mapping[tuple[str, str, str], Failure],
    series: Sequence[Series],
    curve_styles: Sequence[Style],
    outputs: int,
    runs: Set[str],
) -> CaseSection:
    findings = [finding for entry in series for finding in entry.findings]
    shown = first_measure([entry for entry in series if entry.axis], case.shown)
    sources = list(dict.fromkeys(finding.source for finding in findings))
    units = {quantity: unit for entry in series if entry.profile for quantity, unit in entry.profile.units.items()}
    first = case.shown if case.shown in units else next(iter(units), "")
    known_theory = theory(series, curve_styles)
    # On a coarse grid a mode ends out of phase by many periods. Its errors show no order and are left out if no order is judged.
    convergent = known_theory is None or any(entry.bands for entry in series)
    ladders = [entry for entry in series if entry.axis and convergent]
    known = measures(ladders)
    dominance = maps(series)
    curves = _curves(series, curve_styles, shown, first)
    errors = charts.convergence(series, curve_styles, known)
    drawn, legend = drawing(dict(case.setup))
    return CaseSection(
        anchor=anchor,
        name=case.name,
        unfolded=False,
        mark=mark(findings),
        gates=gate_marks(findings),
        exposes=case.exposes,
        citation=case.citation,
        equations=tuple(mathml(latex) for latex in case.equations),
        setup=tuple(_fact(name, value) for name, value in case.setup),
        drawing=drawn,
        legend=legend,
        quantities=_options([q for q, _ in known], shown and shown[0], {}),
        norms=_options([norm for _, norm in known], shown and shown[1], NORM_NAMES),
        charted=_charted(ladders),
        theory=known_theory,
        curves=curves,
        still=still(errors, charts.key(shown), [curve.index for curve in curves if curve.shown]) if shown else "",
        wave_quantities=_options(list(units), first, {}),
        histories=() if units else _recorded(series, curves),
        thumbnail_quantity=first,
        tables=order_tables(ladders, shown),
        source_rows=source_rows(series),
        maps=tuple(str(figure["title"]) for figure in dominance),
        groups=verdict_groups(record, findings, places, failed, sources),
        sources=tuple(sources),
        runs=tuple(row for entry in series for row in _runs(entry, runs)),
        cost=_cost(series),
        figures=figures(series, curve_styles, errors, known_theory, units, outputs, dominance),
    )


def _fact(name: str, value: str) -> Fact:
    name = re.sub(r"^face (\w)([+-])$", lambda face: f"face {face[1]}{face[2].replace('-', MINUS)}", name)
    return Fact(name, typeset_numbers(value).replace(" = ", "\u00a0=\u00a0"))


def _options(values: Sequence[str], selected: str | None, names: dict[str, str]) -> tuple[Option, ...]:
    return tuple(Option(value, names.get(value, value), value == selected) for value in dict.fromkeys(values))


def _recorded(series: Sequence[Series], curves: Sequence[Curve]) -> tuple[Option, ...]:
    """Series with histories to draw; the first one that the convergence chart shows is selected."""
    named = [
        (curve, f"{curve.solver}, {curve.ladder}") for curve, entry in zip(curves, series, strict=True) if any(balances(entry))
    ]
    first = next((curve.index for curve, _ in named if curve.shown), named[0][0].index if named else 0)
    return tuple(Option(str(curve.index), text, curve.index == first) for curve, text in named)


def _charted(series: Sequence[Series]) -> bool:
    levels = any(len(entry.levels) > 1 for entry in series)
    return levels and any((estimate.error > 0).any() for entry in series for estimate in entry.estimates.values())


def _curves(series: Sequence[Series], curve_styles: Sequence[Style], shown: Measure | None, quantity: str) -> tuple[Curve, ...]:
    doubtful = [k for k, entry in enumerate(series) if shown in entry.estimates and not entry.passed]
    chosen = selection(series, shown) | set(doubtful[:DOUBTFUL])
    curves = []
    for k, (entry, style) in enumerate(zip(series, curve_styles, strict=True)):
        estimate = entry.estimates.get(shown) if shown else None
        curve = Curve(
            index=k,
            solver=entry.solver,
            ladder=ladder(entry.refinement),
            order=order(estimate.order) if estimate else "",
            shown=k in chosen,
            passed=entry.passed,
            paint=style.paint,
            stroke=STROKES[style.dash],
            symbol=style.symbol,
            thumbnail=thumbnail(entry.profile, quantity) if entry.profile else None,
            mark=mark(entry.verified),
        )
        curves.append(curve)
    return tuple(curves)


def _runs(entry: Series, runs: Set[str]) -> list[RunRow]:
    return [
        RunRow(
            solver=entry.solver,
            ladder=ladder(entry.refinement),
            h=cell_size(level.h),
            dt=size(level.dt),
            courant=size(level.courant),
            ppc=count(level.ppc),
            steps=count(level.steps),
            point_steps=count(level.point_steps),
            seconds=number(level.seconds, 2),
            outcome=level.outcome,
            href=f"../runs/{level.run}.nc" if level.run in runs else "",
        )
        for level in entry.levels
    ]


def _cost(series: Sequence[Series]) -> str:
    levels = [level for entry in series for level in entry.levels]
    steps = sum(level.point_steps for level in levels)
    return f"{len(levels)} runs, {number(float(steps))} point-steps, {number(sum(level.seconds for level in levels), 2)} s"
