"""Runs of the unmodified solvers, which must pass for any number of processes and threads and any particle seed."""

import dataclasses
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mpmverify.convergence.verdict import worst
from mpmverify.criteria import Dispersion
from mpmverify.criteria.criterion import Criterion
from mpmverify.dataset.files import Results
from mpmverify.execution.runner import Plan, run
from mpmverify.execution.workers import environment
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.kill_table import UnmodifiedRun
from mpmverify.judgement.summary import ranked
from mpmverify.selftest.fault_judge import counts
from mpmverify.study import Series, Study

JITTER = 1e-5
"""Random displacement of the particles, as a fraction of their spacing.

It adds a quadrature error that does not fall with h: at 1e-4 and above, published errors change in their third digit.
"""
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


@dataclass(frozen=True)
class Setting:
    """Number of worker processes, threads of each process, and jitter and random seed of the particle positions."""

    jobs: int
    threads: int
    jitter: float
    seed: int


def settings(count: int) -> list[Setting]:
    """Return distinct settings; every other one has no jitter, so that the regression gate applies."""
    return [Setting(1 + k % 3, (1, 2, 4)[k // 3 % 3], JITTER if k % 2 else 0.0, k if k % 2 else 0) for k in range(count)]


def unmodified(studies: Sequence[Study], setting: Setting, baseline: Baseline) -> UnmodifiedRun:
    """Run and judge the trials once, in a temporary folder."""
    began = time.perf_counter()
    if setting.jitter:
        studies = [jittered(study, setting) for study in studies]
    with tempfile.TemporaryDirectory(prefix="mpmverify-") as folder, environment(dict.fromkeys(THREADS, str(setting.threads))):
        plan = Plan(Results(Path(folder)), baseline, jobs=setting.jobs)
        findings = [finding for judged in run(studies, plan) for finding in judged.findings if counts(finding)]
    not_passed = ranked(findings)
    return UnmodifiedRun(
        **dataclasses.asdict(setting),
        verdict=worst(finding.verdict for finding in findings).value,
        judged=len(findings),
        reason=str(not_passed[0]) if not_passed else "",
        seconds=time.perf_counter() - began,
    )


def jittered(study: Study, setting: Setting) -> Study:
    """Add jitter to every series, except those judged by what holds for regular particles only.

    These are dispersion relations, and angular momenta: particles out of place have another one, and a torque.
    """

    def regular(criterion: Criterion) -> bool:
        return isinstance(criterion, Dispersion) or getattr(criterion, "stock", "") == "angular_momentum"

    def moved(series: Series) -> Series:
        if any(map(regular, series.criteria)):
            return series
        return dataclasses.replace(series, refinement=series.refinement.with_jitter(setting.jitter, setting.seed))

    cases = (dataclasses.replace(case, series=tuple(map(moved, case.series))) for case in study.cases)
    return dataclasses.replace(study, cases=tuple(cases))
