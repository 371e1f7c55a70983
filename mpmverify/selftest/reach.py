"""Which lines of the solvers each trial runs: a fault elsewhere cannot change its results."""

import ast
import inspect
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import FrameType
from typing import Any

from mpmverify.dataset.files import Results
from mpmverify.execution.runner import Plan, run
from mpmverify.judgement.baseline import Baseline
from mpmverify.selftest.faults import Edit, Fault
from mpmverify.selftest.planting import planted, replanted
from mpmverify.study import Study

Lines = Mapping[str, frozenset[int]]
"""Numbers of the lines that were run, by file relative to the folder of the solvers."""


def lines_run(trial: Study, sources: Path, scratch: Path) -> Lines:
    """Run a trial with a copy of the solvers, and return the lines of the copy that Python or numba ran.

    Parameters
    ----------
    trial : Study
    sources : Path
        Folder of the solvers.
    scratch : Path
        Parent of the folder of the copy, which has no compiled code at first: traced functions run in Python while they are compiled.

    Notes
    -----
    All lines of a function that numba compiles count as run.
    """
    seen: dict[str, set[int]] = {}
    with tempfile.TemporaryDirectory(dir=scratch) as folder, planted(Fault("", "", "", ()), sources, Path(folder)) as package:
        root = f"{Path(folder) / package}/"

        def note(frame: FrameType, event: str, argument: Any) -> Any:
            file = frame.f_code.co_filename
            if not file.startswith(root):
                return None
            seen.setdefault(file, set()).add(frame.f_lineno)
            return note

        before = sys.gettrace()
        sys.settrace(note)
        try:
            for _ in run(
                [replanted(trial, package)], Plan(Results(Path(folder) / "results"), Baseline(Path(folder) / "none"), jobs=0)
            ):
                pass
        finally:
            sys.settrace(before)
        for name, module in list(sys.modules.items()):
            if name.partition(".")[0] == package:
                for function in (getattr(value, "py_func", None) for value in vars(module).values()):
                    if function is not None and (file := function.__code__.co_filename).startswith(root):
                        lines, first = inspect.getsourcelines(function)
                        seen.setdefault(file, set()).update(range(first, first + len(lines)))
        return {file.removeprefix(root): frozenset(lines) for file, lines in seen.items()}


def reaches(lines: Lines, fault: Fault, sources: Path) -> bool:
    """Whether a statement that a fault edits is among the lines that were run."""
    return any(lines.get(edit.file, frozenset()) & _statement(edit, sources) for edit in fault.edits)


def _statement(edit: Edit, sources: Path) -> set[int]:
    """Lines of the innermost statements that hold the passage of an edit."""
    text = (sources / edit.file).read_text(encoding="utf-8")
    begin = edit.begin(text)
    first, last = (text.count("\n", 0, at) + 1 for at in (begin, begin + len(edit.old.rstrip("\n"))))
    around = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.stmt)]
    found: set[int] = set()
    for line in range(first, last + 1):
        holding = [node for node in around if node.lineno <= line <= (node.end_lineno or 0)]
        if holding:
            inner = max(holding, key=lambda node: (node.lineno, node.col_offset))
            found |= set(range(inner.lineno, (inner.end_lineno or inner.lineno) + 1))
    return found
