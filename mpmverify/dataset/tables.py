"""Files of several studies read into flat tables, for the comparison of two sets of results."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from mpmverify.criteria.evidence import SeriesId, evidence_of
from mpmverify.dataset.fits import read_orders
from mpmverify.dataset.levels import read_levels
from mpmverify.dataset.study import parsing, read_study_groups, solvers, stored_findings
from mpmverify.dataset.tree import Group
from mpmverify.judgement.baseline import values_by_level
from mpmverify.judgement.tables import PROVENANCE, Order, Run, SeriesKey, Tables, verdicts_by_criterion


def read_tables(paths: Sequence[Path]) -> Tables:
    """Read the files of some studies.

    Raises
    ------
    ResultsError
        If a file is missing, unreadable, damaged, not an mpmverify study or of another schema.
    """
    tables = Tables({}, {}, {}, {}, {})
    for path in paths:
        groups = read_study_groups(path)
        with parsing(path):
            part = _tables(groups)
        tables = Tables(
            {**tables.provenance, **part.provenance},
            {**tables.runs, **part.runs},
            {**tables.errors, **part.errors},
            {**tables.orders, **part.orders},
            {**tables.verdicts, **part.verdicts},
        )
    return tables


def _tables(groups: Mapping[str, Group]) -> Tables:
    """Return the tables of one study."""
    attributes = groups["/"].attributes
    study = attributes["id"]
    runs: dict[tuple[SeriesKey, str], Run] = {}
    errors: dict[tuple[SeriesKey, str, str], tuple[float, float]] = {}
    orders: dict[tuple[SeriesKey, str], Order] = {}
    for solver, group in solvers(groups):
        levels = read_levels(solver, group)
        names: dict[SeriesId, set[str]] = {}
        for level in levels:
            series = SeriesKey(study, *level.series)
            # Each level alone: the evidence of a series omits what one of its levels lacks.
            seen = evidence_of([level])
            ((name, values),) = values_by_level(seen)
            names.setdefault(level.series, set()).add(name)
            runs[series, name] = Run(level.outcome, level.steps, level.point_steps, level.seconds)
            errors |= {(series, name, measure): error for measure, error in values.items()}
        for (identity, measure), fit in read_orders(group, levels).items():
            orders[SeriesKey(study, *identity), measure] = Order(*fit, frozenset(names[identity]))
    known = {series for series, _ in runs}
    every = verdicts_by_criterion(stored_findings(groups))
    verdicts = {
        judged: verdict for judged, verdict in every.items() if judged[0] in known
    }  # what was not run is lost, not worse
    return Tables({study: {name: str(attributes[name]) for name in PROVENANCE}}, runs, errors, orders, verdicts)
