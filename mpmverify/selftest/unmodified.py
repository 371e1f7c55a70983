"""Runs of the unmodified solvers, which must pass whatever the processes, the threads and the seed of the particles."""

import dataclasses
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mpmverify.convergence.verdict import worst
from mpmverify.criteria import Dispersion
from mpmverify.dataset.files import Results
from mpmverify.execution.runner import Plan, run
from mpmverify.execution.workers import environment
from mpmverify.judgement.baseline import Baseline
from mpmverify.judgement.kill_table import UnmodifiedRun
from mpmverify.judgement.summary import ranked
from mpmverify.selftest.verdict import counts
from mpmverify.study import Series, Study

JITTER = 1e-5
"""Random places spoil the quadrature by a share that does not fall with h: from 1e-4 on it shows in the third digit of published errors."""
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


@dataclass(frozen=True)
class Setting:
    """Worker processes, threads of each, and the jitter and seed of the particles."""

    jobs: int
    threads: int
    jitter: float
    seed: int


def settings(count: int) -> list[Setting]:
    """Settings that differ from one another; every other one has all particles at their places, for the regression gate."""
    return [Setting(1 + k % 3, (1, 2, 4)[k // 3 % 3], JITTER if k % 2 else 0.0, k if k % 2 else 0) for k in range(count)]


def unmodified(studies: Sequence[Study], setting: Setting, baseline: Baseline) -> UnmodifiedRun:
    """Run and judge the trials once, in a folder of their own."""
    began = time.perf_counter()
    if setting.jitter:
        studies = [jittered(study, setting) for study in studies]
    with tempfile.TemporaryDirectory(prefix="mpmverify-") as folder, environment(dict.fromkeys(THREADS, str(setting.threads))):
        plan = Plan(Results(Path(folder)), baseline, jobs=setting.jobs)
        findings = [finding for judged in run(studies, plan) for finding in judged.findings if counts(finding)]
    bad = ranked(findings)
    return UnmodifiedRun(
        **dataclasses.asdict(setting),
        verdict=worst(finding.verdict for finding in findings).value,
        judged=len(findings),
        reason=str(bad[0]) if bad else "",
        seconds=time.perf_counter() - began,
    )


def jittered(study: Study, setting: Setting) -> Study:
    """Move the particles of every series, save where a dispersion relation, which is that of equal cells, is to hold to round-off."""

    def moved(series: Series) -> Series:
        if any(isinstance(criterion, Dispersion) for criterion in series.criteria):
            return series
        return dataclasses.replace(series, refinement=series.refinement.with_jitter(setting.jitter, setting.seed))

    cases = (dataclasses.replace(case, series=tuple(map(moved, case.series))) for case in study.cases)
    return dataclasses.replace(study, cases=tuple(cases))
