"""The figures that the handbook shows of the codes on the bench, which their tests compare with what they find."""

import re
from collections.abc import Iterable
from pathlib import Path

PAGE = Path(__file__).parents[2] / "reports" / "handbook" / "codes.md"
ROW = re.compile(r"^\| ([^|]+) \| `([\w-]+)` \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE)
MEASURED = re.compile(r"order of (\w+) in .*: order (-?\d+\.\d+)")
APART = 0.02
"""Difference from the figure that the page shows, which is rounded; other processors round sums otherwise."""


def agree(case: str, solver: str, findings: Iterable[object]) -> None:
    """Assert that every order among the findings on a case is the one that the page shows, and that it shows no others."""
    rows = {(row[0].replace("`", ""), row[1]): row[2:] for row in ROW.findall(PAGE.read_text(encoding="utf-8"))}
    shown = dict(zip(("displacement", "velocity", "stress"), rows[case, solver], strict=True))
    found = {quantity: float(order) for quantity, order in MEASURED.findall("\n".join(map(str, findings)))}
    stated = {quantity: float(text) for quantity, text in shown.items() if re.fullmatch(r"-?\d+\.\d+", text)}
    assert stated.keys() == found.keys()
    assert all(abs(stated[quantity] - found[quantity]) <= APART for quantity in found), (stated, found)
