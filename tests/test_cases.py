"""What `mpmverify list STUDY` says of each case."""

import dataclasses

import pytest
from click.testing import CliRunner

from mpmverify import studies
from mpmverify.cli import cli
from mpmverify.cli.cases import described
from mpmverify.errors import UsageError
from mpmverify.problem import Discretisation
from mpmverify.study import Refinement


@pytest.mark.parametrize(
    ("study", "case", "lines"),
    [
        (
            "plane-waves",
            "clamped",
            (
                "domain [0, 0.5] m x [0.25, 1.25] m",
                "faces x-, x+: periodic",
                "strain displacement gradient up to 1e-05",
                "hardly sees which measure the stress has",
                "moves up to 3.2e-06 m, which is 0.00015 cells of the finest level",
                "body force none",
                "levels nu_C=0.3: h = 0.04167,",
            ),
        ),
        (
            "moving-bodies",
            "square",
            ("body force at material points", "starts with velocity", "which is 17 cells of the finest level"),
        ),
        ("axial-vibration", "", ("strain not known:", "starts with velocity", "faces x-, x+: velocity 0 m/s")),
        ("advection", "step", ("material transport, a = 1 m/s", "fields u")),
        ("mpm-stability", "", ("your code cannot be judged here by what it declares",)),
    ],
)
def test_of_a_named_study_every_case_is_described(study, case, lines):
    result = CliRunner().invoke(cli, ["list", study])
    assert result.exit_code == 0
    blocks = [" ".join(block.split()) for block in result.output.split("\n\n")[1:]]
    assert [
        block.startswith(f"{study}, {declared.name} ") for block, declared in zip(blocks, studies.get(study).cases, strict=True)
    ]
    (described,) = [block for block in blocks if block.startswith(f"{study}, {case or studies.get(study).cases[0].name} ")]
    for line in lines:
        assert line in described


CLAMPED = next(case for case in studies.get("plane-waves").cases if case.name == "clamped")


def test_a_case_of_ones_own_is_described_whatever_it_lacks():
    assert "cannot be judged here" in dict(described(dataclasses.replace(CLAMPED, series=(), ladder=None)))["your code"]
    fine = Refinement("fine", (Discretisation(0.5 / 2048, 0.3), Discretisation(0.5 / 4096, 0.3)), 2)
    assert dict(described(dataclasses.replace(CLAMPED, ladder=fine)))["strain"].startswith(
        "not looked for: the coarsest level has 8388608"
    )


def test_an_exact_field_that_raises_is_named():
    fields = {**CLAMPED.problem.exact.fields, "displacement": lambda X, t: 1 / 0}
    exact = dataclasses.replace(CLAMPED.problem.exact, fields=fields)
    case = dataclasses.replace(CLAMPED, problem=dataclasses.replace(CLAMPED.problem, exact=exact))
    with pytest.raises(UsageError, match="the exact displacement of case 'clamped' raises ZeroDivisionError: division by zero"):
        dict(described(case))
