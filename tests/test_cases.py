"""What `mpmverify list STUDY` says of each case."""

import pytest
from click.testing import CliRunner

from mpmverify import studies
from mpmverify.cli import cli


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
        ("axial-vibration", "", ("starts with velocity", "faces x-, x+: velocity 0 m/s")),
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
