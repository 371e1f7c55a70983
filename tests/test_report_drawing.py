"""The drawing of a problem: every face of every shipped case has its symbol, bodies are where they are, names are escaped."""

import re
from xml.etree import ElementTree

import pytest

from mpmverify import studies
from mpmverify.dataset.statement import statement
from mpmverify.reports.drawing import MEANING, drawing

CASES = [(study.name, case.name, case.problem.problem) for study in map(studies.get, studies.NAMES) for case in study.cases]
BAR = {
    "domain": "[0, 1] m",
    "face x-": "velocity 0 m/s",
    "face x+": "traction [Pa]: ramp load, amplitude = 1e-06, duration = 0.3",
}
BOX = {"domain": "[0, 2] m x [0, 1] m"}


def elements(svg: str) -> list[ElementTree.Element]:
    return list(ElementTree.fromstring(svg).iter())


def styles(svg: str) -> list[str]:
    return [element.get("class", "") for element in elements(svg)]


@pytest.mark.parametrize(("study", "case", "problem"), CASES, ids=[f"{study}-{case}" for study, case, _ in CASES])
def test_every_face_of_a_shipped_case_has_a_known_kind(study, case, problem):
    setup = statement(problem)
    svg, _ = drawing(setup)
    kinds = re.findall(r"[xyz][+-] (\w+)", elements(svg)[0].get("aria-label", ""))
    assert len(kinds) == sum(name.startswith("face ") for name in setup)
    assert set(kinds) <= MEANING.keys()
    assert styles(svg).count("body") >= 1, "the body is drawn"
    assert not re.search(r"\b(nan|inf)\b", svg)


def test_a_bar_is_clamped_at_one_end_and_loaded_at_the_other():
    svg, legend = drawing(BAR)
    assert {"wall", "hatch", "load", "head"} <= set(styles(svg))
    assert legend == "Hatched: clamped; arrows: prescribed traction."
    free, _ = drawing(BAR | {"face x+": "traction 0 Pa"})
    assert "load" not in styles(free)


@pytest.mark.parametrize(
    ("condition", "style"),
    [
        ("velocity 0 m/s", "roller"),
        ("velocity -0.25 m/s", "load"),
        ("fixed", "hatch"),
        ("periodic", "joined"),
        ("traction 2 Pa", "load"),
        ("absorbing", "hatch"),
        ("inflow 1", "load"),
        ("outflow", "load"),
    ],
)
def test_each_kind_of_face_has_its_symbol(condition, style):
    svg, _ = drawing(BOX | {"face y-": condition})
    assert style in styles(svg)
    assert style not in styles(drawing(BOX)[0])


def test_a_block_is_drawn_where_it_is():
    svg, _ = drawing(BOX | {"body": "block, lower = (0.5, 0.25), upper = (1.5, 1.0)"})
    box, block = (next(e for e in elements(svg) if e.get("class") == name) for name in ("domain", "body"))
    scale = float(box.get("width")) / 2
    assert float(block.get("x")) - float(box.get("x")) == pytest.approx(0.5 * scale, abs=0.2)
    assert float(block.get("width")) == pytest.approx(scale, abs=0.2)
    assert float(block.get("height")) == pytest.approx(0.75 * scale, abs=0.2)
    assert float(block.get("y")) == pytest.approx(float(box.get("y")), abs=0.2)


def test_names_that_nobody_expects_are_escaped_and_leave_the_face_without_symbol():
    svg, legend = drawing(BOX | {"face x+": "<b>&\"'", "body": "torus, radius = 1"})
    assert "<b>" not in svg
    assert legend == ""
    assert "body" not in styles(svg)
