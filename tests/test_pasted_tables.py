"""Tables as people paste them, and the answer that each should get."""

import pytest
from click.testing import CliRunner

from mpmverify.cli import cli

ROUGH_START = """\
h,L2
1.0,20.0
0.5,2.0
0.25,0.0625
0.125,0.015625
0.0625,0.00390625
0.03125,0.0009765625
0.015625,0.000244140625
0.0078125,6.103515625e-05
"""
HDG_DEGREE_1 = """\
h,val,grad,post
0.25,18.04,22.07,17.98
0.16666666666666666,6.125,9.472,6.084
0.125,0.9785,4.26,0.7102
0.08333333333333333,0.273,1.866,0.06115
0.0625,0.1493,1.046,0.0288
0.041666666666666664,0.06965,0.4846,0.009204
0.03125,0.04018,0.2784,0.004027
0.020833333333333332,0.01831,0.1264,0.001236
0.015625,0.01043,0.07185,0.0005306
0.010416666666666666,0.00469,0.03228,0.0001599
"""
CELLS = """\
cells,dofs,L2,H1,Linfty
64,81,1.840e+00,2.858e+00,1.835e+00
256,289,3.570e-02,1.199e+00,1.307e-01
1024,1089,1.192e-02,7.565e-01,7.168e-02
4096,4225,3.047e-03,3.823e-01,2.128e-02
16384,16641,7.660e-04,1.917e-01,5.554e-03
"""
CONSTANT = """\
h,a,b
1,0.0699,0.131
0.5,0.0699,0.131
0.25,0.0699,0.131
0.125,0.0699,0.131
"""
SMALL_UNIT = """\
h,L2
1.0,3e-14
0.5,7.5e-15
0.25,1.875e-15
0.125,4.6875e-16
0.0625,1.171875e-16
0.03125,2.9296875e-17
"""
ORDER_DX = """\
L2,dx
1.606e-01,0.25
7.638e-03,0.125
8.601e-04,0.0625
1.107e-04,0.03125
"""
EXTRA = """\
h,n,time,L2
0.25,4,0.1,1.606e-01
0.125,8,0.4,7.638e-03
0.0625,16,1.6,8.601e-04
0.03125,32,6.9,1.107e-04
"""
COMMENT = """\
# deal.II
h,L2
0.25,1.606e-01
0.125,7.638e-03
0.0625,8.601e-04
0.03125,1.107e-04
"""
WS = """\
h      L2
0.25   1.606e-01
0.125  7.638e-03
0.0625 8.601e-04
0.03125 1.107e-04
"""
FORTRAN = """\
h,L2
0.25D0,1.606D-01
0.125D0,7.638D-03
0.0625D0,8.601D-04
0.03125D0,1.107D-04
"""
RATE = """\
h,L2,rate
0.25,1.606e-01,-
0.125,7.638e-03,4.39
0.0625,8.601e-04,3.15
0.03125,1.107e-04,2.96
"""
MD = """\
| h | L2 |
|---|---|
| 0.25 | 1.606e-01 |
| 0.125 | 7.638e-03 |
| 0.0625 | 8.601e-04 |
"""


def judge(text, *options):
    return CliRunner().invoke(cli, ["judge", "-", *options], input=text)


def lines(result, column):
    """The line with the verdict on a column."""
    (found,) = [line for line in result.output.splitlines() if line.split(":")[0].endswith(f" {column}")]
    return found


SECOND = ("--low", "1.8", "--high", "2.2")
THIRD = ("--low", "2.7", "--high", "3.3")


def test_a_rough_start_is_dropped_by_name():
    found = lines(judge(ROUGH_START, *SECOND), "L2")
    assert found.startswith("PASS L2: order 2.000")
    assert "h=1" in found
    assert "h=0.5" in found


@pytest.mark.parametrize(
    ("column", "options", "verdict"),
    [("val", ("--low", "2.1"), "not PASS"), ("val", SECOND, "PASS"), ("post", THIRD, "PASS")],
)
def test_a_published_rough_start_has_its_published_order(column, options, verdict):
    found = lines(judge(HDG_DEGREE_1, "--error", column, *options), column)
    assert found.startswith("PASS ") == (verdict == "PASS")
    assert verdict == "not PASS" or "without" in found


def test_counts_are_no_sizes():
    refused = judge(CELLS)
    assert refused.exit_code == 2
    assert "--cells DIM" in refused.stderr
    result = judge(CELLS, "--cells", "2", "--low", "L2=1.7", "--high", "L2=2.3", "--low", "H1=0.7", "--high", "H1=1.3")
    assert "'dofs'" in result.output.partition("Left out: ")[2].splitlines()[0]
    assert lines(result, "H1").startswith("PASS ")
    assert not lines(result, "L2").startswith("FAIL ")


def test_a_constant_error_is_stagnant():
    result = judge(CONSTANT)
    assert result.exit_code == 1
    for column in ("a", "b"):
        assert lines(result, column).startswith("FAIL ")
        assert "stagnant" in lines(result, column)
    assert "divergent" not in result.output


def test_absolute_errors_in_a_small_unit_have_a_scale():
    assert lines(judge(SMALL_UNIT, "--scale", "1e-13", *SECOND), "L2").startswith("PASS L2: order 2.000")
    result = judge(SMALL_UNIT, *SECOND)
    assert not lines(result, "L2").startswith("PASS ")
    assert "at most 1e-12 count as round-off" in result.output
    assert "--scale" in result.output


@pytest.mark.parametrize(
    ("text", "size", "left_out"),
    [
        (ORDER_DX, "dx", ""),
        (EXTRA, "h", "'n', 'time'"),
        (COMMENT, "h", ""),
        (WS, "h", ""),
        (FORTRAN, "h", ""),
        (RATE, "h", "'rate'"),
    ],
)
def test_the_layout_of_a_table_does_not_change_its_verdict(text, size, left_out):
    result = judge(text)
    assert f"Sizes: '{size}'. Errors: 'L2'.{f' Left out: {left_out}.' * bool(left_out)}\n" in result.output
    assert lines(result, "L2") == lines(judge(COMMENT), "L2").replace("h=", f"{size}=")
    assert "order" in lines(result, "L2")


def test_markdown_is_read():
    assert judge(MD).output.startswith(
        "     h         L2  order\n  0.25     0.1606      -\n 0.125   0.007638  4.394\n0.0625  0.0008601  3.151\n"
    )
