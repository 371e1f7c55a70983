"""Plugins of the tests, which pytest takes from here alone; no time limit for an example; what the workers of pytest-xdist share."""

import os

# Workers share the processors: a thread that spins while it waits for another keeps that other from running. Read on import of numpy.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from typing import Any

import pytest
from hypothesis import settings

pytest_plugins = ["pytester"]

settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")

ONE_BY_ONE = ("tests/test_planted_faults.py", "tests/sweeps/test_named_faults.py", "tests/sweeps/test_quick_report.py")
"""Files whose tests share nothing: they come last, and keep all workers busy to the end."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """With `--dist loadfile`, give each file to one worker, as its tests share what they compile and solve, but for `ONE_BY_ONE`."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file: str = super()._split_scope(nodeid)
            return nodeid if file in ONE_BY_ONE else file

    return Scheduling(config, log)
