"""Verdicts on the errors of a table: one for each column and group of rows."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from mpmverify.convergence.columns import Columns, Group, Size
from mpmverify.convergence.fits import fit_order
from mpmverify.convergence.levels import Array
from mpmverify.convergence.order_verdict import PLAUSIBLE, verdict
from mpmverify.convergence.series import FLAT, ROUND_OFF, Convergence, analyse
from mpmverify.convergence.verdict import Judgement, Verdict
from mpmverify.errors import UsageError

if TYPE_CHECKING:
    from mpmverify.convergence.sources import Separation

ByColumn = Mapping[str, float]
"""Numbers by column; "" holds for all others."""


@dataclass(frozen=True)
class Demands:
    """What the errors of a table have to show.

    Parameters
    ----------
    low, high : mapping of str to float
        Edges of the band of orders by column of errors; in a design by size, too. "" holds for all others.
    scale : mapping of str to float
        Size of the solution, by which absolute errors are divided, by column of errors. "" holds for all others.
    round_off : float
        As in `analyse`.
    uncertainty : float
        As in `analyse`, in the unit of the table.
    exact : float, optional
        As in `verdict`.

    Raises
    ------
    UsageError
        If a scale is not positive and finite, or the error at round-off is negative or not finite.
    """

    low: ByColumn = field(default_factory=dict)
    high: ByColumn = field(default_factory=dict)
    scale: ByColumn = field(default_factory=dict)
    round_off: float = ROUND_OFF
    uncertainty: float = 0.0
    exact: float | None = None

    def __post_init__(self) -> None:
        for scale in self.scale.values():
            if not 0 < scale < np.inf:
                raise UsageError(f"the scale must be positive and finite, not {scale:g}")
        if not 0 <= self.round_off < np.inf:
            raise UsageError(f"the error at round-off must not be negative, and finite, but is {self.round_off:g}")

    def band(self, *names: str) -> tuple[float, float] | None:
        """Band for the first of these names that has an edge, or else for all; None without one."""
        for name in (*names, ""):
            low, high = self.low.get(name), self.high.get(name)
            if not low is high is None:
                low = self.low.get("", FLAT) if low is None else low
                return low, self.high.get("", PLAUSIBLE) if high is None else high
        return None


@dataclass(frozen=True)
class JudgedColumn:
    """Errors of one column in one group of rows, and the verdict on them.

    Parameters
    ----------
    column : str
    group : Group
    sizes : tuple of Size
        One for a ladder, several for a design.
    verdict : Verdict
    reason : str
    series : Convergence or None
        Of a ladder, with errors relative to the scale.
    separation : Separation or None
        Of a design.
    orders : mapping of int to float
        Observed order between a row of the table and the next coarser level; only the first row of a level has one.
    round_off : float
    """

    column: str
    group: Group
    sizes: tuple[Size, ...]
    verdict: Verdict
    reason: str
    series: Convergence | None = None
    separation: "Separation | None" = None
    orders: Mapping[int, float] = field(default_factory=dict)
    round_off: float = ROUND_OFF

    @property
    def name(self) -> str:
        return self.group.named(self.column)

    @property
    def has_round_off(self) -> bool:
        """Whether an error is taken for round-off, and is not zero."""
        return self.series is not None and bool(np.any((self.series.error > 0) & (self.series.error <= self.round_off)))


def judge_table(columns: Columns, demands: Demands) -> tuple[JudgedColumn, ...]:
    """Judge every column of errors of a table.

    Raises
    ------
    UsageError
        If a demand names no column, every error falls as a count grows that was taken for a size, an error is negative, or `verdict`
        refuses a series.
    """
    known = {"", *columns.judged, *(name for size in columns.sizes.values() for name in (size.column, size.symbol))}
    for name in (*demands.low, *demands.high, *demands.scale):
        if name not in known:
            raise UsageError(f"{name!r} is no column that is judged: choose from {', '.join(sorted(known - {''}))}")
    _refuse_counts(columns)
    return tuple(_judged(columns, name, group, demands) for group in columns.groups for name in columns.judged)


def _refuse_counts(columns: Columns) -> None:
    """Refuse a table whose errors all fall as the size grows, unless the size is one by its name."""
    slopes = []
    for group in columns.groups:
        size = columns.size(group)
        if size.sure or not group.axis.together:
            return
        for name in columns.judged:
            error = columns.table.numbers(name)[group.rows]
            usable = np.isfinite(error) & (error > 0)
            if len(set(size.values[group.rows][usable])) > 1:
                slopes.append(fit_order(size.values[group.rows][usable], error[usable]).order)
    if slopes and max(slopes) < -FLAT:
        raise UsageError(
            f"every error in {columns.table.place} falls as {size.column!r} grows, so it is a count and no size: turn it into one "
            f"by --h {size.column} and --cells DIM, --dofs DIM or --levels RATIO"
        )


def _judged(columns: Columns, name: str, group: Group, demands: Demands) -> JudgedColumn:
    table = columns.table
    (rows, missing), errors = columns.given(name, group), table.numbers(name)
    for row in rows:
        if errors[row] < 0:
            raise UsageError(
                f"{table.place}, line {table.rows[row][0]}: the error {table.cells(name)[row]} in column {name!r} is negative: "
                "give magnitudes, or judge values by `mpmverify gci`"
            )
    scale = demands.scale.get(name, demands.scale.get("", 1.0))
    sizes = tuple(columns.sizes[axis] for axis in group.axis.varied if axis in columns.sizes) or (columns.size(group),)
    if group.axis.together:
        sizes = (columns.size(group),)
    if not len(rows):
        return JudgedColumn(name, group, sizes, Verdict.INCONCLUSIVE, "no level has an error")
    try:
        judged = _ladder if group.axis.together or demands.exact is not None else _design
        found = judged(name, group, sizes, rows, errors[rows] / scale, demands, scale)
    except UsageError as error:
        raise UsageError(f"column {name!r}: {error}") from error
    notes = [group.axis.note] if group.axis.together and len(group.axis.varied) > 1 else []
    notes += [f"no error is given at {', '.join(missing)}"] if missing else []
    return replace(found, reason="; ".join((found.reason, *notes)))


def _ladder(
    name: str, group: Group, sizes: tuple[Size, ...], rows: np.ndarray, error: Array, demands: Demands, scale: float
) -> JudgedColumn:
    h, band, uncertainty = sizes[0].values[rows], demands.band(name), demands.uncertainty / scale
    symbol = sizes[0].symbol
    found, reason = verdict(
        h, error, band=band, round_off=demands.round_off, uncertainty=uncertainty, exact=demands.exact, size=symbol
    )
    series = analyse(h, error, expected=band, round_off=demands.round_off, uncertainty=uncertainty, size=symbol)
    first = np.flatnonzero(np.diff(series.h, prepend=series.h[0]))  # of each size but the coarsest, in the series
    orders = {int(rows[np.argmin(np.abs(h - series.h[k]))]): float(series.pairwise[k - 1]) for k in first}
    return JudgedColumn(name, group, sizes, found, reason, series, orders=orders, round_off=demands.round_off)


def _design(
    name: str, group: Group, sizes: tuple[Size, ...], rows: np.ndarray, error: Array, demands: Demands, scale: float
) -> JudgedColumn:
    from mpmverify.convergence.sources import describe, judge_sources, separate  # they take a third of a second to load

    if demands.uncertainty:
        raise UsageError("the sources of error are separated without an uncertainty: leave out --uncertainty")
    if not np.all(np.isfinite(error)):
        return JudgedColumn(name, group, sizes, Verdict.ERROR, "the error is not finite on at least one run")
    separation = separate({size.symbol: size.values[rows] for size in sizes}, error)
    bands = [(size.symbol, *band) for size in sizes if (band := demands.band(size.symbol, size.column, name))]
    judgement: Judgement = judge_sources(separation, bands)
    if not bands and not separation.obstacle:
        told = ", ".join(describe(source) for source in separation.sources)
        judgement = Verdict.INCONCLUSIVE, f"{told}; without a band to expect it in, no exponent passes"
    return JudgedColumn(name, group, sizes, *judgement, separation=separation)
