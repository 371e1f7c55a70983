"""Faults planted in the harness itself (judge, norms, criteria, baseline) break a property that the unmodified harness has.

A copy of a module or package is imported under another name, unmodified or with one edit. Every property of `harness_faults.PROPERTIES`
must hold for the unmodified copy. At least one property of the same module or package must fail for each copy with a fault.
"""

import importlib
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from harness_faults import FAULTS, PROPERTIES, Fault

import mpmverify

ROOT = Path(mpmverify.__file__).parent


@pytest.fixture
def planted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str, Fault | None], ModuleType]]:
    """Import a copy of a part of the harness, with a fault or none."""
    monkeypatch.syspath_prepend(str(tmp_path))
    name = f"harness_{tmp_path.name}"

    def copy(part: str, fault: Fault | None) -> ModuleType:
        target = tmp_path / name
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            target.mkdir()
            shutil.copy(ROOT / f"{part}.py", target / "__init__.py")
        for path in target.glob("*.py"):
            path.write_text(
                path.read_text(encoding="utf-8").replace(f"mpmverify.{part.replace('/', '.')}.", f"{name}."), encoding="utf-8"
            )
        if fault:
            path = target / ("__init__.py" if fault.file == f"{part}.py" else Path(fault.file).name)
            text = path.read_text(encoding="utf-8")
            assert text.count(fault.old) == 1, f"{fault.file} holds {fault.old!r} {text.count(fault.old)} times"
            path.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
        importlib.invalidate_caches()
        return importlib.import_module(name)

    yield copy
    for module in [module for module in sys.modules if module.partition(".")[0] == name]:
        del sys.modules[module]


def is_broken(module: ModuleType, part: str) -> bool:
    """Whether a property does not hold for a module; those behind the first such property are not looked at."""
    try:
        for holds in PROPERTIES[part]:
            holds(module)
    except AssertionError:
        return True
    return False


@pytest.mark.parametrize("part", PROPERTIES)
def test_every_property_holds_for_the_unmodified_copy(part: str, planted: Any) -> None:
    module = planted(part, None)
    for holds in PROPERTIES[part]:
        holds(module)


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_every_fault_breaks_a_property(fault: Fault, planted: Any) -> None:
    assert is_broken(planted(fault.part, fault), fault.part)
