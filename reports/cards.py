"""Cards of the studies on the overview: a picture, measured against accepted orders, verdicts and cost."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import quote

from mpmverify.convergence.verdict import Verdict
from mpmverify.judgement.findings import Finding

from .notation import number, order
from .overview import mark, shares
from .parts import Mark, Share
from .record import Record, Series
from .solver_names import family
from .thumbnails import HEIGHT, WIDTH, field_thumbnail, thumbnail

STRIP_WIDTH, STRIP_HEIGHT, LEFT, LARGEST = 260.0, 58.0, 8.0, 4.0
"""Box of the strip of orders, its margin, and the largest order on its axis; a larger one is drawn at the end."""
TOP, BOTTOM, RADIUS, STEP = 4.0, 42.0, 2.6, 5.4
"""Ends of the bands, radius of a dot, and distance of dots that lie above each other."""


@dataclass(frozen=True)
class Card:
    """A study on the overview.

    Parameters
    ----------
    study, title, href, summary : str
    mark : Mark
        The worst verdict.
    shares : tuple of Share
    picture, strip : str
        SVG of a final profile, and of the measured orders over the accepted bands; "" if there is none.
    orders : str
        What the strip shows, in a sentence.
    seconds : float
        Time of all runs [s].
    cost, solvers : str
        Number of runs and their time, and number of solvers.
    dimensions, families : tuple of str
    words : str
        Text that a search looks through, in lower case.
    """

    study: str
    title: str
    href: str
    mark: Mark
    shares: tuple[Share, ...]
    summary: str
    picture: str
    strip: str
    orders: str
    seconds: float
    cost: str
    solvers: str
    dimensions: tuple[str, ...]
    families: tuple[str, ...]
    words: str


def card(record: Record) -> Card:
    """Make the card of a study."""
    levels = [level for series in record.series for level in series.levels]
    families = tuple(dict.fromkeys(family((scheme,)) for scheme in record.schemes.values()))
    dimensions = tuple(f"{case.dimension}D" for case in record.cases)
    title = str(record.attributes["title"])
    words = (record.name, title, *(case.name for case in record.cases), *record.schemes, *families)
    return Card(
        study=record.name,
        title=title,
        href=f"{quote(record.name)}.html",
        mark=mark(record.findings),
        shares=shares(record.findings),
        summary=str(record.attributes["summary"]),
        picture=picture(record),
        strip=strip(record.series),
        orders=orders(record.series),
        seconds=round(sum(level.seconds for level in levels), 3),
        cost=f"{len(levels)} runs, {number(sum(level.seconds for level in levels), 2)} s",
        solvers=f"{len(record.schemes)} solver{'s' * (len(record.schemes) != 1)}",
        dimensions=tuple(sorted(set(dimensions))),
        families=families,
        words=" ".join(words).lower(),
    )


def picture(record: Record) -> str:
    """Draw a field in two or three dimensions, or the final profile of the first series that passed, as SVG; "" if there is none."""
    if drawn_field := field_thumbnail(record):
        return drawn_field
    shown = {case.name: case.shown for case in record.cases}
    known = [series for series in record.series if series.profile]
    for series in sorted(known, key=lambda entry: not entry.passed):
        assert series.profile
        quantity = shown[series.case] if shown[series.case] in series.profile.fields else next(iter(series.profile.fields))
        drawn = thumbnail(series.profile, quantity)
        if drawn and drawn.exact:
            return (
                f'<svg class="wave" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" preserveAspectRatio="none" aria-hidden="true">'
                f'<path class="exact" d="{drawn.exact}"/><path class="numerical" d="{drawn.numerical}"/></svg>'
            )
    return ""


def judged_orders(series: Sequence[Series]) -> list[tuple[float, float, float, bool]]:
    """Return (measured order, lowest and highest accepted order, whether the order lies between them) of each judged order."""
    table = []
    for entry in series:
        for measure, (low, high) in entry.bands.items():
            estimate = entry.estimates.get(measure)
            if estimate and math.isfinite(estimate.order):
                table.append((estimate.order, low, high, low <= estimate.order <= high))
    return table


def strip(series: Sequence[Series]) -> str:
    """Draw the measured orders as dots over the accepted bands, as SVG; "" if no order was judged.

    Dots of about the same order lie above each other. An order outside its band is drawn as a cross.
    """
    known = judged_orders(series)
    if not known:
        return ""
    parts = [
        f'<rect class="accepted" x="{_across(low):.1f}" y="{TOP:g}" width="{_across(high) - _across(low):.1f}" height="{BOTTOM - TOP:g}"/>'
        for low, high in sorted({(low, high) for _, low, high, _ in known})
    ]
    for whole in range(int(LARGEST) + 1):
        x = _across(whole)
        parts.append(f'<path class="tick" d="M{x:.1f} {BOTTOM:g}v4"/><text x="{x:.1f}" y="{STRIP_HEIGHT - 2:g}">{whole}</text>')
    columns: dict[int, int] = {}
    for value, _, _, inside in sorted(known, key=lambda one: one[3], reverse=True):
        column = round(_across(value) / (2 * RADIUS))
        above = columns[column] = columns.get(column, -1) + 1
        # A stack that is too high begins again at the bottom: the dots are translucent.
        y = BOTTOM - RADIUS - 1 - (above * STEP) % (BOTTOM - TOP - 2 * RADIUS)
        x = _across(value)
        parts.append(
            f'<circle class="dot-in" cx="{x:.1f}" cy="{y:.1f}" r="{RADIUS:g}"/>'
            if inside
            else f'<path class="dot-out" d="M{x - 3:.1f} {y - 3:.1f}l6 6m0-6l-6 6"/>'
        )
    axis = f'<path class="tick" d="M{LEFT:g} {BOTTOM:g}H{STRIP_WIDTH - LEFT:g}"/>'
    return f'<svg class="order-dots" viewBox="0 0 {STRIP_WIDTH:g} {STRIP_HEIGHT:g}" aria-hidden="true">{"".join(parts)}{axis}</svg>'


def _across(value: float) -> float:
    return LEFT + min(max(value, 0.0), LARGEST) / LARGEST * (STRIP_WIDTH - 2 * LEFT)


def orders(series: Sequence[Series]) -> str:
    """Say what the strip shows: "24 orders from 0.98 to 2.03, 24 in their bands"; "" if no order was judged."""
    known = judged_orders(series)
    if not known:
        return ""
    measured = [value for value, *_ in known]
    inside = sum(within for *_, within in known)
    if len(known) == 1:
        return f"1 order, {order(measured[0])}, {'in' if inside else 'outside'} the accepted band"
    return f"{len(known)} orders, {order(min(measured))} to {order(max(measured))}; {inside} in the accepted band"


def headline(findings: Sequence[Finding], judged: Sequence[Share]) -> str:
    """Say in a sentence what failed first and why, or that nothing did."""
    for verdict in (Verdict.FAIL, Verdict.ERROR):
        for finding in findings:
            if finding.verdict is verdict:
                where = f"{finding.study}, {finding.case}, {finding.solver}"
                return f"First {verdict}: {where}: {finding.criterion}: {finding.reason}."
    if not judged:
        return "Nothing was judged."
    if any(finding.verdict is Verdict.INCONCLUSIVE for finding in findings):
        return "Nothing failed; the evidence does not decide every criterion."
    limits = sum(finding.word != finding.verdict for finding in findings)
    return f"Every criterion holds; {limits} of them are known limits of a scheme." if limits else "Every criterion holds."


def changes(findings: Sequence[Finding]) -> str:
    """Say in a sentence how the errors compare with the baseline."""
    regression = [finding for finding in findings if finding.gate == "regression"]
    if not regression:
        return "No error was compared with a baseline."
    changed = sum(finding.verdict is Verdict.FAIL for finding in regression)
    compared = changed + sum(finding.verdict is Verdict.PASS for finding in regression)
    said = f"The errors of {changed or 'no'} series changed against the baseline, of {compared} that were compared"
    left = len(regression) - compared
    return f"{said}; {left} could not be compared." if left else f"{said}."
