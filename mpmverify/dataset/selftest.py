"""The result of a self-test as one DataTree: the outcome of each planted fault and of each run of the unmodified solvers.

Layout
------
/          number of faults that the rules made, provenance
/faults    one row per fault: rule, place, original and faulty source, outcome and the criterion that detected it
/runs      one row per unmodified run: processes, threads, seed and worst verdict
/series, /designs, /limits  one row per kind of random series: numbers of right, wrong and missing verdicts
"""

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import netCDF4

from mpmverify.atomic import write_atomic
from mpmverify.convergence.synthetic import Rate
from mpmverify.dataset import provenance
from mpmverify.dataset.files import check_ours, damaged, make_way
from mpmverify.dataset.tree import CHECKSUM, Group, read_groups, text, variable, write_groups
from mpmverify.judgement.kill_table import Fate, PlantedFault, Rates, SelfTest, UnmodifiedRun

KINDS: dict[str, type[Any]] = {"fault": PlantedFault, "run": UnmodifiedRun, "kind": Rate}
RATES = tuple(entry.name for entry in dataclasses.fields(Rates))
UNITS = {"seconds": "s"}
WORDS = {"deviation": "largest relative deviation from the results of the original", "seconds": "wall time with compilation"}


def write_selftest(path: Path, test: SelfTest) -> None:
    """Write the result of a self-test.

    Raises
    ------
    ResultsError
        If `path` exists and is not an mpmverify self-test, or the file cannot be written.
    """
    make_way(path, "selftest")
    attributes = provenance.attributes(
        "selftest", "Planted faults", "Verdicts on solvers with one fault each, and on random series of known truth."
    )
    said = {"id": "selftest", "tier": test.tier, "sites": test.sites, "every_study": int(test.every_study)}
    groups = {
        "/": Group(attributes=attributes | said),
        "/faults": _columns("fault", test.faults),
        "/runs": _columns("run", test.runs),
    }
    groups |= {f"/{name}": _columns("kind", getattr(test.rates, name)) for name in RATES}
    write_atomic(path, lambda temporary: write_groups(temporary, groups))


def _columns(dimension: str, rows: Sequence[Any]) -> Group:
    variables = {}
    for entry in dataclasses.fields(KINDS[dimension]):
        values = [getattr(row, entry.name) for row in rows]
        attributes = {"long_name": WORDS.get(entry.name, entry.name)}
        if values and isinstance(values[0], str):
            variables[entry.name] = variable(dimension, text(values), attributes)
        else:
            variables[entry.name] = variable(dimension, values, attributes | {"units": UNITS.get(entry.name, "1")})
    return Group(variables)


def read_selftest(path: Path) -> SelfTest:
    """Read the result of a self-test.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, damaged or not an mpmverify self-test.
    """
    attributes = check_ours(path, "selftest")
    try:
        with netCDF4.Dataset(path) as file:
            digest, groups = read_groups(file)
        if attributes.get(CHECKSUM) != digest:
            raise damaged(path)
        faults = tuple(dataclasses.replace(row, fate=Fate(row.fate)) for row in _rows(PlantedFault, groups["/faults"]))
        runs = _rows(UnmodifiedRun, groups["/runs"])
        rates = Rates(*(_rows(Rate, groups[f"/{name}"]) for name in RATES))
        every_study = bool(attributes["every_study"])
        return SelfTest(str(attributes["tier"]), int(attributes["sites"]), faults, runs, rates, every_study)
    except (OSError, RuntimeError, AttributeError, ValueError, TypeError, LookupError) as error:
        raise damaged(path) from error


def _rows(kind: Any, group: Group) -> tuple[Any, ...]:
    column = group.columns
    columns = [column[entry.name].tolist() for entry in dataclasses.fields(kind)]
    return tuple(kind(*row) for row in zip(*columns, strict=True))
