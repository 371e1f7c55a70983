"""Tables of errors from tutorials, demos and papers, in the layout in which they stand there: the orders that their authors report.

Numbers only, with their sources. The pages of deal.II are the results of its tutorial programs, https://dealii.org/developer/doxygen.
"""

import json

import pytest
from click.testing import CliRunner

from mpmverify.cli import cli


def run(command, text, *options):
    return CliRunner().invoke(cli, [command, "-", *options], input=text)


def judged(text, *options):
    """Judged columns by name."""
    result = run("judge", text, *options, "--format", "json")
    assert result.exit_code in (0, 1), result.stderr
    return {column["name"]: column for column in json.loads(result.stdout)["columns"]}


DEALII_7 = """\
cycle cells dofs     L2        H1      Linfty
    0    64   289 1.606e-01 1.278e+00 3.029e-01
    1   256  1089 7.638e-03 5.248e-01 4.816e-02
    2  1024  4225 8.601e-04 1.086e-01 4.827e-03
    3  4096 16641 1.107e-04 2.756e-02 7.804e-04
    4 16384 66049 1.394e-05 6.915e-03 9.991e-05
"""
DEALII_7_RATES = """\
n cells         H1                   L2
0    64 2.858e+00    -    - 1.840e+00     -    -
1   256 1.199e+00 2.38 1.25 3.570e-02 51.54 5.69
2  1024 7.565e-01 1.58 0.66 1.192e-02  2.99 1.58
3  4096 3.823e-01 1.98 0.98 3.047e-03  3.91 1.97
4 16384 1.917e-01 1.99 1.00 7.660e-04  3.98 1.99
"""
DEALII_20 = (
    '<table>\n<tr>\n<th></th>\n<th colspan="3" align="center">Finite element order</th>\n</tr>\n'
    "<tr>\n<th>Refinement level</th>\n<th>0</th>\n<th>1</th>\n<th>2</th>\n</tr>\n"
    "<tr><th>0</th>  <td>1.45344</td>  <td>0.0831743</td>  <td>0.0235186</td></tr>\n"
    "<tr><th>1</th>  <td>0.715099</td>  <td>0.0245341</td>  <td>0.00293983</td></tr>\n"
    "<tr><th>2</th>  <td>0.356383</td>  <td>0.0063458</td>  <td>0.000367478</td></tr>\n"
    "<tr><th>3</th>  <td>0.178055</td>  <td>0.00159944</td>  <td>4.59349e-05</td></tr>\n"
    "<tr><th>4</th>  <td>0.0890105</td>  <td>0.000400669</td>  <td>5.74184e-06</td></tr>\n"
    "<tr><th>5</th>  <td>0.0445032</td>  <td>0.000100218</td>  <td>7.17799e-07</td></tr>\n"
    "<tr><th>6</th>  <td>0.0222513</td>  <td>2.50576e-05</td>  <td>9.0164e-08</td></tr>\n"
    "<tr><th></th>  <th>$O(h)$</th>  <th>$O(h^2)$</th>  <th>$O(h^3)$</th></tr>\n</table>\n"
)
DEALII_34 = """\
cycle cells dofs    L2(phi)     Linfty(alpha)
    0    20   20 4.465e-02    - 5.000e-02    -
    1    40   40 1.081e-02 2.05 2.500e-02 1.00
    2    80   80 2.644e-03 2.03 1.250e-02 1.00
    3   160  160 6.529e-04 2.02 6.250e-03 1.00
"""
DEALII_47 = r"""
<table align="center" class="doxtable">
 <tr>
  <th>Number of refinements </th><th> $\|u-u_h\|_{L_2}$ </th><th> Conv. rates </th><th> $|u-u_h|_{H^1}$ </th><th> Conv. rates </th>
  <th> $|u-u_h|^\circ_{H^2}$ </th><th> Conv. rates </th>
 </tr>
 <tr>
  <td> 2 </td><td> 2.045e-04 </td><td> </td><td> 4.402e-03 </td><td> </td><td> 1.641e-01 </td><td> </td>
 </tr>
 <tr>
  <td> 3 </td><td> 1.312e-05 </td><td> 3.96 </td><td> 5.537e-04 </td><td> 2.99 </td><td> 4.096e-02 </td><td> 2.00 </td>
 </tr>
 <tr>
  <td> 4 </td><td> 8.239e-07 </td><td> 3.99 </td><td> 6.904e-05 </td><td> 3.00 </td><td> 1.023e-02 </td><td> 2.00 </td>
 </tr>
 <tr>
  <td> 5 </td><td> 5.158e-08 </td><td> 3.99 </td><td> 8.621e-06 </td><td> 3.00 </td><td> 2.558e-03 </td><td> 2.00 </td>
 </tr>
</table>
"""
DEALII_51 = """\
cells dofs      val L2        grad L2      val L2-post
   16   160 3.613e-01    - 1.891e+00    - 3.020e-01    -
   36   336 6.411e-02 4.26 5.081e-01 3.24 3.238e-02 5.51
   64   576 3.480e-02 2.12 2.533e-01 2.42 5.277e-03 6.31
  144  1248 8.297e-03 3.54 5.924e-02 3.58 6.330e-04 5.23
  256  2176 2.254e-03 4.53 1.636e-02 4.47 1.403e-04 5.24
  576  4800 4.558e-04 3.94 3.277e-03 3.96 1.844e-05 5.01
 1024  8448 1.471e-04 3.93 1.052e-03 3.95 4.378e-06 5.00
 2304 18816 2.956e-05 3.96 2.104e-04 3.97 5.750e-07 5.01
 4096 33280 9.428e-06 3.97 6.697e-05 3.98 1.362e-07 5.01
 9216 74496 1.876e-06 3.98 1.330e-05 3.99 1.788e-08 5.01
"""
DEALII_74 = (
    "<table><tr><th>cycle</th><th>n_cells</th><th>n_dofs</th><th>L2 </th><th>rate</th><th>H1</th><th>rate</th><th>Energy</th></tr>"
    + "".join(
        f'<tr><td align="center">{cycle}</td><td>{cells}</td><td>{dofs}</td><td>{l2}</td><td>{rate or "&nbsp;"}</td><td>{h1}</td>'
        f"<td>{h1_rate or '&nbsp;'}</td><td>{energy}</td></tr>\n"
        for cycle, cells, dofs, l2, rate, h1, h1_rate, energy in (
            (0, 16, 256, "1.933e-03", "", "1.061e-01", "", "1.506e-01"),
            (1, 64, 1024, "9.605e-05", "4.33", "8.995e-03", "3.56", "1.133e-02"),
            (2, 256, 4096, "5.606e-06", "4.10", "9.018e-04", "3.32", "9.736e-04"),
            (3, 1024, 16384, "3.484e-07", "4.01", "1.071e-04", "3.07", "1.088e-04"),
            (4, 4096, 65536, "2.179e-08", "4.00", "1.327e-05", "3.01", "1.331e-05"),
            (5, 16384, 262144, "1.363e-09", "4.00", "1.656e-06", "3.00", "1.657e-06"),
        )
    )
)
DEALII_78 = """\
n cells         H1                  L2
      1 5.774e-01    -    - 1.667e-01    -    -
      2 2.889e-01 2.00 1.00 3.906e-02 4.27 2.09
      4 1.444e-01 2.00 1.00 9.679e-03 4.04 2.01
      8 7.218e-02 2.00 1.00 2.405e-03 4.02 2.01
     16 3.609e-02 2.00 1.00 5.967e-04 4.03 2.01
     32 1.804e-02 2.00 1.00 1.457e-04 4.10 2.03
"""
DEALII_85 = """\
| Cycle | Mesh size | $L^2$-Error | EOC  |
|:-----:|:---------:|:-----------:|:----:|
|   0   |  0.3025   |  8.0657e-02 |  -   |
|   1   |  0.1513   |  1.8711e-02 | 2.11 |
|   2   |  0.0756   |  4.1624e-03 | 2.17 |
|   3   |  0.0378   |  9.3979e-04 | 2.15 |
"""
DEALII_90 = """\
| Cycle |   DOFS   | Rate | Iterations | $L^2$-Error |  EOC  | $H^1$-Error | EOC  |$s_h^{1/2}(u_h)$|  EOC  |
|:-----:|:--------:|:----:|:----------:|:-----------:|:-----:|:-----------:|:----:|:--------------:|:-----:|
| 0     |    12370 |   -  |   15       | 7.6322e-02  |  -    | 3.6212e-01  |  -   |   2.2423e-01   |    -  |
| 1     |    49406 | 2.00 |   18       | 1.1950e-02  | 2.68  | 1.4752e-01  | 1.30 |   1.1238e-01   | 1.00  |
| 2     |   196848 | 1.99 |   19       | 1.7306e-03  | 2.79  | 7.4723e-02  | 0.98 |   6.1131e-02   | 0.88  |
| 3     |   785351 | 2.00 |   22       | 3.6276e-04  | 2.25  | 3.9329e-02  | 0.93 |   3.0185e-02   | 1.02  |
| 4     |  3136501 | 2.00 |   25       | 7.5910e-05  | 2.26  | 1.9694e-02  | 1.00 |   1.4875e-02   | 1.02  |
| 5     | 12536006 | 2.00 |   26       | 1.7279e-05  | 2.14  | 9.8443e-03  | 1.00 |   7.4067e-03   | 1.01  |
| 6     | 50122218 | 2.00 |   30       | 4.3891e-06  | 1.98  | 4.9219e-03  | 1.00 |   3.7042e-03   | 1.00  |
"""
DEALII_95 = """\
| Cycle | Mesh size | $L^2$-Error | EOC  |
|:-----:|:---------:|:-----------:|:----:|
|   0   |  0.3025   |  1.2442e-04 |  -   |
|   1   |  0.1513   |  9.6514e-06 | 3.69 |
|   2   |  0.0756   |  8.3693e-07 | 3.53 |
|   3   |  0.0378   |  7.4062e-08 | 3.50 |
"""
DEALII_104 = """\
| Refinement |       DoFs | Iterations |    Time (s) | Velocity Error | Pressure Error |
|-----------:|-----------:|-----------:|------------:|---------------:|---------------:|
|          0 |      2,312 |         10 |     2.4e-02 |       4.5e-02  |       1.5e-01  |
|          1 |     15,468 |         20 |     6.0e-02 |       6.0e-03  |       1.2e-02  |
|          2 |    112,724 |         22 |     1.1e-01 |       7.6e-04  |       1.2e-03  |
|          3 |    859,812 |         23 |     2.5e-01 |       9.6e-05  |       2.3e-04  |
|          4 |  6,714,692 |         23 |     1.2e+00 |       1.2e-05  |       5.6e-05  |
|          5 | 53,070,468 |         24 |     8.8e+00 |       1.5e-06  |       1.4e-05  |
"""
FENICS = "".join(
    f"h={h} E={error} r={rate}\n\n"
    for h, error, rate in (
        ("1.25E-01", "3.25E-02", "1.83"),
        ("6.25E-02", "8.37E-03", "1.96"),
        ("3.12E-02", "2.11E-03", "1.99"),
        ("1.56E-02", "5.29E-04", "2.00"),
        ("7.81E-03", "1.32E-04", "2.00"),
        ("3.79E-03", "3.11E-05", "2.00"),
    )
)
EXAHYPE = """\
numPts\tl1      \tl2      \tlinf    \to1  \to2  \toinf
20\t2,43E-02\t6,28E-03\t5,29E-03
40\t5,03E-03\t1,27E-03\t1,16E-03\t2,27\t2,30\t2,19
60\t1,98E-03\t4,91E-04\t4,41E-04\t2,30\t2,35\t2,39
80\t1,01E-03\t2,46E-04\t2,21E-04\t2,35\t2,40\t2,40
"""
MPMAT = """\
% G=0.0001
disp1=[1.181767235896483e-05;
       3.062114801402464e-06;
       7.712732858447164e-07;
       1.931993470892981e-07];

% G=0.001, standard MPM
disp1MPM=[1.078575308827472e-05;
      2.563045809675697e-06;
      6.089991540886196e-07;
      1.478400791855386e-07];

size=[0.125000000000000;
  0.062500000000000;
  0.031250000000000;
  0.015625000000000];
"""
MPMAT_FEM = """\
dispLinf1=[2.720662490135263e-04;
          6.838537185840609e-05;
          1.711870155361189e-05;
          4.281061852364640e-06;
          1.071939388213574e-06;
          2.679848470533935e-07
     ];

size=[0.125;
  0.062500000000000;
  0.031250000000000;
  0.015625000000000;
  0.007812500000000;
  0.003906250000000];
"""
NLFEM = """\
| h| dof| L2 Error| Rates|
|---|---|---|---|
| 1.00e-01 | 8.10e+01 | 2.35e-03 | 0.00e+00 |
| 5.00e-02 | 3.61e+02 | 5.92e-04 | 1.99e+00 |
| 2.50e-02 | 1.52e+03 | 1.57e-04 | 1.91e+00 |
| 1.25e-02 | 6.24e+03 | 3.83e-05 | 2.04e+00 |
"""
THETA_SCHEME = r"""
\begin{tabular}{l|l|l}
$n$ gridpoints & error & order of error \\ \hline
8 & 0.0001493 & nan \\
16 & 2.297e-05 & -2.701 \\
32 & 3.76e-06 & -2.611 \\
64 & 6.406e-07 & -2.553 \\
128 & 1.107e-07 & -2.533 \\
\end{tabular}
"""
CUT_CELLS = """\
| method | h | lp_norm | inside_cells | inside_cells_by_dim | all_err | empty_err | pair_order_all |
| --- | --- | --- | --- | --- | --- | --- | --- |
| Heat | 1 | L^2 | 5 | [4, 4] | 0.923985 | 0 | NaN |
| Heat | 0.5 | L^2 | 21 | [7, 7] | 0.198488 | 0 | 2.21882 |
| Heat | 0.25 | L^2 | 97 | [13, 13] | 0.120006 | 0 | 0.725951 |
| Heat | 0.125 | L^2 | 449 | [26, 26] | 0.0410258 | 0 | 1.5485 |
| Heat | 0.0625 | L^2 | 1925 | [51, 51] | 0.0163361 | 0 | 1.32847 |
| Heat | 0.03125 | L^2 | 7909 | [102, 102] | 0.00687345 | 0 | 1.24896 |
"""


PUBLISHED = [
    pytest.param(DEALII_7, ("--cells", "2"), {"L2": 3, "H1": 2, "Linfty": 3}, id="deal.II step-7, Q2"),
    pytest.param(
        DEALII_7, ("--dofs", "2"), {"L2": 3, "H1": 2, "Linfty": 3}, id="deal.II step-7, Q2, by its degrees of freedom"
    ),
    pytest.param(DEALII_7_RATES, ("--cells", "2"), {"L2": 2, "H1": 1}, id="deal.II step-7, Q1, rates without names"),
    pytest.param(DEALII_20, ("--levels", "2"), {"0": 1, "1": 2, "2": 3}, id="deal.II step-20, HTML, columns named by numbers"),
    pytest.param(DEALII_34, ("--cells", "1"), {"L2(phi)": 2, "Linfty(alpha)": 1}, id="deal.II step-34, rates without names"),
    pytest.param(
        DEALII_47,
        ("--levels", "2"),
        {"||u-u_h||_L_2": 4, "|u-u_h|_H^1": 3, "|u-u_h|^circ_H^2": 2},
        id="deal.II step-47, HTML with formulas",
    ),
    pytest.param(
        DEALII_51,
        ("--cells", "2"),
        {"val L2": 4, "grad L2": 4, "val L2-post": 5},
        id="deal.II step-51, Q3, names of two words",
    ),
    pytest.param(DEALII_74, ("--cells", "2"), {"L2": 4, "H1": 3, "Energy": 3}, id="deal.II step-74, HTML"),
    pytest.param(DEALII_78, ("--cells", "1"), {"L2": 2, "H1": 1}, id="deal.II step-78, rates without names"),
    pytest.param(DEALII_85, (), {"L^2-Error": 2.15}, id="deal.II step-85, Markdown"),
    pytest.param(
        DEALII_90,
        ("--dofs", "2"),
        {"L^2-Error": 2.1, "H^1-Error": 1, "s_h^1/2(u_h)": 1},
        id="deal.II step-90, Markdown with iterations",
    ),
    pytest.param(DEALII_95, (), {"L^2-Error": 3.55}, id="deal.II step-95, Markdown"),
    pytest.param(
        DEALII_104, ("--dofs", "3"), {"Velocity Error": 3, "Pressure Error": 2}, id="deal.II step-104, commas in thousands"
    ),
    pytest.param(DEALII_104, ("--levels", "2"), {"Velocity Error": 3, "Pressure Error": 2}, id="deal.II step-104, by levels"),
    pytest.param(FENICS, (), {"E": 2}, id="Langtangen, A FEniCS tutorial (2011), section 1.7.5, log"),
    pytest.param(
        EXAHYPE, ("--dofs", "1"), {"l1": 2.3, "l2": 2.35, "linf": 2.3}, id="ExaHyPE, convergence analysis, spreadsheet"
    ),
    pytest.param(MPMAT, (), {"disp1": 2, "disp1MPM": 2.05}, id="mpmat, impmMMS1DBody.m, MATLAB"),
    pytest.param(MPMAT_FEM, (), {"dispLinf1": 2}, id="mpmat, femULMMS.m, MATLAB"),
    pytest.param(NLFEM, (), {"L2 Error": 2}, id="nlfem, result_testConfConstant.md"),
    pytest.param(THETA_SCHEME, ("--dofs", "1"), {"error": 2.55}, id="theta scheme, mivanit/numerical-PDE-nonsense, LaTeX"),
]


@pytest.mark.parametrize(("text", "options", "orders"), PUBLISHED)
def test_the_order_is_the_one_that_was_published(text, options, orders):
    found = judged(text, *options)
    finest = {
        name: min(column["levels"], key=lambda level: next(iter(level.values())))["order"] for name, column in found.items()
    }
    assert finest == pytest.approx(orders, abs=0.15)


@pytest.mark.parametrize(("text", "options", "orders"), PUBLISHED)
def test_the_published_order_does_not_fail_and_no_other_one_passes(text, options, orders):
    for name, order in orders.items():
        only = (*options, "--error", name)
        assert judged(text, *only, "--low", str(order - 0.35), "--high", str(order + 0.35))[name]["verdict"] != "FAIL"
        for low, high in ((order + 0.4, order + 1), (order - 1, order - 0.4)):
            assert judged(text, *only, "--low", str(low), "--high", str(high))[name]["verdict"] != "PASS"


def test_columns_that_are_no_errors_are_left_out():
    assert json.loads(run("judge", DEALII_90, "--dofs", "2", "--format", "json").stdout)["left out"] == [
        "Cycle",
        "Rate",
        "Iterations",
        "L^2-Error EOC",
        "H^1-Error EOC",
        "s_h^1/2(u_h) EOC",
    ]


def test_errors_that_vanish_are_exact_and_others_are_judged():
    found = judged(CUT_CELLS, "--low", "0.8", "--high", "1.7")
    assert found.keys() == {"all_err", "empty_err"}
    assert "exact" in found["empty_err"]["reason"]


def test_rates_without_sizes_say_what_is_missing():
    """docs/src/index.md of Trixi.jl prints errors and rates alone."""
    result = run("judge", "error     EOC\n9.14e-06  -\n5.69e-07  4.01\n3.55e-08  4.00\n2.22e-09  4.00\n")
    assert result.exit_code == 2
    assert "no column of sizes by its name (error, EOC)" in result.stderr
