"""Tables as people have them: whatever separates the cells and however numbers are written, the same numbers are read."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpmverify.convergence.column_names import Role, role
from mpmverify.convergence.numerals import Decimal, grid, number, plain
from mpmverify.convergence.table import parse_table
from mpmverify.errors import UsageError


def read(text):
    return parse_table(text, "'errors.csv'")


def columns(text):
    """Columns of numbers by their names."""
    table = read(text)
    return {name: table.numbers(name).tolist() for name in table.names if not table.is_text(name)}


TWO = {"h": [0.25, 0.125], "L2": [1.2e-2, 3e-3]}
SAME = {
    "csv": "h,L2\n0.25,1.2e-2\n0.125,3e-3\n",
    "semicolons": "h;L2\n0.25;1.2e-2\n0.125;3e-3\n",
    "declared separator": "sep=;\nh;L2\n0.25;1.2e-2\n0.125;3e-3\n",
    "tabs": "h\tL2\n0.25\t1.2e-2\n0.125\t3e-3\n",
    "bars": "h|L2\n0.25|1.2e-2\n0.125|3e-3\n",
    "white space": "  h      L2\n0.25   1.2e-2\n  0.125  3e-3\n",
    "comma and blank": "h, L2\n0.25, 1.2e-2\n0.125, 3e-3\n",
    "decimal commas": "h;L2\n0,25;1,2e-2\n0,125;3e-3\n",
    "decimal commas in white space": "h L2\n0,25 1,2e-2\n0,125 3e-3\n",
    "decimal commas in quotes": 'h,L2\n"0,25","1,2e-2"\n"0,125","3e-3"\n',
    "header of numpy.savetxt": "# h L2\n2.5e-01 1.2e-02\n1.25e-01 3.0e-03\n",
    "header of numpy.savetxt with commas": "# h L2\n2.5e-01,1.2e-02\n1.25e-01,3.0e-03\n",
    "comments": "# run 5\n% of today\nh,L2\n! coarse\n0.25,1.2e-2\n// fine\n0.125,3e-3\n",
    "comments at the end": "# of mine\n# h L2\n0.25 1.2e-2 # coarse\n0.125 3e-3 ! fine\n",
    "units": "h,L2\nm,-\n0.25,1.2e-2\n0.125,3e-3\n",
    "units in brackets": "h L2\n[m] [Pa]\n0.25 1.2e-2\n0.125 3e-3\n",
    "title": "Convergence\n\nh,L2\n0.25,1.2e-2\n0.125,3e-3\n",
    "Fortran": "h L2\n0.25D0 1.2D-02\n0.125D+00 3.000D-03\n",
    "fractions": "h,L2\n1/4,1.2e-2\n1/8,3/1000\n",
    "powers": "h,L2\n2^-2,1.2e-2\n2**-3,3*10^-3\n",
    "spaced products": "h   L2\n1 / 4  1.2 x 10^-2\n1/8  3 * 10^-3\n",
    "Markdown": "| h | L2 |\n|---|:--:|\n| **0.25** | `1.2e-2` |\n| 0.125 | 3e-3 |\n",
    "Markdown in prose": "We see:\n\n| h | $L2$ |\n|---|---|\n| 0.25 | 1.2e-2 |\n| 0.125 | 3·10⁻³ |\n\nIt converges.\n",
    "Markdown beside formulas": "$$a & b \\\\ c & d$$\n\n| h | L2 |\n|---|---|\n| 0.25 | 1.2e-2 |\n| 0.125 | 3e-3 |\n",
    "bare Markdown": "h | L2\n--- | ---\n0.25 | 1.2e-2\n0.125 | 3e-3\n",
    "Org": "| h | L2 |\n|---+---|\n| 0.25 | 1.2e-2 |\n| 0.125 | 3e-3 |\n",
    "grid of reStructuredText": "+-----+------+\n| h   | L2   |\n+=====+======+\n|0.25 |1.2e-2|\n+-----+------+\n|0.125|3e-3  |\n+-----+------+\n",
    "simple reStructuredText": "=====  ======\nh      L2\n=====  ======\n0.25   1.2e-2\n0.125  3e-3\n=====  ======\n",
    "box": "┏━━━━━┳━━━━━━┓\n┃ h   ┃ L2   ┃\n┡━━━━━╇━━━━━━┩\n│ 0.25│1.2e-2│\n│0.125│ 3e-3 │\n└─────┴──────┘\n",
    "LaTeX": "\\begin{tabular}{l@{}c}\\hline\n$h$ & $L2$ \\\\ \\hline\n1/4 & $1.2\\cdot10^{-2}$ \\\\\n1/8 & 3e-3 \\\\ \\hline\n\\end{tabular}\n",
    "booktabs": (
        "\\toprule\nh & L2 \\\\ % of mine\n\\midrule\n$\\frac{1}{4}$ & \\num{1.2e-2} \\\\[2pt]\n"
        "$2^{-3}$ & \\textbf{0.003} \\\\\n\\bottomrule\n"
    ),
    "siunitx": (
        "\\begin{table}\\begin{tabular}{S[table-format=1.3] S}\n{$h$} & {$L2$} \\\\\n"
        "0.25 & 1.2e-2 \\tabularnewline\n0.125 & $3 \\times 10^{-3}$ \\\\\n\\end{tabular}\\end{table}"
    ),
    "HTML": (
        "<p>See:</p><table><tr><th>h</th><th>L<sub>2</sub></th></tr>\n<tr><td>0.25</td><td>1.2&middot;10<sup>-2</sup></td></tr>"
        "<tr><td>0.125<td>3e-3</table>"
    ),
    "JSON records": '[{"h": 0.25, "L2": 1.2e-2}, {"h": 0.125, "L2": 3e-3}]',
    "JSON columns": '{"h": [0.25, 0.125],\n "L2": [1.2e-2, 3e-3]}',
    "JSON of pandas": '{"h": {"0": 0.25, "1": 0.125}, "L2": {"0": 0.012, "1": 0.003}}',
    "Python lists": "h = [1/4, 1/8]\nL2 = np.array([1.2e-2,  # coarse\n 3e-3])\n",
    "MATLAB vectors": "% mine\nh=[0.25;\n   0.125];\nL2 = [1.2e-2 3e-3]';\n",
    "log": "h=2.5E-01 L2=1.2E-02\nh=1.25E-01 L2=3.0E-03\n",
    "log with blanks": "h: 0.25, L2: 1.2e-2\nh: 0.125, L2: 3e-3\n",
}


@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_the_layout_does_not_matter(text):
    found = columns(text)
    assert list(found) == list(TWO)
    assert [*found["h"], *found["L2"]] == pytest.approx([*TWO["h"], *TWO["L2"]], rel=1e-15)


def test_quantities_may_stand_in_rows():
    assert columns("h, 1, 0.5, 0.25\nL2, 4, 2, 1\n") == {"h": [1, 0.5, 0.25], "L2": [4, 2, 1]}


ACROSS = {"h": [0.2, 0.2, 0.1, 0.1], "dt": [1, 0.5, 1, 0.5], "error": [4, 3, 2, 1]}


@pytest.mark.parametrize(
    "head",
    ["h \\ dt,1,0.5", "h\\dt,1,0.5", "h/dt,1,0.5", "h | dt,1,0.5", "h,dt=1,dt=0.5", '"h, dt",1,0.5'],
)
def test_errors_may_stand_in_a_matrix_of_two_sizes(head):
    assert columns(f"{head}\n0.2,4,3\n0.1,2,1\n") == ACROSS


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (",h,L2\n0,1,2\n1,2,3\n", ("(no name)", "h", "L2")),
        ("   h  L2   rate\n0  1  2.0  NaN\n1  2  3.0  1.5\n", ("(no name)", "h", "L2", "rate")),
        ("h,L2,order,H1,order\n1,1,-,1,-\n2,2,1,2,1\n", ("h", "L2", "L2 order", "H1", "H1 order")),
        ("h,L2,\n1,2,\n2,3,\n", ("h", "L2")),
        ("h,L2\n1,2,\n2,3,\n", ("h", "L2")),
        ("h  L2 error  rate\n1  2  -\n2  3  1\n", ("h", "L2 error", "rate")),
        ("cells dofs  val L2\n  16   80  1.8e-1\n  64  288  9.7e-2\n", ("cells", "dofs", "val L2")),
        ("n  H1         L2\n1  0.5    -   0.25    -\n2  0.2 1.00   0.06 2.00\n", ("n", "H1", "H1 rate", "L2", "L2 rate")),
        ("n\tl2\to2\n1\t4\n2\t1\t2\n", ("n", "l2", "o2")),
        (
            "$h$ & \\multicolumn{2}{c}{P1} & \\multicolumn{2}{c}{P2} \\\\ \\cmidrule(lr){2-3}\n"
            " & error & rate & error & rate \\\\\n1 & 1 & -- & 1 & -- \\\\\n2 & 1 & 0 & 1 & 0 \\\\\n",
            ("h", "P1 error", "P1 rate", "P2 error", "P2 rate"),
        ),
        (
            "\\multirow{2}{*}{$h$} & \\multicolumn{2}{c}{$\\|u - u_h\\|_{L^2}$} \\\\\n1 & 1 & -- \\\\\n2 & 1 & 0 \\\\\n",
            ("h", "||u - u_h||_L^2", "||u - u_h||_L^2 rate"),
        ),
        ("dofs;L2\n1,024;0.5\n4,096;0.1\n", ("dofs", "L2")),
        ("h,L2,note\n1,2,\n2,3,\n", ("h", "L2", "note")),
        ("h | L2\n1 | 2\n2 | 3\n | $O(h)$\n", ("h", "L2")),
    ],
)
def test_columns_are_named_as_their_author_meant(text, names):
    table = read(text)
    assert table.names == names
    assert len(table.rows) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("| h | e |\n|---|---|\n| 1 | 2 |\n\nThen:\n\n| h | e |\n|---|---|\n| 1 | 2 |\n", "holds 2 tables, at lines 1, 7"),
        ("h,e\n1,2\nh,e\n1,2\n", "holds two tables"),
        ("<table><tr><td>1<tr><td>2</table><table><tr><td>1<tr><td>2</table>", "holds 2 tables"),
        ("# h e\n1 1\n2 2\n\n\n# h e\n1 2\n2 3\n", "holds two tables, the second at line 7"),
        ("h  e   rate\n4  4   -\n2      2\n1  1   2\n", "line 3 has 2 cells where line 2 has 3"),
        ("h;e\n0,5;0.1\n", "mixes decimal commas"),
        ("n;e\n1,024;2\n", "may be 1.024 or 1024"),
    ],
)
def test_what_could_be_read_in_two_ways_is_refused(text, said):
    with pytest.raises(UsageError, match=said):
        read(text)


def test_lines_are_counted_in_the_file():
    assert [line for line, _ in read("# mine\n\nh,e\n1,2\n\n2,3\n").rows] == [4, 6]
    assert [
        line for line, _ in read("\\begin{tabular}{cc}\nh & e \\\\\n\\hline\n1 & 2 \\\\\n2 & 3 \\\\\n\\end{tabular}").rows
    ] == [4, 5]


def test_a_cell_without_a_value_is_not_a_number_that_is_none():
    table = read("h,e\n1,-\n2,nan\n3,\n4,1\n")
    assert table.given("e").tolist() == [False, True, False, True]
    assert [math.isnan(value) for value in table.numbers("e")] == [True, True, True, False]


# Numbers.


@pytest.mark.parametrize(
    ("cell", "value"),
    [
        ("1.2-103", 1.2e-103),
        ("1.234(-4)", 1.234e-4),
        ("\\sqrt{2}/8", math.sqrt(2) / 8),
        ("√2/16", math.sqrt(2) / 16),
        ("−1.5", -1.5),
        ("1.2×10⁻³", 1.2e-3),
        ("$-1.2\\times10^{-3}$", -1.2e-3),
        ("1.5\\,\\%", 0.015),
        ("16 × 16", 256),
        ("\\SI{1.2e-3}{\\metre}", 1.2e-3),
        ("inf", math.inf),
        (".5", 0.5),
        ("5.", 5),
    ],
)
def test_a_number_may_be_written_in_many_ways(cell, value):
    assert number(plain(cell)) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "cell", ["1_0", "two", "0x10", "1e", "e5", "1/0", "1-2", "1.2 s", "", "--", "1,2", "1,2345", "1.2.3", "L2"]
)
def test_what_is_no_number_is_none(cell):
    assert number(plain(cell)) is None


def test_grids_have_directions():
    assert grid(plain("16 × 8")) == (16, 8)
    assert grid(plain("$16^3$")) == ()


@given(st.floats(allow_infinity=False, allow_nan=False))
def test_every_float_is_read_exactly(value):
    for text in (repr(value), f"{value:.16e}", f"{value:.16E}".replace("E", "D"), repr(value).replace("-", "−")):
        assert number(plain(text)) == value
    assert number(repr(value).replace(".", ","), Decimal.COMMA) == value
    mantissa, _, exponent = f"{value:.16e}".partition("e")
    for text in (f"${mantissa}\\cdot10^{{{int(exponent)}}}$", f"{mantissa} x 10^{int(exponent)}", f"\\num{{{value!r}}}"):
        assert number(plain(text)) == value


# Names.


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        (
            Role.SPACE,
            "h, dx, Δx, h_max, hmax, mesh size, Mesh Size h, h [m], $h$, \\Delta x, grid spacing, element size, delta_x, size",
        ),
        (Role.TIME_STEP, "dt, Δt, \\Delta t, tau, time step, time_step, dt [s], step size"),
        (Role.PARTICLES, "ppc, PPC, particles per cell"),
        (Role.DIRECTION, "nx, N_x, 1/h, h^-1, cells per side, elements per edge"),
        (Role.STEPS, "steps, time steps, N_t"),
        (Role.CELLS, "cells, #cells, n_cells, elements, N, n, number of elements, active cells, nel, mesh, grid, resolution"),
        (Role.DOFS, "dofs, #DoFs, ndof, N_dof, degrees of freedom, unknowns, nodes, numPts, $n$ gridpoints, particles"),
        (Role.LEVEL, "level, refinement level, cycle, number of refinements, lvl"),
        (Role.RATE, "rate, order, EOC, eoc(u), L2 rate, order_L2, conv. rate, Conv. rates, log2, r, o1, p_obs, pair_order_all"),
        (
            Role.OTHER,
            "time, CPU time [s], seconds, wall_time, iterations, Newton its, memory, cond, seed, inside_cells, t, h^2, O(h), O(dt^2)",
        ),
        (Role.VARIANT, "p, k, degree, polynomial degree, case, method, CFL"),
        (
            Role.ERROR,
            "L2, H1, Linfty, error, L2 error, err_u, time error, velocity, u, ||u - u_h||_L^2, all_err, e_h, RMSE, L2error, |u|_H1",
        ),
    ],
)
def test_a_column_is_known_by_its_name(kind, names):
    assert {name: role(plain(name)) for name in names.split(", ")} == dict.fromkeys(names.split(", "), kind)


# Any style.

NUMBERS = st.floats(1e-12, 1e6)
NAMES = st.lists(st.sampled_from(["L2", "H1 error", "velocity", "e_u", "max norm"]), min_size=1, max_size=4, unique=True)


def latex(value):
    mantissa, _, exponent = f"{value:.16e}".partition("e")
    return f"${mantissa}\\cdot 10^{{{int(exponent)}}}$"


STYLES = {
    "csv": (",".join, repr),
    "semicolons and decimal commas": (";".join, lambda value: repr(value).replace(".", ",")),
    "tabs and Fortran": ("\t".join, lambda value: f"{value:.16E}".replace("E", "D")),
    "white space": (lambda cells: "   ".join(f"{cell:>26}" for cell in cells), repr),
    "Markdown": (lambda cells: f"| {' | '.join(cells)} |", repr),
    "LaTeX": (lambda cells: f"{' & '.join(cells)} \\\\", latex),
    "HTML": (lambda cells: f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>", repr),
}


@given(
    st.sampled_from(list(STYLES)),
    NAMES,
    st.lists(st.lists(NUMBERS, min_size=5, max_size=5), min_size=2, max_size=6),
    st.sampled_from(["\n", "\n\n"]),
    st.sampled_from(["", "# of mine\n", "% of mine\n"]),
)
def test_a_table_in_any_style_gives_the_same_numbers(style, names, levels, end, comment):
    joined, written = STYLES[style]
    names = ["h", *names]
    lines = [joined(names), *(joined([written(value) for value in level[: len(names)]]) for level in levels)]
    if style == "Markdown":
        lines.insert(1, joined(["---"] * len(names)))
    table = read(("" if style in ("LaTeX", "HTML") else comment) + end.join(lines) + "\n")
    assert table.names == tuple(names)
    for column, name in enumerate(names):
        assert table.numbers(name).tolist() == [level[column] for level in levels]


@given(st.text(max_size=200))
def test_any_text_is_read_or_refused_in_one_sentence(text):
    try:
        table = read(text)
    except UsageError as error:
        said, table = str(error), None
    if table is None:
        assert said.startswith("'errors.csv'")
    else:
        assert len(set(table.names)) == len(table.names)
        assert {len(cells) for _, cells in table.rows} == {len(table.names)}
