"""Make the table of signatures: the faults of the textbook's code, planted in some of its variants, on cases that own codes are put on."""

import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mpmverify.criteria.evidence import Level
from mpmverify.criteria.expectations import expectations
from mpmverify.errors import UsageError
from mpmverify.execution.diagnosis import problem_digest
from mpmverify.execution.evaluation import Task, evaluate
from mpmverify.judgement.diagnosis import SAME, Signature, Signatures, measured, signature
from mpmverify.problem import Array
from mpmverify.selftest.faults import Fault
from mpmverify.selftest.planting import copied, planted
from mpmverify.selftest.processes import each_alone
from mpmverify.selftest.textbook_faults import CAUSES, returning_gradient
from mpmverify.solution import Solver
from mpmverify.study import Case, Study

PATIENT = 600.0
"""Limit on the processor time of a variant with a fault on all cases [s]."""


class Bench(NamedTuple):
    """A case, and how many of its coarsest levels are solved."""

    study: str
    case: str
    levels: int


BENCHES = (
    Bench("plane-waves", "clamped", 2),
    Bench("plane-waves", "neo-hookean-updated", 2),
    Bench("plane-waves", "neo-hookean-affine", 2),
    Bench("loads-and-supports", "layer, splines", 2),
    Bench("loads-and-supports", "block, plane", 2),
    Bench("moving-bodies", "square", 2),
    Bench("large-deformation", "square", 1),
    Bench("generalised-vortex", "0.05 rad", 1),
    Bench("axial-vibration", "small-strain", 2),
    Bench("driven-bar", "loaded-right", 2),
)
VARIANTS = (
    ("USL", "FLIP", "quadratic", "updated"),
    ("MUSL", "FLIP", "linear", "updated"),
    ("MUSL", "FLIP", "linear", "total"),
    ("MUSL", "APIC", "quadratic", "updated"),
)
"""Schedule, transfer, basis and formulation of the variants of the code."""
SOUND = "sound"


class Job(NamedTuple):
    """A variant with a fault, or a sound one, on all cases."""

    cause: str
    number: int
    fault: Fault
    variant: Solver
    cases: tuple[tuple[str, Case, int], ...]
    sources: Path


def make_signatures(
    get: Callable[[str], Study],
    sources: Path,
    code: Callable[..., Solver],
    jobs: int,
    progress: Callable[[str, int, int], None] = lambda *_: None,
) -> Signatures:
    """Plant every fault in every variant of the textbook's code, one at a time, and return the table of their signatures.

    Parameters
    ----------
    get : callable
        Returns a study by name.
    sources : Path
        Folder of the solvers.
    code : callable
        Class of the textbook's code, which takes `VARIANTS`.
    jobs : int
        Faults at the same time.
    progress : callable
        Called with (what is done, done, in all).

    Raises
    ------
    UsageError
        If a fault does not fit the source.
    """
    variants = [code(*choices) for choices in VARIANTS]
    cases = tuple((bench.study, _case(get(bench.study), bench.case), bench.levels) for bench in BENCHES)
    faults = [(SOUND, 0, Fault("textbook", "named", SOUND, ()))]
    faults += [(cause, number, fault) for cause, several in CAUSES.items() for number, fault in enumerate(several)]
    tasks = [Job(*fault, variant, cases, sources) for variant in variants for fault in faults]
    found: dict[tuple[str, str, int], Signature] = {}
    for done, (job, row) in enumerate(each_alone(signature_of, tasks, jobs, PATIENT, _failed, [__name__]), 1):
        found[job.variant.name, job.cause, job.number] = row
        progress("signatures", done, len(tasks))
    entries = tuple(sorted({entry for row in found.values() for entry in row}))
    rows = {key: np.array([row.get(entry, np.nan) for entry in entries]) for key, row in found.items()}
    sound = {variant.name: rows[variant.name, SOUND, 0] for variant in variants}
    changes = {name: dict(_changes(name, reference, rows)) for name, reference in sound.items()}
    return Signatures(
        {f"{study} | {case.name}": problem_digest(case.problem) for study, case, _ in cases}, entries, sound, changes
    )


def _changes(
    variant: str, reference: Array, rows: dict[tuple[str, str, int], Array]
) -> Iterator[tuple[str, tuple[Array, ...]]]:
    """Yield each cause with the changes by its faults, if one of them changes any error: some cannot be made in some variants."""
    for cause, several in CAUSES.items():
        changes = tuple(rows[variant, cause, number] - reference for number in range(len(several)))
        seen = tuple(change for change in changes if np.nanmax(np.abs(change)) > SAME)
        if seen:
            yield cause, seen


def signature_of(job: Job) -> Signature:
    """Return the signature of a variant with a fault."""
    try:
        with (
            warnings.catch_warnings(action="ignore"),
            tempfile.TemporaryDirectory(prefix="mpmverify-") as folder,
            planted(returning_gradient(job.fault), job.sources, Path(folder)) as package,
        ):
            solver, found = copied(package, job.variant), dict[str, float]()
            for study, case, count in job.cases:
                found |= signature(study, map(measured, _levels(solver, study, case, count)))
            return found
    except Exception:
        traceback.print_exc()  # here, where the place is known: the error reaches the caller as text
        raise


def _levels(solver: Solver, study: str, case: Case, count: int) -> Iterator[Level]:
    """Yield the coarsest levels of the ladder on which a case judges a solver of any origin."""
    ladder, criteria = case.ladder_in_h(), expectations(solver, case.problem, case.norm, case.margin)
    for index, at in enumerate(ladder.tier("quick")[:count]):
        yield evaluate(Task(None, study, index, case.name, ladder.label, case.problem, solver, at, criteria, "")).level


def _case(study: Study, name: str) -> Case:
    found = [case for case in study.cases if case.name == name]
    if not found:
        raise UsageError(f"study {study.name!r} has no case {name!r}: adapt the cases of the signatures")
    return found[0]


def _failed(reason: str, *, undecided: bool) -> Signature:
    raise RuntimeError(f"a fault has no signature: {reason}")
