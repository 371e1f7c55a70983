"""The page of the handbook on traced functions names what the package has."""

import re
from pathlib import Path

import pytest

from mpmverify.solvers import tracing

PAGE = Path(__file__).parent.parent / "reports" / "handbook" / "tracing.md"


@pytest.fixture(scope="module")
def page():
    return PAGE.read_text(encoding="utf-8")


def test_every_name_of_the_page_exists(page):
    """Names in code font that are called, and those of the example, are of the package or of Python."""
    said = set(re.findall(r"`(?:with )?([a-z_]+)\(", page))
    of_python = {"float", "int"}
    assert said - of_python <= set(tracing.__all__)
    assert {"where", "cond", "switch", "while_loop", "for_range", "parallel_for", "outlined", "checksum"} <= set(
        tracing.__all__
    )
    assert sorted(tracing.__all__) == sorted(set(tracing.__all__))
    assert all(hasattr(tracing, name) for name in tracing.__all__)
