"""Plugins of the tests, which pytest takes from here alone; no time limit for an example; one worker for what compiles the same."""

import os

# Workers share the processors: a thread that spins while it waits for another keeps that other from running. Read on import of numpy.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections.abc import Iterator

import pytest
from hypothesis import settings

from mpmverify.solvers.mpm import MaterialPoint, Transfer
from mpmverify.solvers.mpm.basis import BASES

pytest_plugins = ["pytester"]

settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")


def compiled_for(name: str, value: object) -> Iterator[str]:
    """What a parameter says about the kernels that a test of the material point method compiles."""
    if isinstance(value, MaterialPoint):
        yield value.basis
        yield from compiled_for(name, value.transfer)
    elif isinstance(value, Transfer):
        yield f"affine {value.affine}, {'several terms' if value.terms > 1 else 'one term'}"
    elif (name == "basis" and value in BASES) or name == "dimension":
        yield str(value)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give tests that compile the same to one worker: two that begin at the same time both compile it."""
    for item in items:
        parameters = item.callspec.params if isinstance(item, pytest.Function) and hasattr(item, "callspec") else {}
        kernels = [word for name in sorted(parameters) for word in compiled_for(name, parameters[name])]
        if kernels and not item.get_closest_marker("xdist_group"):
            item.add_marker(pytest.mark.xdist_group(", ".join(sorted(kernels))))
