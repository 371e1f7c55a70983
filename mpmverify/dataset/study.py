"""One study as one DataTree: levels, errors, fits and verdicts by solver, with the profiles that the pages show.

Layout
------
/                    case metadata, provenance
/<solver>            error(level, quantity, norm), absolute errors and exact norms by quantity, fits by series, verdicts by criterion
/<solver>/snapshots  fields of one level of each series: contiguous ragged arrays, one row an output time, one variable a component
/<solver>/histories  energy, momentum, mass and impulse of the same runs: contiguous ragged arrays, one row a series

Runs in two and three dimensions have components and units of their own: theirs are `snapshots_2d`, `histories_3d` and so on.
"""

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mpmverify.atomic import write_atomic
from mpmverify.criteria.criterion import Criterion
from mpmverify.criteria.evidence import Level, SeriesId
from mpmverify.dataset import provenance
from mpmverify.dataset.criteria import read_criteria, with_criteria
from mpmverify.dataset.files import check_ours
from mpmverify.dataset.findings import lacking_attribute, with_findings
from mpmverify.dataset.fits import with_fits
from mpmverify.dataset.levels import level_table, read_levels
from mpmverify.dataset.snapshots import Snapshots, snapshot_groups
from mpmverify.dataset.sources import with_sources
from mpmverify.dataset.statement import statement
from mpmverify.dataset.tree import text, write_tree
from mpmverify.errors import MpmverifyError, ResultsError
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
) -> None:
    """Write a judged study whole.

    Parameters
    ----------
    path : Path
    study : Study
    levels : sequence of Level
        What is kept of every run.
    snapshots : mapping of SeriesId to Snapshots
        Runs whose fields and histories the pages show.
    judged : Judged
    tier : str
        "quick" or "full".
    inputs : str
        Digest of everything that the file depends on; "" where it is to be made again next time.

    Raises
    ------
    ResultsError
        If a file that is not ours stands at `path`, which is never overwritten, or the file cannot be written.
    """
    if path.exists():
        check_ours(path, "study")
    tree = study_tree(study, levels, snapshots, judged, tier=tier, inputs=inputs)
    write_atomic(path, lambda temporary: write_tree(temporary, tree))


def study_tree(
    study: Study, levels: Sequence[Level], snapshots: Mapping[SeriesId, Snapshots], judged: Judged, *, tier: str, inputs: str
) -> xr.DataTree:
    """Tree of a judged study; parameters as of `write_study`."""
    root = _root(study, tier, inputs, sorted({level.seed for level in levels if level.jitter}))
    groups = {"/": root.assign_attrs(lacking_attribute(judged.missing_series))}
    for name, solver in study.solvers().items():
        mine = [level for level in levels if level.solver == name]
        dataset = level_table(mine).assign_attrs(solver=name, scheme=_describe(solver), orders=json.dumps(dict(solver.orders)))
        dataset = with_criteria(dataset, name, study.criteria())
        dataset = with_sources(with_fits(dataset, mine, judged), name, judged)
        findings = [finding for series, some in judged.by_series.items() if series.solver == name for finding in some]
        groups[f"/{name}"] = with_findings(dataset, findings)
        shown = [shot for series, shot in snapshots.items() if series.solver == name]
        groups |= {f"/{name}/{group}": part for group, part in snapshot_groups(shown).items()}
    return xr.DataTree.from_dict(groups)


def _describe(value: Any) -> str:
    choices = ", ".join(f"{f.name}={getattr(value, f.name)!r}" for f in dataclasses.fields(value))
    return f"{type(value).__name__}({choices})"


def _root(study: Study, tier: str, inputs: str, seeds: Sequence[int]) -> xr.Dataset:
    def each(read: Any) -> tuple[str, np.ndarray]:
        return "study_case", text([read(case) for case in study.cases])

    return xr.Dataset(
        {
            "exposes": each(lambda case: case.problem.exposes),
            "citation": each(lambda case: case.problem.exact.citation),
            "equations": each(lambda case: json.dumps(case.problem.equations)),
            "setup": each(lambda case: json.dumps(statement(case.problem.problem), ensure_ascii=False)),
            "shown": each(lambda case: case.shown),
        },
        # Not "case", which the solvers' groups have by level: a group inherits the dimensions of its parent.
        coords={"study_case": each(lambda case: case.name)},
        attrs=provenance.attributes("study", study.title, study.summary)
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
    """What a study's file holds for a judge.

    Parameters
    ----------
    name : str
    attributes : mapping
        Attributes of the file: provenance, tier, restriction.
    levels : tuple of Level
        Solver by solver.
    declared : mapping of SeriesId to tuple of Criterion
    """

    name: str
    attributes: Mapping[Any, Any]
    levels: tuple[Level, ...]
    declared: Mapping[SeriesId, tuple[Criterion, ...]]


def read_study(path: Path) -> StoredStudy:
    """Read a study's file.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, foreign, damaged or that of another study than its name says.
    """
    tree = read_tree(path)
    levels: list[Level] = []
    declared: dict[SeriesId, tuple[Criterion, ...]] = {}
    with damage(path):
        for solver, dataset in solvers(tree):
            levels += read_levels(solver, dataset)
            declared |= read_criteria(solver, dataset)
    return StoredStudy(tree.attrs["id"], tree.attrs, tuple(levels), declared)


def solvers(tree: xr.DataTree) -> Iterator[tuple[str, xr.Dataset]]:
    """Dataset of each solver in a study's tree, by its name."""
    for name, node in tree.children.items():
        yield name, node.to_dataset(inherit=False)


def read_tree(path: Path) -> xr.DataTree:
    """Read a study's file into memory as it lies.

    Raises
    ------
    ResultsError
        If the file is missing, unreadable, foreign, damaged or that of another study than its name says.
    """
    study = check_ours(path, "study").get("id")
    if study != path.stem:
        raise ResultsError(f"'{path}' holds the study {study!r}: rename it to '{study}.nc', or move it away")
    try:
        with xr.open_datatree(path, engine="netcdf4") as tree:
            return tree.load()
    except (OSError, RuntimeError, ValueError) as error:
        raise ResultsError(f"'{path}' is damaged: delete it and run `mpmverify run` again") from error


@contextmanager
def damage(path: Path) -> Iterator[None]:
    """Name the file whose content cannot be understood. Wrap the parsing only: its errors mean a damaged file."""
    try:
        yield
    except MpmverifyError:
        raise
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        raise ResultsError(f"'{path}' is damaged: delete it and run `mpmverify run` again") from error
