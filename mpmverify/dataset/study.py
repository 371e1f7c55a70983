"""The file of a study, one DataTree: levels, errors, fits and verdicts by solver, and the fields that the report shows.

Layout
------
/                    case metadata, provenance, verdicts that changed since the run before
/<solver>            error(level, quantity, norm), absolute errors and exact norms by quantity, fits by series, verdicts by criterion
/<solver>/snapshots  fields of one level of each series: contiguous ragged arrays, one row per output time, one variable per component
/<solver>/histories  energy, momentum, mass and impulse of the same runs: contiguous ragged arrays, one row per series

Runs in two and three dimensions have other components and units; their groups are `snapshots_2d`, `histories_3d` and so on.
"""

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import netCDF4

from mpmverify.atomic import write_atomic
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import Level, SeriesId
from mpmverify.dataset import provenance
from mpmverify.dataset.criteria import criterion_table, read_criteria
from mpmverify.dataset.files import SCHEMA, check_ours, damaged, make_way
from mpmverify.dataset.findings import finding_table, lacking_attribute, read_findings, read_lacking
from mpmverify.dataset.fits import fit_table
from mpmverify.dataset.history import change_table, history
from mpmverify.dataset.levels import level_table, read_levels
from mpmverify.dataset.snapshots import Snapshots, snapshot_groups
from mpmverify.dataset.sources import source_table
from mpmverify.dataset.statement import statement
from mpmverify.dataset.tree import CHECKSUM, Group, Variable, read_groups, text, variable, write_groups
from mpmverify.errors import MpmverifyError, ResultsError
from mpmverify.judgement.findings import Finding
from mpmverify.judgement.judging import Judged
from mpmverify.study import Study


def write_study(
    path: Path,
    study: Study,
    levels: Sequence[Level],
    snapshots: Mapping[SeriesId, Snapshots],
    judged: Judged,
    *,
    tier: str,
    inputs: str,
    run: str,
    problems: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Group]:
    """Write the file of a judged study, with what has changed since the file that it replaces, and return its groups by path.

    Parameters
    ----------
    path : Path
        File to write. A file that is not an mpmverify study is never overwritten.
    study : Study
        Declaration of the study.
    levels : sequence of Level
        Errors, metrics and work of every run.
    snapshots : mapping of SeriesId to Snapshots
        Runs whose fields and histories the report shows.
    judged : Judged
        Findings, fits and separations of the study.
    tier : str
        "quick" or "full".
    inputs : str
        Digest of everything that the file depends on; "" if the file must be written again at the next run.
    run : str
        Start of the run that judged the study, by ISO 8601.
    problems : mapping of str to str
        Digest of the problem of each case: by them a reader knows whether the cases are those of another study of this name.

    Raises
    ------
    ResultsError
        If `path` is not an mpmverify study, or the file cannot be written.
    """
    make_way(path, "study")
    series = [finding for findings in judged.by_series.values() for finding in findings]
    past = history(path, run, inputs, series, study.restricted_to)
    attributes = lacking_attribute(judged.missing_series) | {"problems": json.dumps(dict(problems))}
    root = _root(study, tier, inputs, sorted({level.seed for level in levels if level.jitter}))
    groups = {"/": root.joined(change_table(past)).joined(Group(attributes=attributes))}
    declared = study.criteria()
    for name, solver in study.solvers().items():
        mine = [level for level in levels if level.solver == name]
        findings = [finding for series, some in judged.by_series.items() if series.solver == name for finding in some]
        said = Group(attributes={"solver": name, "scheme": _describe(solver), "orders": json.dumps(dict(solver.orders))})
        for part in (
            level_table(mine),
            criterion_table(name, declared),
            fit_table(mine, judged),
            source_table(name, judged),
            finding_table(findings),
        ):
            said = said.joined(part)
        groups[f"/{name}"] = said
        shown = [shot for series, shot in snapshots.items() if series.solver == name]
        groups |= {f"/{name}/{group}": part for group, part in snapshot_groups(shown).items()}
    checksum = write_atomic(path, lambda temporary: write_groups(temporary, groups))
    return groups | {"/": groups["/"].joined(Group(attributes={CHECKSUM: checksum}))}


def _describe(value: Any) -> str:
    shown = [f.name for f in dataclasses.fields(value) if f.repr] if dataclasses.is_dataclass(value) else []
    choices = ", ".join(f"{name}={getattr(value, name)!r}" for name in shown)
    return f"{type(value).__name__}({choices})"


def _root(study: Study, tier: str, inputs: str, seeds: Sequence[int]) -> Group:
    def each(read: Any) -> Variable:
        return variable("study_case", text([read(case) for case in study.cases]))

    return Group(
        {
            "exposes": each(lambda case: case.problem.exposes),
            "citation": each(lambda case: case.problem.exact.citation),
            "equations": each(lambda case: json.dumps(case.problem.equations)),
            "setup": each(lambda case: json.dumps(statement(case.problem.problem), ensure_ascii=False)),
            "shown": each(lambda case: case.shown),
        },
        # Groups inherit coordinates from their parent, and the solvers' groups have a coordinate "case" by level.
        {"study_case": each(lambda case: case.name)},
        provenance.attributes("study", study.title, study.summary)
        | {
            "id": study.name,
            "tier": tier,
            "restricted_to": study.restricted_to,
            "inputs": inputs,
            "seeds": ", ".join(map(str, seeds)) or "none: no run is random",
        },
    )


@dataclass(frozen=True)
class StoredStudy:
    """The part of a study's file that is needed to judge it.

    Parameters
    ----------
    name : str
        Name of the study.
    attributes : mapping
        Global attributes of the file: provenance, tier, restriction.
    levels : tuple of Level
        Levels of all solvers, grouped by solver.
    declared : mapping of SeriesId to tuple of Criterion
        Declared criteria of every series.
    """

    name: str
    attributes: Mapping[Any, Any]
    levels: tuple[Level, ...]
    declared: Mapping[SeriesId, tuple[Criterion, ...]]


def read_study(path: Path) -> StoredStudy:
    """Read the levels and declared criteria of a study's file.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, damaged, not an mpmverify study, or a study with another name than the file.
    UsageError
        If a declared criterion is unknown.
    """
    groups = read_study_groups(path)
    levels: list[Level] = []
    declared: dict[SeriesId, tuple[Criterion, ...]] = {}
    with parsing(path):
        for solver, group in solvers(groups):
            levels += read_levels(solver, group)
            declared |= read_criteria(solver, group.columns)
    attributes = groups["/"].attributes
    return StoredStudy(attributes["id"], attributes, tuple(levels), declared)


def solvers(groups: Mapping[str, Group]) -> Iterator[tuple[str, Group]]:
    """Yield the name and the group of each solver of a study."""
    for place, group in groups.items():
        if place.count("/") == 1 and place != "/":
            yield place.removeprefix("/"), group


def stored_findings(groups: Mapping[str, Group]) -> tuple[Finding, ...]:
    """Return all findings of a study, the one on missing baseline entries last."""
    attributes = groups["/"].attributes
    name = attributes["id"]
    findings = [finding for solver, group in solvers(groups) for finding in read_findings(name, solver, group.columns)]
    missing = read_lacking(attributes)
    return (*findings, *([missing] if missing else []))


def read_study_groups(path: Path, *, renamed: bool = False) -> dict[str, Group]:
    """Return the groups of a study's file by path, after all checks; the root's path is "/".

    Parameters
    ----------
    path : Path
    renamed : bool
        Whether the file may have another name than the study.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, damaged, not an mpmverify study, or a study with another name than the file.
    """
    try:
        with netCDF4.Dataset(path) as file:
            stated = {name: str(file.getncattr(name)) for name in file.ncattrs()}
            if (stated.get("mpmverify_kind"), stated.get("mpmverify_schema")) != ("study", str(SCHEMA)):
                check_ours(path, "study")  # says what it is, before more of it is read
            if not renamed and stated.get("id") != path.stem:
                raise ResultsError(
                    f"'{path}' contains the study {stated.get('id')!r}: rename it to '{stated.get('id')}.nc', or move it away"
                )
            digest, groups = read_groups(file)
    except ResultsError:
        raise
    except (OSError, RuntimeError, ValueError, TypeError, AttributeError, IndexError) as error:
        check_ours(path, "study")
        raise damaged(path) from error
    if stated.get(CHECKSUM) != digest:
        raise damaged(path)
    return groups


@contextmanager
def parsing(path: Path) -> Iterator[None]:
    """Turn errors in the block into a `ResultsError` that names the file as damaged; the block must only parse its content."""
    try:
        yield
    except MpmverifyError:
        raise
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        raise damaged(path) from error
