"""Data of the charts on the page of a study, which the script of the report draws."""

from collections.abc import Sequence

from . import charts
from .balances import balances, errors
from .field_panel import escaped
from .notation import cell_size
from .phase import motions
from .record import Series
from .styles import Style
from .theory import Theory


def figures(
    series: Sequence[Series],
    curve_styles: Sequence[Style],
    convergence: charts.Figure,
    known_theory: Theory | None,
    units: dict[str, str],
    outputs: int,
    dominance: list[charts.Figure],
) -> str:
    """Return the data of the charts of a case as JSON, escaped for use in HTML.

    Parameters
    ----------
    series, curve_styles : sequences
        Series of the case, with the style of each.
    convergence : Figure
        Chart of errors and orders.
    known_theory : Theory or None
    units : dict of str to str
        Unit of each quantity that has a profile.
    outputs : int
        Largest number of output times of a profile.
    dominance : list of Figure
    """
    table = []
    for entry, style in zip(series, curve_styles, strict=True):
        time = entry.histories.get("time")
        table.append(
            {
                "paint": style.paint,
                "symbol": style.symbol,
                "seconds": [charts.sig(level.seconds) for level in entry.levels],
                "steps": [level.point_steps for level in entry.levels],
                "h": cell_size(entry.profile.h) if entry.profile else "",
                "waves": charts.waves(entry.profile, outputs) if entry.profile else None,
                "time": charts.floats(time) if time is not None else None,
                "histories": [
                    charts.history(part)
                    for part in (*errors(entry), *motions(entry), *(balances(entry) if time is not None else ()))
                ],
            }
        )
    body = {
        "convergence": convergence,
        "theory": known_theory and known_theory.figure,
        "dominance": dominance,
        "waves": charts.wave_figures(units),
        "history": charts.history_layout(),
        "series": table,
    }
    return escaped(body)
