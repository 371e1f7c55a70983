"""Fits, criteria and verdicts of a study's tree: judged from the stored numbers alone."""

import dataclasses
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mpmverify import baseline as regression
from mpmverify.criteria import StabilityLimit, Stall, Unstable
from mpmverify.dataset.criteria import criteria, with_criteria
from mpmverify.dataset.evidence import evidence, series_of
from mpmverify.dataset.sources import with_sources
from mpmverify.dataset.study import read_study, solvers, text
from mpmverify.errors import MpmverifyError, ResultsError, UsageError
from mpmverify.gate import Criterion, Evidence, Finding, judge
from mpmverify.norms import NORMS
from mpmverify.study import Study


def without_baseline(criteria: Iterable[Criterion]) -> bool:
    """Whether a series is known to stall, to become unstable or to be at the limit, so that it has no regression verdict."""
    return any(isinstance(criterion, Stall | Unstable | StabilityLimit) for criterion in criteria)


def judged(tree: xr.DataTree, baseline: regression.Baseline) -> xr.DataTree:
    """Return a study's tree with its fits and verdicts made anew: verification by its criteria, regression by the baseline.

    A series that is known to stall has no regression verdict: where particles cross cells the error is noise, and the last
    digits of another compiler are enough to change the first ones. One that is unstable has no error, and at the limit of stability
    rounding decides how far a wave has grown.

    Raises
    ------
    ResultsError
        If a criterion is stored of a series that is not: it would hold of nothing, unseen.
    """
    return _with_judgements(tree, _understood(tree), baseline)


@dataclass(frozen=True)
class _Understood:
    """What a study's tree holds of one solver, as the judge takes it: criteria, and evidence by (case, refinement)."""

    dataset: xr.Dataset
    declared: Sequence[tuple[str, str, Criterion]]
    seen: Mapping[tuple[str, str], Evidence]


def _understood(tree: xr.DataTree) -> dict[str, _Understood]:
    """All that is judged, by solver; content that cannot be understood raises here, and not where it is judged."""
    return {
        solver: _Understood(
            dataset, criteria(dataset), {name: evidence(dataset, levels) for name, levels in series_of(dataset).items()}
        )
        for solver, dataset in solvers(tree)
    }


def _with_judgements(tree: xr.DataTree, content: Mapping[str, _Understood], baseline: regression.Baseline) -> xr.DataTree:
    study = tree.attrs["id"]
    run = []
    for solver, stored in content.items():
        table = []
        for case, refinement, criterion in stored.declared:
            if (case, refinement) not in stored.seen:
                raise ResultsError(
                    f"{criterion.title!r} is to hold of {study}/{case}/{solver} ({refinement}), which is not there: run it again"
                )
        for (case, refinement), seen in stored.seen.items():
            run.append((case, solver, refinement))
            mine = [entry for *of, entry in stored.declared if of == [case, refinement]]
            judgements = [("verification", criterion.title, judge(criterion, seen), criterion.source) for criterion in mine]
            if not without_baseline(mine):
                judgement = baseline.judge(study, solver, case, refinement, seen)
                judgements.append(("regression", regression.TITLE, judgement, baseline.source))
            for gate, title, (verdict, reason), source in judgements:
                table.append(Finding(study, case, solver, refinement, gate, title, verdict, reason, source))
        fitted = with_sources(with_fits(stored.dataset, stored.seen), stored.declared, stored.seen)
        tree[solver].dataset = with_verdicts(fitted, table)
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


def with_fits(dataset: xr.Dataset, evidence: Mapping[tuple[str, str], Evidence]) -> xr.Dataset:
    """Add fits by series, quantity and norm, and the pairwise orders by level, to a solver's dataset."""
    identities = series_of(dataset)
    shape = (len(identities), dataset.sizes["quantity"], len(NORMS))
    numbers = {name: np.full(shape, np.nan) for name in ("order", "order_low", "order_high", "floor")}
    words = {name: np.full(shape, "", dtype=object) for name in ("classification", "dropped")}
    pairwise = np.full((dataset.sizes["level"], *shape[1:]), np.nan)
    kept = np.zeros(pairwise.shape, dtype=np.int8)
    axes: list[str] = []
    for row, (identity, levels) in enumerate(identities.items()):
        seen = evidence[identity]
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


@contextmanager
def damage(path: Path) -> Iterator[None]:
    """Name the file whose content cannot be understood; nothing else is done in this context, whose errors would be blamed on the file.

    Raises
    ------
    ResultsError
        If reading fails by what the content lacks or holds.
    """
    try:
        yield
    except MpmverifyError:
        raise
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        raise ResultsError(f"'{path}' is damaged: delete it and run `mpmverify run` again") from error


def read_findings(path: Path, baseline: regression.Baseline) -> list[Finding]:
    """Read the file of a study and judge it anew.

    Parameters
    ----------
    path : Path
    baseline : Baseline
        Of the regression gate.

    Raises
    ------
    ResultsError
        If it cannot be read, is damaged, or holds nothing that could be judged.
    """
    tree = read_study(path)
    with damage(path):
        content = _understood(tree)
    found = findings(_with_judgements(tree, content, baseline))
    if not found:
        raise ResultsError(f"'{path}' holds nothing to judge: delete it and run `mpmverify run` again")
    return found


def accepted(baseline: regression.Baseline, paths: Sequence[Path], reason: str) -> int:
    """Take the errors of the files of some studies over into a baseline, and return how many series that were.

    Parameters
    ----------
    baseline : Baseline
        Changed in memory alone.
    paths : sequence of Path
        Files of studies.
    reason : str
        Why the errors may change.

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
            content = _understood(tree)
        count += _take_over(baseline, tree.attrs["id"], content)
    with damage(paths[0]):
        newest = read_study(paths[0]).attrs
        entry = {"date": newest["date_created"], "commit": f"{newest['commit']} ({newest['commit_state']})", "reason": reason}
    baseline.accepted.append(entry)
    return count


def _take_over(baseline: regression.Baseline, study: str, content: Mapping[str, _Understood]) -> int:
    count = 0
    for solver, stored in content.items():
        skipped = {(case, refinement) for case, refinement, entry in stored.declared if without_baseline([entry])}
        for (case, refinement), seen in stored.seen.items():
            if (case, refinement) in skipped:
                continue
            failed = [outcome for outcome in seen.outcomes if outcome != "completed"]
            if failed or not all(np.isfinite(table).all() for table in seen.error.values()):
                where = f"{study}/{case}/{solver} ({refinement})"
                raise UsageError(f"{where} did not complete on every level: a baseline takes finished runs alone")
            baseline.updated(study, solver, case, refinement, seen)
            count += 1
    return count
