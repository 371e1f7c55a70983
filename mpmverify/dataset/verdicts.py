"""Fits, criteria and verdicts of a study's tree: judged from the stored numbers alone."""

import dataclasses
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mpmverify import baseline as regression
from mpmverify.criteria import CRITERIA, Stall, Unstable
from mpmverify.dataset.sources import with_sources
from mpmverify.dataset.study import evidence, read_study, series_of, solvers, text
from mpmverify.errors import MpmverifyError, ResultsError, UsageError
from mpmverify.gate import Criterion, Finding, judge
from mpmverify.norms import NORMS
from mpmverify.study import Study


def without_baseline(criteria: Iterable[Criterion]) -> bool:
    """Whether a series is known to stall or to become unstable, so that it has no regression verdict."""
    return any(isinstance(criterion, Stall | Unstable) for criterion in criteria)


def judged(tree: xr.DataTree, baseline: regression.Baseline) -> xr.DataTree:
    """Return a study's tree with its fits and verdicts made anew: verification by its criteria, regression by the baseline.

    A series that is known to stall has no regression verdict: where particles cross cells the error is noise, and the last
    digits of another compiler are enough to change the first ones. One that is unstable has no error.

    Raises
    ------
    ResultsError
        If a criterion is stored of a series that is not: it would hold of nothing, unseen.
    """
    study = tree.attrs["id"]
    run = []
    for solver, dataset in solvers(tree):
        table = []
        declared = criteria(dataset)
        series = series_of(dataset)
        for case, refinement, criterion in declared:
            if (case, refinement) not in series:
                raise ResultsError(
                    f"{criterion.title!r} is to hold of {study}/{case}/{solver} ({refinement}), which is not there: run it again"
                )
        for (case, refinement), levels in series.items():
            run.append((case, solver, refinement))
            seen = evidence(dataset, levels)
            mine = [entry for of_case, of_refinement, entry in declared if (of_case, of_refinement) == (case, refinement)]
            judgements = [("verification", criterion.title, judge(criterion, seen), criterion.source) for criterion in mine]
            if not without_baseline(mine):
                judgement = baseline.judge(study, solver, case, refinement, seen)
                judgements.append(("regression", regression.TITLE, judgement, baseline.source))
            for gate, title, (verdict, reason), source in judgements:
                table.append(Finding(study, case, solver, refinement, gate, title, verdict, reason, source))
        tree[solver].dataset = with_verdicts(with_sources(with_fits(dataset), declared), table)
    absent = baseline.lacking(study, run, str(tree.attrs.get("restricted_to", "")))
    tree.attrs[LACKING] = json.dumps(dataclasses.asdict(absent)) if absent else ""
    return tree


def declare(tree: xr.DataTree, study: Study) -> xr.DataTree:
    """Store the criteria of a study in its tree."""
    for solver, dataset in solvers(tree):
        declared = [
            (case.name, series.refinement.label, criterion)
            for case, series in study.series()
            if series.solver.name == solver
            for criterion in series.criteria
        ]
        tree[solver].dataset = with_criteria(dataset, declared)
    return tree


def with_fits(dataset: xr.Dataset) -> xr.Dataset:
    """Add fits by series, quantity and norm, and the pairwise orders by level, to a solver's dataset."""
    identities = series_of(dataset)
    shape = (len(identities), dataset.sizes["quantity"], dataset.sizes["norm"])
    numbers = {name: np.full(shape, np.nan) for name in ("order", "order_low", "order_high", "floor")}
    words = {name: np.full(shape, "", dtype=object) for name in ("classification", "dropped")}
    pairwise = np.full(dataset["error"].shape, np.nan)
    kept = np.zeros(dataset["error"].shape, dtype=np.int8)
    axes: list[str] = []
    for row, levels in enumerate(identities.values()):
        seen = evidence(dataset, levels)
        axes.append(seen.axis.size)
        for k, quantity in enumerate(dataset["quantity"].values.tolist()):
            for n, norm in enumerate(NORMS):
                if quantity not in seen.error:
                    continue
                series = seen.convergence(quantity, norm)
                if series is None:
                    continue
                words["classification"][row, k, n] = series.classification.value
                words["dropped"][row, k, n] = "; ".join(series.dropped)
                coarse_first = levels[np.argsort(-seen.sizes[seen.axis.size])]
                pairwise[coarse_first[1:], k, n] = series.pairwise
                kept[coarse_first, k, n] = series.kept
                if series.fit:
                    fit = series.fit
                    for name, value in zip(numbers, (fit.order, fit.low, fit.high), strict=False):
                        numbers[name][row, k, n] = value
                if series.floor:
                    numbers["floor"][row, k, n] = series.floor.floor
    dims = ("series", "quantity", "norm")
    meaning = {
        "order": "fitted order in the size that the series refines",
        "order_low": "lower end of its 95 % interval",
        "order_high": "upper end of its 95 % interval",
        "floor": "relative error floor E0 where one shows",
    }
    return dataset.assign(
        {name: (dims, values, {"units": "1", "long_name": meaning[name]}) for name, values in numbers.items()}
        | {name: (dims, values) for name, values in words.items()}
        | {
            "order_pairwise": (
                ("level", "quantity", "norm"),
                pairwise,
                {"units": "1", "long_name": "observed order from the coarser level"},
            ),
            "kept": (("level", "quantity", "norm"), kept, {"units": "1", "long_name": "1 where the level is in the fit"}),
        }
    ).assign_coords(
        series_case=("series", text([case for case, _ in identities])),
        series_refinement=("series", text([refinement for _, refinement in identities])),
        series_axis=("series", text(axes), {"long_name": "size that the series refines; empty for a design"}),
    )


LACKING = "lacking"
"""Attribute of a study: the verdict on what it lacks of the baseline, as JSON."""
VERDICT_COLUMNS = ("case", "refinement", "gate", "criterion", "verdict", "reason", "source")


def with_verdicts(dataset: xr.Dataset, findings: Sequence[Finding]) -> xr.Dataset:
    """Add the findings of a solver to its dataset, one row a criterion."""
    columns = {
        f"verdict_{name}": ("finding", text([str(getattr(finding, name)) for finding in findings])) for name in VERDICT_COLUMNS
    }
    return dataset.drop_dims("finding", errors="ignore").assign(columns)


def findings(tree: xr.DataTree) -> list[Finding]:
    """Verdicts that are stored in a study's tree: those of its series, and one when the baseline holds series that it lacks."""
    table: list[Finding] = []
    for solver, dataset in solvers(tree):
        columns = [dataset[f"verdict_{name}"].values.tolist() for name in VERDICT_COLUMNS]
        where = {"study": tree.attrs["id"], "solver": solver}
        table += [Finding.of(where | dict(zip(VERDICT_COLUMNS, row, strict=True))) for row in zip(*columns, strict=True)]
    return table + lacking(tree.attrs)


def lacking(attributes: Mapping[Any, Any]) -> list[Finding]:
    """Verdict on what a study lacks, by the attributes of its tree; none where it lacks nothing."""
    stored = attributes.get(LACKING)
    return [Finding.of(json.loads(stored))] if stored else []


def with_criteria(dataset: xr.Dataset, declared: Sequence[tuple[str, str, Criterion]]) -> xr.Dataset:
    """Add the declared criteria (case, refinement, criterion) of a solver to its dataset, so that a file can be judged alone."""
    rows = [
        # A criterion is a frozen dataclass, which its protocol cannot say.
        (case, refinement, json.dumps({"type": type(criterion).__name__} | dataclasses.asdict(criterion)))  # type: ignore[call-overload]
        for case, refinement, criterion in declared
    ]
    names = ("criterion_case", "criterion_refinement", "criterion_json")
    return dataset.assign({name: ("criterion", text([row[k] for row in rows])) for k, name in enumerate(names)})


def criteria(dataset: xr.Dataset) -> list[tuple[str, str, Criterion]]:
    """Declared criteria of a solver's dataset."""
    names = ("criterion_case", "criterion_refinement", "criterion_json")
    table = []
    for case, refinement, stored in zip(*(dataset[name].values.tolist() for name in names), strict=True):
        values = json.loads(stored)
        kind = values.pop("type")
        if kind not in CRITERIA:
            raise UsageError(f"the criterion {kind!r} of {case!r} is unknown: choose from {', '.join(CRITERIA)}")
        table.append((case, refinement, CRITERIA[kind](**{name: _frozen(value) for name, value in values.items()})))
    return table


def _frozen(value: Any) -> Any:
    """JSON knows no tuples."""
    return tuple(_frozen(entry) for entry in value) if isinstance(value, list) else value


@contextmanager
def damage(path: Path) -> Iterator[None]:
    """Name the file whose stored content cannot be understood.

    Raises
    ------
    ResultsError
        If what is done with the content fails by what it lacks or holds.
    """
    try:
        yield
    except MpmverifyError:
        raise
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        raise ResultsError(f"'{path}' is damaged: delete it and run `mpmverify run` again") from error


def read_findings(path: Path, baseline: regression.Baseline) -> list[Finding]:
    """Read the file of a study and judge it anew.

    Raises
    ------
    ResultsError
        If it cannot be read, is damaged, or holds nothing that could be judged.
    """
    tree = read_study(path)
    with damage(path):
        found = findings(judged(tree, baseline))
    if not found:
        raise ResultsError(f"'{path}' holds nothing to judge: delete it and run `mpmverify run` again")
    return found


def accepted(baseline: regression.Baseline, paths: Sequence[Path], reason: str) -> int:
    """Take the errors of the files of some studies over into a baseline, and return how many series that were.

    Raises
    ------
    ResultsError
        If a file cannot be read, or is damaged.
    UsageError
        If a run among them did not complete. Nothing may be written then.
    """
    count = 0
    for path in paths:
        tree = read_study(path)
        with damage(path):
            count += _take_over(baseline, tree)
    with damage(paths[0]):
        newest = read_study(paths[0]).attrs
        entry = {"date": newest["date_created"], "commit": f"{newest['commit']} ({newest['commit_state']})", "reason": reason}
    baseline.accepted.append(entry)
    return count


def _take_over(baseline: regression.Baseline, tree: xr.DataTree) -> int:
    count = 0
    for solver, dataset in solvers(tree):
        skipped = {(case, refinement) for case, refinement, entry in criteria(dataset) if without_baseline([entry])}
        for (case, refinement), levels in series_of(dataset).items():
            if (case, refinement) in skipped:
                continue
            seen = evidence(dataset, levels)
            failed = [outcome for outcome in seen.outcomes if outcome != "completed"]
            if failed or not all(np.isfinite(table).all() for table in seen.error.values()):
                where = f"{tree.attrs['id']}/{case}/{solver} ({refinement})"
                raise UsageError(f"{where} did not complete on every level: a baseline takes finished runs alone")
            baseline.updated(tree.attrs["id"], solver, case, refinement, seen)
            count += 1
    return count
