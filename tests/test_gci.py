"""Grid convergence indices of tables of values: the worked examples of the literature, and every kind of behaviour."""

import json
import math

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.cli import cli
from mpmverify.convergence.gci import Behaviour, observed_order
from mpmverify.convergence.grid_levels import grid_levels
from mpmverify.errors import UsageError


def gci(text, *options):
    return CliRunner().invoke(cli, ["gci", "-", *options], input=text)


CELIK = """\
cells,reattachment length
18000,6.063
8000,5.972
4500,5.863
"""
CELIK_FINER = """\
cells,axial velocity,oscillating
18000,10.7880,6.0042
4500,10.7250,5.9624
980,10.6050,6.0909
"""
NPARC = "spacing  pressure_recovery\n1  0.97050\n2  0.96854\n4  0.96178\n"


@pytest.mark.parametrize(
    ("cells", "values", "behaviour", "order", "limit", "change", "index"),
    [
        ((18000, 8000, 4500), (6.063, 5.972, 5.863), Behaviour.MONOTONE, 1.53, 6.1685, 0.015, 0.022),
        ((18000, 4500, 980), (10.7880, 10.7250, 10.6050), Behaviour.MONOTONE, 0.75, 10.8801, 0.006, 0.011),
        ((18000, 4500, 980), (6.0042, 5.9624, 6.0909), Behaviour.OSCILLATORY, 1.51, 6.0269, 0.007, 0.005),
    ],
)
def test_the_sample_calculations_of_celik_and_others(cells, values, behaviour, order, limit, change, index):
    """Table 1 of Celik et al. (2008), https://doi.org/10.1115/1.2960953, to the digits that it prints."""
    finest = grid_levels([count**-0.5 for count in cells], values)[-1]
    assert finest.behaviour is behaviour
    assert round(finest.order, 2) == order
    assert finest.limit == pytest.approx(limit, abs=1e-4)
    assert round(finest.change, 3) == change
    assert round(finest.confirmed, 3) == index


def test_the_example_of_the_nparc_alliance():
    """https://www.grc.nasa.gov/www/wind/valid/tutorial/spatconv.html, and the output of its program verify."""
    _, middle, finest = grid_levels([1, 2, 4], [0.97050, 0.96854, 0.96178])
    assert finest.order == pytest.approx(1.786170, abs=1e-6)
    assert finest.limit == pytest.approx(0.971300, abs=1e-6)
    assert 100 * finest.confirmed == pytest.approx(0.103083, abs=1e-6)
    assert 100 * middle.confirmed == pytest.approx(0.356249, abs=1e-6)
    assert 1 / finest.ratio == pytest.approx(0.997980, abs=1e-6)


def test_the_command_shows_every_pair_with_both_factors():
    result = gci(NPARC)
    assert result.exit_code == 0
    assert result.output == (
        "spacing  pressure_recovery  change %    order   limit  GCI 1.25 %   GCI 3 %    ratio  behaviour\n"
        "      4            0.96178         -        -       -           -         -        -          -\n"
        "      2            0.96854  0.697958        -       -    0.356249  0.854998        -          -\n"
        "      1             0.9705  0.201958  1.78617  0.9713    0.103083  0.247398  1.00202   monotone\n"
        "\n"
        "Sizes: 'spacing'. Values: 'pressure_recovery'.\n"
        "pressure_recovery: monotone; order 1.786, limit 0.9713003; "
        "index of the finest level 0.103 % (factor 1.25) or 0.247 % (factor 3)\n"
    )


def test_a_number_of_cells_needs_its_dimension():
    assert "--cells DIM (for 'cells')" in gci(CELIK).stderr
    data = json.loads(gci(CELIK, "--cells", "2", "--format", "json").stdout)
    assert data["columns"][0]["levels"][-1]["order"] == pytest.approx(1.53, abs=0.005)
    assert [
        column["levels"][-1]["behaviour"]
        for column in json.loads(gci(CELIK_FINER, "--cells", "2", "--format", "json").stdout)["columns"]
    ] == [
        "monotone",
        "oscillatory",
    ]
    assert "oscillating: oscillatory; order 1.508" in gci(CELIK_FINER, "--cells", "2").output


def test_a_formal_order_gives_a_band_with_its_factor():
    assert "with the formal order 2 the limit lies within 0.9705 ± 0.0024 (factor 3)" in gci(NPARC, "--formal", "2").output
    second = "h,f\n" + "".join(f"{h},{1 + h**2!r}\n" for h in (0.4, 0.2, 0.1))
    assert "(factor 1.25)" in gci(second, "--formal", "2").output.rpartition("the limit lies within")[2]


@pytest.mark.parametrize(
    ("values", "behaviour"),
    [
        ([1, 2, 1.5], "oscillatory"),
        ([1, 2, 0.5], "divergent"),
        ([1, 2, 4], "divergent"),
        ([1, 1, 2], "divergent"),
        ([1, 2, 2], "constant"),
        ([1, 2, 2.5], "monotone"),
    ],
)
def test_the_behaviour_is_named(values, behaviour):
    finest = grid_levels([4, 2, 1], values)[-1]
    assert finest.behaviour == behaviour
    assert math.isnan(finest.index) == (behaviour in ("divergent", "constant"))
    text = "h,f\n" + "".join(f"{h},{value}\n" for h, value in zip((4, 2, 1), values, strict=True))
    assert f"f: {behaviour}" in gci(text).output


def test_a_value_that_is_not_finite_has_its_own_status():
    assert gci("h,f\n4,1\n2,nan\n1,2\n").exit_code == 3


def test_a_level_without_a_value_is_named():
    assert "no value is given at h=2 (line 3)" in gci("h,f\n4,1\n2,-\n1,1.5\n0.5,1.7\n").output


def test_groups_are_studies_of_their_own():
    text = "scheme,h,f\n" + "".join(
        f"{name},{h},{1 + h**order!r}\n" for name, order in (("a", 1), ("b", 2)) for h in (0.4, 0.2, 0.1)
    )
    columns = json.loads(gci(text, "--format", "json").stdout)["columns"]
    assert {column["name"]: round(column["levels"][-1]["order"], 6) for column in columns} == {
        "f (scheme=a)": 1,
        "f (scheme=b)": 2,
    }


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        ("h,f\n2,1\n1,2\n", (), "needs three levels, or two and the formal order"),
        ("h,f\n2,1\n", ("--formal", "2"), "needs two levels"),
        ("h,f\n2,1\n1,2\n", ("--formal", "nan"), "the formal order must be positive"),
        ("h,f\n2,1\n2,2\n1,3\n", (), "column 'f': "),
        ("h,dt,f\n2,1,1\n2,2,1\n1,1,2\n1,2,3\n", (), "needs a ladder in one of them"),
        ("h,time\n2,1\n1,2\n", (), "has no column of values beside 'h': name one with --value"),
        ("", (), "is empty"),
        ("2 1\n1 2\n", (), "such as --h 1 --value 2"),
    ],
)
def test_what_has_no_index_is_refused_in_one_sentence(text, options, said):
    result = gci(text, *options)
    assert result.exit_code == 2
    assert said in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


def test_two_levels_take_the_formal_order():
    _, fine = grid_levels([2, 1], [1.4, 1.1], formal=2)
    assert fine.index == pytest.approx(0.1 / 1.1)
    assert fine.behaviour is None


def test_a_size_that_is_given_twice_is_refused():
    with pytest.raises(UsageError):
        grid_levels([2, 1, 1], [1, 2, 3])


RATIOS = st.floats(1.1, 4)


@given(RATIOS, RATIOS, st.floats(0.1, 6), st.booleans())
def test_the_observed_order_solves_its_equation(wide, narrow, order, alternating):
    sign = 1 if alternating else -1
    growth = narrow**order * (wide**order + sign) / (narrow**order + sign)
    assert observed_order(wide, narrow, growth, alternating=alternating) == pytest.approx(order, rel=1e-9)


@given(RATIOS, RATIOS, st.floats(0.5, 4), st.floats(-10, 10), st.sampled_from([-1, 1]))
def test_values_of_a_power_law_have_its_order_and_limit(wide, narrow, order, limit, sign):
    h = [wide * narrow, narrow, 1.0]
    finest = grid_levels(h, [limit + sign * size**order for size in h])[-1]
    assert finest.order == pytest.approx(order, rel=1e-6)
    assert finest.limit == pytest.approx(limit, abs=1e-6)
