"""Grid convergence indices of all levels of a quantity, as the procedure of Celik and others (2008) reports them."""

import math
from dataclasses import dataclass

from mpmverify.convergence.columns import Columns, Group, Size
from mpmverify.convergence.gci import CONFIRMED, UNCONFIRMED, Behaviour, GridConvergence, grid_convergence, observed_order
from mpmverify.convergence.levels import Numbers, levels
from mpmverify.errors import UsageError


@dataclass(frozen=True)
class GridLevel:
    """One level, compared with the next coarser one.

    Parameters
    ----------
    h, value : float
    change : float
        |f - f_coarser|/|f| [1]; NaN on the coarsest level.
    behaviour : Behaviour or None
        Of this level and the two coarser ones; None on the two coarsest levels.
    order : float
        Observed on the same three levels; NaN where there is none.
    limit : float
        Richardson extrapolation at this order, in the unit of the value; NaN where there is none.
    index : float
        Grid convergence index with a factor of safety of 1: |f - f_coarser|/(r^p - 1)/|f| [1]. The second coarsest level takes the
        order of the next finer one. NaN where no order is known.
    ratio : float
        The index of the coarser pair over r^p times that of this pair: 1 in the asymptotic range; NaN where no order is known.
    """

    h: float
    value: float
    change: float = math.nan
    behaviour: Behaviour | None = None
    order: float = math.nan
    limit: float = math.nan
    index: float = math.nan
    ratio: float = math.nan

    @property
    def confirmed(self) -> float:
        """Grid convergence index with the factor 1.25, for three levels or more [1]."""
        return CONFIRMED * self.index

    @property
    def unconfirmed(self) -> float:
        """Grid convergence index with the factor 3 [1]."""
        return UNCONFIRMED * self.index


def grid_levels(h: Numbers, value: Numbers | None = None, *, formal: float | None = None) -> tuple[GridLevel, ...]:
    """Orders, limits and grid convergence indices of a quantity, coarsest level first.

    Parameters
    ----------
    h, value : array-like
        As in `grid_convergence`; at least two levels.
    formal : float, optional
        Theoretical order of the scheme. The ratios are taken at it, and two levels alone need it.

    Raises
    ------
    UsageError
        If `levels` refuses the series, a size is given twice, the formal order is not positive and finite, or there are fewer than three
        levels without a formal order.

    Notes
    -----
    The order is that of `grid_convergence`. Where the two changes have opposite signs, it is the one that Celik et al. give, with +1 in
    place of -1, and the behaviour is oscillatory. At the order that was observed on the same three levels, the ratio is the quotient of
    the two finer values, and close to 1 whatever the range; at the formal order it is a test.

    References
    ----------
    Celik I. B., Ghia U., Roache P. J., Freitas C. J. (2008), https://doi.org/10.1115/1.2960953
    Slater J. W., Examining spatial (grid) convergence. NPARC Alliance CFD Verification and Validation Web Site, NASA Glenn Research Center.
    """
    if formal is not None and not (math.isfinite(formal) and formal > 0):
        raise UsageError(f"the formal order must be positive, not {formal:g}")
    sizes, values = (array.tolist() for array in levels(h, value))
    if len(set(sizes)) < len(sizes):
        raise UsageError("a grid convergence index needs one value at each size")
    if len(sizes) < (3 if formal is None else 2):
        needed = "three levels, or two and the formal order" if formal is None else "two levels"
        raise UsageError(f"a grid convergence index needs {needed}")
    found = [GridLevel(sizes[0], values[0])]
    for k in range(1, len(sizes)):
        behaviour, order = (None, math.nan) if k == 1 else _observed(sizes[k - 2 : k + 1], values[k - 2 : k + 1])
        at = order
        if k == 1:
            at = _observed(sizes[:3], values[:3])[1] if len(sizes) > 2 else formal or math.nan
        step, ratio = values[k] - values[k - 1], sizes[k - 1] / sizes[k]
        asymptotic = math.nan if k == 1 else _ratio(sizes[k - 2 : k + 1], values[k - 2 : k + 1], formal or order)
        limit = values[k] + _rest(step, ratio, order)
        index = _relative(_rest(step, ratio, at), values[k])
        found.append(GridLevel(sizes[k], values[k], _relative(step, values[k]), behaviour, order, limit, index, asymptotic))
    return tuple(found)


def _observed(h: list[float], value: list[float]) -> tuple[Behaviour, float]:
    """Behaviour and order on three levels; NaN where the values do not converge."""
    coarse, fine = value[1] - value[0], value[2] - value[1]
    if not math.isfinite(coarse + fine):
        return Behaviour.NON_FINITE, math.nan
    if fine == 0:
        return Behaviour.CONSTANT, math.nan
    alternating = coarse * fine < 0
    order = observed_order(h[0] / h[1], h[1] / h[2], abs(coarse / fine), alternating=alternating) if coarse else -math.inf
    if not 0 < order < math.inf:
        return Behaviour.DIVERGENT, math.nan
    return Behaviour.OSCILLATORY if alternating else Behaviour.MONOTONE, order


def _rest(step: float, ratio: float, order: float) -> float:
    """Distance from the finer of two values to the limit."""
    return step / math.expm1(order * math.log(ratio))


def _relative(difference: float, value: float) -> float:
    return abs(difference / value) if value else math.nan


def _ratio(h: list[float], value: list[float], order: float) -> float:
    coarse, fine = (
        _relative(_rest(value[k] - value[k - 1], h[k - 1] / h[k], order), value[k]) if math.isfinite(order) else math.nan
        for k in (1, 2)
    )
    return coarse / fine / (h[1] / h[2]) ** order if fine else math.nan


@dataclass(frozen=True)
class GridColumn:
    """Values of one column of a table in one group of rows.

    Parameters
    ----------
    column : str
    group : Group
    size : Size
    levels : tuple of GridLevel
        Coarsest first.
    band : GridConvergence or None
        Band around the finest value that contains the limit, where the formal order is known.
    missing : tuple of str
        Sizes and lines of levels without a value.
    """

    column: str
    group: Group
    size: Size
    levels: tuple[GridLevel, ...]
    band: GridConvergence | None
    missing: tuple[str, ...]

    @property
    def name(self) -> str:
        return self.group.named(self.column)


def grid_table(columns: Columns, *, formal: float | None = None) -> tuple[GridColumn, ...]:
    """Grid convergence of every column of values of a table.

    Raises
    ------
    UsageError
        If sizes vary independently, or `grid_levels` refuses a column.
    """
    return tuple(_column(columns, name, group, formal) for group in columns.groups for name in columns.judged)


def _column(columns: Columns, name: str, group: Group, formal: float | None) -> GridColumn:
    if not group.axis.together:
        raise UsageError(f"{group.axis.note}: a grid convergence index needs a ladder in one of them")
    size, rows, missing = columns.size(group), *columns.given(name, group)
    h, value = size.values[rows], columns.table.numbers(name)[rows]
    try:
        levels_of = grid_levels(h, value, formal=formal)
        band = None if formal is None else grid_convergence(h, value, formal=formal)
    except UsageError as error:
        raise UsageError(f"column {name!r}: {error}") from error
    return GridColumn(name, group, size, levels_of, band, missing)
